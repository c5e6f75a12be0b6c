# SPDX-License-Identifier: MIT
"""A wire with encoders of this process on it: a door of the library's bus, where all that happens between them is."""

from __future__ import annotations

import functools
import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ._native import EncoderError, RangeError, aligned, checked, load
from .clock import LEAD_NS, NEVER, Clock

if TYPE_CHECKING:
    from .encoder import Encoder

# What is told and not read yet: what one moment makes encoders say is as much as half of it at most.
ROOM, ROOM_EACH = 256, 16


@functools.cache
def row_of(**members: str) -> struct.Struct:
    """Of what a queue has: the moment, whether it was looked at only, and these members of a struct dg_tap_event, by their
    paths, each with its format."""
    ffi, _ = load()
    rows = {ffi.offsetof("struct dg_bus_told", "looked"): "?"}
    for path, form in members.items():
        rows[ffi.offsetof("struct dg_bus_told", "event", *path.split("__"))] = form
    text, end = "=Q", 8  # event.at is first
    for offset, form in sorted(rows.items()):
        text += f"{offset - end}x{form}"
        end = offset + struct.calcsize(f"={form}")
    return struct.Struct(f"{text}{ffi.sizeof('struct dg_bus_told') - end}x")


def make_bus(medium: str, encoders: int, wire: Any, ops: Any, ctx: Any) -> tuple[Any, Any]:
    """Make a bus with room for so many. @return what has to outlive it, and the bus"""
    ffi, lib = load()
    kind = ffi.cast("struct dg_bus_medium *", getattr(lib, f"dg_bus_{medium}"))
    size = lib.dg_bus_size(kind, encoders)
    if size == 0:
        raise RangeError(f"{encoders} encoders: more than there can be on such a wire, or none")
    setup = ffi.new("struct dg_bus_setup *")
    setup.size, setup.medium, setup.encoders = ffi.sizeof("struct dg_bus_setup"), kind, encoders
    setup.wire, setup.ops, setup.ctx = wire, ops, ctx
    keep, place = aligned(size)
    return (keep, wire, ops, ctx), lib.dg_bus_init(place, size, setup)


class Wire:
    """What a line and a CAN bus have in common. Encoders come to it when they are switched on for the first time, and leave it
    when they are closed."""

    MEDIUM = ""  # as the library's objects are called
    MOST = 0  # encoders

    def __init__(self, clock: Clock | None) -> None:
        self._ffi, self._lib = load()
        self.clock = clock or Clock()
        self._encoders: list[Encoder] = []  # of this wire, whether they were on or not
        self._placed: list[Encoder] = []  # by their places on the bus
        self._panels: list[Encoder] = []  # those with faults, which may end
        self._bus: Any = None
        self._room = 0
        self._most = 0  # so many may wait to be read before time stops
        self._event = self._ffi.new("struct dg_tap_event *")
        self._queue = self._ffi.new("struct dg_bus_queue *")

    # ------------------------------------------------------------ who is on it

    def _join(self, encoder: Encoder, own: bool) -> None:
        """It will be on this wire. `own`: which was made for it."""
        if len(self._encoders) == self.MOST:
            raise RangeError(f"{self.MOST + 1} encoders on one wire: expected {self.MOST} at most")
        self._room = self._room or (1 if own else self.MOST)
        if not self._encoders:
            self.clock._members.append(self)
        self._encoders.append(encoder)

    def _leave(self, encoder: Encoder) -> None:
        """It is closed."""
        if encoder not in self._encoders:
            return
        self._encoders.remove(encoder)
        if encoder in self._panels:
            self._panels.remove(encoder)
        if encoder._place is not None:
            self._lib.dg_bus_detach(self._bus, encoder._place, self.clock._ns)
            self._read()
            self._placed.remove(encoder)
            for place, one in enumerate(self._placed):
                one._place = place
        if not self._encoders:
            self.clock._members.remove(self)

    def _attach(self, encoder: Encoder) -> None:
        """It is about to be switched on for the first time, or was before anybody listened."""
        if self._bus is None or len(self._placed) == self._room:
            self._build()
        encoder._place = checked(self._lib.dg_bus_attach(self._bus, encoder._host, self._ffi.NULL), encoder.model)
        self._placed.append(encoder)

    def _build(self) -> None:
        """A bus for those that are on it, and for as many as there can be from the second time on."""
        if self._bus is not None and self._room < self.MOST:
            self._room = self.MOST
        self._keep, self._bus = make_bus(self.MEDIUM, self._room, self._setup(), *self._door(self._room))
        self._look_on()
        placed, self._placed = self._placed, []
        for one in placed:
            self._attach(one)
            self._control(one)

    def _door(self, encoders: int) -> tuple[Any, Any]:
        """Operations of a bus with so many, and what they are called with."""
        self._room, room = encoders, ROOM + ROOM_EACH * encoders
        self._rows = self._ffi.new("struct dg_bus_told[]", room)
        self._queue.told, self._queue.room, self._queue.count = self._rows, room, 0
        self._most = room // 2
        self._told = self._ffi.buffer(self._rows)
        self._row = self._told_as()
        return self._ffi.cast("struct dg_bus_ops *", self._lib.dg_bus_queue_ops), self._queue

    def _open(self, bus: Any, keep: Any) -> None:
        """There is a bus with all encoders of this wire, which got their power a second ago. What they said meanwhile nobody
        has heard."""
        self._keep, self._bus, self._placed = keep, bus, list(self._encoders)
        for place, one in enumerate(self._placed):
            one._place = place
            self._lib.dg_bus_changed(bus, place, self.clock._ns - LEAD_NS)
        self._lib.dg_bus_step(bus, self.clock._ns)
        self._queue.count = 0
        self._look_on()

    def _look_on(self) -> None:
        """What is only looked at is told if somebody looks."""
        if self._bus is not None:
            self._lib.dg_bus_watch(self._bus, self._looks())

    def _looks(self) -> bool:
        """Whether somebody does."""
        return False

    def _setup(self) -> Any:
        """What the medium takes."""
        raise NotImplementedError

    def _told_as(self) -> struct.Struct:
        """How a row of what is told is read."""
        raise NotImplementedError

    def _control(self, encoder: Encoder) -> None:
        """Faults of its panel, if it has one, are of what it sends and hears here."""
        if encoder._panel is not None and encoder._place is not None:
            control = self._lib.dg_host_panel_encoder(encoder._panel)
            self._lib.dg_bus_control(self._bus, encoder._place, control)
            if encoder not in self._panels:
                self._panels.append(encoder)

    # ------------------------------------------------------------ time

    def _next(self) -> int:
        due = NEVER if self._bus is None else int(self._lib.dg_bus_next(self._bus))
        return min([due, *(one._deadline for one in self._panels)]) if self._panels else due

    def _run(self, until_ns: int) -> None:
        """Whatever is due, each at its own moment. Faults end at theirs."""
        while self._panels and (due := min(one._deadline for one in self._panels)) <= until_ns:
            self._step(due)
            for one in self._panels:
                if one._deadline <= due:
                    self._serve_panel(one, due)
        self._step(until_ns)

    def _step(self, until_ns: int) -> None:
        if self._bus is None:
            return
        step, bus, queue, most = self._lib.dg_bus_step_queued, self._bus, self._queue, self._most
        while step(bus, queue, until_ns, most) <= until_ns:
            self._read()
        if queue.count:
            self._read()

    def _look(self, now: int) -> None:
        """Whatever was due before has happened, and it is `now`."""
        if self._bus is not None:
            self._lib.dg_bus_look(self._bus, now)

    def _serve_panel(self, encoder: Encoder, now: int) -> None:
        self._look(now)
        encoder._deadline = max(now + 1, int(self._lib.dg_host_panel_step(encoder._panel, now)))
        self._lib.dg_bus_changed(self._bus, encoder._place, now)

    def _change(self, encoder: Encoder) -> None:
        """Something was done to it at the present: what it does about it happens."""
        if encoder._place is None:
            return
        if encoder in self._panels:
            self._serve_panel(encoder, self.clock._ns)
        else:
            self._lib.dg_bus_changed(self._bus, encoder._place, self.clock._ns)
        self._read()

    def _touch(self) -> None:
        """Shafts have moved."""
        for encoder in self._encoders:
            self._change(encoder)

    def _read(self) -> None:
        """Take what was told."""
        size, queue = self._row.size, self._queue
        rows = list(self._row.iter_unpack(self._told[: size * queue.count]))
        queue.count = 0
        if rows:
            self._hear(rows)

    def _hear(self, rows: Sequence[tuple[Any, ...]]) -> None:
        """What the encoders have said."""
        raise NotImplementedError
