#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A plant: 10 000 CANopen encoders as a rig of 80 buses with 125 nodes each, in one SIL Kit simulation with its master,
which turns a shaft for each bus, says SYNC on it, and checks each position that it is told against that shaft. The
frames of a bus travel packed, those of a step in one message.

Prints what it took. The status is 1 when a position was wrong or missing. Needs the command drehgeber, a C compiler for
the master, and SIL Kit's libSilKit.so, which README.md says how to get.
"""

import argparse
import contextlib
import ctypes
import os
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from ctypes import c_char_p, c_int, c_void_p
from pathlib import Path

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[2]
PATIENCE_S = 120
PROCESSES_MAX, THREADS_MAX = 256, 64
REFUSED = 2  # the master has printed why


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


# ---------------------------------------------------------------- processes


class Registry:
    """It introduces the participants to each other, in this process."""

    def __init__(self, library: str, uri: str):
        try:
            self.library = ctypes.CDLL(library)
        except OSError as error:
            sys.exit(f"plant: no SIL Kit library: {error}; $DREHGEBER_SILKIT_LIBRARY names one, see README.md")
        self.library.SilKit_GetLastErrorString.restype = c_char_p
        configuration, self.made, listens = c_void_p(), c_void_p(), c_char_p()
        self._call("ParticipantConfiguration_FromString", ctypes.byref(configuration), b'{"Logging":{"Sinks":[]}}')
        self._call("Vendor_Vector_SilKitRegistry_Create", ctypes.byref(self.made), configuration)
        self._call("Vendor_Vector_SilKitRegistry_StartListening", self.made, uri.encode(), ctypes.byref(listens))

    def _call(self, function: str, *arguments: object) -> None:
        if getattr(self.library, f"SilKit_{function}")(*arguments) != 0:
            sys.exit(f"plant: SIL Kit: {function}: {self.library.SilKit_GetLastErrorString().decode()}")

    def close(self) -> None:
        """Participants that have joined go on."""
        self.library.SilKit_Vendor_Vector_SilKitRegistry_Destroy(self.made)


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
    """Seconds on a processor so far, of all threads, to the nanosecond."""
    clock = c_int()
    if ctypes.CDLL(None).clock_getcpuclockid(pid, ctypes.byref(clock)) != 0:
        raise ProcessLookupError(pid)
    return time.clock_gettime(clock.value)


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


def compile_master(folder: str, ending: Ending) -> str:
    """The program, from the sources beside this script."""
    program = f"{folder}/master"
    command = ["cc", "-std=c11", "-O2", "-o", program, *map(str, sorted(HERE.glob("*.c"))), "-ldl", "-pthread"]
    try:
        with ending:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
            )
    except OSError as error:
        sys.exit(f"plant: cc: {error.strerror}; a C compiler makes the master, or --master names one that is made")
    if done.returncode != 0:
        sys.exit(f"plant: cc has ended with {done.returncode}: {done.stdout.strip()}")
    return program


class Master:
    """The program that turns the shafts and checks the positions. A line of it is a word and what belongs to it: master.c
    lists them. Behind `begin` and `end` it waits for a line. It leaves the simulation when its input ends."""

    def __init__(self, program: str, plant: argparse.Namespace, uri: str):
        numbers = {name: getattr(plant, name) for name in ("processes", "buses", "nodes", "ms", "step_us", "sync_ms")}
        numbers |= {"aggregate": plant.aggregate, "packed": int(plant.frames == "packed"), "hash": int(plant.hash)}
        try:
            self.process = subprocess.Popen(
                [program, uri, *(f"{name}={number}" for name, number in numbers.items())], bufsize=0,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**os.environ, "DREHGEBER_SILKIT_LIBRARY": plant.library},
            )  # fmt: skip
        except OSError as error:
            sys.exit(f"plant: {program}: {error.strerror}; --master names the program")
        self.rest = b""

    def lines(self, seconds: float) -> Iterator[tuple[str, str]]:
        """Those that it prints within this time, at least one if there is one. Its end is the word `ended`."""
        if not select.select([self.process.stdout], [], [], seconds)[0]:
            return
        read = os.read(self.process.stdout.fileno(), 1 << 16)
        *whole, self.rest = (self.rest + read).split(b"\n")
        for line in whole:
            word, _, rest = line.decode(errors="replace").partition(" ")
            yield word, rest
        if not read:
            yield "ended", ""

    def answer(self) -> None:
        """It goes on."""
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(b"\n")

    def close(self) -> int:
        """End it. @return its status"""
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
        return self.process.wait()


# ---------------------------------------------------------------- figures


class Figures:
    """What it took, with the processes that run here."""

    def __init__(self, rigs: Rigs, master: Master, plant: argparse.Namespace):
        self.pids = [process.pid for process in (master.process, *rigs.all)]
        self.plant = plant
        self.before: list[float] = []
        self.after: list[float] = []
        self.memory: list[int] = []

    def begin(self) -> None:
        """The first step that counts."""
        self.before = list(map(spent_s, self.pids))

    def end(self) -> None:
        """Behind the last one."""
        self.after = list(map(spent_s, self.pids))
        self.memory = list(map(memory_kb, self.pids))

    def tell(self, told: dict[str, str], started: list[tuple[str, float]]) -> None:
        """A line for each, of what the master has told."""
        plant, wall = self.plant, float(told["seconds"])
        steps, carried = int(told["steps"]), int(told["frames"])
        virtual = steps * plant.step_us / 1e6
        used = [after - before for before, after in zip(self.before, self.after)]
        here = len(self.pids) - 1
        frames = max(1, carried)
        theirs = max(1, frames * here // plant.processes)
        rows = [
            ("encoders", f"{plant.all * plant.nodes} = {plant.processes} rigs x {plant.buses} buses x {plant.nodes} nodes"),
            ("start-up", ", ".join(f"{what} {seconds:.2f} s" for what, seconds in started)),
            ("memory", f"{sum(self.memory[1:]) / 1024:.0f} MB in {here} rigs, {self.memory[0] / 1024:.0f} MB master"),
            ("simulated", f"{virtual:.2f} s in steps of {plant.step_us} us, SYNC each {plant.sync_ms} ms: {wall:.2f} s"),
            ("virtual s per s", f"{virtual / wall:.3f}"),
            ("steps/s", f"{steps / wall:.0f}"),
            ("frames/s", f"{(carried + int(told['syncs'])) / wall:.0f}"),
            ("processor", f"{sum(used[1:]):.3f} s in {here} rigs, {used[0]:.3f} s master, of {os.cpu_count()} cores"),
            ("a frame", f"{sum(used[1:]) * 1e6 / theirs:.3f} us in its rig, {used[0] * 1e6 / frames:.3f} us in the master"),
            ("positions", f"{told['checked']} checked, {told['wrong']} wrong"),
        ]
        if "hash" in told:
            rows.append(("hash", told["hash"]))
        for name, figure in rows:
            print(f"{name:19} {figure}", flush=True)


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
    parser.add_argument("--master", metavar="PROGRAM", help="the compiled master (compile master.c with cc)")
    parser.add_argument("--hash", action="store_true", help="print a hash of all packed frames that the master received")
    plant = parser.parse_args()
    plant.here = plant.here if plant.here is not None else range(plant.processes)
    plant.all = plant.processes * plant.buses
    plant.library = library()
    if (plant.join or plant.rig is not None) and plant.registry is None:
        parser.error("--registry silkit://HOST:PORT says where the master is")
    if plant.registry is not None and not re.fullmatch(r"silkit://[^/,\s]+:\d{1,5}", plant.registry):
        parser.error(f"--registry {plant.registry}: expected silkit://HOST:PORT")
    if plant.hash and plant.frames != "packed":
        parser.error("--hash is of packed frames")
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


def follow(master: Master, rigs: Rigs, figures: Figures, began: float) -> tuple[dict[str, str], list[str]]:
    """Until the simulation is over. @return what the master has told, and its complaints"""
    told: dict[str, str] = {}
    complaints: list[str] = []
    while not told.keys() & {"over", "ended"}:
        rigs.check()
        for word, rest in master.lines(0.1):
            told[word] = rest
            if word == "begin":
                figures.begin()
                master.answer()
            elif word == "end":
                figures.end()
                master.answer()
            elif word == "joined":
                told[word] = f"{time.monotonic() - began:.2f}"
            elif word == "progress":
                print(f"plant: {rest}, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
            elif word == "complaint":
                complaints.append(rest)
    return told, complaints


def run_all(plant: argparse.Namespace, folder: str, ending: Ending) -> int:
    """The registry, the rigs of this machine, the master."""
    program = plant.master or compile_master(folder, ending)
    began = time.monotonic()
    uri = plant.registry or f"silkit://127.0.0.1:{free_port()}"
    registry = Registry(plant.library, uri)
    rigs, master, status = Rigs(plant, uri, folder, ending), None, 1
    try:
        rigs.start()
        rigs.wait_ready()
        started = [("encoders ready", time.monotonic() - began)]
        with ending:
            master = Master(program, plant, uri)
        figures = Figures(rigs, master, plant)
        told, complaints = follow(master, rigs, figures, began)
        if "end" in told and "over" in told:
            figures.tell(told, [*started, ("all joined", float(told["joined"]))])
    finally:
        with ending:
            rigs.close()
            if master is not None:
                status = master.close()
            registry.close()
    for complaint in complaints:
        print(f"plant: {complaint}", file=sys.stderr)
    if status not in (0, 1, REFUSED):
        print(f"plant: the master has ended with {status}", file=sys.stderr)
    elif status != REFUSED and "end" not in told:
        print("plant: the simulation ended too early", file=sys.stderr)
    return min(1, abs(status))


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
