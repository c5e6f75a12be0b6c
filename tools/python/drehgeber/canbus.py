# SPDX-License-Identifier: MIT
"""A CAN bus in this process: CANopen encoders, and masters that talk to them."""

from __future__ import annotations

import weakref
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from ._native import EncoderError, checked, load, octets, whole, within
from .clock import NEVER, SECOND_NS, SECONDS_MAX, Clock, seconds_of

if TYPE_CHECKING:
    from .encoder import Encoder

DATA = 16
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


class CanBus:
    """CAN without time on the wire: what is sent is heard at once. `name` is what
    can.Bus(interface="drehgeber", channel=NAME) knows it by, as long as somebody holds it."""

    def __init__(self, name: str | None = None, *, clock: Clock | None = None) -> None:
        self._ffi, self._lib = load()
        self.name = name
        self.clock = clock or Clock()
        self._nodes: list[Encoder] = []
        self._ports: list[CanPort] = []
        self._event = self._ffi.new("struct dg_host_event *")
        self._data = self._ffi.buffer(self._event.data)
        self._ids = self._ffi.new("uint16_t[]", self._lib.DG_HOST_FILTERS)
        self._kind: int = self._lib.DG_HOST_CAN
        self._remote: int = self._lib.DG_HOST_REMOTE
        if name is not None:
            if name in _named:
                raise EncoderError(f"there is a bus {name!r} already")
            _named[name] = self
        self.clock._members.append(self)

    @staticmethod
    def named(name: str) -> CanBus | None:
        """The bus of that name, if there is one."""
        return _named.get(name)

    @property
    def nodes(self) -> tuple[Encoder, ...]:
        """The encoders on it."""
        return tuple(self._nodes)

    def port(self) -> CanPort:
        """One more master."""
        with self.clock.lock:
            return CanPort(self)

    # ------------------------------------------------------------ what happens on it

    def _next(self) -> int:
        return min((node._deadline for node in self._nodes), default=NEVER)

    def _answer_at(self) -> int:
        """When the next answer comes that a master is still to get; NEVER: there is none."""
        answer_at = self._lib.dg_host_answer_at
        return min((int(answer_at(node._host)) for node in self._nodes), default=NEVER)

    def _run(self, until_ns: int) -> None:
        """Deadline by deadline: what a node says, the others hear at that moment."""
        now = self.clock._ns
        while (due := self._next()) < until_ns:
            now = max(due, now + 1)
            if now >= until_ns:
                break
            self._serve(now)
        self._serve(until_ns)

    def _serve(self, now: int) -> None:
        """At one moment, until nobody says anything any more."""
        stepped = self._nodes
        while stepped:
            for node in stepped:
                node._step(now)
            stepped = self._spread(stepped)

    def _spread(self, senders: list[Encoder]) -> list[Encoder]:
        """Let masters and nodes hear what these have said. @return the nodes that did"""
        event, receive = self._event, self._lib.dg_host_receive
        listeners: dict[int, list[Encoder]] | None = None
        reached: dict[Encoder, None] = {}
        for sender in senders:
            while receive(sender._host, event) == 1:
                if event.kind != self._kind:
                    continue
                remote, length = bool(event.flags & self._remote), event.length
                data = b"" if remote else self._data[:length]
                self._tell(CanFrame(seconds_of(event.at), event.id, data, remote, length))
                if listeners is None:
                    listeners = self._listeners()
                for node in listeners.get(event.id, ()):
                    if node is not sender:
                        self._to(node)
                        reached[node] = None
        return list(reached)

    def _listeners(self) -> dict[int, list[Encoder]]:
        """Which identifiers the nodes listen to at the moment, if there are others to hear them."""
        listeners: dict[int, list[Encoder]] = {}
        for node in self._nodes if len(self._nodes) > 1 else ():
            count = self._lib.dg_host_filters(node._host, self._ids)
            for id in self._ffi.unpack(self._ids, count) if count > 0 else ():
                listeners.setdefault(id, []).append(node)
        return listeners

    def _tell(self, frame: CanFrame, sender: CanPort | None = None) -> None:
        for port in self._ports:
            if port is not sender:
                port._heard.append(frame)
        self.clock.changed.notify_all()

    def _to(self, node: Encoder) -> None:
        """The event at hand, to a node."""
        if node._made:
            result = self._lib.dg_host_send(node._host, self._event)
            if result != 0:
                checked(result, f"frame {self._event.id:03X}h")

    def _send(self, id: int, data: bytes, remote: bool, dlc: int, sender: CanPort) -> None:
        """Of a master, now. The lock is held."""
        event, now = self._event, self.clock._ns
        event.at, event.id, event.kind, event.length = now, id, self._kind, dlc
        event.flags = self._remote if remote else 0
        self._data[:] = data.ljust(DATA, b"\0")
        for node in self._nodes:
            self._to(node)
        if len(self._ports) > 1:
            self._tell(CanFrame(seconds_of(now), id, data, remote, dlc), sender)
        self._serve(now)
