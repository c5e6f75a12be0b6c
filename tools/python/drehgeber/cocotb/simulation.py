# SPDX-License-Identifier: MIT
"""The simulator's time and pins, and what all encoders in a simulation have in common."""

from __future__ import annotations

import random
from collections.abc import Callable, Coroutine
from typing import Any, Generic, Literal, TypeVar

import cocotb
from cocotb.handle import LogicObject
from cocotb.simtime import get_sim_time
from cocotb.task import Task
from cocotb.triggers import Event, Timer
from cocotb.types import Logic

from .._native import EncoderError, aligned, checked, load
from ..canbus import CanBus
from ..clock import LEAD_NS, NEVER, Clock
from ..encoder import Encoder, Setting, SinCos
from ..instrument import Instrument
from ..model import Model, find_model
from ..rs485 import Line
from ..shaft import TURN, Shaft
from ..world import World

PS_PER_NS = 1000
LEAD_PS = LEAD_NS * PS_PER_NS
LEVELS = {"0": False, "L": False, "1": True, "H": True}
OWNED = "the simulator owns time: await cocotb.triggers.Timer"

T = TypeVar("T")


def now_ps() -> int:
    """Since the simulation began."""
    return int(get_sim_time("ps"))


def ps_of(ns: float) -> int:
    return round(ns * PS_PER_NS)


async def until_ps(at_ps: int) -> None:
    """Never early; the simulator's steps may be coarser."""
    left = at_ps - now_ps()
    if left > 0:
        await Timer(left, "ps", round_mode="ceil")


class SimulationClock(Clock):
    """The simulator's time, which nobody moves from Python. Encoders that go by one, and shafts of it, are
    brought up to the same moment: `Shaft(SimulationClock(), "60RPM")`."""

    def _sync(self) -> int:
        with self.lock:
            self._go(max(self._ns, LEAD_NS + now_ps() // PS_PER_NS))
        return self._ns

    def advance(self, seconds: float) -> None:
        """Refused: the simulator owns time."""
        raise EncoderError(OWNED)

    def _wait_until(self, at_ns: int) -> None:
        raise EncoderError(OWNED)

    def _due(self) -> int:
        return min((course._due for course in self._courses), default=NEVER)


class News(Generic[T]):
    """What somebody may wait for, each time anew."""

    def __init__(self) -> None:
        self._event = Event()
        self._latest: T | None = None

    def tell(self, what: T) -> None:
        told, self._event = self._event, Event()
        self._latest = what
        told.set()

    @property
    def latest(self) -> T | None:
        return self._latest

    async def next(self) -> T:
        await self._event.wait()
        assert self._latest is not None
        return self._latest


class Noise:
    """Jitter with a seed."""

    def __init__(self, jitter_ns: float, seed: int) -> None:
        self.most_ps = ps_of(jitter_ns)
        self._random = random.Random(seed)
        if self.most_ps < 0:
            raise EncoderError(f"jitter_ns={jitter_ns}: 0 or more")

    def ps(self) -> int:
        return self._random.randint(-self.most_ps, self.most_ps)


class Delay:
    """A level gets somewhere later, and in order. `delay_ps` 0 without noise: at once."""

    def __init__(self, arrive: Callable[[bool], None], delay_ps: int, noise: Noise | None = None) -> None:
        self._arrive = arrive
        self._delay_ps = delay_ps
        self._noise = noise
        self._latest_ps = 0

    def put(self, level: bool) -> None:
        if self._delay_ps == 0:
            self._arrive(level)
            return
        at_ps = now_ps() + self._delay_ps + (self._noise.ps() if self._noise is not None else 0)
        self._latest_ps = max(at_ps, self._latest_ps + 1)
        cocotb.start_soon(self._later(self._latest_ps, level))

    async def _later(self, at_ps: int, level: bool) -> None:
        await until_ps(at_ps)
        self._arrive(level)


def level_of(pin: LogicObject, before: bool) -> bool:
    """What is neither 0 nor 1 leaves a line as it was."""
    return LEVELS.get(str(pin.value), before)


def drive(pin: LogicObject | None, level: bool | Logic) -> None:
    if pin is not None:
        pin.value = Logic(level)


def queued(name: str) -> Model:
    """A model with a handle that keeps what it says until somebody looks."""
    found, (_, lib) = find_model(name), load()
    wire = lib.dg_host_wire_of(found.device)
    size = lib.dg_host_size(found.device, wire)
    keep, place = aligned(size)
    handle = lib.dg_host_init(place, size, found.device, wire)
    lib.dg_host_take_side(handle, lib.dg_bus_side_of(found.device))
    return Model(found.device, (found, keep), handle)


class Served(Encoder):
    """An encoder in this process that says when it was looked after."""

    served: Callable[[], None] | None = None

    def _line_up(self, bus: CanBus | None, line: Line | None) -> None:
        """It is on pins: what several make of a wire is the simulator's."""
        self._bus, self._line, self._wire_at = bus, line, None
        with self.clock.lock:
            self.clock._members.append(self)

    def _run(self, until_ns: int) -> None:
        self._step(until_ns)
        if self.served is not None:
            self.served()

    def _hint(self, text: str) -> None:
        cocotb.log.warning("%s: %s", self.model, text)


class SimulatedEncoder(Instrument):
    """What all encoders in a simulation have in common; see BissEncoder, SsiEncoder and HiperfaceEncoder.

    Settings are those of `--set`, as keywords. `shaft` is a Shaft of a SimulationClock, that of another
    encoder, or words for one of its own. It has had power for a second when it is made, unless `power` is False. `memory` is an
    image of its EEPROM. The line needs `line_delay_ns` each way. `jitter_ns` is how much earlier or later each edge of the encoder is
    than it should be at most, the same sequence for the same `seed`."""

    PROTOCOL = ""

    def __init__(
        self,
        model: str,
        *,
        shaft: Shaft | str = "0",
        power: bool = True,
        memory: bytes | None = None,
        line_delay_ns: float = 0,
        jitter_ns: float = 0,
        seed: int = 1,
        settings: dict[str, Any],
    ) -> None:
        if line_delay_ns < 0:
            raise EncoderError(f"line_delay_ns={line_delay_ns}: 0 or more")
        self._line_ps = ps_of(line_delay_ns)
        self._noise = Noise(jitter_ns, seed)
        self._alarm: Task[None] | None = None
        self._alarm_ns = NEVER
        clock = shaft.clock if isinstance(shaft, Shaft) else SimulationClock()
        if not isinstance(clock, SimulationClock):
            raise EncoderError("a shaft in a simulation goes by a SimulationClock")
        self._clock = clock
        self._encoder = Served(queued(model), clock=clock, shaft=shaft, power=power, memory=memory, **settings)
        self._encoder._speaks(self.PROTOCOL)
        self._host, self._lib, self._ffi = self._encoder._host, self._encoder._lib, self._encoder._ffi
        self._event: Any = self._ffi.new("struct dg_host_event *")
        self._encoder.served = self._after

    def __repr__(self) -> str:
        return f"<drehgeber.cocotb.{type(self).__name__} {self.model}>"

    # ------------------------------------------------------------ time

    def _serve(self) -> int:
        """Whatever is due up to now happens. @return now, in the library's nanoseconds"""
        return self._clock._sync()

    def _after(self) -> None:
        """It was looked after: what it said goes out, and somebody wakes when it is due again."""
        while self._lib.dg_host_receive(self._host, self._event) > 0:
            self._said(self._event)
        due = min(self._encoder._deadline, self._clock._due())
        if due < self._alarm_ns:
            if self._alarm is not None:
                self._alarm.cancel()
            self._alarm_ns = due
            self._alarm = cocotb.start_soon(self._wake(due))

    async def _wake(self, due: int) -> None:
        await until_ps(due * PS_PER_NS - LEAD_PS)
        self._alarm, self._alarm_ns = None, NEVER
        self._serve()

    def _said(self, event: Any) -> None:
        """An event of the wire."""
        raise NotImplementedError

    def _watch(self, pin: LogicObject, changed: Callable[[], None]) -> None:
        """Have `changed` called whenever the pin has another value."""

        async def forever() -> None:
            while True:
                await pin.value_change
                changed()

        start(forever())

    # ------------------------------------------------------------ the encoder

    @property
    def model(self) -> str:
        """Its name, as on the command line."""
        return self._encoder.model

    @property
    def shaft(self) -> Shaft:
        """What it sits on; assign another one, of the same clock. Its `move()` is without `wait`: see move()."""
        return self._encoder.shaft

    @shaft.setter
    def shaft(self, shaft: Shaft) -> None:
        self._encoder.shaft = shaft

    async def move(self, degrees: float, rpm: float = 60) -> None:
        """Turn the shaft to an angle, and wait until it is there."""
        self.shaft.move(degrees, rpm, wait=False)
        settled = int(self._lib.dg_shaft_settled(self.shaft._c))
        await until_ps(settled * PS_PER_NS - LEAD_PS)

    @property
    def world(self) -> World:
        """What it senses: `encoder.world.temperature = 85`."""
        return self._encoder.world

    def position(self, at_ps: int | None = None) -> int:
        """In counts, as the wire would tell it at a moment; None: now. No time passes."""
        counts = self._ffi.new("uint64_t *")
        at = self._serve() if at_ps is None else ns_of(at_ps)
        checked(self._lib.dg_host_position(self._host, at, counts), f"{self.model}: the position")
        return int(counts[0])

    def angle(self, at_ps: int | None = None) -> float:
        """Degrees of the shaft at a moment; None: now."""
        at = self._serve() if at_ps is None else ns_of(at_ps)
        return float(self._lib.dg_host_angle(self._host, at)) * 360 / TURN

    def settings(self) -> list[Setting]:
        """What can be set, the quantities of its world included."""
        return self._encoder.settings()

    def set(self, key: str, value: str | float) -> None:
        """Set one, as text, or a number."""
        self._encoder.set(key, value)

    def get(self, key: str) -> str:
        """What it is, as text."""
        return self._encoder.get(key)

    @property
    def memory(self) -> bytes:
        """An image of its EEPROM. Assign one while it is off."""
        return self._encoder.memory

    @memory.setter
    def memory(self, image: bytes) -> None:
        self._encoder.memory = image

    @property
    def powered(self) -> bool:
        """Whether it is on."""
        return self._encoder.powered

    def power(self, state: bool | Literal["CYCLE"]) -> None:
        """True, False, or "CYCLE": off and on again."""
        self._encoder.power(state)

    def ask(self, line: str) -> str | None:
        """A line of SCPI; its answer, None when it has none. Raises ScpiError."""
        return self._encoder.ask(line)

    def scpi(self, line: str) -> str | None:
        """The same."""
        return self.ask(line)

    def set_fault(
        self,
        name: str,
        count: int | None = None,
        probability: float | None = None,
        duration_ms: float | None = None,
    ) -> None:
        """Let a fault happen: until it is cleared, `count` times, or as long as it says. Faults of the wire
        that this one has not are refused."""
        self._encoder.set_fault(name, count, probability, duration_ms)

    def clear_fault(self, name: str = "") -> None:
        """Clear one fault, or all."""
        self._encoder.clear_fault(name)


def ns_of(at_ps: int) -> int:
    """A moment as the library has it."""
    return (LEAD_PS + at_ps) // PS_PER_NS


def start(work: Coroutine[Any, Any, None]) -> Task[None]:
    """Until the end of the test."""
    return cocotb.start_soon(work)


def sincos_of(encoder: SimulatedEncoder, at_ps: int | None) -> SinCos:
    to = encoder._ffi.new("int32_t[4]")
    at = encoder._serve() if at_ps is None else ns_of(at_ps)
    checked(encoder._lib.dg_host_sincos(encoder._host, at, to), f"{encoder.model}: sine and cosine")
    return SinCos(*(level / 1e6 for level in to))
