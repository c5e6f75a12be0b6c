# SPDX-License-Identifier: MIT
"""A rig in a SIL Kit simulation with defects that come and go, for DREHGEBER_SOAK_SECONDS, or as many virtual hours as
DREHGEBER_SILKIT_HOURS says in steps of DREHGEBER_SILKIT_STEP_US. A CANopen node is read by SYNC and a BiSS encoder by
its frames in every step. A position that is told without an error has to be that of the shaft at its moment.

By hand: DREHGEBER_SILKIT_HOURS=10 python3 -m pytest -q -rP tests/e2e/silkit/soak.py"""
import itertools
import math
import os
import struct
import time

from rig import Client
from simulation import Participant, Registry, Rig

SECONDS = float(os.environ.get("DREHGEBER_SOAK_SECONDS", "60"))
HOURS = float(os.environ.get("DREHGEBER_SILKIT_HOURS", "0"))
STEP_NS = 1000 * int(os.environ.get("DREHGEBER_SILKIT_STEP_US", "1000"))
FRAME = "application/vnd.drehgeber.frame.v1"
SECOND = 1_000_000_000
# Bits of a turn, bits of a position, and in which time behind the moment of a message it was sensed.
WIDTHS = {"can": (16, 28, 0), "biss": (21, 33, 25_000)}
FAULTS = {
    "can": ["wire_drop", "wire_deaf", "wire_duplicate", "bus_off", "error_passive", "overrun", "temperature_high",
            "led_current_high"],
    "biss": ["wire_drop", "wire_delay", "wire_damage", "wire_break", "temperature_high", "watchdog_fired"],
}
RIG = """
[rig]
name = cell
control = unix:{folder}/rig.sock
[shaft s]
motion = 97RPM
[encoder can]
model = f3668
wire = silkit:{uri},CAN1
[encoder biss]
model = s3684-biss
wire = silkit:{uri},CHAIN
"""
RPM = 97
RESTART = 1000  # steps, twice those from one start of all nodes to the next


class Watch:
    """The master: what it was told, and what of it was wrong."""

    def __init__(self):
        self.right = {"can": 0, "biss": 0}
        self.wrong, self.marked, self.steps, self.now, self.begun = [], 0, 0, 0, None
        self.sound_from = 0  # the step from which on the node has to answer: math.inf while it is bent
        self.silent, self.answers_due = [], 0

    def judge(self, kind: str, at_ns: int, told: int):
        turn, whole, late_ns = WIDTHS[kind]
        low, high = ((at * RPM << turn) // (60 * SECOND) for at in (at_ns, at_ns + late_ns))
        if (told - low) % (1 << whole) <= high - low:
            self.right[kind] += 1
        else:
            self.wrong.append((kind, at_ns, low, told))

    def step(self, master, now):
        self.begun = self.begun or time.monotonic()
        self.now, self.steps = now, self.steps + 1
        positions = [(at, content) for at, name, content, _ in master.frames if name == 0x2BF]
        for at, content in positions:
            self.judge("can", at - STEP_NS, struct.unpack("<I", content)[0])
        if self.steps > self.sound_from + RESTART and now > 2 * SECOND + RESTART * STEP_NS:
            self.answers_due += 1
            self.silent += [] if positions else [now]
        for _, _, content in master.data:
            at, verdict, flags, _, _, multi, single, _, _ = struct.unpack("<Q4B3IQ", content)
            if (verdict, flags) != (0, 0):
                self.marked += 1
                continue
            self.judge("biss", at, multi << WIDTHS["biss"][0] | single)
        del master.frames[:], master.data[:]
        if now > 2 * SECOND:
            master.send(0x80, b"")
        if self.steps % (RESTART // 2) == 0:
            master.send(0, b"\x01\x00")  # whoever was bus-off, or has started anew

    def going_on(self) -> bool:
        if HOURS:
            return self.now < HOURS * 3600 * SECOND
        return self.begun is None or time.monotonic() < self.begun + SECONDS


def bend(control, watch, kind, name):
    """For a while."""
    watch.sound_from = math.inf if kind == "can" else watch.sound_from
    control.do(f"INST:SEL {kind};:FAUL:SET {name}")
    time.sleep(0.05)
    control.do(f"FAUL:CLE {name}")
    if kind == "can":
        watch.sound_from = watch.steps
        # As many steps with answers due as without, however fast they are.
        while watch.going_on() and watch.steps < watch.sound_from + 2 * RESTART:
            time.sleep(0.01)
    time.sleep(0.05)


def test_every_position_is_right_or_marked(tmp_path):
    registry, watch = Registry(), Watch()
    master = Participant(registry.uri, "master", watch.step, required=["cell", "master"], step_ns=STEP_NS)
    file = tmp_path / "cell.ini"
    file.write_text(RIG.format(folder=tmp_path, uri=registry.uri).replace(
        ",CAN1\n", f",CAN1\nstep_us = {STEP_NS // 1000}\n"))
    master.can("CAN1")
    master.subscribe("CHAIN/frame", FRAME)
    program = Rig(file)
    rounds = 0
    try:
        program.ready("ready rig")
        master.start()
        with Client(f"unix:{tmp_path}/rig.sock") as control:
            for kind, name in itertools.cycle([(kind, name) for kind, names in FAULTS.items() for name in names]):
                if not watch.going_on() or master.failed:
                    break
                bend(control, watch, kind, name)
                rounds += 1
        master.stop()
        master.wait()
        assert program.wait() == 0
    finally:
        master.close()
        program.close()
        registry.end()
    took = time.monotonic() - watch.begun
    print(f"{watch.now / 3600 / SECOND:.3f} virtual h in {took:.0f} s: {watch.steps} steps, "
          f"{watch.steps / took:.0f}/s; {rounds} defects; positions right: {watch.right['can']} by SYNC, "
          f"{watch.right['biss']} by BiSS; {watch.marked} marked; {len(watch.wrong)} wrong; "
          f"{len(watch.silent)} of {watch.answers_due} answers to SYNC missing")
    assert watch.wrong[:20] == []
    # A frame in each step, right or marked; an answer in each while nothing is wrong with the node.
    assert watch.right["biss"] + watch.marked >= watch.steps - 2
    assert watch.silent[:20] == [] and watch.answers_due > watch.steps // 4
    assert watch.marked > 0 and rounds >= 10
