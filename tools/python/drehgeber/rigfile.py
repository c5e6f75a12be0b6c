# SPDX-License-Identifier: MIT
"""Rig files in this process: all that is in one, on one clock, without its wires."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ._native import Medium, aligned, checked, load, text_of
from .canbus import WAITING, WAITING_EACH, CanBus
from .chain import Chain
from .clock import LEAD_NS, Clock
from .clocked import Biss
from .course import Course
from .encoder import Encoder
from .model import Model
from .plan import Plan
from .ring import Ring
from .rs485 import Line
from .shaft import Shaft, read_points, replay_points
from .world import World

# Buses of the engine that masters here are doors of. Masters of other wires have encoders by their handles, or make a bus.
DOORS: dict[int, type[CanBus] | type[Line]] = {Medium.FRAMES: CanBus, Medium.CHARACTERS: Line}


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
        self._ffi, self._lib = load()
        self._plan = plan = Plan(source, data, folder)
        self.clock = clock or Clock()
        self.name = plan.name
        self.shafts: dict[str, Shaft] = {}
        self.buses: dict[str, CanBus] = {}
        self.lines: dict[str, Line] = {}
        self.encoders: dict[str, Encoder] = {}
        self._files: dict[str, Path] = {}
        self._shared: dict[str, list[Encoder]] = {}  # of each [bus]
        self._doors: dict[int, CanBus | Line] = {}  # of wires
        self._courses: list[tuple[int, str, Course]] = []  # encoders, what they sense, how that goes on
        self._kept: list[Any] = [plan]  # what the engine borrows
        with self.clock.lock:
            engine = self._make(self.clock._sync())
            self._wrap(engine)
            self._start(engine, self.clock._ns)

    # ------------------------------------------------------------ what the library makes, and asks for

    def _make(self, now: int) -> Any:
        """A rig at work, without power so far: include/drehgeber/rig_engine.h."""
        ffi, lib, plan = self._ffi, self._lib, self._plan
        setup, wrong = ffi.new("struct dg_engine_setup *"), ffi.new("struct dg_plan_error *")
        setup.size, setup.plan, setup.begin = ffi.sizeof("struct dg_engine_setup"), plan.rows, now
        setup.frames_wait = WAITING + WAITING_EACH * max((row.encoder_count for row in plan.each("wire")), default=0)
        answers, failures = [], []  # nothing is raised through the library
        for name, refused in ("wire", -1), ("motion", -1), ("course", ffi.NULL):
            form, call = ffi.typeof(getattr(setup, name)), getattr(self, f"_give_{name}")
            answers.append(ffi.callback(form, call, error=refused, onerror=lambda _, error, __: failures.append(error)))
            setattr(setup, name, answers[-1])
        size = lib.dg_engine_size(setup)
        memory, place = aligned(size)
        self._kept.append(memory)
        engine = lib.dg_engine_make(place, size, setup, wrong)
        if failures:
            raise failures[0]
        plan.require(engine != ffi.NULL, wrong)
        return engine

    def _give_wire(self, _: Any, index: int, to: Any, __: Any) -> int:
        """A door that is told what goes over it, frames at once."""
        row, name = to.plan, text_of(to.plan.name).lower()
        if row.stack.medium not in DOORS:
            return 0
        self._doors[index] = door = DOORS[row.stack.medium](clock=self.clock)
        to.ops, to.ctx = door._door(row.encoder_count)
        to.frames.pace = False
        if isinstance(door, CanBus) and not row.is_private:
            self.buses[name] = door
        elif isinstance(door, Line) and not row.is_private:
            self.lines[name] = door
        return 0

    def _give_motion(self, _: Any, index: int, name: Any, to: Any, __: Any) -> int:
        row, path = self._plan.rows.shafts[index], self._plan.folder / text_of(name)
        with self._plan.told(f"shaft {text_of(row.name)}", row.motion_line):
            motion, points = replay_points(read_points(path))
            checked(self._lib.dg_motion_set(to, motion), "motion 'points'")
        self._kept.append(points)
        return 0

    def _give_course(self, _: Any, index: int, setting: Any, __: Any) -> Any:
        key, (file, _, _) = text_of(setting.key), text_of(setting.value).partition(",")
        with self._plan.told(f"encoder {text_of(self._plan.rows.encoders[index].name)}", setting.line):
            points = getattr(World, key)._points(self._plan.file(file, setting.line))
            course = Course(self.clock, points, None, loop=False, steps=False)  # the engine knows the words
        self._courses.append((index, key, course))
        return course._of_rig

    # ------------------------------------------------------------ what there is of it here

    def _wrap(self, engine: Any) -> None:
        """Shafts and encoders as everywhere."""
        plan, made, shafts = self._plan, self._lib.dg_engine_control(engine).shafts, list[Shaft]()
        for index, row in enumerate(plan.each("shaft")):
            shafts.append(shaft := Shaft(self.clock))
            shaft._c, shaft._driver = self._ffi.addressof(made[index].shaft), None if row.driver < 0 else shafts[row.driver]
            shaft._kept = self._kept
            self.shafts[text_of(row.name).lower()] = shaft
        for index, row in enumerate(plan.each("encoder")):
            wire, door, name = plan.rows.wires[row.wire], self._doors.get(row.wire), text_of(row.name)
            bus, line = door if isinstance(door, CanBus) else None, door if isinstance(door, Line) else None
            model = Model(row.model, self._kept, self._lib.dg_engine_encoder(engine, index))
            self.encoders[name.lower()] = one = Encoder(model, shaft=shafts[row.shaft], bus=bus, line=line, power=False)
            one._own_bus = bool(wire.is_private)
            if not wire.is_private:
                self._shared.setdefault(text_of(wire.name).lower(), []).append(one)
            self._remember(name, row, one)

    def _remember(self, name: str, row: Any, encoder: Encoder) -> None:
        nvm = self._plan.word(row.nvm)
        if nvm is None:
            return
        self._files[name.lower()] = path = self._plan.folder / nvm
        if path.exists() and path.stat().st_size:
            with self._plan.told(f"encoder {name}", row.nvm_line):
                encoder.memory = path.read_bytes()

    def _start(self, engine: Any, now: int) -> None:
        """All have had their power for a second."""
        lib, encoders, wrong = self._lib, list(self.encoders.values()), self._ffi.new("struct dg_plan_error *")
        for index, one in enumerate(encoders):
            self._plan.require(lib.dg_engine_power_encoder(engine, index, now - LEAD_NS, wrong) == 0, wrong)
            one._made = True
        for index in range(self._plan.rows.wire_count):
            bus = lib.dg_engine_bus(engine, index)
            if index in self._doors:
                self._doors[index]._open(bus, self._kept)
            while index not in self._doors and lib.dg_bus_count(bus) > 0:
                lib.dg_bus_detach(bus, 0, 0)
        for one in encoders:
            if one._wire_at is None:
                one._step(now)
        for index, name, course in self._courses:
            encoders[index].world._courses[name] = course
            encoders[index]._follow(course, now)

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

    def __exit__(self, *_: object) -> None:
        self.close()
