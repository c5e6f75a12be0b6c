# SPDX-License-Identifier: MIT
"""The example rig of forty encoders for a minute: masters on every wire check every position, defects
come and go on each of them, and no deadline is missed but in a few slow rounds of the loop.

A machine that stands still, as an emulated or a shared one does now and then, misses deadlines for
everybody. A referee with nothing but a clock says when that was. Tenths of a second with such a stall
prove little about drehgeber; the run goes on until there are enough of the others, see judgement.py.
"""
import contextlib
import os
import re
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

REPOSITORY = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPOSITORY / "tools/python"))
import drehgeber  # noqa: E402
from judgement import Judgement, Span, complaint, judge  # noqa: E402
from masters import MASTERS, WIRES, Heard, memory_kib, percent, start_masters, ticks  # noqa: E402

RIG = REPOSITORY / "tools/examples/forty.ini"
RUN_S = float(os.environ.get("RIG_SECONDS", "60"))  # at least, and as many of time kept, but
RUN_MOST_S = 3 * RUN_S
KEPT_LEAST_S = RUN_S / 2  # of time kept; a machine that keeps less of it is named
SPAN_S = 0.1  # a stall and its aftermath take half of it
PRIORITY = 10
HELD_S = 1.0  # how long a defect lasts after it was seen


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


class Watch:
    """The missed deadlines of each span. Encoders of a wire count together: one speaks for all."""

    def __init__(self, rig):
        self._rig = rig
        spokesmen = {(encoder.wire, encoder.address): encoder.name for encoder in rig.encoders.values()}
        # A request each: in an emulated machine one answer for all of them may take the rig more than the 10 ms that
        # its own calls may take, and the rig counts such a call as a delay on every wire.
        self._questions = [f"INST:SEL {name};:STAT?" for name in spokesmen.values()]
        # A stall makes each encoder of an RS485 line or another wire miss one, and each wire one more.
        self.most = sum(encoder.wire == "pty" for encoder in rig.encoders.values()) + 2 * len(spokesmen)
        self.spans = []
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def count(self) -> int:
        said = ";".join(map(self._rig.ask, self._questions))
        return sum(map(int, re.findall(r"\bwire_late=(\d+)", said)))

    def _run(self):
        begin, before = time.monotonic(), self.count()
        while not self._end.wait(SPAN_S):
            now, count = time.monotonic(), self.count()
            self.spans.append(Span(begin, time.monotonic(), count - before))
            begin, before = now, count

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self._end.set()
        self._thread.join()

    def judgement(self, stalls: list) -> Judgement:
        return judge(list(self.spans), list(stalls), self.most)


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


def run_for_a_minute(rig, heard: Heard, watch: Watch) -> float:
    """Defects at regular times, then on until enough is seen. How many seconds it took."""
    begin = time.monotonic()
    for i, defect in enumerate(DEFECTS):
        inject(rig, defect, heard)
        time.sleep(max(0.0, begin + (i + 1) * RUN_S / len(DEFECTS) - time.monotonic()))
    while watch.judgement(heard.stalls).kept_s < RUN_S and time.monotonic() < begin + RUN_MOST_S:
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

    judgement = watch.judgement(heard.stalls)
    if judgement.kept_s < KEPT_LEAST_S:
        print(f"note: the machine kept time for {judgement.kept_s:.1f} of {took_s:.0f} s only; what was missed "
              "in the rest was set against its stalls")
    print(f"{took_s:.1f} s: drehgeber {shares[0]:.1f} % CPU, {rss} KiB (peak {peak} KiB), "
          f"all masters {sum(shares[1:]):.1f} % CPU")
    for master in masters:
        print(master.wire, master.where, master.figures)
    longest_s = max((stall.end - stall.begin for stall in heard.stalls), default=0)
    print(f"the machine kept time for {judgement.kept_s:.1f} s of them in {len(watch.spans)} looks; it stood "
          f"still {len(heard.stalls)} times, up to {1000 * longest_s:.1f} ms; "
          f"{sum(span.missed for span in watch.spans)} deadlines missed in all")
    print("heard:", "; ".join(heard.lines[begin:]))

    assert statuses == [0] * len(masters)
    expected = [line for defect in DEFECTS for line in (*defect.seen, *defect.cleared)]
    assert sorted(heard.lines[begin:]) == sorted(expected)
    for master in masters:
        assert master.figures["wrong"] == 0
        assert master.figures["exchanges"] >= WIRES[master.wire][1] * judgement.kept_s
    assert [name for name, state in states.items() if state["wire_up"] != 1] == []
    assert complaint(judgement) == ""
