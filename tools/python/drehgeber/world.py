# SPDX-License-Identifier: MIT
"""What an encoder in this process senses beside its shaft."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from ._native import EncoderError, load, within
from .clock import SECOND_NS, SECONDS_MAX
from .course import Course
from .shaft import read_points

if TYPE_CHECKING:
    from .encoder import Encoder

T = TypeVar("T", float, int, bool)


def _cut(value: Decimal, parts: int) -> Decimal:
    return Decimal(int(value * parts)) / parts


class Quantity(Generic[T]):
    """An attribute of World: counted by the library in parts of its unit."""

    def __init__(self, kind: Callable[[float], T], help: str, parts: int = 1) -> None:
        self._kind: Callable[[float], T] = kind
        self._parts = parts
        self.__doc__ = help

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, world: None, owner: type) -> Quantity[T]: ...
    @overload
    def __get__(self, world: World, owner: type) -> T: ...
    def __get__(self, world: World | None, owner: type) -> T | Quantity[T]:
        if world is None:
            return self
        return self._kind(world._encoder._sensed(self._name) / self._parts)

    def __set__(self, world: World, value: float) -> None:
        world._encoder._sensed(self._name)
        counts = self._counts(value, self._limits())
        world.stop(self._name)
        world._encoder._sense(self._name, counts)

    def _limits(self) -> tuple[float, float]:
        ffi, lib = load()
        row = lib.dg_keys_find(ffi.addressof(lib.dg_world_keys), self._name.encode())
        return row.min / self._parts, row.max / self._parts

    def _counts(self, value: float | Decimal, limits: tuple[float, float]) -> int:
        return round(within(value, *limits, self._name) * self._parts)

    def _points(self, course: str | Path | Iterable[tuple[float | Decimal, float | Decimal]]) -> list[tuple[int, int]]:
        """Nanoseconds and counts, all of which can be; what a file has more of is cut."""
        limits = self._limits()
        if isinstance(course, (str, Path)):
            rows = read_points(Path(course), f"time_s,{self._name}")
            course = [(_cut(at, SECOND_NS), _cut(value, self._parts)) for at, value in rows]
        return [
            (round(within(at, 0, SECONDS_MAX, "seconds") * SECOND_NS), self._counts(value, limits))
            for at, value in course
        ]


class World:
    """What the encoder senses, by the names that settings have. Assign, and it is so; the encoder
    finds its own error codes."""

    __slots__ = ("_courses", "_encoder")  # assigning to a name that is none of these is an error

    temperature = Quantity(float, "degC in the housing", 1000)
    led_current_ua = Quantity(int, "of the optical scanner's LED")
    supply_mv = Quantity(int, "supply voltage")
    battery_mv = Quantity(int, "battery of the multiturn counter")
    sin_amplitude_permille = Quantity(int, "of the nominal amplitude")
    cos_amplitude_permille = Quantity(int, "of the nominal amplitude")
    sin_offset_permille = Quantity(int, "of the nominal amplitude")
    cos_offset_permille = Quantity(int, "of the nominal amplitude")
    singleturn_ok = Quantity(bool, "the singleturn track can be read")
    multiturn_amplitude_ok = Quantity(bool, "the multiturn sensor's amplitude is sufficient")
    multiturn_sync_ok = Quantity(bool, "multiturn and singleturn agree")
    multiturn_vector_ok = Quantity(bool, "the multiturn sensor's vector length is in range")
    eeprom_acknowledges = Quantity(bool, "the EEPROM acknowledges")
    watchdog_fired = Quantity(bool, "the watchdog has reset the processor")

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._courses: dict[str, Course] = {}

    def _quantity(self, name: str) -> Quantity[Any]:
        quantity = getattr(type(self), name, None)
        if not isinstance(quantity, Quantity):
            raise EncoderError(f"no encoder senses {name!r}")
        self._encoder._sensed(name)
        return quantity

    def begin(self, name: str, course: str | Path | Iterable[tuple[float, float]]) -> None:
        """An encoder that has never been on gets its power with what the course is at 0."""
        quantity = self._quantity(name)
        for at, counts in quantity._points(course):
            if at == 0:
                self._encoder.set(name, str(Decimal(counts) / quantity._parts))

    def play(
        self,
        name: str,
        course: str | Path | Iterable[tuple[float, float]],
        *,
        loop: bool = False,
        steps: bool = False,
    ) -> None:
        """Let a quantity follow points (seconds from now on, value), or a CSV file of such lines:
        world.play("led_current_ua", [(0, 12000), (600, 4000)]). Between them it goes straight, or with
        `steps` holds, as states always do; a step is two points at one moment. With `loop` the last point's
        moment is 0 of the next lap. Another course, assigning to the quantity, or stop() ends it."""
        quantity = self._quantity(name)
        points = quantity._points(course)
        clock = self._encoder.clock
        with clock.lock:
            clock._sync()
            put = self._encoder._sense_now
            steps = steps or quantity._kind is bool
            made = Course(clock, points, lambda counts: put(name, counts), loop=loop, steps=steps)
            self.stop(name)
            self._courses[name] = made
            clock._courses.append(made)
            clock._go(clock._ns)

    def _end(self) -> None:
        """It is sensed no more."""
        for name in list(self._courses):
            self.stop(name)

    def stop(self, name: str) -> None:
        """The quantity stays what it is."""
        clock, course = self._encoder.clock, self._courses.pop(name, None)
        with clock.lock:
            if course in clock._courses:
                clock._courses.remove(course)
            elif course is not None and course._put is None:
                self._encoder._follow(course, None)
