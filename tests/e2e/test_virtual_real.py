# SPDX-License-Identifier: MIT
"""A rig in real time, on a pty, says what it says in virtual time: the same bytes in the same order, and each of
them as much later as this machine wakes up late. The same master leads both."""
import os
import re
import select
import statistics
import subprocess
import time
import tty
from functools import reduce
from operator import xor

import pytest

from rig import PATIENCE_S, Rigs
from vcd import signals_of

VIRTUAL_MASTER = os.environ["VIRTUAL_MASTER"]
MS = 1_000_000
RESOLUTION_NS = 2_000  # traces have microseconds
# A rig counts what it does more than 5 ms late, and calls of more than 10 ms (platform/linux, "Choices"):
# what it has not counted is not later than both.
LATE_NS = 15 * MS
# Half of all moments, also on a machine that stood still now and then: its timers are good for 0.1 ms.
USUALLY_LATE_NS = 1 * MS

RIG = """
[rig]
control = unix:{folder}/s
[bus wire]
wire = {wire}
trace = trace.{suffix}
[shaft motor]
motion = 30DEG
[encoder a]
model = {models[0]}
bus = wire
shaft = motor
{own[0]}
[encoder b]
model = {models[1]}
bus = wire
shaft = motor
{own[1]}
"""


class Virtual:
    """A rig in virtual time, and its master, in a process of their own."""

    def __init__(self, file):
        self.heard = b""
        self.process = subprocess.Popen([VIRTUAL_MASTER, file], text=True, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE)

    def _lead(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        self.heard += bytes.fromhex(self.process.stdout.readline())

    def say(self, data: bytes):
        self._lead(f"say {data.hex().upper()}")

    def hear(self, count: int):
        self._lead(f"hear {count} {int(PATIENCE_S * 1e9)}")

    def pause(self, span_ms: int):
        self._lead(f"pass {span_ms * MS}")

    def order(self, *lines: str):
        for line in lines:
            self._lead(f"order {line}")

    def end(self):
        self.process.stdin.close()
        assert self.process.wait(PATIENCE_S) == 0
        self.process.stdout.close()


class Real:
    """The command, a master at its pty, and a client of its control plane."""

    def __init__(self, rig):
        self.rig, self.client = rig, rig.client()
        self.heard = b""
        self.line = os.open(re.search(r"/dev/pts/\d+", rig.ready_line)[0], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.line)

    def say(self, data: bytes):
        assert os.write(self.line, data) == len(data)

    def _hear_until(self, end: float, count: int) -> int:
        """So many bytes, or all there are before `end`. @return how many are missing"""
        while count > 0 and select.select([self.line], [], [], max(0.0, end - time.monotonic()))[0]:
            data = os.read(self.line, count)
            self.heard += data
            count -= len(data)
        return count

    def hear(self, count: int):
        assert self._hear_until(time.monotonic() + PATIENCE_S, count) == 0, self.heard

    def pause(self, span_ms: int):
        self._hear_until(time.monotonic() + span_ms / 1000, 65536)

    def order(self, *lines: str):
        for line in lines:
            self.client.do(line)

    def end(self):
        """@return what the rig itself has counted as late"""
        state = dict(part.split("=", 1) for part in self.client.ask("STAT?").split(","))
        os.close(self.line)
        assert self.rig.end() == 0
        return int(state["wire_late"])


# --- RS485 ---


def request(text: str) -> bytes:
    data = bytes.fromhex(text)
    return data + bytes([reduce(xor, data)])


def talk_on_a_line(master):
    """Both encoders, and what the manual says of 42h, 44h, 46h, 50h, 56h; then what goes wrong."""
    def ask(text, length):
        master.say(request(text))
        if length:
            master.hear(length)
        master.pause(20 if length else 60)

    master.pause(300)  # the start-up window
    for text, length in (("4042", 7), ("4142", 7), ("404448", 6), ("4156", 40), ("4046", 6), ("414400", 4), ("4050", 4),
                         ("4099", 4), ("4250", 0)):
        ask(text, length)
    master.order("INST:SEL a", "FAUL:SET wire_delay,COUN,1")
    ask("4042", 7)
    master.order("FAUL:SET wire_drop,COUN,1")
    ask("4042", 0)
    ask("4042", 7)
    master.order("FAUL:SET wire_duplicate,COUN,1", "SHAF:POS 75DEG")
    ask("4042", 14)
    master.order("INST:SEL b", "FAUL:SET wire_damage,COUN,1", "FAUL:SET temperature_high")
    ask("4142", 7)
    ask("4142", 7)
    master.order("POW OFF")
    ask("4142", 0)
    ask("4042", 7)
    master.order("POW ON")
    ask("4142", 7)
    master.pause(300)


def characters_of(changes: list):
    """What a receiver at 9600 Bd, 8E1, finds on a line that is idle first: (ns of the start bit, byte)."""
    free = 0
    bit = 1e9 / 9600
    for number, (at, level) in enumerate(changes):
        if level == 0 and at >= free:
            later = changes[number:]
            bits = [[is_ for when, is_ in later if when <= at + (1.5 + place) * bit][-1] for place in range(8)]
            free = at + 10.5 * bit
            yield at, sum(is_ << place for place, is_ in enumerate(bits))


def line_events(text: str):
    signals = signals_of(text)
    return sorted((at, name, byte) for name in ("request", "reply") for at, byte in characters_of(signals[name]))


# --- CAN over SLCAN ---

ACKNOWLEDGED = 2  # "z" and a carriage return


def sizes(*counts: int) -> int:
    """Characters of frames with so many bytes."""
    return sum(len("t0000\r") + 2 * count for count in counts)


def talk_on_a_bus(master):
    """NMT, SYNC, SDO to both, an abort, heartbeats; then what goes wrong."""
    def send(text, *counts):
        master.say(text.encode() + b"\r")
        master.hear(ACKNOWLEDGED + sizes(*counts))
        master.pause(20 if counts else 120)

    master.pause(300)  # boot-up
    master.say(b"S5\rO\r")
    master.pause(300)
    send("t00020100", 4, 2, 6, 4, 2, 6)
    send("t0800", 4, 4)
    send("t60184001100000000000", 8)
    send("t60284003650000000000", 8)
    send("t60284001200000000000", 8)
    master.say(b"t60182B17100058020000\r")  # a heartbeat each 600 ms: a busy machine ends it before a fourth one
    master.hear(ACKNOWLEDGED + sizes(1, 8) + 3 * sizes(1))
    send("t60182B17100000000000", 8)
    master.order("INST:SEL a", "FAUL:SET wire_delay,COUN,1")
    send("t60184001100000000000", 8)
    master.order("FAUL:SET wire_drop,COUN,1")
    send("t60184001100000000000")
    send("t60184001100000000000", 8)
    master.order("SHAF:POS 75DEG")
    send("t0800", 4, 4)
    master.order("INST:SEL b", "POW OFF")
    send("t0800", 4)
    master.order("POW ON")
    master.pause(300)


def bus_events(text: str):
    """Who speaks follows from the identifier (CiA 301, predefined connection set)."""
    for line in text.splitlines():
        stamp, _wire, frame = line.split(" ")
        masters = frame[:3] in ("000", "080") or frame[0] == "6"
        yield round(float(stamp.strip("()")) * 1e6) * 1000, "request" if masters else "reply", frame


# --- both ---

KINDS = {
    "line": (("s3684-rs485", "s3674-rs485"), ("sincos_us = 0", "sincos_us = 0\naddress = 0x41"), "vcd",
             ("rs485\naddress = tcp:127.0.0.1:0", "pty"), talk_on_a_line, line_events),
    "bus": (("f3668", "f3658"), ("node = 1", "node = 2"), "log",
            ("slcan\naddress = tcp:127.0.0.1:0", "slcan"), talk_on_a_bus, bus_events),
}


def later_by(virtual: list, real: list):
    """How much later than in virtual time everything of an encoder comes behind what the master said last."""
    said = [0, 0]
    for events in zip(virtual, real):
        moments = [at for at, _who, _what in events]
        if events[0][1] == "request":
            said = moments
        else:
            yield (moments[1] - said[1]) - (moments[0] - said[0])


@pytest.mark.parametrize("kind", KINDS)
def test_real_time_is_virtual_time_and_late(tmp_path, capsys, kind):
    models, own, suffix, wires, talk, events_of = KINDS[kind]
    texts = []
    for time_, wire in zip(("virtual", "real"), wires):
        (tmp_path / time_).mkdir()
        texts.append(RIG.format(folder=tmp_path / time_, wire=wire, suffix=suffix, models=models, own=own))
    (tmp_path / "virtual/rig.ini").write_text(texts[0])
    first = Virtual(tmp_path / "virtual/rig.ini")
    talk(first)
    first.end()
    rigs = Rigs(tmp_path / "real")
    try:
        second = Real(rigs.begin(texts[1]))
        talk(second)
        late = second.end()
    finally:
        assert rigs.end() == []
    virtual, real = (list(events_of((tmp_path / f"{time_}/trace.{suffix}").read_text()))
                     for time_ in ("virtual", "real"))
    assert first.heard == second.heard
    assert [event[1:] for event in virtual] == [event[1:] for event in real]
    assert {who for _at, who, _what in virtual} == {"request", "reply"}
    lateness = list(later_by(virtual, real))
    assert -RESOLUTION_NS <= min(lateness) and statistics.median(lateness) <= USUALLY_LATE_NS, lateness
    if late == 0:
        assert max(lateness) <= LATE_NS, lateness
        return
    with capsys.disabled():
        print(f"\nnote: {kind}: late {late} times, says the rig itself: not each moment was judged")
