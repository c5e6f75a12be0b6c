# SPDX-License-Identifier: MIT
"""The command with two protocols that nobody has heard of (tests/strangers), beside an S36 and an SSI encoder: on wires,
in traces, by SCPI, on panels. Each is served, or refused by name, and none is taken for another one."""
import json
import re
import socket
import sys
import time
from pathlib import Path

import pytest
import serial

sys.path.insert(0, str(Path(__file__).parents[1]))
from rig import PATIENCE_S, PROGRAM, Client, Rigs, run, run_refused  # noqa: E402
from test_top import Panel  # noqa: E402
from vcd import signals_of  # noqa: E402

ELEVEN, TENBIT = "eleven-24", "tenbit-low"
BAUD = 2_500_000
QUARTER = bytes.fromhex("02 00 00 40 00 00 00 00 00 00 42")
SLOT_3, QUARTER_3 = b"\x1a", bytes.fromhex("1a 00 00 40 00 00 00 00 00 00 5a")
S36_REQUEST, S36_QUARTER = bytes.fromhex("40 42 02"), bytes.fromhex("40 42 00 00 40 00 42")
MIXED = """[rig]
control = unix:rig.sock
[shaft main]
motion = 90DEG
[bus line]
wire = pty
address = line
{trace}
[encoder s36]
model = s3684-rs485
bus = line
[encoder one]
model = eleven-24
bus = line
[encoder other]
model = eleven-24
bus = line
slot = 3
[encoder ssi]
model = ssi-25
wire = sim
[encoder ten]
model = tenbit-low
wire = sim
"""


@pytest.fixture
def rigs(tmp_path):
    """Rigs of a test, each ended; nothing unasked was said."""
    ours = Rigs(tmp_path)
    yield ours
    assert ours.end() == []


@pytest.fixture
def rig(rigs):
    return rigs.begin(MIXED.format(trace=""))


def ask(path, request: bytes, baud: int = BAUD, parity: str = "N", count: int = 11,
        timeout: float = PATIENCE_S) -> bytes:
    with serial.Serial(str(path), baud, parity=parity, timeout=timeout) as port:
        time.sleep(0.02)  # silence, which ends what an S36 has heard so far
        port.write(request)
        return port.read(count)


def state(client, name: str) -> dict:
    row = client.ask(f"INST:SEL {name};:STAT?")
    return dict(word.split("=", 1) for word in row.strip('"').split(",") if "=" in word)


def test_they_are_listed():
    rows = {row["model"]: row for row in json.loads(run("list", "--json").stdout)}
    assert rows[ELEVEN]["speaks"] == "eleven characters" and rows[TENBIT]["speaks"] == "words of ten bits"
    assert {ELEVEN, TENBIT, "tenbit-high"} <= {line.split()[0] for line in run("list").stdout.splitlines()}
    own = run("run", ELEVEN, "--help").stdout
    assert "reaction_us" in own and "cycle" not in own and "--pty" in own and "--sim" not in own


def test_faults_are_told():
    names = [row["name"] for row in json.loads(run("faults", ELEVEN, "--json").stdout)]
    assert names == ["singleturn_lost", "wire_drop", "wire_deaf", "wire_delay", "wire_damage"]


@pytest.mark.parametrize(("words", "told"), [
    (("ssi", TENBIT), "an SSI model"), (("biss", TENBIT), "a BiSS model"), (("eds", ELEVEN), "a CANopen model"),
    (("map", TENBIT), "an INTERBUS model"),
    (("run", ELEVEN, "--sim"), ELEVEN), (("run", TENBIT, "--pty"), TENBIT), (("run", ELEVEN, "--node", "3"), ELEVEN),
    (("run", TENBIT, "--gpio=gpiochip0:1,2"), TENBIT), (("run", ELEVEN, "--slcan"), ELEVEN),
    (("run", TENBIT, "--nvm", "a.nvm"), TENBIT), (("run", ELEVEN, "--nvm", "a.nvm"), ELEVEN),
    (("run", ELEVEN, "--serial", "1"), ELEVEN),
    (("run", ELEVEN, "--trace", "a.log"), "eleven characters"), (("run", TENBIT, "--trace", "a.csv"), "ten bits"),
])
def test_what_it_is_not_is_refused_by_name(words, told, tmp_path):
    ended = run(*words, cwd=tmp_path)
    assert ended.returncode in (1, 2) and ended.stdout == ""
    lines = ended.stderr.splitlines()
    assert len(lines) == 1 and told in lines[0], lines


@pytest.mark.parametrize(("section", "told"), [
    ("[encoder a]\nmodel = eleven-24\nwire = pty\naddress = 0x41\n", "address: eleven-24 has none; expected slot = N"),
    ("[encoder a]\nmodel = s3684-rs485\nwire = pty\nslot = 1\n", "slot: s3684-rs485 has none; expected address = N"),
    ("[encoder a]\nmodel = tenbit-low\nwire = sim\nslot = 1\n", "slot: tenbit-low has none; "),
    ("[encoder a]\nmodel = eleven-24\nwire = pty\nslot = 16\n", "slot 16: expected a slot in 0..15"),
    ("[bus b]\nwire = pty\n[encoder a]\nmodel = eleven-24\nbus = b\n[encoder c]\nmodel = eleven-24\nbus = b\n",
     "slot: as delivered 0 is slot of [encoder a] already"),
    ("[bus b]\nwire = sim\n[encoder a]\nmodel = ssi-25\nbus = b\n[encoder c]\nmodel = tenbit-low\nbus = b\n",
     "b has encoders of another protocol"),
    ("[bus b]\nwire = tty:/dev/ttyS9\n[encoder a]\nmodel = s3684-rs485\nbus = b\n[encoder c]\nmodel = eleven-24\nbus = b\n",
     "b has encoders of another protocol"),
])
def test_a_rig_file_is_refused_by_name(section, told, tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text(section.replace("wire = tty:/dev/ttyS9", "wire = tty\naddress = /dev/ttyS9"))
    line = run_refused(2, "run", file)
    assert told in line, line


def test_several_slots_are_a_section(rigs, tmp_path):
    rigs.begin("[rig]\n[shaft main]\nmotion = 90DEG\n[bus line]\nwire = pty\naddress = line\n"
               "[encoder e]\nmodel = eleven-24\nbus = line\nslot = 2..4\n")
    assert ask(tmp_path / "line", SLOT_3) == QUARTER_3


def test_each_answers_its_own_requests(rig, tmp_path):
    line = tmp_path / "line"
    assert ask(line, b"\x02") == QUARTER
    assert ask(line, SLOT_3) == QUARTER_3
    assert ask(line, S36_REQUEST, 9600, "E", 7) == S36_QUARTER
    assert ask(line, b"\x8a", timeout=0.1) == b""
    client = rig.client()
    deadline = time.monotonic() + PATIENCE_S
    while int(state(client, "other")["strange"]) < 1 + 11 + 1:  # nobody has answered the last one, heard or not
        assert time.monotonic() < deadline
    one, other, s36 = (state(client, name) for name in ("one", "other", "s36"))
    assert (one["frames"], other["frames"]) == ("1", "1")
    assert int(one["damaged"]) >= len(S36_REQUEST + S36_QUARTER)  # what the S36 and its master have said
    assert int(other["strange"]) == 1 + 11 + 1  # a request and a reply for slot 0, one for slot 1
    assert s36["frames"] == "1" and int(s36["damaged"]) > 0, s36
    assert one["wire_baud"] == str(BAUD) and s36["wire_baud"] == "9600"
    assert one["wire_collided"] == "0"


def test_scpi_knows_them(rig, tmp_path):
    client = rig.client()
    line = tmp_path / "line"
    client.do("INST:SEL one")
    assert state(client, "one")["position"] == str(1 << 22)
    client.do("FAUL:SET singleturn_lost")
    assert ask(line, b"\x02")[4] == 1
    assert state(client, "one")["errors"] == "01"
    client.do("FAUL:CLE;:WORL:SING OFF")
    assert ask(line, b"\x02")[4] == 1
    client.do("WORL:SING ON;:FAUL:SET wire_drop,COUN 1")
    assert ask(line, b"\x02", timeout=0.1) == b""
    assert ask(line, b"\x02") == QUARTER
    client.do("POW OFF")
    assert ask(line, b"\x02", timeout=0.1) == b""
    assert ask(line, SLOT_3) == QUARTER_3
    client.do("POW ON;:INST:SEL ten;:FAUL:SET wire_break")
    ten = state(client, "ten")
    assert (ten["power"], ten["position"]) == ("1", "256")
    client.send("SSI:FRAM?")
    assert "ten: it is no SSI encoder" in client.ask("SYST:ERR?")
    client.send("BISS:REG? 0")
    assert "ten: it is no BiSS encoder" in client.ask("SYST:ERR?")


def test_a_wire_of_its_own_is_told_in_its_words(start, tmp_path):
    one = start("--verbose", "--shaft", "90DEG", model=ELEVEN)
    assert ask(one.path, b"\x02") == QUARTER
    assert one.errors.wait().endswith(" < request 02h")
    assert one.errors.wait().endswith(" > 02h -> position 4194304")
    ten = start("--sim", "--verbose", "--shaft", "90DEG", model=TENBIT, wire=[])
    assert ten.errors.wait().endswith(" > word 256")
    ten.end()
    ten.errors.so_far()


def test_a_mixed_wire_is_not_told_in_the_words_of_one(rig, tmp_path):
    client = rig.client()
    client.do("INST:SEL s36")
    assert client.ask("TRAC:LAST? 3").endswith('several protocols: the data on this wire is not shown in words"')
    assert ask(tmp_path / "line", b"\x02") == QUARTER
    assert client.ask("TRAC:LAST? 3").count('"') == 2
    client.do("INST:SEL ten")
    client.ask("TRAC:LAST?")
    deadline = time.monotonic() + 5
    while "word 256" not in (told := client.ask("TRAC:LAST?")):
        assert time.monotonic() < deadline, told


def bytes_of(changes: list, baud: int) -> bytes:
    """The characters of a line without parity."""
    bit, found, free = 1e9 / baud, bytearray(), 0
    level = lambda at: [value for moment, value in changes if moment <= at][-1]  # noqa: E731
    for at, value in changes:
        if value == 0 and at >= free:
            found.append(sum(level(at + (i + 1.5) * bit) << i for i in range(8)))
            free = at + 9.5 * bit
    return bytes(found)


@pytest.mark.parametrize("mixed", [False, True])
def test_a_trace_has_its_bits(rigs, start, tmp_path, mixed):
    if mixed:
        one = rigs.begin(MIXED.format(trace="trace = a.vcd"))
        path = tmp_path / "line"
    else:
        one = start("--trace", tmp_path / "a.vcd", "--shaft", "90DEG", model=ELEVEN)
        path = one.path
    assert ask(path, b"\x02") == QUARTER
    assert one.end() == 0
    dump = (tmp_path / "a.vcd").read_text()
    signals = signals_of(dump)
    assert bytes_of(signals["request"], BAUD) == b"\x02"
    assert bytes_of(signals["reply"], BAUD) == QUARTER
    assert ("request_02h" in dump) is not mixed and "damaged" not in dump


def test_a_clocked_trace_has_its_word(start, tmp_path):
    one = start("--sim", "--trace", tmp_path / "a.vcd", "--shaft", "90DEG", model=TENBIT, wire=[])
    time.sleep(0.5)
    assert one.end() == 0
    dump = (tmp_path / "a.vcd").read_text()
    assert "word_256" in dump and {"CLOCK", "DATA"} <= set(signals_of(dump))


def test_a_wire_that_nobody_has_heard_of(rigs):
    """CAN in UDP datagrams: encoders, an SDO, what is wrong with an address, the port in the ready line."""
    own = run("run", "f3668", "--help").stdout
    assert "--udp" in own and "--udp" not in run("run", ELEVEN, "--help").stdout
    assert "--udp is no wire of eleven-24" in run_refused(2, "run", ELEVEN, "--udp=127.0.0.1:0")
    assert "expected HOST:PORT" in run_refused(1, "run", "f3668", "--udp=nowhere")
    ours = rigs.begin("[rig]\n[shaft main]\nmotion = 90DEG\n[bus b]\nwire = udp\naddress = 127.0.0.1:0\n"
                      "[encoder a]\nmodel = f3668\nbus = b\nnode = 5..6\n")
    ready = re.fullmatch(r"ready f3668 udp:127\.0\.0\.1:(\d+)/5 \S+", ours.ready_line)
    assert ready, ours.ready_line
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.settimeout(PATIENCE_S)
        line.connect(("127.0.0.1", int(ready[1])))
        for node in (5, 6):
            line.send(bytes([0x06, node, 8]) + bytes.fromhex("4004600000000000"))
            assert line.recv(64) == bytes([0x05, 0x80 + node, 8]) + bytes.fromhex("4304600000400000")


def test_top_shows_them(rig, tmp_path):
    panel = Panel(f"{PROGRAM} top unix:{tmp_path}/rig.sock")
    try:
        panel.wait(r"one +eleven-24", r"ten +tenbit-low", r"s36 +s3684-rs485")
    finally:
        panel.close()


def test_a_panel_asks_what_a_client_can_ask(rig):
    """drehgeber web only carries SCPI: what its page asks at first is answered for each encoder."""
    with Client(rig.controls[0]) as client:
        for name in client.ask("INST:CAT?").replace('"', "").split(","):
            client.do(f"INST:SEL {name}")
            for question in ("INST:SEL?", "INST:MOD?", "INST:WIRE?", "STAT?", "FAUL:ACT?", "FAUL:CAT?"):
                assert client.ask(question) != "", (name, question)
            assert client.ask("SYST:ERR?").startswith("0,")
