# SPDX-License-Identifier: MIT
"""What an encoder in this process senses beside its shaft."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar, overload

from ._native import EncoderError
from .course import Course
from .shaft import read_points

if TYPE_CHECKING:
    from .encoder import Encoder

T = TypeVar("T", float, int, bool)


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
        world._encoder._sense(self._name, self._counts(value))

    def _counts(self, value: float) -> int:
        return round(value * self._parts)


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

    def play(self, name: str, course: str | Path | Iterable[tuple[float, float]]) -> None:
        """Let a quantity follow points (seconds from now on, value), straight between them, or a CSV file
        of such lines: world.play("led_current_ua", [(0, 12000), (600, 4000)]). A step is two points at one
        moment. Another course, or stop(), ends it; what is assigned meanwhile lasts until the next point
        or hundredth of a second."""
        points = read_points(Path(course)) if isinstance(course, (str, Path)) else course
        quantity = getattr(type(self), name, None)
        if not isinstance(quantity, Quantity):
            raise EncoderError(f"no encoder senses {name!r}")
        clock = self._encoder.clock
        with clock.lock:
            clock._sync()
            put = self._encoder._sense_now
            made = Course(clock, points, lambda value: put(name, quantity._counts(value)))
            self.stop(name)
            self._courses[name] = made
            clock._courses.append(made)
            clock._go(clock._ns)

    def stop(self, name: str) -> None:
        """The quantity stays what it is."""
        clock, course = self._encoder.clock, self._courses.pop(name, None)
        with clock.lock:
            if course in clock._courses:
                clock._courses.remove(course)
