# SPDX-License-Identifier: MIT
"""A CAN bus in this process: CANopen encoders, and masters that talk to them."""

from __future__ import annotations

import struct
import weakref
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ._native import EncoderError, RangeError, octets, whole, within
from .clock import NEVER, SECOND_NS, SECONDS_MAX, Clock, seconds_of
from .wire import Wire, row_of

if TYPE_CHECKING:
    from .encoder import Encoder

DATA = 8
BAUD_MAX = 1_000_000
# Frames that wait at most: for their time, for encoders that hear them, late by a fault.
WAITING, WAITING_EACH = 1024, 8
# What a controller is, or has done: enum dg_host_bus.
CONTROLLER = ("active", "passive", "off", "overrun")
# Whether anybody acknowledges: enum dg_bus_company.
COMPANY = ("unknown", "somebody", "nobody")
_named: weakref.WeakValueDictionary[str, CanBus] = weakref.WeakValueDictionary()


class CanFrame(NamedTuple):
    """A frame; `at` is the moment it was complete, as Clock.now counts."""

    at: float
    id: int
    data: bytes
    remote: bool = False
    dlc: int = 0


class CanPort:
    """A master's controller: it hears everybody but itself."""

    def __init__(self, bus: CanBus) -> None:
        self.bus = bus
        self._heard: deque[CanFrame] = deque()
        bus._ports.append(self)

    def send(self, id: int, data: bytes = b"", remote: bool = False, dlc: int | None = None) -> None:
        """Send a frame now; what is answered at once is there when this returns."""
        bus, data = self.bus, octets(data, "data")
        id = whole(id, 0, 0x7FF, "id")
        length = whole(len(data), 0, 8, "length of data")
        dlc = length if dlc is None else whole(dlc, 0, 8, "dlc")
        with bus.clock.lock:
            if self not in bus._ports:
                raise EncoderError("the port, or the encoder that it was for, is closed")
            bus.clock._sync()
            bus._send(id, data, remote, dlc, self)
            if 0x600 <= id < 0x680:  # SDO: whoever waits for the answer looks when it is due
                bus.clock.changed.notify_all()

    def recv(self) -> CanFrame | None:
        """The next frame that was heard; None: there is none so far. No time passes."""
        if not self._heard and self.bus.clock.real:
            self.bus.clock._sync()
        try:
            return self._heard.popleft()
        except IndexError:
            return None

    def wait(self, timeout: float | None = None) -> CanFrame | None:
        """As recv(), but wait in real time for somebody else to say something, or to move on
        virtual time; None after `timeout` seconds. An answer that an encoder takes its time for
        ("save") is waited for in virtual time, too: that passes until it comes, and no longer than
        `timeout`."""
        clock = self.bus.clock
        if timeout is not None:
            timeout = float(within(timeout, 0, SECONDS_MAX, "timeout"))
        end = None if timeout is None else clock._monotonic() + timeout
        with clock.lock:
            limit = NEVER if timeout is None else clock._ns + round(timeout * SECOND_NS)
            while (frame := self.recv()) is None:
                due = NEVER if clock.real else self.bus._answer_at()
                if clock._ns < limit and due != NEVER:
                    clock._go(min(due, limit))
                    continue
                left = None if end is None else end - clock._monotonic()
                if left is not None and left <= 0:
                    return None
                clock._sleep(left, self.bus._next())
        return frame

    def close(self) -> None:
        """Leave the bus."""
        with self.bus.clock.lock:
            if self in self.bus._ports:
                self.bus._ports.remove(self)


class CanBus(Wire):
    """A CAN bus. A frame is heard at once, and those of one moment in the order of the encoders on it, unless `pace` gives each
    its time at the bit rate, or `arbitrate` lets a lower identifier go first. `bit_rate` is that of the wire in bit/s: encoders of
    another one are deaf and mute; 0: it carries all. `name` is what can.Bus(interface="drehgeber", channel=NAME) knows it by,
    as long as somebody holds it."""

    MEDIUM = "frames"
    MOST = 127

    def __init__(
        self,
        name: str | None = None,
        *,
        clock: Clock | None = None,
        pace: bool = False,
        arbitrate: bool = False,
        bit_rate: int = 0,
    ) -> None:
        super().__init__(clock)
        self.name = name
        self._ports: list[CanPort] = []
        self._event.kind = self._lib.DG_TAP_FRAME
        self._frame = self._event.frame
        self._data = self._ffi.buffer(self._frame.data)
        self._looked: deque[CanFrame] | None = None  # where somebody does
        self._wire = self._ffi.new("struct dg_bus_frames_setup *", {"size": self._ffi.sizeof("struct dg_bus_frames_setup")})
        self._wire.pace, self._wire.arbitrate = bool(pace), bool(arbitrate)
        self._wire.line.bit_rate = whole(bit_rate, 0, BAUD_MAX, "bit_rate")
        if name is not None:
            if name in _named:
                raise EncoderError(f"there is a bus {name!r} already")
            _named[name] = self

    @staticmethod
    def named(name: str) -> CanBus | None:
        """The bus of that name, if there is one."""
        return _named.get(name)

    @property
    def nodes(self) -> tuple[Encoder, ...]:
        """The encoders on it."""
        return tuple(self._encoders)

    def port(self) -> CanPort:
        """One more master."""
        with self.clock.lock:
            return CanPort(self)

    def watch(self) -> deque[CanFrame]:
        """Whatever goes over the bus from now on, of masters and encoders, oldest first, with the moment at which it was sent,
        however long it had to wait for its time (`pace`). Empty it as you read; a bus has one."""
        with self.clock.lock:
            if self._looked is None:
                self._looked = deque()
                self._look_on()
            return self._looked

    # ------------------------------------------------------------ the controllers of its encoders

    def controller(self, state: str) -> None:
        """What the bus has made of the encoders' controllers: "active", "passive" or "off", which lasts until it is "active"
        again; or "overrun": they have lost a frame. Faults of an encoder make its own worse, never better."""
        what = self._word(state, CONTROLLER)
        with self.clock.lock:
            now = self.clock._sync()
            if self._bus is not None:
                self._lib.dg_bus_frames_controller(self._bus, now, what)
                self._read()

    def company(self, who: str) -> None:
        """Whether anybody acknowledges, which encoders show on their LEDs: "somebody", "nobody", or "unknown", as to begin
        with."""
        self._wire.line.company = self._word(who, COMPANY)
        with self.clock.lock:
            now = self.clock._sync()
            if self._bus is not None and self._lib.dg_bus_frames_set_line(self._bus, self._ffi.addressof(self._wire.line)):
                self._lib.dg_bus_step(self._bus, now)
                self._read()

    @staticmethod
    def _word(word: str, words: tuple[str, ...]) -> int:
        if word not in words:
            raise RangeError(f"{word!r}: expected {', '.join(words[:-1])} or {words[-1]}")
        return words.index(word)

    # ------------------------------------------------------------ what happens on it

    def _setup(self) -> Any:
        rooms = WAITING + WAITING_EACH * self._room
        self._waiting = self._ffi.new("struct dg_bus_frames_room[]", rooms)
        self._wire.room, self._wire.rooms = self._waiting, rooms
        return self._wire

    def _told_as(self) -> struct.Struct:
        return row_of(frame__id="H", frame__rtr="?", frame__dlc="B", frame__data="8s")

    def _looks(self) -> bool:
        return self._looked is not None

    def _answer_at(self) -> int:
        """When the next answer comes that a master is still to get; NEVER: there is none."""
        answer_at = self._lib.dg_host_answer_at
        return min((int(answer_at(node._host)) for node in self._encoders), default=NEVER)

    def _hear(self, rows: Sequence[tuple[Any, ...]]) -> None:
        for at, id, remote, length, data, looked in rows:
            frame = CanFrame(seconds_of(at), id, b"" if remote else data[:length], remote, length)
            if not looked:
                for port in self._ports:
                    port._heard.append(frame)
            elif self._looked is not None:
                self._looked.append(frame)
        self.clock.changed.notify_all()

    def _send(self, id: int, data: bytes, remote: bool, dlc: int, sender: CanPort) -> None:
        """Of a master, now. The lock is held."""
        now = self.clock._ns
        if len(self._ports) > 1:
            frame = CanFrame(seconds_of(now), id, data, remote, dlc)
            for port in self._ports:
                if port is not sender:
                    port._heard.append(frame)
            self.clock.changed.notify_all()
        if self._bus is not None:
            to = self._frame
            self._event.at, to.id, to.rtr, to.dlc = now, id, remote, dlc
            self._data[:] = data.ljust(DATA, b"\0")
            self._lib.dg_bus_rx(self._bus, self._event)
            self._read()
