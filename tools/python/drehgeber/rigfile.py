# SPDX-License-Identifier: MIT
"""Rig files in this process: all that is in one, on one clock, without its wires."""

from __future__ import annotations

import functools
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

from ._native import Medium, text_of
from .canbus import CanBus
from .chain import Chain
from .clock import Clock
from .clocked import Biss
from .course import is_file, split_words
from .encoder import Encoder
from .model import Model
from .plan import Plan
from .ring import Ring
from .rs485 import Line
from .shaft import Shaft
from .world import World


class Rig:
    """A rig file as `drehgeber run` takes it, in virtual time: Rig("bench.ini").advance(1.5).

    Its wires are not made. CANopen encoders of a [bus] share a CanBus, those with RS485 a Line, INTERBUS encoders a
    Ring, BiSS encoders a Chain; every other encoder has its master for itself. `nvm` files are read, and written by
    close(). Use it as a context to have that done. It closes the encoders, too."""

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
        self._plan = plan = Plan(source, data, folder)
        self.clock = clock or Clock()
        self.name = plan.name
        self.shafts: dict[str, Shaft] = {}
        self.buses: dict[str, CanBus] = {}
        self.lines: dict[str, Line] = {}
        self.encoders: dict[str, Encoder] = {}
        self._files: dict[str, Path] = {}
        self._shared: dict[str, list[Encoder]] = {}  # of each [bus]
        for row in plan.each("shafts", "shaft_count"):
            self._make_shaft(row)
        for row in plan.each("wires", "wire_count"):
            self._make_wire(row)
        for row in plan.each("encoders", "encoder_count"):
            self._make_encoder(row)

    def _make_shaft(self, row: Any) -> None:
        plan, name, motion = self._plan, text_of(row.name), self._plan.word(row.motion)
        if row.driver >= 0:
            make = partial(Shaft, driver=self._shaft_at(row.driver), ratio=(row.ratio[0], row.ratio[1]))
        elif motion is not None and motion.lower().endswith(".csv"):
            make = partial(Shaft, self.clock, str(plan.folder / motion))
        else:
            make = partial(Shaft, self.clock, motion or "0")
        self.shafts[name.lower()] = plan.told(f"shaft {name}", row.motion_line or row.line, make)

    def _shaft_at(self, index: int) -> Shaft:
        return self.shafts[text_of(self._plan.rows.shafts[index].name).lower()]

    def _make_wire(self, row: Any) -> None:
        """Of a [bus], where encoders meet."""
        name = text_of(row.name)
        self._plan.check_wire(f"{'encoder' if row.is_private else 'bus'} {name}", row)
        name = name.lower()
        if row.is_private:
            return
        self._shared[name] = []
        if row.stack.medium == Medium.FRAMES:
            self.buses[name] = CanBus(clock=self.clock)
        elif row.stack.medium == Medium.CHARACTERS:
            self.lines[name] = Line(self.clock)

    def _make_encoder(self, row: Any) -> None:
        plan, name = self._plan, text_of(row.name)
        section, wire = f"encoder {name}", self._plan.rows.wires[row.wire]
        bus = "" if wire.is_private else text_of(wire.name).lower()
        shaft, on, line = self._shaft_at(row.shaft), self.buses.get(bus), self.lines.get(bus)
        make = partial(Encoder, Model(row.model, plan), shaft=shaft, bus=on, line=line, power=False)
        encoder = plan.told(section, row.line, make)
        courses = self._set_up(section, row, encoder)
        self._remember(name.lower(), section, row, encoder)
        for word, file, _, _ in courses:
            plan.told(section, word.line, partial(encoder.world.begin, word.key, file))
        plan.told(section, row.line, encoder._start)
        for word, file, loop, steps in courses:
            plan.told(section, word.line, partial(encoder.world.play, word.key, file, loop=loop, steps=steps))
        self.encoders[name.lower()] = encoder
        if bus:
            self._shared[bus].append(encoder)

    def _set_up(self, section: str, row: Any, encoder: Encoder) -> list[tuple[Any, Path, bool, bool]]:
        """Its settings. @return the courses among them"""
        plan, courses = self._plan, []
        for word in plan.words(row.settings):
            if World.senses(word.key) and is_file(word.value):
                file, loop, steps = plan.told(section, word.line, partial(split_words, word.value))
                courses.append((word, plan.file(file, word.line), loop, steps))
            else:
                plan.told(section, word.line, partial(encoder.set, word.key, word.value))
        serial, address = plan.word(row.serial), encoder._address_key()
        if serial is not None:
            plan.told(section, row.serial_line, partial(encoder.set, "serial", serial))
        if address is not None and row.address >= 0:
            plan.told(section, row.address_line, partial(encoder.set, address, row.address))
        return courses

    def _remember(self, name: str, section: str, row: Any, encoder: Encoder) -> None:
        nvm = self._plan.word(row.nvm)
        if nvm is None:
            return
        self._files[name] = path = self._plan.folder / nvm
        if path.exists() and path.stat().st_size:
            image = path.read_bytes()
            self._plan.told(section, row.nvm_line, lambda: setattr(encoder, "memory", image))

    def _masters(self, kind: type[Ring] | type[Chain], fits: Callable[[Encoder], bool]) -> dict[str, Any]:
        return {name: kind(members) for name, members in self._shared.items() if fits(members[0])}

    @functools.cached_property
    def rings(self) -> dict[str, Ring]:
        """The masters of INTERBUS encoders that share a [bus], in the order of the file."""
        return self._masters(Ring, lambda one: one.medium is Medium.WORDS)

    @functools.cached_property
    def chains(self) -> dict[str, Chain]:
        """The masters of BiSS encoders that share a [bus], likewise."""
        return self._masters(Chain, lambda one: one.protocol == Biss.PROTOCOL)

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
