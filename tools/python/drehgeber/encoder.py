# SPDX-License-Identifier: MIT
"""An encoder in this process, without wires, in virtual time."""

from __future__ import annotations

import contextlib
import sys
import warnings
import weakref
from array import array
from collections import deque
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from . import _native
from ._native import ERR_ARGUMENT, ERR_WIRE, WIRES, EncoderError, Medium, checked, encoded, octets, whole, within
from .canbus import CanBus, CanPort
from .clock import LEAD_NS, NEVER, SECOND_NS, SECONDS_MAX, Clock
from .clocked import Biss, Clocked, Level, Ssi
from .control import ScpiError, split
from .course import Course
from .instrument import Instrument, power_word
from .model import Model, Word, find_model
from .ring import Ring
from .rs485 import Line
from .shaft import Shaft, forms
from .wire import Wire
from .world import World

_named: weakref.WeakValueDictionary[str, Encoder] = weakref.WeakValueDictionary()
ANSWER = 1 << 16
GEARED = "a geared shaft is turned by its driver"  # the shaft of a panel, by the encoder's own
TEXT = 256


class HintWarning(UserWarning):
    """Why a master may be waiting for an encoder in this process. A note: nothing has failed."""


class Setting(NamedTuple):
    """Something that can be set of an encoder."""

    name: str
    unit: str
    help: str
    always: bool  # else before the first power-on
    words: tuple[str, ...]  # the values it can have; () when it is a number or a text


class SinCos(NamedTuple):
    """The process channel, in volts."""

    sin_plus: float
    sin_minus: float
    cos_plus: float
    cos_minus: float


def _one_clock(clock: Clock | None, *others: Shaft | str | CanBus | Line | None) -> Clock:
    """The clock by which all of these go: one of its own where none is given."""
    given = [one.clock for one in others if one is not None and not isinstance(one, str)]
    clocks = given if clock is None else [clock, *given]
    if any(one is not clocks[0] for one in clocks):
        raise EncoderError("the encoder, its shaft and its bus go by the same clock")
    return clocks[0] if clocks else Clock()


class Encoder(Instrument):
    """An encoder: `Encoder("f3668", node=5, shaft="60RPM")`; also of a file: `Encoder("vendor.eds")`, a CANopen encoder
    of its EDS or DCF file, `Encoder("mine.ini")`, the last [model NAME] there.

    Settings are those of `--set`, as keywords. `shaft` is a Shaft, which others may share, or words for
    one of its own; `bus` is a CanBus for a CANopen encoder, `line` a Line for one with RS485, else it has
    one of its own; `clock` is theirs, or one of its own. It has had power for a second when it is made, unless `power` is False.
    `memory` is an image of its EEPROM. `name` is what pyserial knows it by, drehgeber://NAME, as long as
    somebody holds it."""

    def __init__(
        self,
        model: Word | Model,
        *,
        clock: Clock | None = None,
        shaft: Shaft | str = "0",
        bus: CanBus | None = None,
        line: Line | None = None,
        power: bool = True,
        memory: bytes | None = None,
        name: str | None = None,
        **settings: str | float,
    ) -> None:
        self._ffi, self._lib = _native.load()
        self._closed = False
        self._model = found = model if isinstance(model, Model) else find_model(model)
        self._handle: Any = found.handle
        if found.handle is None:
            side = self._lib.dg_bus_side_of(found.device)
            size = self._lib.dg_host_size_on_bus(found.device, side)
            self._keep, place = _native.aligned(size)
            self._handle = self._lib.dg_host_init_on_bus(place, size, found.device, side)
        self._panel: Any = None
        self._ring: Any = None  # of several, which it stands in
        self._back: list[bytes] = []  # what has come back, in a ring of its own
        self._levels: deque[Level] | None = None  # of its line, where somebody watches
        self._place: int | None = None  # on its wire, from the first power-on
        self._deadline = NEVER
        self._hint_due: Any = self._ffi.new("uint64_t *")
        self._made = False
        self.model = found.name
        self.name = name
        self.protocol: str = self._ffi.string(self._lib.dg_host_protocol(self._host)).decode()
        self.medium = self._known_medium()
        self._join(clock, shaft, bus, line)
        self._register()
        for key, value in settings.items():
            self.set(key, value)
        if memory is not None:
            self.memory = memory
        self.world = World(self)
        if power:
            self._start()

    def _known_medium(self) -> Medium:
        """Of its wire. A later library may have encoders on wires that this package has no masters for."""
        try:
            return Medium(self._lib.dg_host_medium(self._host))
        except ValueError:
            raise EncoderError(f"{self.model} speaks {self.protocol}, over a wire that is unknown here", ERR_WIRE) from None

    def _join(self, clock: Clock | None, shaft: Shaft | str, bus: CanBus | None, line: Line | None) -> None:
        """Its clock, its bus or line, its shaft."""
        if not isinstance(shaft, (Shaft, str)):
            raise TypeError(f"shaft {shaft!r}: expected a Shaft, or words: {forms()}")
        self._own_bus = bus is None
        for wire, medium in ((bus, Medium.FRAMES), (line, Medium.CHARACTERS)):
            if wire is not None and self.medium is not medium:
                raise EncoderError(f"{self.model} has no {WIRES[medium]}")
        self.clock = _one_clock(clock, shaft, bus, line)
        self._shaft = shaft if isinstance(shaft, Shaft) else Shaft(self.clock, shaft)
        self._lib.dg_host_shaft_of(self._host, self._shaft._c)
        self._line_up(bus, line)

    def _line_up(self, bus: CanBus | None, line: Line | None) -> None:
        """Be among those that this bus or line, or else its clock, lets live; without one, on one of its own."""
        self._bus = CanBus(clock=self.clock) if bus is None and self.medium is Medium.FRAMES else bus
        self._line = Line(self.clock) if line is None and self.medium is Medium.CHARACTERS else line
        self._wire_at: Wire | None = self._bus if self._bus is not None else self._line
        with self.clock.lock:
            if self._wire_at is not None:
                self._wire_at._join(self, own=self._wire_at not in (bus, line))
            else:
                self.clock._members.append(self)

    def _register(self) -> None:
        if self.name is None:
            return
        if self.name in _named or self.name in _native.models():
            raise EncoderError(f"there is an encoder {self.name!r} already, or a model")
        _named[self.name] = self

    @staticmethod
    def named(name: str) -> Encoder | None:
        """The encoder of that name, if there is one."""
        return _named.get(name)

    def _start(self) -> None:
        """Switch it on a second ago; what it said meanwhile nobody has heard."""
        with self.clock.lock:
            now = self.clock._sync()
            checked(self._lib.dg_host_power(self._host, now - LEAD_NS, True), f"{self.model} on")
            self._made = True
            self._step(now)
            self._attach()

    def _listen(self, heard: Callable[[Any], None]) -> None:
        """Have it called with what the encoder says, unless a bus hears that."""
        if self._ring is None:
            form = "void(void *, const struct dg_host_event *)"
            self._heard = self._ffi.callback(form, lambda _, event: heard(event))
            self._lib.dg_host_listen(self._host, self._heard, self._ffi.NULL)

    def _attach(self) -> None:
        """From now on its wire lets it live."""
        if self._wire_at is not None and self._place is None:
            self._wire_at._attach(self)

    def close(self) -> None:
        """Take it off its bus or line, and off its clock; its courses end. It is of no use any more."""
        with self.clock.lock:
            if self._wire_at is not None:
                self._wire_at._leave(self)
            elif self in self.clock._members:
                self.clock._members.remove(self)
            if self._bus is not None and self._own_bus:
                self._bus._ports.clear()
            self.world._end()
            self._closed = True

    @property
    def _host(self) -> Any:
        if self._closed:
            raise EncoderError(f"{self!r} is closed")
        return self._handle

    def __repr__(self) -> str:
        return f"<drehgeber.Encoder {self.model} at {self.clock.now} s>"

    # ------------------------------------------------------------ time

    def _step(self, now: int) -> None:
        if not self._made:  # it may yet be switched on a second ago
            return
        if self._panel is not None:
            self._deadline = self._lib.dg_host_panel_step(self._panel, now)
        else:
            self._deadline = self._lib.dg_host_step(self._host, now)
        if self.medium is Medium.EDGES:  # some of these have hints
            self._tell(now)
            self._deadline = min(self._deadline, int(self._hint_due[0]))

    def _tell(self, now: int) -> None:
        """What the user should know by then."""
        text = self._lib.dg_host_hint(self._host, now, self._hint_due)
        if text != self._ffi.NULL:
            self._hint(self._ffi.string(text).decode())

    def _hint(self, text: str) -> None:
        level, frame = 1, sys._getframe()
        while frame.f_back is not None and str(frame.f_globals.get("__name__")).startswith(f"{__package__}."):
            level, frame = level + 1, frame.f_back
        warnings.warn(f"{self.name or self.model}: {text}", HintWarning, stacklevel=level)

    _run = _step

    def _next(self) -> int:
        return self._deadline

    def _enter(self, now: int) -> int:
        """It is the present for its wire, too: something is about to be done to it. @return the present"""
        if self._wire_at is not None:
            self._wire_at._look(now)
        return now

    def _changed(self) -> None:
        """Something was done to it at the present: what it does about it happens."""
        if self._wire_at is not None:
            self._wire_at._change(self)
        else:
            self._run(self.clock._ns)

    _touch = _changed

    # ------------------------------------------------------------ settings, memory, power

    def settings(self) -> list[Setting]:
        """What can be set, the quantities of its world included."""
        key = self._ffi.new("struct dg_host_key *")
        found: list[Setting] = []
        while self._lib.dg_host_key(self._host, len(found), key) == 0:
            name, unit, help = (self._ffi.string(text).decode() for text in (key.name, key.unit, key.help))
            found.append(Setting(name, unit, help, key.always == 1, self._words(name)))
        return found

    def _words(self, name: str) -> tuple[str, ...]:
        words: list[str] = []
        while (word := self._lib.dg_host_word(self._host, name.encode(), len(words))) != self._ffi.NULL:
            words.append(self._ffi.string(word).decode())
        return tuple(words)

    def set(self, key: str, value: str | float) -> None:
        """Set one, as text, or a number."""
        text = str(int(value)) if isinstance(value, bool) else str(value)
        with self.clock.lock:
            result = self._lib.dg_host_set(self._host, encoded(key, "setting"), encoded(text, key))
        checked(result, f"{self.model}: {key}={text}{self._expected(key, result)}")

    def get(self, key: str) -> str:
        """What it is, as text."""
        to = self._ffi.new("char[]", TEXT)
        checked(self._lib.dg_host_get(self._host, encoded(key, "setting"), to, TEXT), f"{self.model}: {key}")
        return str(self._ffi.string(to).decode())

    def _key(self, name: str) -> Any:
        """A setting as the library describes it; None: there is no such one."""
        key = self._ffi.new("struct dg_host_key *")
        index = 0
        while self._lib.dg_host_key(self._host, index, key) == 0:
            if self._ffi.string(key.name).decode() == name:
                return key
            index += 1
        return None

    def _expected(self, name: str, result: int) -> str:
        """What a refused value of a setting could be, in words."""
        key = self._key(name) if result == ERR_ARGUMENT else None
        if key is None:
            return ""
        if key.type == self._lib.DG_HOST_KEY_WORD:
            return f": expected {' or '.join(self._words(name))}"
        what = " characters" if key.type == self._lib.DG_HOST_KEY_TEXT else ""
        scale = 10**key.places
        return f": expected {key.min / scale:.10g}..{key.max / scale:.10g}{what}"

    @property
    def memory(self) -> bytes:
        """An image of its EEPROM; b"" of one that has none. Assign one while it is off."""
        to = bytearray(self._lib.dg_host_memory_size(self._host))
        if to:
            with self.clock.lock:
                result = self._lib.dg_host_memory_copy(self._host, self._ffi.from_buffer(to), len(to))
            checked(result, "the image")
        return bytes(to)

    @memory.setter
    def memory(self, image: bytes) -> None:
        image = octets(image, "the image")
        checked(self._lib.dg_host_memory_load(self._host, image, len(image)), "the image")

    @property
    def powered(self) -> bool:
        """Whether it is on."""
        return bool(self._lib.dg_host_powered(self._host))

    def power(self, state: bool | Literal["CYCLE"]) -> None:
        """True, False, or "CYCLE": off and on again."""
        on = power_word(state) != "OFF"
        with self.clock.lock:
            self._attach()
            now = self._enter(self.clock._sync())
            if on and self._wire_at is not None and self.powered:  # what it is saying ends
                self._lib.dg_host_power(self._host, now, False)
                self._changed()
            checked(self._lib.dg_host_power(self._host, now, on), f"{self.model} on")
            self._made = True
            self._changed()

    def save(self) -> bytes:
        """Everything but faults and its place on a shaft, to go on from with restore()."""
        to = bytearray(self._lib.dg_host_state_size(self._host))
        with self.clock.lock:
            result = self._lib.dg_host_save(self._host, self._ffi.from_buffer(to), len(to))
        checked(result, "a state")
        return bytes(to)

    def restore(self, state: bytes) -> None:
        """Go on from what an encoder of this model has saved, not later than now. A damaged state, or one made so
        that it would lead out of the encoder's memory, is refused; all else that it says is believed: take none
        from whom you would not let steer the encoder."""
        state = octets(state, "the state")
        size = self._lib.dg_host_state_size(self._host)
        if len(state) > size:
            raise EncoderError(f"the state: {len(state)} bytes, not {size}: of another model, or too long")
        with self.clock.lock:
            self._attach()
            self._enter(self.clock._sync())
            checked(self._lib.dg_host_restore(self._host, state, len(state)), "the state")
            self._made = True
            self._changed()

    # ------------------------------------------------------------ physics

    @property
    def shaft(self) -> Shaft:
        """What it sits on; assign another one, of the same clock."""
        return self._shaft

    @shaft.setter
    def shaft(self, shaft: Shaft) -> None:
        if not isinstance(shaft, Shaft):
            raise TypeError(f"shaft {shaft!r}: expected a Shaft")
        if shaft.clock is not self.clock:
            raise EncoderError("the encoder and its shaft go by the same clock")
        _ = self._host  # it is not closed
        with self.clock.lock:
            self.clock._sync()
            self._shaft = shaft
            if self._panel is not None:
                self._couple()
            else:
                self._lib.dg_host_shaft_of(self._host, shaft._c)
            self._changed()

    def _sensed(self, name: str) -> int:
        to = self._ffi.new("int64_t *")
        checked(self._lib.dg_host_world_get(self._host, encoded(name, "quantity"), to), f"{self.model}: {name}")
        return int(to[0])

    def _sense(self, name: str, value: int) -> None:
        with self.clock.lock:
            self.clock._sync()
            self._sense_now(name, value)

    def _sense_now(self, name: str, value: int) -> None:
        """The lock is held, and it is the present, or a moment on the way there."""
        now = self._enter(self.clock._ns)
        checked(self._lib.dg_host_world_set(self._host, now, name.encode(), value), f"{self.model}: {name}")
        self._changed()

    def _follow(self, course: Course, now: int | None) -> None:
        """Let its panel go along a course from now on, in front of which its faults are; None: no longer."""
        lib, panel = self._lib, self._with_panel()
        rig, encoder = lib.dg_host_panel_rig(panel), lib.dg_host_panel_encoder(panel)
        if now is None:
            lib.dg_rig_unfollow(rig, encoder, course._of_rig.quantity)
        else:
            checked(lib.dg_rig_follow(rig, encoder, course._of_rig, now), f"{self.model}: a course")
            self._changed()

    # ------------------------------------------------------------ looks

    @property
    def position(self) -> int:
        """As the wire would tell it now, in counts."""
        return self.positions(None, 0, 1)[0]

    def positions(self, t0: float | None, dt: float, n: int) -> array[int]:
        """Positions as the wire would tell them at `t0` (None: now), t0 + dt, ...: `n` of them, without
        a loop in Python. No time passes; the shaft goes on as it does now."""
        n = whole(n, 0, 1 << 32, "n")
        counts = array("Q", bytes(8 * n))
        step = round(within(dt, 0, SECONDS_MAX, "dt") * SECOND_NS)
        with self.clock.lock:
            now = self.clock._sync()
            at = now if t0 is None else self.clock._ns_of(t0)
            to = self._ffi.from_buffer("uint64_t[]", counts)
            result = self._lib.dg_host_positions(self._host, at, step, to, n)
        checked(result, f"{self.model}: the position")
        return counts

    @property
    def sincos(self) -> SinCos:
        """RS485: the process channel now."""
        to = self._ffi.new("int32_t[4]")
        with self.clock.lock:
            result = self._lib.dg_host_sincos(self._host, self.clock._sync(), to)
        checked(result, f"{self.model}: sine and cosine")
        return SinCos(*(level / 1e6 for level in to))

    # ------------------------------------------------------------ wires

    def _wire(self, medium: Medium) -> None:
        if self.medium is not medium:
            raise EncoderError(f"{self.model} speaks {self.protocol}: it has no {WIRES[medium]}", ERR_WIRE)

    def _speaks(self, protocol: str) -> None:
        """For what serves this protocol only."""
        if self.protocol != protocol:
            raise EncoderError(f"{self.model} speaks {self.protocol}, not {protocol}", ERR_WIRE)

    def _master(self, name: str, kind: Any) -> Any:
        """Made when it is asked for first."""
        _ = self._host  # it is not closed
        found = self.__dict__.get(f"_{name}_master")
        if found is None:
            found = self.__dict__[f"_{name}_master"] = kind(self)
        return found

    @property
    def rs485(self) -> Line:
        """RS485: the line that it is on, and its master."""
        _ = self._host  # it is not closed
        self._wire(Medium.CHARACTERS)
        assert self._line is not None
        return self._line

    def request(self, data: bytes, timeout: float = 0.1) -> bytes:
        """RS485: a frame there and what comes back, b"" after `timeout` of silence. Time goes on as on
        the line."""
        return self.rs485.request(data, timeout)

    @property
    def bus(self) -> CanBus:
        """CANopen: the bus that it is on."""
        self._wire(Medium.FRAMES)
        assert self._bus is not None
        return self._bus

    @property
    def can(self) -> CanPort:
        """CANopen: a master on its bus."""
        self._wire(Medium.FRAMES)
        master: CanPort = self._master("can", lambda _: self.bus.port())
        return master

    @property
    def clocked(self) -> Clocked:
        """The master of a clocked line, whatever its encoder speaks: frames and edges."""
        self._wire(Medium.EDGES)
        master: Clocked = self._master("clocked", Clocked)
        return master

    @property
    def biss(self) -> Biss:
        """The master of its line."""
        self._speaks(Biss.PROTOCOL)
        master: Biss = self._master(Biss.PROTOCOL, Biss)
        return master

    @property
    def ssi(self) -> Ssi:
        """The master of its line."""
        self._speaks(Ssi.PROTOCOL)
        master: Ssi = self._master(Ssi.PROTOCOL, Ssi)
        return master

    @property
    def ring(self) -> Ring:
        """INTERBUS: the master of a ring of this encoder alone."""
        self._wire(Medium.WORDS)
        master: Ring = self._master("ring", Ring)
        return master

    # ------------------------------------------------------------ faults and SCPI

    def _couple(self) -> None:
        """Its panel's shaft follows the one that it sits on."""
        own = self._lib.dg_host_panel_shaft(self._panel)
        checked(self._lib.dg_shaft_couple(own, self._shaft._c, 1, 1), "the shaft of a panel")

    def _with_panel(self) -> Any:
        host = self._host  # it is not closed
        if self._panel is None:
            size = self._lib.dg_host_panel_size()
            self._panel_keep, place = _native.aligned(size)
            self._answer = self._ffi.new("char[]", ANSWER)
            panel = self._lib.dg_host_panel_make(place, size, host)
            if panel == self._ffi.NULL:
                raise EncoderError(f"{self.model}: faults and SCPI need an encoder that was on", -9)
            self._panel = panel
            self._couple()
            if self._wire_at is not None:
                self._wire_at._control(self)
        return self._panel

    def _scpi(self, line: str) -> str:
        lib, now = self._lib, self.clock._ns
        result = lib.dg_host_scpi(self._with_panel(), now, encoded(line, "a line", "ascii"), self._answer, ANSWER)
        checked(result, line)
        return str(self._ffi.string(self._answer).decode("ascii"))

    def ask(self, line: str) -> str | None:
        """An SCPI line; its answer, None when it has none. Raises ScpiError."""
        with self.clock.lock:
            self._enter(self.clock._sync())
            answer = self._scpi(line)
            code, text, *_ = split(self._scpi("SYST:ERR:ALL?"))
            self._changed()
        if int(code) != 0:
            raise ScpiError(int(code), text.replace(GEARED, "turn the encoder's .shaft"), line)
        return answer or None

    def set_fault(
        self,
        name: str,
        count: int | None = None,
        probability: float | None = None,
        duration_ms: float | None = None,
    ) -> None:
        """Let a fault happen: until it is cleared, `count` times, or as long as it says."""
        with self.clock.lock:
            if (count, probability, duration_ms) == (None, None, None):
                self._switch(name, True)
            elif name in (fault["name"] for fault in self.faults()):
                super().set_fault(name, count, probability, duration_ms)
            else:
                checked(self._lib.DG_HOST_ERR_NAME, f"{self.model}: fault {name}")

    def clear_fault(self, name: str = "") -> None:
        """Clear one fault, or all."""
        for one in [name] if name else self.active_faults():
            self._switch(one, False)

    def _switch(self, name: str, on: bool) -> None:
        with self.clock.lock:
            now = self._enter(self.clock._sync())
            result = self._lib.dg_host_fault_set(self._with_panel(), now, encoded(name, "fault"), on)
            checked(result, f"{self.model}: fault {name}")
            self._changed()
