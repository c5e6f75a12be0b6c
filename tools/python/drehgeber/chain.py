# SPDX-License-Identifier: MIT
"""Chains of BiSS encoders in this process: frames of all of them, and registers of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ._native import EncoderError, RangeError, checked, octets, whole
from .clock import seconds_of
from .clocked import Biss, Frame
from .wire import make_bus

if TYPE_CHECKING:
    from .encoder import Encoder

CLOCK_HZ = 1_000_000
SILENT = -14
# Failures of an access as results of a handle; one that is busy for too long does not answer.
FAILURES = {-1: SILENT, -2: -13, -3: SILENT, -4: -4}


class Chain:
    """The master of a chain: `Chain([first, second])`, the first one is nearest to it, all on the same clock. What happens
    between them, with faults behind each one's driver, is the library's bus, and so is the master. Time goes on as long as it
    clocks, with 1 MHz."""

    def __init__(self, encoders: Sequence[Encoder]) -> None:
        self._encoders = members = tuple(encoders)
        if not members or len(set(map(id, members))) < len(members):
            raise EncoderError("an encoder stands in a chain once, and one at least")
        for one in members:
            one._speaks(Biss.PROTOCOL)
            if one.clock is not members[0].clock:
                raise EncoderError("encoders of a chain go by the same clock")
        self._ffi, self._lib = ffi, lib = members[0]._ffi, members[0]._lib
        self.clock = members[0].clock
        self._queue = ffi.new("struct dg_bus_queue *")  # without room: levels are read, and nobody is told
        ops = ffi.cast("struct dg_bus_ops *", lib.dg_bus_queue_ops)
        self._keep, self._bus = make_bus("edges", len(members), ffi.NULL, ops, self._queue)
        lib.dg_bus_watch(self._bus, False)
        with self.clock.lock:
            for one in members:
                checked(lib.dg_bus_attach(self._bus, one._host, ffi.NULL), f"{one.model} in a chain")
                one._ring = self  # whoever holds an encoder holds what listens to it
        setup = ffi.new("struct dg_bus_master_setup *")
        setup.size, setup.bus, setup.clock_hz = ffi.sizeof("struct dg_bus_master_setup"), self._bus, CLOCK_HZ
        setup.protocol = self._protocol = ffi.cast("struct dg_master_protocol *", lib.dg_biss_master)
        self._master = ffi.new("struct dg_bus_master *")
        lib.dg_bus_master_init(self._master, setup, 0)

    @property
    def encoders(self) -> tuple[Encoder, ...]:
        """In the order of the line."""
        return self._encoders

    def _begin(self) -> None:
        """It is the present for the bus. What was done to the encoders since is looked at."""
        lib, now = self._lib, self.clock._sync()
        for place, one in enumerate(self._encoders):
            one._run(now)
            panel = one._panel
            lib.dg_bus_control(self._bus, place, self._ffi.NULL if panel is None else lib.dg_host_panel_encoder(panel))
        lib.dg_bus_master_pause(self._master, now)

    def _end(self) -> None:
        """The clock follows."""
        self.clock._wait_until(self._master.now)

    def _frame(self, place: int) -> Frame:
        """What was read of an encoder."""
        master, word = self._master, self._ffi.new("struct dg_master_word *")
        self._protocol.word(master, place, word)
        return Frame(
            seconds_of(master.latched), seconds_of(master.now), word.position, word.multiturn, word.singleturn,
            word.error, word.warning, self._protocol.judge(master, place) == 0, word.life, word.bits, word.count,
        )  # fmt: skip

    def frame(self) -> tuple[Frame, ...]:
        """A frame of all encoders, with the position of a microsecond from now."""
        with self.clock.lock:
            self._begin()
            self._lib.dg_bus_master_read(self._master)
            self._end()
            if not self._master.answered:
                raise EncoderError("nobody answers", SILENT)
            return tuple(self._frame(place) for place in range(len(self._encoders)))

    def _access(self, place: int, address: int, count: int, **memory: Any) -> int:
        """Registers, to or from `memory`. @return how many"""
        access = self._ffi.new("struct dg_biss_access *")
        access.place = whole(place, 0, len(self._encoders) - 1, "place")
        access.address = whole(address, 0, 127, "address")
        if not 1 <= count <= 64:
            raise RangeError(f"{count} registers: expected 1..64")
        access.n = count
        for name, bytes_ in memory.items():
            setattr(access, name, bytes_)
        with self.clock.lock:
            silent = self._master.silent
            self._begin()
            result = self._lib.dg_biss_access(self._master, access)
            self._end()
            if access.done == 0 or self._master.silent != silent:
                checked(FAILURES[result], f"{count} registers from {address:02X}h")
        return int(access.done)

    def register(self, place: int, address: int, count: int = 1) -> bytes:
        """Read registers of the encoder at a place, 0 is the first one; less than `count` where it refuses one."""
        to = self._ffi.new("uint8_t[]", 64)
        done = self._access(place, address, whole(count, 1, 64, "count"), got=to)
        return bytes(self._ffi.buffer(to, done))

    def write_register(self, place: int, address: int, data: bytes) -> int:
        """Write registers. How many it took."""
        data = octets(data, "registers")
        return self._access(place, address, len(data), sent=self._ffi.from_buffer("uint8_t[]", data))
