# SPDX-License-Identifier: MIT
"""Rig files in this process: all that is in one, on one clock, without its wires."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from types import TracebackType

from ._native import EncoderError, models
from .canbus import CanBus
from .clock import Clock
from .course import is_file, split_words
from .encoder import Encoder
from .rigwords import NAME, Section, sections
from .rs485 import Line
from .shaft import Shaft
from .world import World

# What wires have of their own: there are none here.
OF_WIRES = {"pace", "cycle", "tear", "break_at", "clock_hz", "compensate", "line_delay_ns", "time", "step_us"}
# What is no setting of an encoder.
TAKEN = {"model", "shaft", "bus", "wire", "trace", "nvm"}
TURNS = 2**31 - 1


def _whole(text: str) -> int:
    """As the command takes it: 64, 0x40 or 40h."""
    text = text.lower()
    digits = text.removesuffix("h").removeprefix("0x")
    if not re.fullmatch("[0-9a-f]+", digits) or (digits == text and not digits.isdecimal()):
        raise EncoderError(f"{text or 'nothing'} is no number")
    return int(digits, 10 if digits == text else 16)


class Rig:
    """A rig file as `drehgeber run` takes it, in virtual time: Rig("bench.ini").advance(1.5).

    Its wires are not made. CANopen encoders of a [bus] share a CanBus, those with RS485 a Line; every other
    encoder has its master for itself. `nvm` files are read, and written by close(). Use it as a context to have
    that done. It closes the encoders, too."""

    def __init__(self, file: str | Path, *, clock: Clock | None = None) -> None:
        path = Path(file)
        self._begin(path.read_bytes(), path.name, path.parent, clock)

    @classmethod
    def of_text(cls, text: str, folder: str | Path = ".", *, clock: Clock | None = None) -> Rig:
        """A rig of the text of a file in `folder`."""
        rig = cls.__new__(cls)
        rig._begin(text.encode(), "text", Path(folder), clock)
        return rig

    def _begin(self, data: bytes, source: str, folder: Path, clock: Clock | None) -> None:
        self._folder = folder
        self.clock = clock or Clock()
        self.name = ""
        self.shafts: dict[str, Shaft] = {}
        self.buses: dict[str, CanBus] = {}
        self.lines: dict[str, Line] = {}
        self.encoders: dict[str, Encoder] = {}
        self._files: dict[str, Path] = {}
        self._wires: dict[str, Section] = {}  # a [bus], or an [encoder] with a wire of its own
        self._numbers: set[tuple[str, str]] = set()
        self._used: set[str] = set()
        self._own_shafts = False
        take = {"rig": self._rig, "shaft": self._shaft, "bus": self._bus, "encoder": self._encoders}
        for section in sections(source, data):
            take[section.kind](section.name.lower(), section)
        self.name = self.name or Path(source).stem
        for name, wire in self._wires.items():
            if wire.kind == "bus" and name not in self._used:
                raise wire.wrong("without encoders")
        if not self.encoders:
            raise EncoderError(f"{source}: no encoder; [encoder NAME] with model = MODEL is right")

    def _rig(self, _: str, section: Section) -> None:
        name = section.get("name")
        if name is None:
            return
        if not NAME.fullmatch(name):
            raise section.wrong(f"name {name}: 1 to 32 letters, digits, _ and - are right", "name")
        if self.name:
            raise section.wrong(f"the rig is called {self.name} already", "name")
        self.name = name

    def _shaft(self, name: str, section: Section) -> None:
        driver, motion = section.get("driver"), section.get("motion")
        if self.encoders and not self._own_shafts:
            raise section.wrong("shafts before all encoders are right")
        if name in self.shafts:
            raise section.wrong("already exists; another name is right")
        if motion is not None and driver is not None:
            raise section.wrong("motion: the driver turns this shaft; one of them is right", "motion")
        if "ratio" in section and driver is None:
            raise section.wrong("ratio: without a driver", "ratio")
        if driver is not None:
            above = self._shaft_named(section, "driver")
            ratio = self._ratio(section)
            self.shafts[name] = section.told("driver", lambda: Shaft(driver=above, ratio=ratio))
            return
        if motion is not None and motion.lower().endswith(".csv"):
            motion = str(self._folder / motion)
        self.shafts[name] = section.told("motion", lambda: Shaft(self.clock, motion or "0"))

    @staticmethod
    def _ratio(section: Section) -> tuple[int, int]:
        text = section.get("ratio") or "1:1"
        found = re.fullmatch(r"([+-]?\d+):([+-]?\d+)", text, re.ASCII)
        turns = [int(part) for part in found.groups()] if found else [0]
        if not all(0 < abs(number) <= TURNS for number in turns):
            raise section.wrong(f"ratio = {text}: TURNS:TURNS with whole numbers other than 0 is right", "ratio")
        return turns[0], turns[1]

    def _shaft_named(self, section: Section, key: str) -> Shaft:
        name = section.get(key) or ""
        if name.lower() not in self.shafts:
            raise section.wrong(f"no shaft {name} so far; the NAME of a [shaft] above is right", key)
        return self.shafts[name.lower()]

    def _wire(self, name: str, section: Section) -> None:
        if name in self._wires:
            raise section.wrong(f"line {self._wires[name].line} has the name already; another name is right")
        self._wires[name] = section

    def _bus(self, name: str, section: Section) -> None:
        """Of CAN or RS485; the encoders of others have their masters for themselves."""
        kind = section.get("wire")
        if kind is None:
            raise section.wrong("without a wire; wire = pty, for one, is right")
        if ":" in kind:
            raise section.wrong("wire = KIND and address = ADDRESS in a line each are right", "wire")
        for key in section.words:
            if key not in OF_WIRES and key not in ("wire", "address", "trace"):
                raise section.wrong(f"{key}: no key of a bus", key)
        self._wire(name, section)
        if kind in ("can", "slcan", "socketcand"):
            self.buses[name] = CanBus(clock=self.clock)
        elif kind in ("pty", "tty", "rs485"):
            self.lines[name] = Line(self.clock)

    def _bus_named(self, section: Section) -> str | None:
        """The bus of an encoder, which takes its wire's keys; None: it has a wire of its own, or none."""
        bus = section.get("bus")
        if bus is None:
            return None
        name = bus.lower()
        if "wire" in section:
            raise section.wrong("a bus and a wire; one of them is right", "bus")
        if name not in self._wires or self._wires[name].kind != "bus":
            raise section.wrong(f"no bus {bus} so far; the NAME of a [bus] above is right", "bus")
        if "trace" in section:
            raise section.wrong(f"trace: right in [bus {bus}], for all its encoders", "trace")
        self._used.add(name)
        return name

    def _encoders(self, name: str, section: Section) -> None:
        """One, or with node = FIRST..LAST, or address, one for each number; what else counts, counts up."""
        key = next((key for key in ("node", "address") if ".." in (section.get(key) or "")), None)
        if key is None:
            self._encoder(name, section)
            return
        if "wire" in section:
            raise section.wrong("several encoders have no wire of their own; bus = NAME of a [bus] is right", "wire")
        first, last = (section.told(key, partial(_whole, text)) for text in section.words[key].value.split("..", 1))
        if last < first:
            raise section.wrong(f"{key} = {section.get(key)}: FIRST..LAST is right", key)
        serial = section.told("serial", partial(_whole, section.get("serial") or "0"))
        for at in range(first, last + 1):
            number = str(at) if key == "node" else f"0x{at:02X}"
            one = section.named(f"{section.name}-{number}")
            if not NAME.fullmatch(one.name):
                raise section.wrong(f"{one.name} is too long for a name; a shorter name is right")
            one.put(key, number)
            if "serial" in section:
                one.put("serial", str(serial + at - first))
            if "nvm" in section:
                one.put("nvm", f"{section.get('nvm')}.{number}")
            self._encoder(one.name.lower(), one)

    def _encoder(self, name: str, section: Section) -> None:
        model = section.get("model")
        if name in self.encoders:
            raise section.wrong("already exists; another name is right")
        if model is None:
            mistyped = next((key for key, word in section.words.items() if word.value in models()), None)
            raise section.wrong("model = MODEL is right", mistyped)
        if not self.encoders:
            self._own_shafts = bool(self.shafts)
        if not self.shafts:
            self.shafts["main"] = Shaft(self.clock)
        shaft = self._shaft_named(section, "shaft") if "shaft" in section else next(iter(self.shafts.values()))
        bus = self._bus_named(section)
        encoder = section.told(
            "bus" if model in models() else "model",
            lambda: Encoder(
                model,
                shaft=shaft,
                bus=self.buses.get(bus) if bus is not None else None,
                line=self.lines.get(bus) if bus is not None else None,
                power=False,
            ),
        )
        if "wire" in section:
            self._wire(name, section)
        self._set_up(name, section, encoder, bus)
        self.encoders[name] = encoder

    def _set_up(self, name: str, section: Section, encoder: Encoder, bus: str | None) -> None:
        courses = {}
        for key, word in section.words.items():
            if World.senses(key) and is_file(word.value):
                courses[key] = section.told(key, partial(split_words, word.value))
            elif key in OF_WIRES and not self._has(encoder, key):
                if bus is not None:
                    raise section.wrong(f"{key}: right in [bus {bus}], for all its encoders", key)
            elif key not in TAKEN:
                section.told(key, partial(encoder.set, key, word.value))
        self._number(section, encoder, bus)
        nvm = section.get("nvm")
        if nvm is not None:
            self._remember(name, section, encoder, self._folder / nvm)
        for key, (file, *_) in courses.items():
            section.told(key, partial(encoder.world.begin, key, self._folder / file))
        section.told(None, encoder._start)
        for key, (file, loop, steps) in courses.items():
            section.told(key, partial(encoder.world.play, key, self._folder / file, loop=loop, steps=steps))

    def _number(self, section: Section, encoder: Encoder, bus: str | None) -> None:
        """What a bus tells its encoders apart by."""
        key = encoder._address_key()
        if bus is None or key is None:
            return
        number = encoder.get(key)
        if (bus, number) in self._numbers:
            raise section.wrong(f"{key} {number}: there is one on {bus} already", key)
        self._numbers.add((bus, number))

    def _remember(self, name: str, section: Section, encoder: Encoder, path: Path) -> None:
        if path in self._files.values():
            raise section.wrong(f"nvm: {path.name} is of another encoder", "nvm")
        self._files[name] = path
        if path.exists() and path.stat().st_size:
            image = path.read_bytes()
            section.told("nvm", lambda: setattr(encoder, "memory", image))

    @staticmethod
    def _has(encoder: Encoder, key: str) -> bool:
        return key in (setting.name for setting in encoder.settings())

    def advance(self, seconds: float) -> None:
        """Let virtual time pass for the whole rig."""
        self.clock.advance(seconds)

    def close(self) -> None:
        """Write the `nvm` files, as the memories are now, and close the encoders."""
        for name, path in self._files.items():
            path.write_bytes(self.encoders[name].memory)
        self._files.clear()
        for encoder in self.encoders.values():
            encoder.close()

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
