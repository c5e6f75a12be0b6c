# SPDX-License-Identifier: MIT
"""Trace files as the tools of the field read them: GTKWave, sigrok, Wireshark, can-utils."""
import csv
import functools
import itertools
import math
import operator
import os
import random
import re
import subprocess
import time

import pytest

from rig import REPOSITORY, Client
from vcd import signals_of

MAKE_TRACES = os.environ["MAKE_TRACES"]
PROGRAM = os.environ["DREHGEBER"]
PARITIES = {"N": "none", "E": "even", "O": "odd"}
BIT_NS = 1e9
SILENCE_NS = 10_000_000


def run(*command, **options):
    """What a tool prints; it must succeed, within a time."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


def trace(path, stack, events, wire="vcan0"):
    run(MAKE_TRACES, stack, wire, str(path), input="".join(line + "\n" for line in events))
    return str(path)


def frame_of(*data):
    """An RS485 frame with its check sum."""
    return bytes([*data, functools.reduce(operator.xor, data)])


def characters(frames, baud, parity, damaged=()):
    """Events of frames (ours, bytes), one after the other; `damaged` are (frame, character)."""
    bits = 10 if parity == "N" else 11
    at = 0.0
    for number, (ours, frame) in enumerate(frames):
        at += SILENCE_NS + 60 * BIT_NS / baud
        for place, byte in enumerate(frame):
            at += bits * BIT_NS / baud
            bad = int((number, place) in damaged)
            yield f"c {at:.0f} {ours} {baud} {parity} {byte:02X} {bad}"


def sigrok_uart(path, baud, parity):
    """Bytes that sigrok's UART decoder finds, and its complaints."""
    decoder = f"uart:rx=request:tx=reply:baudrate={baud}:parity={PARITIES[parity]}"
    rows = "uart=rx-data:tx-data:rx-parity-err:tx-parity-err:rx-warnings:tx-warnings"
    command = ["sigrok-cli", "-i", path, "-I", "vcd", "-P", decoder, "-A", rows]
    lines = [line.partition(": ")[2] for line in run(*command).splitlines()]
    data = [line for line in lines if re.fullmatch("[0-9A-F]{2}", line)]
    return bytes(int(line, 16) for line in data), [line for line in lines if line not in data]


def texts_of(path):
    """The texts of a VCD file, as GTKWave's converters have read and written them."""
    fst = path + ".fst"
    run("vcd2fst", path, fst)
    dump = run("fst2vcd", fst)
    (name,) = re.findall(r"\$var string \d+ (\S+) text \$end", dump)
    return re.findall(rf"^s(\S+) {re.escape(name)}$", dump, re.M), dump


POSITION = [(0, frame_of(0x40, 0x42)), (1, frame_of(0x40, 0x42, 0, 0, 0x30, 0x39))]


@pytest.mark.parametrize("baud, parity", [(9600, "E"), (38400, "N"), (19200, "O")])
def test_rs485_bytes_are_what_sigrok_decodes(tmp_path, baud, parity):
    drawn = random.Random(baud)
    frames = POSITION + [(i % 2, frame_of(*drawn.randbytes(12))) for i in range(4)]
    path = trace(tmp_path / "line.vcd", "rs485", characters(frames, baud, parity))
    found, errors = sigrok_uart(path, baud, parity)
    assert found == b"".join(frame for _ours, frame in frames)
    assert errors == []


@pytest.mark.parametrize("parity, complaint", [("E", "Parity error"), ("N", "Frame error")])
def test_rs485_damage_is_what_sigrok_complains_about(tmp_path, parity, complaint):
    path = trace(
        tmp_path / "line.vcd", "rs485", characters(POSITION, 9600, parity, damaged={(1, 2)})
    )
    found, errors = sigrok_uart(path, 9600, parity)
    assert len(errors) == 1 and complaint in errors[0]
    # What has a parity error is shown all the same.
    assert len(found) >= len(b"".join(frame for _ours, frame in POSITION)) - 1


def test_rs485_in_gtkwave(tmp_path):
    events = [*characters(POSITION, 9600, "E"), "n 90000000 1 encoder a1: power off"]
    texts, dump = texts_of(trace(tmp_path / "line.vcd", "rs485", events, wire="/tmp/enc"))
    assert texts == [
        "40h_42h_read_position",
        "40h_->_42h_position_12345",
        "encoder_a1:_power_off",
    ]
    assert "$scope module rs485 $end" in dump
    assert " request $end" in dump and " reply $end" in dump


def test_two_seconds_of_rs485_in_sigrok_as_they_are(tmp_path):
    """No option makes it faster: the file's steps are those of the line. Who talks is seen."""
    frames = POSITION * 40
    path = trace(tmp_path / "line.vcd", "rs485", characters(frames, 9600, "E"))
    assert int(re.findall(r"^#(\d+)$", open(path, encoding="ascii").read(), re.M)[-1]) > 1_300_000
    for signal, ours in (("request", 0), ("reply", 1)):
        decoder = f"uart:rx={signal}:baudrate=9600:parity=even"
        before = time.monotonic()
        lines = run("sigrok-cli", "-i", path, "-P", decoder, "-A", "uart=rx-data").splitlines()
        assert time.monotonic() - before < 5  # 20 s with steps of 1 ns
        wanted = b"".join(frame for who, frame in frames if who == ours)
        assert bytes(int(line.split()[1], 16) for line in lines) == wanted


@pytest.mark.parametrize("name, command", [
    ("rs485", None), ("biss", ["biss", "s3684-biss", "read"]),
    ("ssi", ["ssi", "ssi-25", "read"]),
])
def test_gtkwave_setups_name_what_is_in_traces(tmp_path, start, name, command):
    path = tmp_path / "trace.vcd"
    if command is None:
        assert start("--trace", path).end() == 0
    else:
        run(PROGRAM, *command, "--trace", str(path))
    scopes, found = [], set()
    for word, *rest in re.findall(r"^\$(scope|upscope|var)(?: \S+ (\S+))?(?: \S+ (\S+) \$end)?", path.read_text(), re.M):
        if word == "scope":
            scopes.append(rest[0])
        elif word == "upscope":
            scopes.pop()
        else:
            found.add(".".join([*scopes, rest[1]]))
    setup = (REPOSITORY / f"tools/gtkwave/{name}.gtkw").read_text()
    assert {line for line in setup.splitlines() if line[0] not in "[@"} == found


def phases(signals):
    """Of the sine, in periods: (ns, 0..1), from the voltages between the lines."""
    for samples in zip(*(signals[f"{name}_{line}"] for name in ("sin", "cos")
                         for line in ("plus", "minus"))):
        assert len({at for at, _volts in samples}) == 1
        plus, minus, cos_plus, cos_minus = (volts for _at, volts in samples)
        yield samples[0][0], math.atan2(plus - minus, cos_plus - cos_minus) / math.tau % 1


def test_rs485_sine_and_cosine_agree_with_42h(start, tmp_path):
    """At 6 rpm a period takes 4.9 ms; the position is latched at the reply's first edge."""
    path = tmp_path / "line.vcd"
    encoder = start("--shaft", "6RPM", "--set", "sincos_us=50", "--trace", path)
    master = encoder.master()
    asked = 20
    positions = [master.read_position() for _ in range(asked)]
    assert encoder.end() == 0
    found, errors = sigrok_uart(str(path), 9600, "E")
    assert (len(found), errors) == (10 * asked, [])
    _texts, dump = texts_of(str(path))
    signals = signals_of(dump)
    # A transaction is 10 characters; the reply begins with the fourth.
    edges, free = [], 0
    for at, level in sorted(signals["request"] + signals["reply"]):
        if level == 0 and at >= free:
            edges.append(at)
            free = at + 10.5 * BIT_NS / 9600
    assert len(edges) == 10 * asked
    samples = list(phases(signals))
    spacing = {later - earlier for (earlier, _), (later, _) in itertools.pairwise(samples[1:])}
    assert min(spacing) == 50_000
    for latched, position in zip(edges[3::10], positions):
        _at, phase = min(samples, key=lambda sample: abs(sample[0] - latched))
        step = position % 32 / 32
        # 25 us are 0.005 periods, a step is 0.031.
        assert (phase - step + 0.01) % 1 < 0.055, (latched, position, phase)


def test_rs485_sine_and_cosine_at_rest_are_told_once(start, tmp_path):
    path = tmp_path / "line.vcd"
    encoder = start("--control", "tcp:127.0.0.1:0", "--files", tmp_path, "--shaft", "0.25REV")
    with Client(int(encoder.out.wait().rsplit(":", 1)[1])) as client:
        client.do(f'TRAC:STAR "{path}"')
        time.sleep(0.3)
        client.do("WORL:AMPL:COS 500")
        time.sleep(0.1)
        client.do("POW OFF")
        time.sleep(0.1)
        client.do("TRAC:STOP")
    signals = signals_of(path.read_text())
    assert [volts for _at, volts in signals["cos_plus"]] == [2.75, 2.625, 0]
    assert [volts for _at, volts in signals["sin_minus"]] == [2.5, 2.5, 0]


def biss_events():
    """Clocks of 1 us: SLO acknowledges, starts, and sends 1010."""
    at = 1000
    for slo in (1, 1, 0, 1, 1, 0, 1, 0):
        yield f"l {at} 0 {slo}"
        yield f"l {at + 500} 1 {slo}"
        at += 1000
    yield "n 1000 1 position 10"


def test_biss_in_gtkwave_and_sigrok(tmp_path):
    path = trace(tmp_path / "biss.vcd", "biss", biss_events())
    texts, _dump = texts_of(path)
    assert texts == ["position_10"]
    shown = run("sigrok-cli", "-i", path, "--show")
    assert "Samplerate: 100000000\n" in shown
    assert re.findall(r"^- (\w+): logic", shown, re.M) == ["MA", "SLO"]
    samples = run("sigrok-cli", "-i", path, "-O", "csv:header=false:label=off")
    rows = [line for line in samples.split("\n") if re.fullmatch(r"[01],[01]", line)]
    ma = [row[0] for row in rows]
    rising = [i for i in range(1, len(ma)) if ma[i - 1] + ma[i] == "01"]
    assert "".join(rows[i][2] for i in rising) == "11011010"


def test_biss_at_10_mhz_in_sigrok(tmp_path):
    """A real trace at full speed, with a cable of 40 m: the idle line in front is short, and sigrok's
    samples of 10 ns have every clock of 100 ns."""
    path = str(tmp_path / "cable.vcd")
    run(PROGRAM, "biss", "s3674-biss", "read", "--trace", path, "--set", "clock_hz=10000000",
        "--set", "line_delay_ns=200")
    samples = run("sigrok-cli", "-i", path, "-O", "csv:header=false:label=off")
    rows = [line for line in samples.split("\n") if re.fullmatch(r"[01],[01]", line)]
    ma, slo = ("".join(row[column] for row in rows) for column in (0, 2))
    first = ma.index("0")
    assert first < 500
    rising = [i for i in range(1, len(ma)) if ma[i - 1:i + 1] == "01"]
    assert len(rising) >= 39
    assert {after - before for before, after in zip(rising, rising[1:])} == {10}
    assert slo.index("10", rising[0]) + 1 - rising[1] == 40  # Ack


# (at ns, ours, id, rtr, data)
CAN = [
    (1_000_000, 0, 0x000, 0, bytes.fromhex("0105")),
    (2_000_001, 0, 0x080, 0, b""),
    (3_000_002, 1, 0x185, 0, bytes.fromhex("39300000")),
    (4_000_000, 0, 0x605, 0, bytes.fromhex("4004600000000000")),
    (5_000_000, 1, 0x585, 0, bytes.fromhex("4304600039300000")),
    (6_000_000, 1, 0x085, 0, bytes.fromhex("1081110000000000")),
    (7_000_000, 0, 0x705, 1, bytes(1)),
    (8_000_000, 1, 0x705, 0, bytes.fromhex("05")),
    (9_123_456_789, 0, 0x7E5, 0, bytes.fromhex("0401000000000000")),
]


def can_events():
    for at, ours, can_id, rtr, data in CAN:
        yield f"f {at} {ours} {can_id:X} {rtr} {len(data)} {data.hex(' ')}"


def tshark(path, *fields):
    """Values of fields, a row for each packet."""
    arguments = [argument for field in fields for argument in ("-e", field)]
    command = ("tshark", "-r", path, "-d", "can.subdissector,canopen", "-T", "fields")
    lines = run(*command, "-E", "separator=;", *arguments).split("\n")
    return [line.split(";") for line in lines if line]


@pytest.mark.parametrize("ending", ["pcapng", "pcap"])
def test_can_frames_in_wireshark(tmp_path, ending):
    before = time.time()
    path = trace(tmp_path / f"can.{ending}", "can", can_events())
    after = time.time()
    rows = tshark(path, "frame.time_epoch", "frame.interface_name", "frame.packet_flags_direction",
                  "can.id", "can.len", "can.flags.rtr")
    assert len(rows) == len(CAN)
    epochs = [float(row[0]) for row in rows]
    for row, epoch, (at, ours, can_id, rtr, data) in zip(rows, epochs, CAN):
        assert before - 0.001 <= epoch - at / 1e9 <= after + 0.001
        assert row[1] == "vcan0"
        assert int(row[2], 0) == (2 if ours else 1)
        assert (int(row[3], 0), int(row[4]), row[5]) == (can_id, len(data), str(rtr))
    nanoseconds = [int(row[0].replace(".", "")) for row in rows]
    assert nanoseconds[-1] - nanoseconds[0] == CAN[-1][0] - CAN[0][0]
    assert "SocketCAN" in run("capinfos", "-E", path)


def test_canopen_in_wireshark(tmp_path):
    path = trace(tmp_path / "can.pcapng", "can", can_events())
    rows = tshark(path, "canopen.node_id", "canopen.nmt_ctrl.cd", "canopen.pdo.data.bytes",
                  "canopen.sdo.main_idx", "canopen.em.err_code", "canopen.nmt_guard.state",
                  "canopen.lss.cs")
    assert int(rows[0][1], 0) == 1
    assert (int(rows[2][0], 0), rows[2][2].replace(":", "")) == (5, "39300000")
    assert int(rows[3][3], 0) == int(rows[4][3], 0) == 0x6004
    assert int(rows[5][4], 0) == 0x8110
    assert int(rows[7][5], 0) == 5
    assert int(rows[8][6], 0) == 4


def test_can_log_in_can_utils(tmp_path):
    path = trace(tmp_path / "can.log", "can", can_events())
    lines = open(path, encoding="ascii").read().split("\n")
    expected = ["%03X#%s" % (can_id, f"R{len(data)}" if rtr else data.hex().upper())
                for _at, _ours, can_id, rtr, data in CAN]
    found = [re.fullmatch(r"\((\d{10}\.\d{6})\) vcan0 (\S+)", line) for line in lines[:-1]]
    assert [match.group(2) for match in found] == expected
    asc = run("log2asc", "-I", path, "vcan0")
    rows = [line.split() for line in asc.split("\n") if re.search(r"\bRx\b", line)]
    assert len(rows) == len(CAN)
    for row, (at, _ours, can_id, rtr, data) in zip(rows, CAN):
        assert float(row[0]) * 1e9 == pytest.approx(at - CAN[0][0], abs=2000)
        assert int(row[2], 16) == can_id
        assert row[4:6] == ["r" if rtr else "d", str(len(data))]
        assert rtr or bytes.fromhex("".join(row[6:6 + len(data)])) == data


def test_interbus_rows(tmp_path):
    events = [
        "w 1000000 1 3 1 2 3 A B C",
        "w 2000000 1 3 1 2 3 A B C",
        "w 3000000 1 3 1 2 FFFF A B C",
        "n 3500000 0 ID cycle",
        "w 4000000 0 3 1 2 FFFF A B C",
        "w 1005000000 1 3 1 2 FFFF A B 8000",
    ]
    path = trace(tmp_path / "ring.csv", "interbus", events)
    with open(path, encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "in_0", "in_1", "in_2", "out_0", "out_1", "out_2", "valid"]
    assert [float(row["time_s"]) for row in rows] == [0.001, 0.003, 0.004, 1.005]
    assert [int(row["in_2"], 16) for row in rows] == [3, 0xFFFF, 0xFFFF, 0xFFFF]
    assert [int(row["out_2"], 16) for row in rows] == [0xC, 0xC, 0xC, 0x8000]
    assert [row["valid"] for row in rows] == ["1", "1", "0", "1"]
