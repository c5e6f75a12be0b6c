# SPDX-License-Identifier: MIT
"""BiSS and SSI of an encoder in this process: frames, registers, edges."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from ._native import checked, octets, whole
from .clock import seconds_of

if TYPE_CHECKING:
    from .encoder import Encoder


class Frame(NamedTuple):
    """A frame as a master sees it."""

    at: float  # the position is of this moment
    end: float  # the encoder is ready for the next one
    position: int  # multiturn and singleturn, binary
    multiturn: int
    singleturn: int
    error: bool
    warning: bool  # BiSS
    good: bool  # check sum or parity are right
    life: int  # BiSS: life counter
    bits: int  # as they came, behind start bit and CDS (BiSS)
    width: int  # how many those are


class Level(NamedTuple):
    """What the encoder's line is from a moment on."""

    at: float
    level: bool


class Clocked:
    """The master of a clocked line. Time goes on as long as it clocks."""

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._frame = encoder._ffi.new("struct dg_host_frame *")
        self._now = encoder._ffi.new("uint64_t *")

    def frame(self) -> Frame:
        """Clock a frame with 1 MHz, latched now. Faults of the wire happen behind this master: see clock()."""
        encoder, got = self._encoder, self._frame
        with encoder.clock.lock:
            now = encoder.clock._sync()
            checked(encoder._lib.dg_host_frame(encoder._host, now, got), f"a frame of {encoder.model}")
            encoder.clock._wait_until(got.end)
        return Frame(
            seconds_of(got.at), seconds_of(got.end), got.position, got.multiturn, got.singleturn,
            got.error == 1, got.warning == 1, got.good == 1, got.life, got.bits, got.count,
        )  # fmt: skip

    def clock(self, level: bool) -> bool:
        """The master's clock is at `level` from now on; the level of the encoder's line, with faults of the wire."""
        encoder = self._encoder
        level = whole(level, 0, 1, "level") == 1
        with encoder.clock.lock:
            now = encoder.clock._sync()
            return checked(encoder._lib.dg_host_clock(encoder._host, now, level), "the clock") == 1

    def watch(self) -> deque[Level]:
        """Each change of the encoder's line from now on, oldest first, with faults of the wire; those of frame() are not told. Empty
        it as you read; an encoder has one."""
        encoder = self._encoder
        with encoder.clock.lock:
            encoder.clock._sync()
            if encoder._levels is None:
                encoder._levels = levels = deque[Level]()
                encoder._listen(lambda event: levels.append(Level(seconds_of(event.at), event.data[0] != 0)))
            return encoder._levels


class Ssi(Clocked):
    """SSI."""

    PROTOCOL = "ssi"


class Biss(Clocked):
    """BiSS: frames, and registers through them."""

    PROTOCOL = "biss"

    def sli(self, level: bool) -> bool:
        """The line of the next encoder in the chain is at `level` from now on, low until then as that of the last one; the level
        of this one's line. frame() and registers are point to point."""
        encoder = self._encoder
        level = whole(level, 0, 1, "level") == 1
        with encoder.clock.lock:
            now = encoder.clock._sync()
            return checked(encoder._lib.dg_host_behind(encoder._host, now, level), "SLI") == 1

    def _registers(self, way: str, address: int, data: object, count: int) -> int:
        encoder = self._encoder
        address = whole(address, 0, 127, "address")
        with encoder.clock.lock:
            self._now[0] = encoder.clock._sync()
            call = getattr(encoder._lib, f"dg_host_registers_{way}")
            done = call(encoder._host, self._now, address, data, count)
            encoder.clock._wait_until(self._now[0])  # a register that is refused takes its time, too
        return checked(done, f"{count} registers from {address:02X}h")

    def register(self, address: int, count: int = 1) -> bytes:
        """Read registers from `address` on; less than `count` where the encoder refuses one."""
        count = whole(count, 1, 64, "count")
        to = self._encoder._ffi.new("uint8_t[]", count)
        done = self._registers("read", address, to, count)
        return bytes(self._encoder._ffi.buffer(to, done))

    def write_register(self, address: int, data: bytes) -> int:
        """Write registers from `address` on. How many it took."""
        data = octets(data, "registers")
        return self._registers("write", address, data, len(data))
