# SPDX-License-Identifier: MIT
"""Rigs of the drehgeber command as context managers: the process, its encoders, its shafts."""

from __future__ import annotations

import contextlib
import os
import pathlib
import queue
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Literal

from .control import Control
from .instrument import Instrument, power_word

READY_S = 30.0
STOP_S = 10.0
# Wires whose address is only a path. In a rig that of each other wire ends in the encoder's place, if it has one.
PATHS = ("pty", "tty", "gpio")


class RigError(Exception):
    """The rig did not start, or has ended; the text is what it said."""


def program() -> str:
    """The drehgeber command: $DREHGEBER, else the one on PATH."""
    found = os.environ.get("DREHGEBER") or shutil.which("drehgeber")
    if not found:
        raise RigError(
            "no drehgeber command: it comes with the package of the system or a build (cmake --install); "
            "put it on PATH, or its path into $DREHGEBER. drehgeber.Encoder needs none"
        )
    return found


class RunningShaft:
    """A shaft: angles in degrees, speeds in rpm, positive clockwise. It is steered through an
    encoder that sits on it."""

    def __init__(self, encoder: RunningEncoder) -> None:
        self._encoder = encoder

    def _told(self, query: str) -> str:
        return self._encoder.ask(query) or ""

    @property
    def name(self) -> str:
        """Its name in the rig."""
        return self._told("SHAF:NAME?").strip('"')

    @property
    def position(self) -> float:
        """Degrees."""
        return float(self._told("SHAF:POS?"))

    @position.setter
    def position(self, degrees: float) -> None:
        self._encoder.ask(f"SHAF:POS {degrees:.9f} DEG")

    @property
    def velocity(self) -> float:
        """rpm; setting it turns at that speed."""
        return float(self._told("SHAF:VEL?"))

    @velocity.setter
    def velocity(self, rpm: float) -> None:
        self._encoder.ask(f"SHAF:VEL {rpm:.3f} RPM")

    @property
    def acceleration(self) -> float:
        """rpm per second of commands to come; 0: at once."""
        return float(self._told("SHAF:ACC?"))

    @acceleration.setter
    def acceleration(self, rpm_per_s: float) -> None:
        self._encoder.ask(f"SHAF:ACC {rpm_per_s:.3f} RPM/S")

    def move(self, degrees: float, rpm: float = 60, wait: bool = True) -> None:
        """Go to an angle; `wait` until it is there."""
        self._encoder.ask(f"SHAF:MOVE {degrees:.9f} DEG,{rpm:.3f} RPM")
        if wait:
            self._encoder.ask("*OPC?")

    def stop(self) -> None:
        """To a standstill, with the acceleration."""
        self._encoder.ask("SHAF:STOP")

    def play(self, motion: str) -> None:
        """What --shaft takes: "sine:90DEG,2S", "run.csv", ..."""
        self._encoder.ask(f'SHAF:PROF "{motion}"')


class RunningEncoder(Instrument):
    """An encoder of a running rig."""

    def __init__(
        self,
        rig: RunningRig | None,
        name: str,
        model: str,
        wire: str,
        address: str,
        place: int | None = None,
    ) -> None:
        self._rig = rig
        self.name = name
        self.model = model
        self.wire = wire  # "pty", "can", ...
        self.address = address  # what a master opens
        self.place = place  # node-ID on CAN, place in a ring; None: there is none, or it is not said
        self.shaft = RunningShaft(self)

    def ask(self, line: str) -> str | None:
        """An SCPI line to this encoder."""
        assert self._rig is not None
        return self._rig.ask(f"INST:SEL {self.name};:{line.lstrip(':')}")

    def world(self, quantity: str, value: str | float | None = None) -> str | None:
        """A quantity of WORLd (e.g. "TEMP", "LED:CURR"): set it, or ask for it."""
        if value is None:
            return self.ask(f"WORL:{quantity}?")
        return self.ask(f"WORL:{quantity} {value}")

    def power(self, state: bool | Literal["CYCLE"]) -> None:
        """True, False, or "CYCLE"."""
        self.ask(f"POW {power_word(state)}")


def parse_ready(rig: RunningRig | None, line: str) -> RunningEncoder | None:
    """The encoder of a line "ready MODEL WIRE:ADDRESS [NAME]"; None for any other line."""
    words = line.split(" ")
    if words[0] != "ready" or len(words) not in (3, 4):
        return None
    wire, _, address = words[2].partition(":")
    if len(words) == 3:  # from the command line: the only one, or a whole ring
        return RunningEncoder(rig, words[1], words[1], wire, address)
    head, slash, place = address.rpartition("/")
    if wire in PATHS or slash == "" or not place.isdecimal():
        return RunningEncoder(rig, words[3], words[1], wire, address, None)
    return RunningEncoder(rig, words[3], words[1], wire, head, int(place))


class RunningRig:
    """A running drehgeber. Use run() or rig()."""

    def __init__(self, arguments: tuple[object, ...], folder: str | Path | None = None) -> None:
        self._scratch = pathlib.Path(tempfile.mkdtemp(prefix="drehgeber-"))
        self.socket = f"{self._scratch}/control.sock"  # the control plane, for other programs
        address = f"unix:{self.socket}"
        self.control: Control | None = None
        self.encoders: dict[str, RunningEncoder] = {}
        self.lines: list[str] = []  # everything it printed
        self._queue: queue.Queue[str | None] = queue.Queue()
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

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.lines.append(line.rstrip("\n"))
            self._queue.put(line.rstrip("\n"))
        self._queue.put(None)

    def _wait_until_ready(self, address: str) -> None:
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
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def ask(self, line: str) -> str | None:
        """An SCPI line; its answer, None when it has none."""
        if self.control is None:
            raise RigError("it has ended")
        return self.control.ask(line)

    def close(self) -> None:
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
        if self._process.stdout is not None:
            self._process.stdout.close()
        shutil.rmtree(self._scratch, ignore_errors=True)
        if early is not None or status != 0:
            said = "\n".join(self.lines)
            raise RigError(f"ended {'early ' if early is not None else ''}with {status}: {said}")

    def __enter__(self) -> RunningRig:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self.close()
        except RigError:
            if kind is None:  # do not hide what went wrong inside
                raise


def run(*arguments: object, folder: str | Path | None = None) -> RunningRig:
    """`drehgeber run ARGUMENTS...`, ready. A context manager."""
    return RunningRig(arguments, folder)


@contextlib.contextmanager
def rig(text: str) -> Iterator[RunningRig]:
    """A rig from the text of a rig file, in a folder of its own that goes with it."""
    with tempfile.TemporaryDirectory(prefix="drehgeber-") as folder:
        path = pathlib.Path(folder) / "rig.ini"
        path.write_text(text)
        with run(path, folder=folder) as running:
            yield running
