# SPDX-License-Identifier: MIT
"""Rig files in this process, in virtual time."""
import os
import subprocess
from pathlib import Path

import drehgeber
import pytest
from drehgeber import Clock, Encoder, EncoderError, Rig

TREE = Path(__file__).resolve().parents[2]
BENCH = """
; the bench of README.md
[rig]
name = bench
[shaft motor]
motion = 60RPM
[shaft wheel]
driver = motor
ratio = 1:-10
[bus can]
wire = slcan
address = /tmp/hub
pace = 1
[bus line]
wire = pty
[encoder Feedback]
model = s3684-rs485   ; on a line
bus = line
address = 0x41
temperature = 85
nvm = feedback.nvm
[encoder load]
model = f3668
bus = can
node = 1
[encoder other]
model = f3668
bus = can
node = 2
shaft = Wheel
[encoder wheel]
model = s3684-biss
shaft = wheel
wire = sim
trace = wheel.vcd
"""


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "bench.ini").write_text(BENCH)
    return tmp_path / "bench.ini"


def test_one_section_for_many(tmp_path):
    """node = FIRST..LAST: what counts, counts up."""
    text = (
        "[bus b]\nwire = slcan\n[encoder N]\nmodel = f3668\nbus = b\nnode = 1..125\nserial = 1000\nnvm = n.nvm\n"
        "[bus l]\nwire = pty\n[encoder r]\nmodel = s3684-rs485\nbus = l\naddress = 0x40..41h\n"
    )
    with Rig.of_text(text, tmp_path) as rig:
        assert list(rig.encoders) == [f"n-{i}" for i in range(1, 126)] + ["r-0x40", "r-0x41"]
        assert len(rig.buses["b"].nodes) == 125 and len(rig.lines["l"].encoders) == 2
        for i in (1, 125):
            node = rig.encoders[f"n-{i}"]
            assert (node.get("node"), node.get("serial")) == (str(i), str(999 + i))
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"n.nvm.{i}" for i in range(1, 126))
    with Rig.of_text(text.replace("1..125", "5..5"), tmp_path) as rig:
        assert list(rig.encoders) == ["n-5", "r-0x40", "r-0x41"]
    for value in ("3..2", "1..x", "..2"):
        with pytest.raises(EncoderError, match="expected|no number"):
            Rig.of_text(text.replace("1..125", value), tmp_path)
    with pytest.raises(EncoderError, match="no wire of their own"):
        Rig.of_text(text.replace("bus = b\nnode", "wire = slcan\nnode"), tmp_path)


def test_a_course_has_begun_when_an_encoder_is_switched_on(tmp_path):
    """3200h of 1003h, the battery; at its first moment the node looks at it."""
    (tmp_path / "flat.csv").write_text("0,1000\n1,1000\n")
    text = "[encoder n]\nmodel = f3668\nwire = slcan\nbattery_mv = "
    with Rig.of_text(f"{text}flat.csv\n", tmp_path) as rig:
        assert rig.encoders["n"].state()["errors"] == "3200"
    with Rig.of_text(f"{text}3600\n", tmp_path) as rig:
        assert rig.encoders["n"].state()["errors"] is None


def test_a_whole_rig_goes_by_one_clock(bench):
    rig = Rig(bench)
    assert (rig.name, list(rig.shafts), list(rig.buses)) == ("bench", ["motor", "wheel"], ["can"])
    assert list(rig.encoders) == ["feedback", "load", "other", "wheel"]
    rig.advance(2.5)
    assert rig.clock.now == 2.5 and rig.shafts["wheel"].position == -90
    assert rig.encoders["feedback"].position == rig.encoders["load"].position == 163840
    assert rig.encoders["other"].position == (1 << 28) - 16384
    assert rig.encoders["wheel"].biss.frame().singleturn == 3 << 19
    assert rig.encoders["feedback"].world.temperature == 85
    assert rig.encoders["feedback"].request(bytes.fromhex("41 42 03"))[:2] == b"\x41\x42"
    assert rig.lines["line"].encoders == (rig.encoders["feedback"],)
    master = rig.buses["can"].port()
    for node in (1, 2):
        master.send(0x600 + node, bytes.fromhex("40 04 60 00 00 00 00 00"))
        answer = master.recv()
        assert answer is not None and answer.id == 0x580 + node


def test_an_eeprom_outlives_its_rig(bench):
    with Rig(bench) as rig:
        rig.encoders["feedback"].request(bytes.fromhex("41 55 00 40 54"))  # 55h: address 40h from now on
        rig.advance(1)
        image = rig.encoders["feedback"].memory
    assert (bench.parent / "feedback.nvm").read_bytes() == image
    with Rig(bench) as rig:
        assert rig.encoders["feedback"].memory == image


@pytest.mark.parametrize("name", ["pitch", "forty"])
def test_the_examples_are_taken(name):
    rig = Rig(TREE / f"tools/examples/{name}.ini", clock=Clock())
    rig.advance(1)
    text = (TREE / f"tools/examples/{name}.ini").read_text()
    assert len(rig.encoders) == text.count("[encoder ")


def test_without_shafts_all_share_one():
    rig = Rig.of_text("[encoder a]\nmodel = f3668\nwire = slcan\n[encoder b]\nmodel = ssi-28\nwire = sim\n")
    rig.shafts["main"].position = 90
    assert rig.encoders["a"].position == rig.encoders["b"].position == 16384
    assert rig.encoders["a"].bus is not None


@pytest.mark.parametrize("wire", ["slcan", "slcan\naddress = tcp:127.0.0.1:0", "socketcand"])
def test_whatever_carries_can_is_a_bus(wire):
    rig = Rig.of_text(f"[bus b]\nwire = {wire}\n[encoder a]\nmodel = f3668\nbus = b\n")
    assert rig.encoders["a"].bus is rig.buses["b"]


@pytest.mark.parametrize("wire", ["pty", "rs485"])
def test_whatever_carries_rs485_is_a_line(wire):
    rig = Rig.of_text(f"[bus b]\nwire = {wire}\n[encoder a]\nmodel = s3684-rs485\nbus = b\n")
    assert rig.lines["b"].encoders == (rig.encoders["a"],)


def test_a_recording_beside_the_file(tmp_path):
    (tmp_path / "run.csv").write_text("0,0\n1,90\n")
    rig = Rig.of_text("[shaft s]\nmotion = run.csv\n[encoder a]\nmodel = f3668\nwire = slcan\n", tmp_path)
    rig.advance(0.5)
    assert rig.shafts["s"].position == pytest.approx(45, abs=1e-6)


ENCODER = "[encoder a]\nmodel = f3668\nwire = slcan\n"
WRONG = {
    "": "^text: without encoders; ",
    "[motor]\n": r"^text:1: \[motor\]: no such section; expected .* or \[encoder NAME\]",
    "[encoder a]\nmodel = s9\n": "^text:2: model: s9 is unknown; expected one of: s3674-rs485 ",
    ENCODER + "node = 500\n": r"^text:4: node 500: expected a node-ID in 1\.\.127",
    ENCODER + "nod = 5\n": r"^text:4: nod: no such key; valid: mt_bits temperature .* watchdog_fired; of the wire: pace$",
    ENCODER + "serial = -5\n": r"^text:4: serial -5: expected a number in 0\.\.4294967295$",
    "[bus b]\nwire = slcan\npace = 2\n" + ENCODER.replace("wire = slcan", "bus = b"): r"^text:3: pace=2: expected 0 or 1$",
    ENCODER + "pace = 2\n": r"^text:4: pace=2: expected 0 or 1$",
    ENCODER.replace("slcan", "silkit:silkit://a:1,b") + "step_us = 0\n": r"expected a number in 1\.\.1000000 us",
    ENCODER + "nvm = bad.nvm\n": r"^text:4: \[encoder a\]: the image: ",
    "[shaft a]\nmotion = fast\n": "^text:2: motion fast: .* FILE.csv$",
    "model = f3668\n": "^text:1: model: stands before the first section; ",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_said_with_its_place(text, tmp_path):
    (tmp_path / "bad.nvm").write_bytes(b"x")
    with pytest.raises(EncoderError, match=WRONG[text]):
        drehgeber.Rig.of_text(text, tmp_path)


LAB = {
    "bench.ini": "[rig]\ninclude = läb/shafts.ini\n[encoder a]\nmodel = f3668\nwire = slcan\n[rig]\ninclude = läb/house.ini\n",
    "läb/shafts.ini": "[rig]\nname = lab\ninclude = deep/more.ini\n[shaft s]\nmotion = run.csv\n",
    "läb/deep/more.ini": "[shaft first]\n",
    "läb/house.ini": "[encoder h]\nmodel = s3684-rs485\nwire = pty\ntemperature = warm.csv\nnvm = h.nvm\n",
    "läb/run.csv": "0,0\n1,90\n",
    "läb/warm.csv": "0,20\n1,30\n",
}


@pytest.fixture
def lab(tmp_path):
    """A folder of its own, with something beside it."""
    for name, text in LAB.items():
        path = tmp_path / "here" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (tmp_path / "secret.ini").write_text("[shaft secret]\n")
    return tmp_path / "here"


def test_models_of_the_file():
    text = "[model slow]\nbase = s3684-biss\ntimeout_us = 30\n[encoder a]\nmodel = slow\nwire = sim\n"
    encoder = Rig.of_text(text).encoders["a"]
    assert (encoder.model, encoder.get("timeout_us")) == ("slow", "30")


def test_files_include_each_other(lab):
    """Names in them are relative to each one's folder."""
    rig = Rig(lab / "bench.ini")
    assert (rig.name, list(rig.shafts)) == ("lab", ["first", "s"])
    rig.advance(0.5)
    assert rig.shafts["s"].position == pytest.approx(45, abs=1e-6)
    assert rig.encoders["h"].world.temperature == 25
    rig.close()
    assert (lab / "läb/h.nvm").stat().st_size
    (lab / "läb/shafts.ini").write_text("[shaft s]\n[rig]\ninclude = deep/more.ini\n")
    (lab / "läb/deep/more.ini").write_text("[encoder b]\nmodel = f3668\nwire = slcan\n\ncolour = red\n")
    with pytest.raises(EncoderError, match=r"^bench.ini:2: läb/shafts.ini:3: läb/deep/more.ini:5: colour: no such key; "):
        Rig(lab / "bench.ini")


@pytest.mark.parametrize("name", ["link.ini", "folder/secret.ini", "folder", "none.ini", "pipe", "../secret.ini", "loop.ini", "long.ini"])
def test_no_file_elsewhere_is_included(lab, name):
    """As the command, which says the same of each."""
    (lab / "link.ini").symlink_to("../secret.ini")
    (lab / "folder").symlink_to("..")
    (lab / "loop.ini").write_text("[rig]\ninclude = loop.ini\n")
    (lab / "long.ini").write_text("\n" * (1 << 20) + "\n")
    os.mkfifo(lab / "pipe")
    (lab / "bench.ini").write_text(f"[rig]\ninclude = {name}\n[encoder a]\nmodel = f3668\nwire = slcan\n")
    command = [os.environ["DREHGEBER"], "run", "bench.ini", "--time", "virtual:1MS", "--control", f"unix:{lab}/s"]
    ended = subprocess.run(command, cwd=lab, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    with pytest.raises(EncoderError, match=r"^bench.ini:2: ") as caught:
        Rig(lab / "bench.ini")
    assert ended.returncode == 2 and str(caught.value) in ended.stderr


def test_encoders_of_a_bus_share_its_master():
    """In the order of the file; each one's own master goes on beside it."""
    rig = Rig.of_text(
        "[bus c]\nwire = sim\nline_delay_ns = 5\n[bus r]\nwire = modbus\n[bus s]\nwire = sim\n"
        "[encoder a]\nmodel = s3684-biss\nbus = c\n[encoder b]\nmodel = s3674-biss\nbus = c\n"
        "[encoder k]\nmodel = ocd-ib-k1\nbus = r\n[encoder l]\nmodel = ocd-ib-k2\nbus = r\n[encoder m]\nmodel = ssi-13\nbus = s\n"
    )
    rig.shafts["main"].position = 90
    rig.advance(1)
    assert (list(rig.chains), list(rig.rings), rig.buses, rig.lines) == (["c"], ["r"], {}, {})
    assert rig.chains["c"].encoders == (rig.encoders["a"], rig.encoders["b"])
    assert [frame.singleturn for frame in rig.chains["c"].frame()] == [1 << 19, 1 << 19]
    rig.advance(1)
    assert rig.rings["r"].cycle() == (1024, 0, 1024)
    assert rig.encoders["a"].biss.frame().singleturn == 1 << 19


def test_texts_are_bytes_as_the_command_takes_them(tmp_path):
    """Of comments nothing is asked; a name of a file is its bytes."""
    (tmp_path / "rig.ini").write_bytes(b"; \xe4\n[encoder a]\nmodel = f3668\nwire = slcan\nnvm = \xe4.nvm\n")
    with Rig(tmp_path / "rig.ini") as rig:
        assert rig.encoders["a"].powered
    assert os.fsencode(tmp_path / "\udce4.nvm") in [os.fsencode(path) for path in tmp_path.iterdir()]
    (tmp_path / "rig.ini").write_bytes(b"[encoder a]\nmodel = f3668\nwire = slcan\ntemperature = \xe4\n")
    with pytest.raises(EncoderError, match=r"^rig.ini:4: temperature=\udce4: expected a number in -273\.\.1000 degC"):
        Rig(tmp_path / "rig.ini")


COURSES = """
[encoder a]
model = s3684-rs485
wire = pty
temperature = warm.csv
led_current_ua = led.csv, LOOP,step
"""


def test_courses_of_a_file(tmp_path):
    (tmp_path / "warm.csv").write_text("0,20\n10,85\n")
    (tmp_path / "led.csv").write_text("0,12000\n1,40000\n2,0\n")
    rig = Rig.of_text(COURSES, tmp_path)
    world = rig.encoders["a"].world
    assert (world.temperature, world.led_current_ua) == (20, 12000)
    rig.advance(5.5)
    assert (world.temperature, world.led_current_ua) == (55.75, 40000)
    rig.advance(5)
    assert (world.temperature, world.led_current_ua) == (85, 12000)
    (tmp_path / "led.csv").write_text("0,12000\n")
    with pytest.raises(EncoderError, match=r"^text:6: led_current_ua=led.csv, LOOP,step: a loop needs a time above 0$"):
        Rig.of_text(COURSES, tmp_path)
    with pytest.raises(EncoderError, match=r"^text:6: led_current_ua=led.csv, LOP,step: 'LOP' is none of the words; "):
        Rig.of_text(COURSES.replace("LOOP", "LOP"), tmp_path)


def test_an_encoder_gets_its_power_with_what_a_course_begins_with(tmp_path):
    (tmp_path / "warm.csv").write_text("0,200\n1,37\n")
    (tmp_path / "led.csv").write_text("5,12000\n")
    assert Rig.of_text(COURSES, tmp_path).encoders["a"].request(bytes.fromhex("40 50 10"))[2] == 0x1E


@pytest.mark.parametrize("bad", ["x,1\n", "0,1\n2,3\n1,1\n", "0,99999\n", None])
@pytest.mark.parametrize("keys", ["[encoder a]\nmodel = f3668\nwire = slcan\ntemperature = x.csv\n", "[shaft a]\nmotion = x.csv\n" + ENCODER])
def test_what_is_wrong_with_a_file_is_said(keys, bad, tmp_path):
    if bad is not None:
        (tmp_path / "x.csv").write_text(bad)
    if bad == "0,99999\n" and "motion" in keys:
        Rig.of_text(keys, tmp_path)
        return
    with pytest.raises((EncoderError, FileNotFoundError), match=r"^text:\d: \[(encoder|shaft) a\]: |No such file"):
        Rig.of_text(keys, tmp_path)


ALONE = {"s3684-rs485": "pty", "s3684-biss": "sim"}


@pytest.mark.parametrize("model", ALONE)
def test_a_fault_is_in_front_of_a_course_of_a_file(model, tmp_path):
    """As in the command: behind it the course goes on."""
    (tmp_path / "warm.csv").write_text("0,20\n10,30\n")
    rig = Rig.of_text(f"[encoder a]\nmodel = {model}\nwire = {ALONE[model]}\ntemperature = warm.csv\n", tmp_path)
    encoder, world = rig.encoders["a"], rig.encoders["a"].world
    rig.advance(1)
    assert world.temperature == 21
    with encoder.fault("temperature_high"):
        rig.advance(1)
        assert world.temperature > 100
    assert world.temperature == 22
    rig.advance(0.5)
    assert world.temperature == 22.5
    world.stop("temperature")
    rig.advance(1)
    assert world.temperature == 22.5
    world.play("temperature", [(0, 40), (1, 50)])
    rig.advance(0.5)
    assert world.temperature == 45


@pytest.mark.parametrize("model", ALONE)
def test_what_is_assigned_ends_a_course_of_a_file(model, tmp_path):
    (tmp_path / "warm.csv").write_text("0,20\n10,30\n")
    rig = Rig.of_text(f"[encoder a]\nmodel = {model}\nwire = {ALONE[model]}\ntemperature = warm.csv\n", tmp_path)
    rig.advance(1)
    rig.encoders["a"].world.temperature = 50
    rig.advance(20)
    assert rig.encoders["a"].world.temperature == 50
    rig.close()
    rig.advance(1)


NODES = "[bus b]\nwire = slcan\n[encoder a]\nmodel = f3668\nbus = b\nnode = 1\n[encoder c]\nmodel = f3668\nbus = b\nnode = 2\n"
UPLOAD = bytes.fromhex("40 04 60 00 00 00 00 00")


def answering(rig, *nodes):
    master = rig.buses["b"].port()
    for node in nodes:
        master.send(0x600 + node, UPLOAD)
    return [frame.id - 0x580 for frame in iter(master.recv, None)]


def test_others_go_by_its_clock_and_join_its_wires():
    clock = Clock()
    own = Encoder("s3684-biss", clock=clock, shaft="60RPM")
    clock.advance(1)
    rig = Rig.of_text(NODES, clock=clock)
    assert answering(rig, 1, 2) == [1, 2]
    late = Encoder("f3668", bus=rig.buses["b"], node=3, shaft=rig.shafts["main"])
    rig.shafts["main"].position = 90
    rig.advance(0.25)
    assert own.position >> 19 == 1 << 2 | 1 and late.position == rig.encoders["a"].position == 16384
    assert answering(rig, 1, 2, 3) == [1, 2, 3]
    rig.encoders["a"].close()
    assert answering(rig, 1, 2, 3) == [2, 3] and rig.buses["b"].nodes == (rig.encoders["c"], late)


def test_one_that_is_closed_leaves_the_others():
    rig = Rig.of_text(NODES)
    rig.encoders["a"].close()
    rig.shafts["main"].position = 90
    rig.encoders["c"].set_fault("wire_drop", duration_ms=10)
    assert answering(rig, 1, 2) == []
    rig.advance(0.02)
    assert answering(rig, 1, 2) == [2] and rig.encoders["c"].position == 16384


def test_serial_numbers_count_up():
    """Of nodes of which the file does not say any, as in the command."""
    rig = Rig.of_text(NODES)
    first, second = (int(rig.encoders[name].get("serial")) for name in "ac")
    assert second == first + 1


def test_each_alone_has_a_master_for_itself():
    text = "[encoder s]\nmodel = ssi-13\nwire = sim\ncode = binary\n[encoder r]\nmodel = ocd-ib-k1\nwire = modbus\n[encoder b]\nmodel = s3674-biss\nwire = sim\n"
    rig = Rig.of_text(text)
    rig.shafts["main"].position = 180
    levels = rig.encoders["s"].clocked.watch()
    for i in range(4):
        rig.encoders["s"].ssi.clock(i % 2 == 1)
        rig.advance(1e-6)
    assert [level.level for level in levels] == [False]
    rig.advance(0.001)
    assert rig.encoders["s"].ssi.frame().good and rig.encoders["r"].ring.cycle() == (2048,)
    assert rig.encoders["r"].ring.identify() == 0x0136 and rig.encoders["b"].biss.sli(True) is False
    assert rig.encoders["b"].biss.frame().good and rig.encoders["b"].biss.register(0x78, 8)


def test_an_end_of_a_line_has_its_words():
    rig = Rig.of_text("[encoder a]\nmodel = s3684-rs485\nwire = pty\nline = any\npace = 0\n")
    assert len(rig.encoders["a"].request(bytes.fromhex("40 42 02"))) == 7 and rig.clock.now < 0.01


def test_states_go_from_one_to_another():
    with Rig.of_text("[encoder a]\nmodel = f3668\nwire = slcan\nnode = 5\n") as rig:
        encoder = rig.encoders["a"]
        encoder.can.send(0x605, b"\x23\x03\x60\x00\x07\0\0\0")
        other = Encoder("f3668")
        other.restore(encoder.save())
        assert other.position == encoder.position == 7 and encoder.can.recv() is not None
