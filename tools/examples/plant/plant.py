#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A plant: 10 000 CANopen encoders as a rig of 80 buses with 125 nodes each, in one SIL Kit simulation with its master,
which turns a shaft for each bus, says SYNC on it, and checks each position that it is told against that shaft. The
frames of a bus travel packed, those of a step in one message.

Prints what it took. The status is 1 when a position was wrong or missing. Needs the command drehgeber and
SIL Kit's libSilKit.so, which README.md says how to get.
"""

import argparse
import contextlib
import ctypes
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from ctypes import c_char_p, c_uint8, c_uint64, c_void_p
from pathlib import Path

from kit import (
    ADDRESS_AND_SIZE, COORDINATED, EVENT_BYTES, EVENT_FRAME, FRAME_ID, ID_AND_DATA, MASTER, ON_ABORT, ON_DATA, ON_FRAME,
    ON_LIFE, ON_STEP, PACK_FRAME, PACK_HEAD, PACKED, RECEIVED, SHAFT, Bytes, Frame, Header, Kit, Lifecycle, Spec, Strings,
    Workflow, version,
)  # fmt: skip

TREE = Path(__file__).resolve().parents[3]
MS = 1_000_000
PATIENCE_S = 120
PROGRESS_S = 2
PROCESSES_MAX, THREADS_MAX = 256, 64

# What is on a bus: F3668 as delivered, 2^16 steps a turn, 2^28 in all; TPDO2 tells the position at SYNC.
START, SYNC, TPDO2 = 0x000, 0x080, 0x280
TURN, STEP_BITS, STEPS = 1 << 32, 16, 1 << 28
MRPM_MAX = 3_000_000
# Nodes have booted by then; a bus that was started hears its first SYNC so much later, or a period of SYNC.
BOOTED_MS, STARTED_MS = 500, 100
# What was said in a step is heard in the next one, and answered, and the answer is heard in the one behind it.
ANSWER_STEPS = 3

# ---------------------------------------------------------------- the plant


class Shaft:
    """Turns with one speed until it is given another one; angles in 2^-32 turns."""

    def __init__(self, number: int):
        self.chance = random.Random(number)
        self.angle = self.mrpm = self.since = 0

    def angle_at(self, at_ns: int) -> int:
        """At a moment of the simulation."""
        return self.angle + self.mrpm * (at_ns - self.since) * TURN // (60_000 * 1000 * MS)

    def position(self, at_ns: int) -> bytes:
        """Of an encoder on it, as TPDO2 has it."""
        return ((self.angle_at(at_ns) >> STEP_BITS) % STEPS).to_bytes(4, "little")

    def turn(self, at_ns: int) -> bytes:
        """Go on with another speed. @return what its topic is told: where it is, and how fast it goes on"""
        self.angle, self.since = self.angle_at(at_ns), at_ns
        self.mrpm = self.chance.randint(-MRPM_MAX, MRPM_MAX)
        return struct.pack("<qq", self.angle, self.mrpm * TURN // 60_000)


def rig_file(rig: int, plant: argparse.Namespace, uri: str) -> str:
    """The rig as the command takes it: the buses of a plant are counted through."""
    text = [f"[rig]\nname = plant-{rig}\nthreads = {plant.threads}\n"]
    buses = range(rig * plant.buses, (rig + 1) * plant.buses)
    text += [f"[shaft s{bus}]\n" for bus in buses]
    keys = f"step_us = {plant.step_us}\n" + ("" if plant.aggregate else "aggregate = 0\n")
    keys += "" if plant.frames == "can" else f"frames = {plant.frames}\n"
    for bus in buses:
        text.append(
            f"[bus b{bus}]\nwire = silkit\naddress = {uri},bus{bus}\n{keys}"
            f"[encoder b{bus}]\nmodel = f3668\nbus = b{bus}\nnode = 1..{plant.nodes}\nshaft = s{bus}\n"
        )
    return "".join(text)


# ---------------------------------------------------------------- the master


class Bus:
    """What the master knows of a bus."""

    def __init__(self, number: int, turn: int):
        self.number = number
        self.turn = turn  # the step of a period in which it is started, and then hears SYNC
        self.shaft = Shaft(number)
        self.expected = b""  # what every node is to tell
        self.said = 0  # when they were asked to
        self.answers = b""  # all of them in a packed message, in the order of their identifiers
        self.missing: set[int] = set()  # identifiers that have not told it yet


class Master:
    """A participant with a controller on each bus, or with the two topics of a packed one."""

    def __init__(self, kit: Kit, plant: argparse.Namespace, uri: str):
        self.kit, self.plant = kit, plant
        self.period = plant.sync_ms * 1000 // plant.step_us
        self.booted = BOOTED_MS * 1000 // plant.step_us
        self.started = self.booted + max(self.period, STARTED_MS * 1000 // plant.step_us)
        self.ends = self.started + plant.ms * 1000 // plant.step_us
        self.whole = self.ends + ANSWER_STEPS
        self.packed = plant.frames == "packed"
        self.ids = frozenset(range(TPDO2 + 1, TPDO2 + 1 + plant.nodes))
        self.fronts = [*(PACK_FRAME.pack(0, identifier, 4, 0) for identifier in sorted(self.ids)), b""]
        self.buses = [Bus(i, i * self.period // plant.all) for i in range(plant.all)]
        self.turns: dict[int, list[Bus]] = {}
        for bus in self.buses:
            self.turns.setdefault(bus.turn, []).append(bus)
        self.step = self.now = self.syncs = self.checked = self.wrong = self.frames = 0
        self.complaints: list[str] = []
        self.begin = self.end = 0.0
        self.ready, self.over = threading.Event(), threading.Event()
        self.begun = lambda: None  # before the first step that counts
        self.ended = lambda: None
        self._join(uri)

    def _join(self, uri: str) -> None:
        kit, self.life, clock, controller = self.kit, c_void_p(), c_void_p(), c_void_p()
        self.participant = c_void_p()
        names = [MASTER, *(f"plant-{rig}" for rig in range(self.plant.processes))]
        configuration = kit.configuration(uri, bool(self.plant.aggregate))
        kit.call("Participant_Create", ctypes.byref(self.participant), configuration, MASTER.encode(), uri.encode())
        array = (c_char_p * len(names))(*map(str.encode, names))
        kit.kept.append(array)
        workflow = Workflow(Header(version(7, 3, 3)), ctypes.pointer(Strings(len(names), array)))
        kit.call("Experimental_SystemController_Create", ctypes.byref(controller), self.participant)
        kit.call("Experimental_SystemController_SetWorkflowConfiguration", controller, ctypes.byref(workflow))
        setup = Lifecycle(Header(version(7, 2)), COORDINATED)
        kit.call("LifecycleService_Create", ctypes.byref(self.life), self.participant, ctypes.byref(setup))
        kit.handle("LifecycleService_SetCommunicationReadyHandler", self.life, ON_LIFE(self._on_ready))
        kit.handle("LifecycleService_SetShutdownHandler", self.life, ON_LIFE(lambda *_: self.over.set()))
        kit.handle("LifecycleService_SetAbortHandler", self.life, ON_ABORT(lambda *_: self.over.set()))
        kit.call("TimeSyncService_Create", ctypes.byref(clock), self.life)
        self.kit.kept.append(on_step := ON_STEP(self._on_step))
        kit.call("TimeSyncService_SetSimulationStepHandler", clock, None, on_step, c_uint64(self.plant.step_us * 1000))
        make = self._topics if self.packed else self._controller
        self.wires = [make(bus.number) for bus in self.buses]
        self.publishers = [self._shaft(bus.number) for bus in self.buses]
        kit.call("LifecycleService_StartLifecycle", self.life)

    def _controller(self, bus: int) -> c_void_p:
        made, handler_id, on_frame = c_void_p(), c_uint64(), ON_FRAME(self._on_frame)
        name = f"bus{bus}".encode()
        self.kit.kept.append(on_frame)
        self.kit.call("CanController_Create", ctypes.byref(made), self.participant, name, name)
        self.kit.call(
            "CanController_AddFrameHandler", made, c_void_p(bus), on_frame, c_uint8(RECEIVED), ctypes.byref(handler_id)
        )
        return made

    def _topics(self, bus: int) -> c_void_p:
        made, topic, on_pack = c_void_p(), f"bus{bus}/frames".encode(), ON_DATA(self._on_pack)
        spec = Spec(Header(version(5, 2)), topic, PACKED)
        self.kit.kept.append(on_pack)
        self.kit.call(
            "DataSubscriber_Create", ctypes.byref(made), self.participant, topic, ctypes.byref(spec), c_void_p(bus), on_pack
        )
        return self._publisher(f"bus{bus}/frames/to", PACKED)

    def _shaft(self, bus: int) -> c_void_p:
        return self._publisher(f"plant-{bus // self.plant.buses}/shaft/s{bus}/turn", SHAFT)

    def _publisher(self, name: str, media_type: bytes) -> c_void_p:
        made, topic = c_void_p(), name.encode()
        spec = Spec(Header(version(5, 2)), topic, media_type)
        self.kit.call(
            "DataPublisher_Create", ctypes.byref(made), self.participant, topic, ctypes.byref(spec), c_uint8(0)
        )
        return made

    # The handlers: one after the other, on a thread of the library.

    def _on_ready(self, *_: object) -> None:
        # Python makes a state for a thread that calls it, and drops it afterwards; one that is held once more stays,
        # and a frame costs half as much.
        ctypes.pythonapi.PyGILState_Ensure()
        for wire in self.wires if not self.packed else ():
            self.kit.call("CanController_Start", wire)
        self.ready.set()

    def _on_frame(self, number: int | None, _controller: int, event: int) -> None:
        frame = c_uint64.from_address(event + EVENT_FRAME).value
        identifier, data = ID_AND_DATA.unpack(ctypes.string_at(frame + FRAME_ID, ID_AND_DATA.size))
        self.frames += 1
        if identifier in self.ids:
            bus = self.buses[number or 0]
            self._check(bus, identifier, ctypes.string_at(data, 4), bus.said)

    def _on_pack(self, number: int | None, _subscriber: int, event: int) -> None:
        bus = self.buses[number or 0]
        address, size = ADDRESS_AND_SIZE.unpack(ctypes.string_at(event + EVENT_BYTES, ADDRESS_AND_SIZE.size))
        message = ctypes.string_at(address, size)
        begin, count, _ = PACK_HEAD.unpack_from(message)
        self.frames += count
        if begin == bus.said and len(bus.missing) == count and message[PACK_HEAD.size :] == bus.answers:
            self.checked += count  # all of them at once, which is what a plant without faults sends
            bus.missing = set()
            return
        at = PACK_HEAD.size
        for _ in range(count):
            offset, identifier, dlc, _ = PACK_FRAME.unpack_from(message, at)
            at += PACK_FRAME.size + dlc
            if identifier in self.ids:
                self._check(bus, identifier, message[at - dlc : at], begin + offset)

    def _check(self, bus: Bus, identifier: int, told: bytes, at_ns: int) -> None:
        if identifier not in bus.missing:
            if bus.expected:
                self._wrong(bus, f"{identifier:03X}h without SYNC")
            return
        bus.missing.discard(identifier)
        self.checked += 1
        if told != bus.expected:
            self._wrong(bus, f"{identifier:03X}h tells {told.hex()}, not {bus.expected.hex()}")
        elif at_ns != bus.said:
            self._wrong(bus, f"{identifier:03X}h is of {at_ns} ns, not of {bus.said} ns")

    def _wrong(self, bus: Bus, what: str) -> None:
        self.wrong += 1
        if len(self.complaints) < 10:
            self.complaints.append(f"step {self.step}: bus{bus.number}: {what}")

    def _on_step(self, _ctx: object, _clock: object, now: int, _duration: int) -> None:
        try:
            self._take_step(now)
        except (Exception, SystemExit) as error:  # the library is in between
            self.complaints.append(f"step {self.step}: {error!r}")
            self.wrong += 1
            self.over.set()

    def _take_step(self, now: int) -> None:
        self.now = now
        if self.step == self.started:
            self.begun()
            self.frames = 0
            self.begin = time.monotonic()
        if self.step < self.booted or self.step >= self.ends:
            due = []
        else:
            due = self.turns.get((self.step - self.booted) % self.period, [])
        for bus in due:
            if self.step < self.started:
                self._send(bus, START, b"\x01\x00")
            else:
                self._sync(bus, now)
        self.step += 1
        if self.step == self.whole:
            self.end = time.monotonic()
            self.ended()
            for bus in self.buses:
                self._all_heard(bus)
                bus.expected = b""
            self.kit.library.SilKit_LifecycleService_Stop(self.life, b"done")

    def _sync(self, bus: Bus, now: int) -> None:
        self._all_heard(bus)
        bus.missing = set(self.ids)
        bus.expected, bus.said = bus.shaft.position(now), now
        bus.answers = bus.expected.join(self.fronts)
        self.syncs += 1
        self._send(bus, SYNC, b"")
        self._publish(self.publishers[bus.number], bus.shaft.turn(now))

    def _all_heard(self, bus: Bus) -> None:
        for identifier in sorted(bus.missing):
            self._wrong(bus, f"{identifier:03X}h is missing")
        bus.missing = set()

    def _send(self, bus: Bus, identifier: int, data: bytes) -> None:
        wire = self.wires[bus.number]
        if self.packed:
            self._publish(wire, PACK_HEAD.pack(self.now, 1, 0) + PACK_FRAME.pack(0, identifier, len(data), 0) + data)
            return
        frame = Frame(Header(version(1, 1)), identifier, 0, len(data))
        frame.data, frame.size = data, len(data)
        self.kit.call("CanController_SendFrame", wire, ctypes.byref(frame), None)

    def _publish(self, publisher: c_void_p, message: bytes) -> None:
        self.kit.call("DataPublisher_Publish", publisher, ctypes.byref(Bytes(message, len(message))))

    def close(self) -> None:
        """Leave the simulation."""
        self.kit.library.SilKit_Participant_Destroy(self.participant)


# ---------------------------------------------------------------- processes


class Ending:
    """By a signal, but never between the start of a rig and its place among those that are ended, nor while they are."""

    SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)

    def __init__(self) -> None:
        self.asked = self.held = 0
        for number in self.SIGNALS:
            signal.signal(number, self._on_signal)

    def close(self) -> None:
        """The exit status is settled. Python, while it ends, would let another signal decide."""
        for number in self.SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    def _on_signal(self, number: int, _frame: object) -> None:
        if not self.held:
            sys.exit(128 + number)
        self.asked = number

    def __enter__(self) -> None:
        self.held = 1

    def __exit__(self, kind: object, *_: object) -> None:
        self.held = 0
        if self.asked and kind is None:
            sys.exit(128 + self.asked)


def spent_s(pid: int) -> float:
    """Seconds on a processor so far, of all threads."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_kb(pid: int) -> int:
    """Proportional set size."""
    text = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
    return int(re.search(r"^Pss:\s+(\d+)", text, re.M)[1])


class Rigs:
    """The rigs that run here."""

    def __init__(self, plant: argparse.Namespace, uri: str, folder: str, ending: Ending):
        self.ending = ending
        self.all: list[subprocess.Popen[bytes]] = []
        self.logs = Path(folder)
        self.numbers = plant.here
        self.plant, self.uri = plant, uri

    def start(self) -> None:
        """All of them; close() ends those that are there when it is broken off."""
        plant, uri = self.plant, self.uri
        environment = {**os.environ, "DREHGEBER_SILKIT_LIBRARY": plant.library}
        for rig in self.numbers:
            file = self.logs / f"plant-{rig}.ini"
            file.write_text(rig_file(rig, plant, uri), encoding="ascii")
            with (self.logs / f"plant-{rig}.said").open("wb") as said:
                command = [plant.program, "run", "--quiet", str(file)]
                try:
                    with self.ending:
                        self.all.append(
                            subprocess.Popen(
                                command, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT, env=environment
                            )
                        )
                except OSError as error:
                    sys.exit(f"plant: {plant.program}: {error.strerror}; --program says where drehgeber is")

    def said(self, rig: int) -> str:
        """What it has printed."""
        return (self.logs / f"plant-{rig}.said").read_text(encoding="utf-8", errors="replace")

    def check(self) -> None:
        """None has gone."""
        for rig, process in zip(self.numbers, self.all):
            if process.poll() not in (None, 0):
                sys.exit(f"plant: plant-{rig} has ended with {process.returncode}: {self.said(rig)[-400:].strip()}")

    def wait_ready(self) -> None:
        """Until every encoder is there."""
        end = time.monotonic() + PATIENCE_S
        for rig in self.numbers:
            while not self.said(rig).endswith("ready rig\n"):
                self.check()
                if time.monotonic() > end:
                    sys.exit(f"plant: plant-{rig} is not ready after {PATIENCE_S} s")
                time.sleep(0.02)

    def close(self) -> None:
        """Those that are left; nothing else."""
        for process in self.all:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        end = time.monotonic() + 10
        for process in self.all:
            try:
                process.wait(max(0.0, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


# ---------------------------------------------------------------- figures


class Figures:
    """What it took, with the processes that run here."""

    def __init__(self, rigs: Rigs, plant: argparse.Namespace):
        self.rigs, self.plant = rigs, plant
        self.before: list[float] = []
        self.after: list[float] = []
        self.memory: list[int] = []

    def _spent(self) -> list[float]:
        return [spent_s(pid) for pid in (os.getpid(), *(process.pid for process in self.rigs.all))]

    def begin(self) -> None:
        """The first step that counts."""
        self.before = self._spent()

    def end(self) -> None:
        """Behind the last one."""
        self.after = self._spent()
        self.memory = [memory_kb(pid) for pid in (os.getpid(), *(process.pid for process in self.rigs.all))]

    def tell(self, master: Master, started: list[tuple[str, float]]) -> None:
        """A line for each."""
        plant, wall = self.plant, master.end - master.begin
        steps = master.whole - master.started
        virtual = steps * plant.step_us / 1e6
        used = [after - before for before, after in zip(self.before, self.after)]
        here = len(self.rigs.all)
        frames = max(1, master.frames)
        theirs = max(1, frames * here // plant.processes)
        rows = [
            ("encoders", f"{plant.all * plant.nodes} = {plant.processes} rigs x {plant.buses} buses x {plant.nodes} nodes"),
            ("start-up", ", ".join(f"{what} {seconds:.2f} s" for what, seconds in started)),
            ("memory", f"{sum(self.memory[1:]) / 1024:.0f} MB in {here} rigs, {self.memory[0] / 1024:.0f} MB master"),
            ("simulated", f"{virtual:.2f} s in steps of {plant.step_us} us, SYNC each {plant.sync_ms} ms: {wall:.2f} s"),
            ("virtual s per s", f"{virtual / wall:.3f}"),
            ("steps/s", f"{steps / wall:.0f}"),
            ("frames/s", f"{(master.frames + master.syncs) / wall:.0f}"),
            ("processor", f"{sum(used[1:]):.2f} s in {here} rigs, {used[0]:.2f} s master, of {os.cpu_count()} cores"),
            ("a frame", f"{sum(used[1:]) * 1e6 / theirs:.1f} us in its rig, {used[0] * 1e6 / frames:.1f} us in the master"),
            ("positions", f"{master.checked} checked, {master.wrong} wrong"),
        ]
        for name, figure in rows:
            print(f"{name:19} {figure}", flush=True)


class Progress:
    """A line on stderr every other second, for whoever waits."""

    def __init__(self) -> None:
        self.began = self.told = time.monotonic()

    def tell(self, what: str) -> None:
        """If it is time."""
        now = time.monotonic()
        if now - self.told > PROGRESS_S:
            self.told = now
            print(f"plant: {what}, {now - self.began:.0f} s", file=sys.stderr, flush=True)


# ---------------------------------------------------------------- the command


def free_port() -> int:
    """Nobody listens there."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def numbers(text: str) -> range:
    """FIRST..LAST, one, or none."""
    if text == "none":
        return range(0)
    first, _, last = text.partition("..")
    found = range(int(first), int(last or first) + 1)
    if not found:
        raise ValueError(text)
    return found


def library() -> str:
    """Of the environment, what tools of the tree have fetched, or the system's."""
    fetched = TREE / "build/silkit/SilKit_py/libSilKit.so"
    return os.environ.get("DREHGEBER_SILKIT_LIBRARY") or (str(fetched) if fetched.exists() else "libSilKit.so")


def options() -> argparse.Namespace:
    """What is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=1, help="rigs of the whole plant (1)")
    parser.add_argument("--threads", type=int, default=2, help="of a rig (2)")
    parser.add_argument("--buses", type=int, default=80, help="of a rig (80)")
    parser.add_argument("--nodes", type=int, default=125, help="of a bus (125)")
    parser.add_argument("--ms", type=int, default=1000, help="virtual time, from the first SYNC on (1000)")
    parser.add_argument("--step-us", type=int, default=1000, help="a step of the simulation (1000)")
    parser.add_argument("--sync-ms", type=int, default=100, help="SYNC on a bus each (100): half of what 250 kBd carry")
    parser.add_argument(
        "--frames", choices=("packed", "can"), default="packed", help="on a topic, packed, or on CAN networks (packed)"
    )
    parser.add_argument(
        "--aggregate", type=int, choices=(0, 1), default=1, help="0: a message of its own for each frame (1: for each step)"
    )
    parser.add_argument("--here", type=numbers, metavar="FIRST..LAST", help="rigs to start on this machine, or none (all)")
    parser.add_argument("--registry", metavar="silkit://HOST:PORT", help="of the master (any port of this machine)")
    parser.add_argument("--join", action="store_true", help="the master and the registry are on another machine")
    parser.add_argument("--rig", type=int, help="print the rig file of one and end")
    parser.add_argument("--program", default="drehgeber", help="the command (drehgeber)")
    plant = parser.parse_args()
    plant.here = plant.here if plant.here is not None else range(plant.processes)
    plant.all = plant.processes * plant.buses
    plant.library = library()
    if (plant.join or plant.rig is not None) and plant.registry is None:
        parser.error("--registry silkit://HOST:PORT says where the master is")
    if plant.registry is not None and not re.fullmatch(r"silkit://[^/,\s]+:\d{1,5}", plant.registry):
        parser.error(f"--registry {plant.registry}: expected silkit://HOST:PORT")
    if not 1 <= plant.threads <= THREADS_MAX:
        parser.error(f"--threads {plant.threads}: expected 1..{THREADS_MAX}")
    if plant.processes > PROCESSES_MAX:
        parser.error(f"{PROCESSES_MAX} processes at most: each knows all others")
    if not 1 <= plant.nodes <= 127 or min(plant.processes, plant.buses, plant.ms, plant.step_us, plant.sync_ms) < 1:
        parser.error("all counts are 1 or more, and a bus has at most 127 nodes")
    rigs = range(plant.processes)
    if not set(plant.here) <= set(rigs) or plant.rig not in (None, *rigs):
        parser.error(f"the rigs of {plant.processes} processes are 0..{rigs[-1]}")
    if plant.sync_ms * 1000 % plant.step_us or plant.sync_ms * 1000 // plant.step_us < 4:
        parser.error("SYNC comes each fourth step at most, and in a step")
    return plant


def run_rigs(plant: argparse.Namespace, folder: str, ending: Ending) -> int:
    """Only rigs: they end with the master."""
    rigs = Rigs(plant, plant.registry, folder, ending)
    try:
        rigs.start()
        rigs.wait_ready()
        print(f"{len(rigs.all)} rigs are ready, for {plant.registry}", flush=True)
        while any(process.poll() is None for process in rigs.all):
            rigs.check()
            time.sleep(0.2)
        rigs.check()
    finally:
        with ending:
            rigs.close()
    return 0


def run_all(plant: argparse.Namespace, folder: str, ending: Ending) -> int:
    """The registry, the rigs of this machine, the master."""
    progress = Progress()
    uri = plant.registry or f"silkit://127.0.0.1:{free_port()}"
    kit = Kit(plant.library)
    registry = kit.registry(uri)
    rigs, master = Rigs(plant, uri, folder, ending), None
    try:
        rigs.start()
        rigs.wait_ready()
        started = [("encoders ready", time.monotonic() - progress.began)]
        master = Master(kit, plant, uri)
        figures = Figures(rigs, plant)
        master.begun, master.ended = figures.begin, figures.end
        while not master.ready.wait(0.1):
            rigs.check()
            progress.tell(f"waiting for all {plant.processes} rigs")
        started.append(("all joined", time.monotonic() - progress.began))
        while not master.over.wait(0.1):
            rigs.check()
            progress.tell(
                f"step {master.step} of {master.whole}, {master.checked} positions checked, {master.wrong} wrong"
            )
        if master.end:
            figures.tell(master, started)
    finally:
        with ending:
            rigs.close()
            if master is not None:
                master.close()
            kit.library.SilKit_Vendor_Vector_SilKitRegistry_Destroy(registry)
    for complaint in master.complaints:
        print(f"plant: {complaint}", file=sys.stderr)
    if not master.end:
        print("plant: the simulation ended too early", file=sys.stderr)
    expected = master.syncs * plant.nodes
    return 0 if master.end and master.wrong == 0 and master.checked == expected > 0 else 1


def main() -> int:
    plant = options()
    if plant.rig is not None:
        print(rig_file(plant.rig, plant, plant.registry), end="")
        return 0
    ending = Ending()
    with contextlib.closing(ending), tempfile.TemporaryDirectory(prefix="plant.") as folder:
        return run_rigs(plant, folder, ending) if plant.join else run_all(plant, folder, ending)


if __name__ == "__main__":
    sys.exit(main())
