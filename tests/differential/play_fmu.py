# SPDX-License-Identifier: MIT
"""The player of FMUs in fmpy: scripts come in, logs go out. README.md has the language.

usage: play_fmu.py 2|3, the version of FMI. The command, $DREHGEBER, makes the FMUs: one for each model, and for each
script of several encoders one of its rig file."""

import math
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[1] / "fmu"))
from conftest import DREHGEBER, Fmu, Slave, Slave2  # noqa: E402
from play_command import write_shared_rig  # noqa: E402
from script import SHARED, read_scripts, word_of  # noqa: E402

SECOND = 1_000_000_000
MARGIN_S = 0.4e-9
COUNTS_OF_RAD = (1 << 32) / (2 * math.pi)
RPM = 2 * math.pi / 60
TRANSMIT = 0x10
UNKNOWN, NO_POWER = -8, -9
WIRES = {"rs485": "RS485", "f3658": "CanChannel", "f3668": "CanChannel", "line": "RS485", "can": "CanChannel"}
BUS = "it"  # of the rig file of a script


def characters(data: bytes) -> list[str]:
    """What an encoder with RS485 has said, as lines of a log."""
    lines = []
    while data:
        at, one, count, _ = struct.unpack_from("<QIHH", data)
        lines += [f"  @{at + (i + 1) * one} byte {byte:02x}" for i, byte in enumerate(data[16 : 16 + count])]
        data = data[16 + count :]
    return lines


def messages(data: bytes, now: int) -> list[str]:
    """Frames of FMI-LS-BUS, which are of this moment."""
    lines = []
    while data:
        code, length = struct.unpack_from("<II", data)
        if code == TRANSMIT:
            number, _, remote = struct.unpack_from("<IBB", data, 8)
            lines.append(f"  @{now} message {number:x} {remote * 8:x} {data[16:length].hex()};")
        data = data[length:]
    return lines


class Signals:
    """An instance of FMI 2.0, as if it were one of FMI 3.0 without events."""

    def __init__(self, fmu: Fmu, early: bool, **settings: Any) -> None:
        assert early
        self.fmu = fmu
        self.inner = Slave2(fmu, **settings)
        self.step, self.close = self.inner.step, self.inner.close

    @property
    def time(self) -> float:
        return self.inner.time

    def set(self, name: str, value: Any) -> None:
        self.inner.set(self.fmu.kinds[name], name, value)

    def get(self, name: str) -> Any:
        return self.inner.get(self.fmu.kinds[name], name)


class Player:
    """An FMU, to which a script happens; `bus` is that of several encoders."""

    def __init__(self, fmu: Fmu, model: str, settings: dict[str, Any], number: int, bus: str = "") -> None:
        signals = fmu.description.fmiVersion.startswith("2")
        self.wire = "" if signals else bus + WIRES.get(model, WIRES.get(model.partition("-")[2], ""))
        self.slave: Any = (Signals if signals else Slave)(fmu, early=True, **settings)
        self.number = number
        self.rig = bus != ""
        self.prefix = ""  # of variables of the encoder that an operation is about
        self.line = ""

    @property
    def now(self) -> int:
        return round(self.slave.time * SECOND)

    def tell(self, data: bytes) -> None:
        lines = characters(data) if self.wire.endswith("RS485") else messages(data, self.now)
        print("".join(line + "\n" for line in lines), end="")

    def end_operation(self) -> None:
        """Its line stands behind what the encoder has sent at that moment."""
        print(self.line, end="")
        self.line = ""

    def go(self, at: int) -> None:
        """From event to event. What an operation has caused at once is told in the step behind it, but by a rig."""
        begin = self.now
        while at / SECOND - self.slave.time > MARGIN_S:
            event = self.slave.step(at / SECOND - self.slave.time)
            if self.now > begin:
                self.end_operation()
            if event and self.wire:
                self.tell(self.slave.fetch(self.wire))
        if at > begin:
            self.end_operation()

    def perform(self, words: list[str]) -> None:
        at, name, *arguments = words
        self.go(int(at))
        self.number += 1
        of, _, word = name.rpartition(":")
        self.prefix = f"e{of}." if of else ""
        answer = OPERATIONS[word](self, *arguments)
        if self.wire:
            self.tell(self.slave.fetch(self.wire))
        self.line += f"{self.number} {name}{answer}\n"
        if self.rig:
            self.end_operation()

    def close(self) -> None:
        self.go(self.now + 1)
        self.slave.close()

    # ------------------------------------------------------------ physics

    def give(self, name: str, value: Any) -> str:
        name = self.prefix + name
        if name not in self.slave.fmu.names:
            return f" {UNKNOWN}"
        self.slave.set(name, bool(value) if self.slave.fmu.kinds[name] == "Boolean" else value)
        return " 0"

    def power(self, on: str) -> str:
        if on == "1":
            self.give("power", False)  # on while it is on is a restart
        return self.give("power", on == "1")

    def shaft(self, angle: str, mrpm: str) -> str:
        self.give("shaft.angle", int(angle) / COUNTS_OF_RAD)
        self.give("shaft.speed", int(mrpm) / 1000 * RPM)
        return ""

    def world(self, name: str, value: str) -> str:
        return self.give(f"world.{name}", int(value) / (1000 if name == "temperature" else 1))

    def fault(self, name: str, on: str) -> str:
        return self.give(f"fault.{name}", on == "1")

    # ------------------------------------------------------------ wires

    def bytes(self, data: str) -> str:
        body = bytes.fromhex(data)
        self.tell(self.slave.send(self.wire, struct.pack("<QIHH", 0, 0, len(body), 0) + body))
        return " 0"

    def send(self, number: int, remote: int, dlc: int, body: bytes) -> str:
        head = struct.pack("<IIIBBH", TRANSMIT, 16 + len(body), number, 0, remote, dlc)
        self.tell(self.slave.send(self.wire, head + body))
        return " 0"

    def can(self, number: str, data: str) -> str:
        body = bytes.fromhex(data.strip("-"))
        return self.send(int(number), 0, len(body), body)

    def remote(self, number: str, dlc: str) -> str:
        return self.send(int(number), 1, int(dlc), bytes(int(dlc)))

    def latch(self) -> str:
        self.slave.tick("MA")
        bits, count, position, good, error, warning = (
            self.slave.get(name) for name in ("frame", "frame.bits", "frame.position", "frame.good", "nERR", "nWARN"))
        return f" 0 {bits:x}/{count} {position:x} {not error:d}{not warning:d}{good:d}"

    # ------------------------------------------------------------ looks

    def result(self) -> int:
        """An FMU shows 0 without power, and has no results."""
        return 0 if self.slave.get(self.prefix + "power") else NO_POWER

    def position(self) -> str:
        return f" {self.result()} {int(self.slave.get(self.prefix + 'position')):x}"

    def sincos(self) -> str:
        volts = (self.slave.get(name) for name in ("sin_plus", "sin_minus", "cos_plus", "cos_minus"))
        return f" {self.result()} " + " ".join(str(round(volt * 1e6)) for volt in volts)


OPERATIONS: dict[str, Callable[..., str]] = {
    "power": Player.power, "shaft": Player.shaft, "world": Player.world, "fault": Player.fault,
    **dict.fromkeys(("bytes", "meet", "over", "twin"), Player.bytes), "can": Player.can, "remote": Player.remote, "latch": Player.latch, "position": Player.position,
    "sincos": Player.sincos,
}


def setting_of(kind: str, value: str) -> Any:
    if kind == "Boolean":
        return value == "1"
    return value if kind == "String" else float(value) if kind in ("Float64", "Real") else int(value)


def make_fmu(folder: str, model: str, version: str) -> Fmu:
    path = f"{folder}/{Path(model).stem}.fmu"
    subprocess.run([DREHGEBER, "fmu", model, "--fmi", version, "--output", path], check=True)
    return Fmu(Path(path))


def play(fmu: Fmu, script: list[list[str]]) -> None:
    """Settings come first, while the FMU is initialized."""
    (_, model, _), *lines = script
    print(" ".join(script[0]))
    settings = {"power": False}
    number = 0
    while lines[0][1] == "set":
        _, _, name, value = lines.pop(0)
        number += 1
        known = name in fmu.kinds
        if known:
            settings[name] = setting_of(fmu.kinds[name], value)
        print(f"{number} set {0 if known else UNKNOWN}")
    player = Player(fmu, model, settings, number)
    for words in lines:
        player.perform(words)
    player.close()


def play_rig(script: list[list[str]], folder: str, version: str) -> None:
    """Several encoders: what is set before the first power-on is in their rig file."""
    head, *lines = script
    print(" ".join(head))
    path = Path(folder, f"{BUS}.ini")
    numbers = write_shared_rig(path, head[1], lines)
    fmu = make_fmu(folder, str(path), version)
    begin = next(i for i, words in enumerate(lines) if word_of(words[1]) not in ("set", "encoder"))
    for number, words in enumerate(lines[:begin], 1):
        print(f"{number} {words[1]} 0")
    player = Player(fmu, head[1], {f"e{number}.power": False for number in numbers}, begin, f"{BUS}.")
    for words in lines[begin:]:
        player.perform(words)
    player.close()
    shutil.rmtree(fmu.folder)


def main() -> None:
    scripts = read_scripts(sys.stdin)
    with tempfile.TemporaryDirectory() as folder:
        models = {script[0][1] for script in scripts} - set(SHARED)
        fmus = {model: make_fmu(folder, model, sys.argv[1]) for model in models}
        for script in scripts:
            if script[0][1] in SHARED:
                play_rig(script, folder, sys.argv[1])
            else:
                play(fmus[script[0][1]], script)
        for fmu in fmus.values():
            shutil.rmtree(fmu.folder)


main()
