# SPDX-License-Identifier: MIT
"""Rigs as context managers: the process, its encoders, its shafts."""

import contextlib
import os
import pathlib
import queue
import shutil
import subprocess
import tempfile
import threading
import time

from .control import Control

READY_S = 30.0
STOP_S = 10.0
# Wires whose addresses in a rig end in the encoder's place.
PLACED = ("can", "slcan", "modbus")


class RigError(Exception):
    """The rig did not start, or has ended; the text is what it said."""


def program():
    """The drehgeber command: $DREHGEBER, else the one on PATH."""
    found = os.environ.get("DREHGEBER") or shutil.which("drehgeber")
    if not found:
        raise RigError("no drehgeber command: put it on PATH, or its path into $DREHGEBER")
    return found


class Shaft:
    """A shaft: angles in degrees, speeds in rpm, positive clockwise. It is steered through an
    encoder that sits on it."""

    def __init__(self, encoder):
        self._encoder = encoder

    @property
    def name(self):
        return self._encoder.ask("SHAF:NAME?").strip('"')

    @property
    def position(self):
        return float(self._encoder.ask("SHAF:POS?"))

    @position.setter
    def position(self, degrees):
        self._encoder.ask(f"SHAF:POS {degrees:.9f} DEG")

    @property
    def velocity(self):
        return float(self._encoder.ask("SHAF:VEL?"))

    @velocity.setter
    def velocity(self, rpm):
        self._encoder.ask(f"SHAF:VEL {rpm:.3f} RPM")

    @property
    def acceleration(self):
        return float(self._encoder.ask("SHAF:ACC?"))

    @acceleration.setter
    def acceleration(self, rpm_per_s):
        self._encoder.ask(f"SHAF:ACC {rpm_per_s:.3f} RPM/S")

    def move(self, degrees, rpm=60, wait=True):
        """Go to an angle; `wait` until it is there."""
        self._encoder.ask(f"SHAF:MOVE {degrees:.9f} DEG,{rpm:.3f} RPM")
        if wait:
            self._encoder.ask("*OPC?")

    def stop(self):
        self._encoder.ask("SHAF:STOP")

    def play(self, motion):
        """What --shaft takes: "sine:90DEG,2S", "run.csv", ..."""
        self._encoder.ask(f'SHAF:PROF "{motion}"')


class Encoder:
    """An encoder of a running rig."""

    def __init__(self, rig, name, model, wire, address, place=None):
        self._rig = rig
        self.name = name
        self.model = model
        self.wire = wire  # "pty", "can", ...
        self.address = address  # what a master opens
        self.place = place  # node-ID on CAN, place in a ring; None: there is none, or it is not said
        self.shaft = Shaft(self)

    def ask(self, line):
        """An SCPI line to this encoder."""
        return self._rig.control.ask(f"INST:SEL {self.name};:{line.lstrip(':')}")

    def state(self):
        """STATe? as a dictionary of strings."""
        parts = self._rig.control.parts(f"INST:SEL {self.name};:STAT?")
        return dict(part.split("=", 1) for part in parts)

    def world(self, quantity, value=None):
        """A quantity of WORLd (e.g. "TEMP", "LED:CURR"): set it, or ask for it."""
        if value is None:
            return self.ask(f"WORL:{quantity}?")
        return self.ask(f"WORL:{quantity} {value}")

    def faults(self):
        """The catalogue: dictionaries with name, kind, cause, effect and chapter."""
        keys = ("name", "kind", "cause", "effect", "chapter")
        parts = self._rig.control.parts(f"INST:SEL {self.name};:FAUL:CAT?")
        return [dict(zip(keys, parts[i : i + 5])) for i in range(0, len(parts), 5)]

    def set_fault(self, name, count=None, probability=None, duration_ms=None):
        line = f"FAUL:SET {name}"
        for word, value, unit in (
            ("COUN", count, ""),
            ("PROB", probability, ""),
            ("DUR", duration_ms, " MS"),
        ):
            if value is not None:
                line += f",{word} {value}{unit}"
        self.ask(line)

    def clear_fault(self, name=""):
        """Clear one fault, or all."""
        self.ask(f"FAUL:CLE {name}".rstrip())

    @contextlib.contextmanager
    def fault(self, name, **limits):
        """A fault for as long as the block lasts."""
        self.set_fault(name, **limits)
        try:
            yield self
        finally:
            self.clear_fault(name)

    def power(self, state):
        """True, False, or "CYCLE"."""
        word = state if isinstance(state, str) else ("ON" if state else "OFF")
        self.ask(f"POW {word}")


def parse_ready(rig, line):
    """The encoder of a line "ready MODEL WIRE:ADDRESS [NAME]"; None for any other line."""
    words = line.split(" ")
    if words[0] != "ready" or len(words) not in (3, 4):
        return None
    wire, _, address = words[2].partition(":")
    if len(words) == 3:  # from the command line: the only one, or a whole ring
        return Encoder(rig, words[1], words[1], wire, address)
    place = None
    if wire in PLACED:
        address, _, place = address.rpartition("/")
    return Encoder(rig, words[3], words[1], wire, address, None if place is None else int(place))


class Rig:
    """A running drehgeber. Use run() or rig()."""

    def __init__(self, arguments, folder=None):
        self._scratch = pathlib.Path(tempfile.mkdtemp(prefix="drehgeber-"))
        self.socket = f"{self._scratch}/control.sock"  # the control plane, for other programs
        address = f"unix:{self.socket}"
        self.control = None
        self.encoders = {}
        self.lines = []  # everything it printed
        self._queue = queue.Queue()
        try:
            self._process = subprocess.Popen(
                [program(), "run", *map(str, arguments), "--control", address],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                cwd=folder,
            )
        except (OSError, RigError) as error:
            shutil.rmtree(self._scratch, ignore_errors=True)
            raise RigError(f"not started: {error}") from error
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        try:
            self._wait_until_ready(address)
            self.control = Control(address)
        except BaseException:
            with contextlib.suppress(RigError):
                self.close()
            raise

    def _read(self):
        for line in self._process.stdout:
            self.lines.append(line.rstrip("\n"))
            self._queue.put(line.rstrip("\n"))
        self._queue.put(None)

    def _wait_until_ready(self, address):
        end = time.monotonic() + READY_S
        while True:
            try:
                line = self._queue.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise RigError(f"not ready after {READY_S} s: {self.lines}") from None
            if line is None:
                raise RigError("\n".join(self.lines) or "ended without a word")
            encoder = parse_ready(self, line)
            if encoder is not None:
                self.encoders[encoder.name] = encoder
            if line == f"control {address}":  # the last line, but for "ready rig"
                return

    @property
    def pid(self):
        return self._process.pid

    def ask(self, line):
        """An SCPI line."""
        return self.control.ask(line)

    def close(self):
        """End it. Raises RigError when it had ended by itself, or did not end well."""
        if self.control is not None:
            self.control.close()
            self.control = None
        early = self._process.poll()
        if early is None:
            self._process.terminate()
        try:
            status = self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            status = self._process.wait()
        self._reader.join(STOP_S)
        self._process.stdout.close()
        shutil.rmtree(self._scratch, ignore_errors=True)
        if early is not None or status != 0:
            said = "\n".join(self.lines)
            raise RigError(f"ended {'early ' if early is not None else ''}with {status}: {said}")

    def __enter__(self):
        return self

    def __exit__(self, kind, value, trace):
        try:
            self.close()
        except RigError:
            if kind is None:  # do not hide what went wrong inside
                raise


def run(*arguments, folder=None):
    """`drehgeber run ARGUMENTS...`, ready. A context manager."""
    return Rig(arguments, folder)


@contextlib.contextmanager
def rig(text):
    """A rig from the text of a rig file, in a folder of its own that goes with it."""
    with tempfile.TemporaryDirectory(prefix="drehgeber-") as folder:
        path = pathlib.Path(folder) / "rig.ini"
        path.write_text(text)
        with run(path, folder=folder) as running:
            yield running
