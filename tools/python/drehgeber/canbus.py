# SPDX-License-Identifier: MIT
"""A CAN bus in this process: CANopen encoders, and masters that talk to them."""

from __future__ import annotations

import weakref
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from ._native import EncoderError, checked, load
from .clock import NEVER, Clock, seconds_of

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
        bus = self.bus
        with bus.clock.lock:
            bus.clock._sync()
            bus._send(id, data, remote, len(data) if dlc is None else dlc, self)

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
        virtual time; None after `timeout` seconds."""
        clock = self.bus.clock
        end = None if timeout is None else clock._monotonic() + timeout
        with clock.lock:
            while (frame := self.recv()) is None:
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
        for node in self._nodes:
            node._step(now)
        pending = [node for node in self._nodes if self._drain(node)]
        while pending:
            for node in self._nodes:
                node._step(now)
            pending = [node for node in self._nodes if self._drain(node)]

    def _drain(self, node: Encoder) -> bool:
        """Whether others than masters heard something of this node."""
        event, others = self._event, len(self._nodes) > 1
        heard = False
        while self._lib.dg_host_receive(node._host, event) == 1:
            if event.kind != self._kind:
                continue
            heard = heard or others
            remote = bool(event.flags & self._remote)
            self._tell(
                CanFrame(
                    seconds_of(event.at), event.id, b"" if remote else self._data[: event.length],
                    remote, event.length,
                )  # fmt: skip
            )
            if others:
                self._to_nodes(node)
        return heard

    def _tell(self, frame: CanFrame, sender: CanPort | None = None) -> None:
        for port in self._ports:
            if port is not sender:
                port._heard.append(frame)
        self.clock.changed.notify_all()

    def _to_nodes(self, sender: Encoder | None = None) -> None:
        """The event at hand, to all nodes but the one it is from."""
        for node in self._nodes:
            if node is not sender and node._made:
                checked(self._lib.dg_host_send(node._host, self._event), f"frame {self._event.id:03X}h")

    def _send(self, id: int, data: bytes, remote: bool, dlc: int, sender: CanPort) -> None:
        """Of a master, now. The lock is held."""
        if len(data) > 8 or dlc > 8 or not 0 <= id <= 0x7FF:
            raise EncoderError(f"{id:X}h with {max(len(data), dlc)} bytes is no frame of 11 bits and 8 bytes")
        event, now = self._event, self.clock._ns
        event.at, event.id, event.kind, event.length = now, id, self._kind, dlc
        event.flags = self._remote if remote else 0
        self._data[:] = data.ljust(DATA, b"\0")
        self._to_nodes()
        if len(self._ports) > 1:
            self._tell(CanFrame(seconds_of(now), id, data, remote, dlc), sender)
        self._serve(now)
