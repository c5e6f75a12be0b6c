# SPDX-License-Identifier: MIT
"""The example rig of forty encoders for a minute: masters on every wire check every position, defects
come and go on each of them, and no deadline is missed.

A machine that stands still, as an emulated or a shared one does now and then, misses deadlines for
everybody. A referee with nothing but a clock says when that was. Seconds with such a stall prove
nothing about drehgeber; the run goes on until there are enough of the others.
"""
import contextlib
import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

REPOSITORY = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "tools/python"))
import drehgeber  # noqa: E402

MASTERS = os.environ.get("RIG_MASTERS", "")
RIG = REPOSITORY / "tools/examples/forty.ini"
RUN_S = float(os.environ.get("RIG_SECONDS", "60"))  # at least, and as many of time kept, but
RUN_MOST_S = 3 * RUN_S
KEPT_LEAST_S = RUN_S / 2  # seconds of time kept without which nothing is proved
AFTERMATH_S = 0.05  # what was held up by a stall is done by then
PATIENCE_S = 20.0  # for what should happen at once on a busy, emulated machine
PRIORITY = 10
HELD_S = 1.0  # how long a defect lasts after it was seen

# Steps in a turn, turns.
FIGURES = {
    "f3658": (65536, 1),
    "f3668": (65536, 4096),
    "s3674-rs485": (65536, 1),
    "s3684-rs485": (65536, 4096),
    "s3684-biss": (2097152, 4096),
    "ocd-ib-k1": (4096, 1),
    "ocd-ib-k2": (4096, 4096),
    "ocd-ib-k3": (4096, 4096),
}
# The wire of a ready line: the master's wire, and the least it has to ask in a second.
WIRES = {"can": ("can", 100), "pty": ("rs485", 10), "modbus": ("ring", 50), "sim": ("biss", 10),
         "clock": ("clock", 10)}


class Defect(NamedTuple):
    encoder: str
    fault: str  # or POWER
    seen: list  # what the masters say while it lasts, and
    cleared: list  # when it is over


POWER = "power"
DEFECTS = [
    Defect("a3", "led_current_high", ["a3 emcy 5200h"], ["a3 emcy 0000h"]),
    Defect("c3", "singleturn_lost", ["c3 error 20h"], ["c3 ok"]),
    Defect("k3", "singleturn_lost", ["k3 invalid"], ["k3 ok"]),
    Defect("e1", "led_current_high", ["e1 nERR"], ["e1 ok"]),
    Defect("b2", "temperature_high", ["b2 emcy 4200h"], ["b2 emcy 0000h"]),
    Defect("d2", "led_current_high", ["d2 error 1Dh", "d2 warning 1Dh"], ["d2 ok"]),
    Defect("k1", "singleturn_lost", ["ring module-error"], ["ring ok"]),
    Defect("a7", "wire_drop", ["a7 silent"], ["a7 ok"]),
    Defect("c5", "wire_damage", ["c5 garbled"], ["c5 ok"]),
    Defect("k2", "wire_break", ["ring bus-error"], ["ring ok"]),
    Defect("e1", "wire_break", ["e1 silent"], ["e1 ok"]),
    Defect("b5", "bus_off", ["b5 silent"], ["b5 emcy 8140h", "b5 emcy 0000h", "b5 ok"]),
    Defect("d8", "wire_drop", ["d8 silent"], ["d8 ok"]),
    Defect("b9", POWER, ["b9 silent"], ["b9 boot-up", "b9 ok"]),
]


class Stall(NamedTuple):
    """The machine stood still."""
    begin: float
    end: float


class Heard:
    """What all masters say, in order."""

    def __init__(self):
        self.lines = []
        self.stalls = []
        self._more = threading.Condition()

    def add(self, line: str):
        with self._more:
            self.lines.append(line)
            self._more.notify_all()

    def wait_for(self, wanted: list, begin: int = 0):
        """Until all of this has been said since `begin`."""
        with self._more:
            if not self._more.wait_for(lambda: set(wanted) <= set(self.lines[begin:]), PATIENCE_S):
                raise AssertionError(f"{wanted} expected, heard {self.lines[begin:]}")


class Master:
    """The master of a wire, in a process of its own."""

    def __init__(self, wire: str, where: str, control: str, devices: list, heard: Heard):
        self.wire = wire
        self.where = where
        self.heard = heard
        self.figures = {}
        self.process = subprocess.Popen([MASTERS, WIRES[wire][0], where, control, *devices],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            words = line.split()
            if words[0] == "figures":
                self.figures = {key: int(value) for key, value in
                                (word.split("=") for word in words[2:])}
            elif words[0] == "clock":
                at, late = (int(word) / 1e9 for word in words[1:])
                self.heard.stalls.append(Stall(at, at + late + AFTERMATH_S))
            else:
                self.heard.add(line.strip())

    def end(self) -> int:
        self.process.terminate()
        status = self.process.wait(PATIENCE_S)
        self.reader.join(PATIENCE_S)
        self.process.stdout.close()
        return status


def devices_of(encoders: list) -> list:
    """The masters' words for the encoders of a wire, in the order of the file."""
    words = []
    register = 0
    for index, encoder in enumerate(encoders):
        steps, turns = FIGURES[encoder.model]
        address = {"can": encoder.place, "pty": 0x40 + index, "modbus": register, "sim": 0}
        register += 1 if turns == 1 else 2
        words.append(f"{encoder.name},{address[encoder.wire]},{steps},{turns}")
    return words


def start_masters(rig, heard: Heard) -> list:
    wires = {}
    for encoder in rig.encoders.values():
        where = encoder.address.rpartition(":")[2] or "-"
        wires.setdefault((encoder.wire, where), []).append(encoder)
    return [Master("clock", "-", rig.socket, [], heard),
            *(Master(wire, where, rig.socket, devices_of(encoders), heard)
              for (wire, where), encoders in wires.items())]


class Watch:
    """The missed deadlines of each second. Encoders of a wire count together: one speaks for all."""

    def __init__(self, rig):
        self._spokesmen = list({(encoder.wire, encoder.address): encoder
                                for encoder in rig.encoders.values()}.values())
        self.seconds = []  # begin, end, missed
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def count(self) -> int:
        return sum(int(encoder.state()["wire_late"]) for encoder in self._spokesmen)

    def _run(self):
        begin, before = time.monotonic(), self.count()
        while not self._end.wait(1.0):
            now, count = time.monotonic(), self.count()
            self.seconds.append((begin, time.monotonic(), count - before))
            begin, before = now, count

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._end.set()
        self._thread.join()

    def kept(self, stalls: list) -> list:
        """Missed deadlines in each of the seconds without a stall."""
        return [missed for begin, end, missed in self.seconds
                if not any(stall.begin < end and begin < stall.end for stall in stalls)]


def inject(rig, defect: Defect, heard: Heard):
    """A defect comes, is seen on its wire, and goes."""
    encoder = rig.encoders[defect.encoder]
    begin = len(heard.lines)
    if defect.fault == POWER:
        encoder.power(False)
    else:
        encoder.set_fault(defect.fault)
    heard.wait_for(defect.seen, begin)
    time.sleep(HELD_S)
    begin = len(heard.lines)
    if defect.fault == POWER:
        encoder.power(True)
    else:
        encoder.clear_fault(defect.fault)
    heard.wait_for(defect.cleared, begin)


def ticks(pid: int) -> int:
    """User and system time so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])


def memory_kib(pid: int, what: str) -> int:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(rf"^{what}:\s+(\d+) kB", status, re.M)[1])


def percent(before: int, after: int, seconds: float) -> float:
    return 100 * (after - before) / os.sysconf("SC_CLK_TCK") / seconds


def run_for_a_minute(rig, heard: Heard, watch: Watch) -> float:
    """Defects at regular times, then on until enough is seen. How many seconds it took."""
    begin = time.monotonic()
    for i, defect in enumerate(DEFECTS):
        inject(rig, defect, heard)
        time.sleep(max(0.0, begin + (i + 1) * RUN_S / len(DEFECTS) - time.monotonic()))
    while len(watch.kept(list(heard.stalls))) < RUN_S and time.monotonic() < begin + RUN_MOST_S:
        time.sleep(1.0)
    return time.monotonic() - begin


def test_forty_encoders_for_a_minute():
    assert os.access(MASTERS, os.X_OK), f"no program at '{MASTERS}': build rig_masters"
    heard = Heard()
    with drehgeber.run(RIG) as rig:
        assert len(rig.encoders) == 40
        # As a rig builder would: whoever answers in milliseconds comes before whoever asks.
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(rig.pid, os.SCHED_FIFO, os.sched_param(PRIORITY))
        masters = start_masters(rig, heard)
        try:
            heard.wait_for([f"{name} ok" for name in [*rig.encoders, "ring"]])
            begin = len(heard.lines)
            pids = [rig.pid, *(master.process.pid for master in masters)]
            before = [ticks(pid) for pid in pids]
            with Watch(rig) as watch:
                took_s = run_for_a_minute(rig, heard, watch)
            shares = [percent(a, ticks(pid), took_s) for a, pid in zip(before, pids)]
            rss, peak = memory_kib(rig.pid, "VmRSS"), memory_kib(rig.pid, "VmHWM")
            states = {name: encoder.state() for name, encoder in rig.encoders.items()}
        finally:
            statuses = [master.end() for master in masters]

    print(f"{took_s:.1f} s: drehgeber {shares[0]:.1f} % CPU, {rss} KiB (peak {peak} KiB), "
          f"all masters {sum(shares[1:]):.1f} % CPU")
    for master in masters:
        print(master.wire, master.where, master.figures)
    kept = watch.kept(heard.stalls)
    longest_s = max((stall.end - stall.begin - AFTERMATH_S for stall in heard.stalls), default=0)
    print(f"the machine kept time in {len(kept)} of {len(watch.seconds)} s, {sum(kept)} deadlines missed "
          f"in them; it stood still {len(heard.stalls)} times, up to {1000 * longest_s:.1f} ms, "
          f"{sum(missed for _, _, missed in watch.seconds)} missed in all")
    print("heard:", "; ".join(heard.lines[begin:]))

    assert statuses == [0] * len(masters)
    expected = [line for defect in DEFECTS for line in (*defect.seen, *defect.cleared)]
    assert sorted(heard.lines[begin:]) == sorted(expected)
    for master in masters:
        assert master.figures["wrong"] == 0
        assert master.figures["exchanges"] >= WIRES[master.wire][1] * took_s
    assert [name for name, state in states.items() if state["wire_up"] != "1"] == []
    assert len(kept) >= KEPT_LEAST_S
    assert sum(kept) == 0
