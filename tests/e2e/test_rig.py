# SPDX-License-Identifier: MIT
"""Rig files: many encoders, shafts and wires of one process."""
import os
import re
import signal
import socket
import struct
import subprocess
import time

import pytest
import serial

from hiperface_master import EncoderError, Master
from rig import PATIENCE_S, PROGRAM, REPOSITORY, Client, Encoder, run_refused

TURN = 65536  # steps of all encoders here that have no other figure
BENCH = """
[rig]
name = bench
control = tcp:127.0.0.1:0
[shaft main]
motion = 990DEG                  ; 2.75 turns
[shaft pitch]
driver = main
ratio = -1:10
[bus line]
wire = pty
address = line
[bus can0]
wire = slcan
address = can0
[bus ring]
wire = modbus
address = 127.0.0.1:0
cycle = 2000
[encoder hf1]
model = s3684-rs485
bus = line
nvm = hf1.nvm
[encoder hf2]
model = s3684-rs485
bus = line
shaft = pitch
address = 0x41
[encoder hf3]
model = s3674-rs485
bus = line
address = 0x42
serial = 246813579
[encoder co1]
model = f3668
bus = can0
[encoder co2]
model = f3658
bus = can0
node = 64
shaft = pitch
[encoder ib1]
model = ocd-ib-k1
bus = ring
[encoder ib3]
model = ocd-ib-k3
bus = ring
[encoder alone]
model = s3684-rs485
wire = pty:alone
[encoder biss]
model = s3684-biss
wire = sim
"""
READY = [
    r"ready s3684-rs485 pty:(\S+) hf1",
    r"ready s3684-rs485 pty:(\S+) hf2",
    r"ready s3674-rs485 pty:(\S+) hf3",
    r"ready f3668 slcan:(/dev/pts/\d+)/63 co1",
    r"ready f3658 slcan:(/dev/pts/\d+)/64 co2",
    r"ready ocd-ib-k1 modbus:127\.0\.0\.1:(\d+)/0 ib1",
    r"ready ocd-ib-k3 modbus:127\.0\.0\.1:(\d+)/1 ib3",
    r"ready s3684-rs485 pty:(\S+) alone",
    r"ready s3684-biss sim: biss",
    r"control tcp:127\.0\.0\.1:(\d+)",
    r"ready rig",
]


class Rig(Encoder):
    """A running rig file, and what its ready lines say."""

    def __init__(self, file, *arguments, **options):
        super().__init__([file, *arguments], **options)
        self.lines = [self.ready_line]
        while self.lines[-1] != "ready rig":
            self.lines.append(self.out.wait())


@pytest.fixture
def rig(tmp_path):
    """Start rigs: rig(TEXT). Each is ended; nothing unasked was said."""
    running = []

    def begin(text, *arguments, **options) -> Rig:
        file = tmp_path / f"rig{len(running)}.ini"
        file.write_text(text)
        running.append(Rig(file, "--files", tmp_path, *arguments, **options))
        return running[-1]

    yield begin
    unasked = [line for one in running for line in one.clean_up()]
    assert unasked == []


def slcan_position(link, node: int) -> int:
    """Upload 6004h by SDO, over the adapter's own language."""
    with serial.Serial(str(link), 115200, timeout=PATIENCE_S) as port:
        port.write(b"S5\rO\r" + b"t%03X84004600000000000\r" % (0x600 + node))
        answer = b""
        while b"t%03X8" % (0x580 + node) not in answer:
            got = port.read_until(b"\r")
            assert got, answer
            answer += got
    data = bytes.fromhex(answer.split(b"t%03X8" % (0x580 + node))[1][:16].decode())
    assert data[:4] == bytes.fromhex("43 04 60 00")
    return struct.unpack("<I", data[4:])[0]


def coupler_words(port: int, count: int) -> tuple:
    """IN words of the ring, as soon as no self-test is going on."""
    request = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, count)
    with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as line:
        for _ in range(2000):
            line.sendall(request)
            answer = line.recv(300)
            words = struct.unpack(f">{count}H", answer[9:])
            if words[0] and not words[-2] & 0x8000:
                return words
    raise AssertionError("the ring does not come up")


def test_a_whole_bench(rig, tmp_path):
    bench = rig(BENCH)
    found = [re.fullmatch(pattern, line) for pattern, line in zip(READY, bench.lines)]
    assert all(found) and len(bench.lines) == len(READY), bench.lines

    # One shaft, one position: 2.75 turns; the geared one stands at -0.275 turns.
    geared = -0.275
    with Master(str(tmp_path / "line")) as master:
        assert master.read_position() == 2.75 * TURN
        master.address = 0x41
        assert master.read_position() == int((geared % 4096) * TURN)
        master.address = 0x42
        assert master.read_position() == 0.75 * TURN
        assert master.identity().serial_number == "246813579"
    with Master(str(tmp_path / "alone")) as master:
        assert master.read_position() == 2.75 * TURN
    assert slcan_position(tmp_path / "can0", 63) == 2.75 * TURN
    assert slcan_position(tmp_path / "can0", 64) == int((geared % 1) * TURN)
    port = int(found[6][1])
    assert coupler_words(port, 3) == (0.75 * 4096, 0, 2.75 * 4096)

    assert (tmp_path / "hf1.nvm").exists()
    assert bench.end() == 0
    assert bench.out.so_far() == []
    for link in ("line", "can0", "alone"):
        assert not os.path.lexists(tmp_path / link)


def test_the_example_of_the_page(rig, tmp_path):
    page = (REPOSITORY / "platform/linux/README.md").read_text()
    text = page.split("```ini\n")[1].split("```")[0]
    text = text.replace(":5025", ":0").replace("/tmp/", f"{tmp_path}/")
    names = [line.split()[-1] for line in rig(text).lines]
    assert names[:3] == ["drive", "load", "tower"] and names[-1] == "rig"


def test_as_many_as_there_may_be(rig):
    ring = "".join(f"[encoder i{n}]\nmodel = ocd-ib-k{n % 3 + 1}\nbus = ring\n" for n in range(512))
    nodes = "".join(f"[encoder c{n}]\nmodel = f3668\nbus = can\nnode = {n}\n" for n in range(1, 128))
    drops = "".join(f"[encoder h{n}]\nmodel = s3684-rs485\nbus = line\naddress = {0x40 + n}\n"
                    for n in range(32))
    bench = rig("[bus ring]\nwire = modbus\naddress = 127.0.0.1:0\n[bus can]\nwire = slcan\n"
                "[bus line]\nwire = pty\n" + ring + nodes + drops)
    assert len(bench.lines) == 512 + 127 + 32 + 1
    assert bench.end() == 0


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_it(rig, signal_number):
    assert rig("[encoder a]\nmodel = f3668\nwire = slcan\n").end(signal_number) == 0


def test_two_at_once_under_one_name(rig):
    text = "[rig]\nname = same\n[encoder a]\nmodel = s3684-rs485\nwire = pty\n"
    assert all(one.alive() for one in [rig(text), rig(text)])


def test_control_addresses_come_from_both(rig, tmp_path):
    text = "[rig]\ncontrol = unix:sock\n[encoder a]\nmodel = s3684-rs485\nwire = pty\n"
    lines = rig(text, "--control", "tcp:127.0.0.1:0").lines
    assert lines[1] == f"control unix:{tmp_path}/sock"
    assert re.fullmatch(r"control tcp:127\.0\.0\.1:\d+", lines[2])


def test_verbose_says_what_goes_over_the_wires(rig, tmp_path):
    bench = rig(BENCH, "--verbose")
    pattern = re.compile(r"\d+\.\d{6} alone ([<>]) .*42h")
    heard = ""
    deadline = time.monotonic() + PATIENCE_S
    with Master(str(tmp_path / "alone")) as master:
        while "<" not in heard or ">" not in heard:
            # A busy machine may hold up a frame in the middle, which makes two lines of it: ask again.
            assert time.monotonic() < deadline, heard
            master.read_position()
            said = [pattern.match(line) for line in [bench.errors.wait(), *bench.errors.so_far()]]
            heard += "".join(found[1] for found in said if found)
    bench.end()
    bench.errors.so_far()


def control_of(rig: Rig) -> Client:
    return Client(int(rig.lines[-2].rpartition(":")[2]))


def test_instruments_by_name(rig):
    with control_of(rig(BENCH)) as control:
        names = control.ask("INST:CAT?").replace('"', "")
        assert names == "hf1,hf2,hf3,co1,co2,ib1,ib3,alone,biss"
        control.do("INST:SEL hf2")
        assert "pitch" in control.ask("SHAF:NAME?")
        assert re.search(r"pty:/dev/pts/\d+", control.ask("INST:WIRE?"))
        control.do("INST:SEL ib3")
        assert re.search(r"modbus:127\.0\.0\.1:\d+/1", control.ask("INST:WIRE?"))
        assert float(control.ask("SHAF:POS?")) == 990


def test_steered_from_outside(rig, tmp_path):
    with control_of(rig(BENCH)) as control:
        control.do("SHAF:POS 360DEG")
        with Master(str(tmp_path / "alone")) as master:
            assert master.read_position() == TURN
        control.do("INST:SEL alone")
        control.do("WORL:SING OFF")
        with Master(str(tmp_path / "line")) as master:  # another encoder's world
            assert master.read_position() == TURN
        control.ask("TRAC:LAST?")
        with Master(str(tmp_path / "alone")) as master, pytest.raises(EncoderError):
            master.read_position()
        deadline = time.monotonic() + PATIENCE_S
        while "42h" not in control.ask("TRAC:LAST? 5"):
            assert time.monotonic() < deadline
        control.refused("TIME:SCAL 0", -221)  # most wires run in real time
        control.do("INST:SEL hf2")
        control.refused('SHAF:PROF "60RPM"', -221)  # geared


def test_a_failure_ends_a_line_and_no_wait(rig):
    """Of the client that these tests use: what is left of the line would have answered."""
    with control_of(rig(SIMULATED)) as control:
        begin = time.monotonic()
        with pytest.raises(AssertionError, match="-113"):
            control.do("NONSENSE;SHAF:POS 0")
        assert time.monotonic() - begin < PATIENCE_S / 2
        control.do("SHAF:POS 0")  # nothing is left of it


SIMULATED = """
[rig]
control = tcp:127.0.0.1:0
[encoder one]
model = s3684-biss
wire = sim
[encoder two]
model = s3674-biss
wire = sim
"""


def test_time_of_simulated_wires(rig):
    with control_of(rig(SIMULATED)) as control:
        control.refused("TIME:STEP 1 S", -221)  # it runs
        control.do("TIME:SCAL 0")
        before = float(control.ask("TIME?"))
        control.do("SHAF:VEL 60 RPM")
        control.do("TIME:STEP 1500 MS")
        assert float(control.ask("TIME?")) - before == pytest.approx(1.5, abs=1e-8)
        assert float(control.ask("SHAF:POS?")) == pytest.approx(540, abs=1e-5)
        control.do("TIME:SCAL 2")
        assert float(control.ask("TIME?")) >= before + 1.5


def test_faults_end_on_the_way(rig):
    with control_of(rig(SIMULATED)) as control:
        control.do("TIME:SCAL 0")
        control.do("FAULT:SET singleturn_lost,DUR 300 MS")
        control.do("TIME:STEP 200 MS")
        assert "singleturn_lost" in control.ask("FAULT:ACT?")
        control.do("TIME:STEP 10 S")
        assert "singleturn_lost" not in control.ask("FAULT:ACT?")
        control.do("TIME:SCAL 1")
        control.do("FAULT:SET singleturn_lost,DUR 50 MS")
        deadline = time.monotonic() + PATIENCE_S
        while "singleturn_lost" in control.ask("FAULT:ACT?"):
            assert time.monotonic() < deadline


def test_profiles(rig, tmp_path):
    with control_of(rig(SIMULATED + "[encoder three]\nmodel = s3674-biss\nwire = sim\n")) as control:
        control.do("TIME:SCAL 0")
        for turn in range(1, 5):  # more than a shaft can borrow from at once
            motion = tmp_path / f"m{turn}.csv"
            motion.write_text(f"0,0\n1,{360 * turn}\n")
            control.do(f'SHAF:PROF "{motion}"')
            assert str(motion) in control.ask("SHAF:PROF?")
            control.do("TIME:STEP 500 MS")
            assert float(control.ask("SHAF:POS?")) == pytest.approx(180 * turn, abs=1e-5)
        control.refused('SHAF:PROF "fast"', -224)
        control.refused('SHAF:PROF "none.csv"', -256)
        assert float(control.ask("SHAF:POS?")) == pytest.approx(720, abs=1e-5)


def test_courses(rig, tmp_path):
    """Exact while the clock is stepped, whatever the steps are."""
    (tmp_path / "warm.csv").write_text("time_s,temperature\n0,20\n10,85  # degC\n")
    (tmp_path / "led.csv").write_text("0,12000\n1,9000\n2,9000\n")
    with control_of(rig(SIMULATED)) as control:
        control.do("TIME:SCAL 0")
        control.do(f'WORL:TEMP:PROF "{tmp_path}/warm.csv"')
        control.do(f'WORL:LED:CURR:PROF "{tmp_path}/led.csv",LOOP,STEP')
        assert control.ask("STAT?").endswith(",courses=temperature/led_current_ua")
        control.do("WORL:SUPP:PROF:POIN 0,5V,0,4V,3S,1V;:WORL:SUPP:PROF:STAT OFF")
        control.do("TIME:STEP 1234.5 MS")
        assert control.ask("WORL:TEMP?;SUPP?;LED:CURR?") == "28.021;4000;9000"  # of 1.234 s
        control.do("TIME:STEP 5 S")
        assert control.ask("WORL:TEMP?;SUPP?;LED:CURR?") == "60.521;4000;12000"
        assert control.ask("WORL:LED:CURR:PROF?") == f'"{tmp_path}/led.csv,LOOP,STEP"'
        control.do("TIME:STEP 20 S")
        assert control.ask("WORL:TEMP?;TEMP:PROF:STAT?") == "85.000;0"
        assert control.ask("STAT?").endswith(",courses=led_current_ua")
        control.do("WORL:LED:CURR 1000;:TIME:STEP 10 S")
        assert control.ask("WORL:LED:CURR?") == "1000" and control.ask("STAT?").endswith(",courses=-")


def test_courses_of_a_file(rig, tmp_path):
    """They begin with the rig, and lie beside its file."""
    (tmp_path / "led.csv").write_text("0,12000\n0.001,40000\n")
    (tmp_path / "lost.csv").write_text("1,0\n")
    text = SIMULATED + "led_current_ua = led.csv\nsingleturn_ok = lost.csv, LOOP\ntemperature = 50\n"
    with control_of(rig(text)) as control:
        last = control.ask("INST:CAT?").replace('"', "").split(",")[-1]
        control.do(f"INST:SEL {last}")
        assert control.ask("WORL:TEMP?;TEMP:PROF?") == '50.000;""'
        deadline = time.monotonic() + PATIENCE_S
        while control.ask("WORL:SING?;LED:CURR?") != "0;40000":
            assert time.monotonic() < deadline
        assert control.ask("WORL:SING:PROF?").endswith('lost.csv,LOOP"')


@pytest.mark.parametrize("model, wire", [("s3684-rs485", "pty"), ("s3684-biss", "sim"), ("ssi-25", "sim"), ("f3658", "slcan"),
                                         ("f3668", "slcan"), ("ocd-ib-k3", "modbus=127.0.0.1:0")])
def test_courses_of_the_command_line(tmp_path, model, wire):
    """They begin before the encoder is switched on, whatever its protocol."""
    courses = {"temperature": "0,20\n0.01,30\n", "singleturn_ok": "0,1\n0.02,0\n"}
    settings = []
    for key, points in courses.items():
        (tmp_path / f"{key}.csv").write_text(points)
        settings += ["--set", f"{key}={tmp_path}/{key}.csv"]
    encoder = Encoder([model, f"--{wire}", *settings, "--control", f"unix:{tmp_path}/s"])
    with Client(f"unix:{tmp_path}/s") as control:
        deadline = time.monotonic() + PATIENCE_S
        while (seen := control.ask("WORL:TEMP?;SING?")) != "30.000;0":
            assert time.monotonic() < deadline, seen
    assert encoder.clean_up() == []


def test_traces_and_recordings(rig, tmp_path):
    trace, motion = tmp_path / "one.vcd", tmp_path / "motion.csv"
    with control_of(rig(SIMULATED)) as control:
        control.refused(f'TRAC:STAR "{tmp_path}/none/x.vcd"', -257)
        control.do(f'TRAC:STAR "{trace}"')
        control.refused(f'TRAC:STAR "{trace}"', -221)
        control.do(f'SHAF:REC:STAR "{motion}", 10 MS')
        control.refused(f'SHAF:REC:STAR "{motion}", 10 MS', -221)
        control.do("SHAF:POS 90")
        control.ask("BISS:FRAM?")
        control.do("TRAC:STOP")
        control.do("TRAC:STOP")
        control.do("SHAF:REC:STOP")
    assert "$enddefinitions" in trace.read_text()
    assert motion.read_text().splitlines()[0] == "time_s,angle_deg"


def test_biss_only_where_it_is(rig):
    with control_of(rig(BENCH)) as control:
        control.refused("BISS:FRAM?", -241)
        control.do("INST:SEL biss")
        deadline = time.monotonic() + PATIENCE_S
        while int(control.ask("BISS:FRAM?").split(",")[0]) != 2.75 * 2 ** 21:  # initialising
            assert time.monotonic() < deadline


def test_a_simulated_master_prints_positions(start):
    encoder = start("--shaft", "990DEG", model="s3684-biss", wire=["--sim"])
    assert encoder.ready_line == "ready s3684-biss sim:"
    for _ in range(2):
        assert encoder.out.wait().startswith("MT 2  ST 1572864  270.000000 deg  nERR 1  nWARN 1  LC ")
    assert encoder.end() == 0


def test_a_simulated_master_can_be_quiet(start):
    encoder = start("--quiet", model="s3684-biss", wire=["--sim"])
    time.sleep(0.3)
    assert encoder.end() == 0 and encoder.out.so_far() == []


# A file, the exit status, and what the one line says behind the file's name.
BAD = [
    ("[encoder a]\nmodel = f3668\nwire = slcan\nnode = 200\n", 2, ":4: node 200: expected a node-ID in 1..127"),
    ("[encoder a]\nmodel = f3668\nwire = slcan\ncolour = red\n", 2, ":4: .*colour"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty\nserial = 1234567890\n", 2, ":4: .*1 to 9"),
    ("[bus b]\nwire = modbus\ncycle = 1\n[encoder a]\nmodel = ocd-ib-k1\nbus = b\n", 2, ":3: .*cycle"),
    ("[encoder a]\nmodel = ocd-ib-k1\nwire = modbus:nowhere\n", 2, ":3: modbus:nowhere: expected HOST:PORT"),
    ("[encoder a]\nmodel = f3668\nwire = slcan\ntemperature = none.csv\n", 1, ":4: temperature=none.csv: .*none.csv"),
    ("[encoder a]\nmodel = f3668\nwire = slcan\ntemperature = rig.csv,LOP\n", 2,
     r":4: temperature=rig.csv,LOP: 'LOP' .*ONCE.LOOP"),
    ("[encoder a]\nmodel = f3668\nwire = slcan\nserial_number = rig.csv\n", 2, ":4: serial_number: no such key"),
    ("[encoder a]\nmodel = ocd-ib-k1\nwire = modbus\nbattery_mv = rig.csv\n", 2, ":4: battery_mv: no such key"),
    ("[shaft a]\nmotion = none.csv\n[encoder a]\nmodel = f3668\nwire = slcan\n", 1, ":2: motion: .*none.csv"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty\nnvm = none/a.nvm\n", 1, ":4: nvm: .*none/a.nvm"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = tty:/dev/does-not-exist\n", 1, ":3: tty:/dev/does-not-exist: "),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty\ntrace = none/a.vcd\n", 1, ":4: trace: .*none/a.vcd"),
    ("[rig]\ncontrol = unix:none/s\n[encoder a]\nmodel = s3684-rs485\nwire = pty\n", 1, ":2: control: .*none/s"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty\ntrace = a.log\n", 2, ":4: trace: .*ends in .vcd"),
    ("[encoder a]\nmodell = f3668\nwire = slcan\n", 2, ":2: modell: .*expected model = f3668"),
    ("[bus b]\nwire = slcan:/x\n[encoder a]\nmodel = f3668\nbus = b\n", 2,
     ":2: wire: .*wire = slcan and address = /x in a line each"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty:x\n[encoder b]\nmodel = s3684-rs485\nwire = pty:x\n", 2,
     r":6: wire: .*\[bus NAME\] with wire = pty and address = .*x"),
    ("[encoder a]\nmodel = \x1b[31mred\a\n", 2, r":2: model: \?\[31mred\? is unknown"),
    ("[encoder a]\nmodel = f3668\nwire = slcan\n = 5\n", 2, ":4: no key in front of '= 5'; expected KEY = VALUE"),
    ("[shaft a]\nmotion = 90\n[encoder a]\nmodel = f3668\nwire = slcan\n", 2, ":2: motion 90: .*90DEG or 90RPM"),
]


@pytest.mark.parametrize("text, status, said", BAD, ids=[said for _, _, said in BAD])
def test_errors(tmp_path, text, status, said):
    file = tmp_path / "rig.ini"
    file.write_text(text)
    assert re.search(said, run_refused(status, "run", file))


def test_nothing_starts_half(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text("[encoder a]\nmodel = s3684-rs485\nwire = pty:a\n"
                    "[encoder b]\nmodel = s3684-rs485\nwire = tty:/dev/does-not-exist\n")
    run_refused(1, "run", file)
    assert not os.path.lexists(tmp_path / "a")


# What is refused behind encoders with an EEPROM file each: before them, behind them.
LATE = [
    ("", "[encoder z]\nmodel = f3668\nwire = can:nope\n"),
    ("", "[encoder z]\nmodel = s3684-rs485\nwire = tty:/dev/does-not-exist\n"),
    ("", "[encoder z]\nmodel = s3684-rs485\nwire = pty\nnvm = none/z.nvm\n"),
    ("", "[encoder z]\nmodel = s3684-rs485\nwire = pty\ntrace = none/z.vcd\n"),
    ("", "[encoder z]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:{taken}\nnvm = z.nvm\n"),
    ("[rig]\ncontrol = unix:none/s\n", ""),
    ("[rig]\ncontrol = unix:s\ncontrol = tcp:127.0.0.1:{taken}\n", ""),
]
WITH_FILES = """
[encoder a]
model = s3684-rs485
wire = pty:a
nvm = a.nvm
trace = a.vcd
[encoder b]
model = s3684-biss
wire = sim
nvm = b.nvm
[encoder c]
model = f3668
wire = slcan:c
nvm = c.nvm
[encoder d]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
nvm = d.nvm
[encoder e]
model = s3684-rs485
wire = pty:e
nvm = old.nvm
"""


@pytest.mark.parametrize("before, behind", LATE)
def test_a_refused_start_leaves_the_folder_as_it_was(rig, tmp_path, before, behind):
    rig("[encoder e]\nmodel = s3684-rs485\nwire = pty\nnvm = old.nvm\n").end()
    old = (tmp_path / "old.nvm").read_bytes()
    (tmp_path / "rig.ini").touch()
    names = sorted(os.listdir(tmp_path))
    with socket.create_server(("127.0.0.1", 0)) as server:
        text = (before + WITH_FILES + behind).replace("{taken}", str(server.getsockname()[1]))
        (tmp_path / "rig.ini").write_text(text)
        run_refused(1, "run", "rig.ini", cwd=tmp_path)
    assert sorted(os.listdir(tmp_path)) == names
    assert (tmp_path / "old.nvm").read_bytes() == old


def test_no_file(tmp_path):
    assert "none.ini" in run_refused(2, "run", tmp_path / "none.ini")
    assert "none.ini" in run_refused(2, "run", "none.ini", cwd=tmp_path)


@pytest.mark.parametrize("model, wire", [("s3684-rs485", "pty"), ("s3684-biss", "sim"), ("f3668", "slcan"),
                                         ("ocd-ib-k3", "modbus:127.0.0.1:0")])
def test_a_foreign_eeprom_file_is_named_by_its_key(tmp_path, model, wire):
    foreign = tmp_path / "foreign"
    foreign.write_bytes(bytes(1278))  # as long as that of the ring
    rig = tmp_path / "rig.ini"
    rig.write_text(f"[encoder a]\nmodel = {model}\nwire = {wire}\nnvm = foreign\n")
    assert re.search(r"^drehgeber: \S*rig\.ini:4: nvm: \S*foreign: ", run_refused(1, "run", rig))
    kind, _, address = wire.partition(":")
    option = f"--{kind}={address}" if address else f"--{kind}"
    assert re.search(r"^drehgeber: --nvm \S*foreign: ", run_refused(1, "run", model, option, "--nvm", foreign))


def test_figures_that_make_no_encoder_are_no_error_of_the_file(tmp_path):
    said = run_refused(1, "run", "ocd-ib-k3", "--modbus", "127.0.0.1:0", "--nvm", tmp_path / "new",
                       "--set", "steps=1", "--set", "steps_minus_one=1")
    assert said.startswith("drehgeber: device 0: these factory figures make no encoder; ")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("option", [["--set", "pace=0"], ["--pty"], ["--shaft", "60RPM"],
                                    ["--nvm", "x"], ["--node", "5"], ["--trace", "x.vcd"]],
                         ids=lambda option: option[0])
def test_options_of_an_encoder_are_refused(tmp_path, option):
    file = tmp_path / "rig.ini"
    file.write_text("[encoder a]\nmodel = s3684-rs485\nwire = pty\n")
    assert option[0] in run_refused(2, "run", file, *option)


def test_closed_stdout(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text("[encoder a]\nmodel = s3684-rs485\nwire = pty:a\n")
    ended = subprocess.run(["sh", "-c", 'exec "$0" run "$1" >&-', PROGRAM, str(file)], text=True,
                           stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=PATIENCE_S)
    assert ended.returncode == 1 and len(ended.stderr.splitlines()) == 1, ended.stderr
    assert not os.path.lexists(tmp_path / "a")
