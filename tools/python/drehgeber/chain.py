# SPDX-License-Identifier: MIT
"""Chains of BiSS encoders in this process: frames of all of them, and registers of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ._native import EncoderError, RangeError, checked, octets, whole
from .clock import seconds_of
from .clocked import Biss, Frame
from .wire import make_bus

if TYPE_CHECKING:
    from .encoder import Encoder

HALF_NS = 500  # of the master's clock
PAUSE_NS = 15_000  # longer than an encoder's timeout
START_CLOCKS = 1200  # longer than any start bit takes
BUSY_NS = 20_000_000
ZEROS = 14  # frames before a control frame
CRC6, CRC4 = (6, 0x43), (4, 0x13)
REFUSED, SILENT, DAMAGED = -13, -14, -4


def remainder(bits: int, width: int, code: tuple[int, int]) -> int:
    """The check sum of `width` bits, as sent: inverted."""
    length, polynomial = code
    bits <<= length
    for place in range(width - 1, -1, -1):
        if bits >> place + length & 1:
            bits ^= polynomial << place
    return bits ^ (1 << length) - 1


class Layout(NamedTuple):
    """Bits of a frame behind CDS: MT, ST, nERR, nWARN, LC, CRC6 inverted."""

    multiturn: int
    singleturn: int
    life: int

    @property
    def width(self) -> int:
        return self.multiturn + self.singleturn + 2 + self.life + CRC6[0]

    def frame(self, at: int, end: int, bits: int) -> Frame:
        """Taken apart."""
        word = bits >> CRC6[0]
        flags, position = word >> self.life, word >> self.life + 2
        return Frame(
            seconds_of(at), seconds_of(end), position, position >> self.singleturn, position & (1 << self.singleturn) - 1,
            not flags & 2, not flags & 1, remainder(word, self.width - CRC6[0], CRC6) == bits & 0x3F,
            word & (1 << self.life) - 1, bits, self.width,
        )  # fmt: skip


class Chain:
    """The master of a chain: `Chain([first, second])`, the first one is nearest to it, all on the same clock. What happens
    between them, with faults behind each one's driver, is the library's bus. Time goes on as long as it clocks, with 1 MHz."""

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
        self._at = 0  # the master's time
        self._answered = False

    @property
    def encoders(self) -> tuple[Encoder, ...]:
        """In the order of the line."""
        return self._encoders

    # ------------------------------------------------------------ edges

    def _begin(self) -> None:
        """It is the present for the bus. What was done to the encoders since is looked at."""
        lib, now = self._lib, self.clock._sync()
        for place, one in enumerate(self._encoders):
            one._run(now)
            panel = one._panel
            lib.dg_bus_control(self._bus, place, self._ffi.NULL if panel is None else lib.dg_host_panel_encoder(panel))
            lib.dg_bus_changed(self._bus, place, now)
        self._at = now

    def _end(self) -> None:
        """The clock follows."""
        self.clock._wait_until(self._at)

    def _edge(self, level: bool) -> None:
        self._at += HALF_NS
        self._lib.dg_bus_edge(self._bus, self._at, level)

    def _bit(self) -> bool:
        """A clock. @return data in the middle of its high half"""
        self._edge(False)
        self._edge(True)
        return bool(self._lib.dg_bus_edges_data(self._bus, self._at + HALF_NS))

    def _bits(self, count: int) -> int:
        value = 0
        for _ in range(count):
            value = value << 1 | self._bit()
        return value

    # ------------------------------------------------------------ frames

    def _layouts(self) -> list[Layout]:
        return [Layout(int(one.get("mt")), int(one.get("st")), 6 if one.get("lc") == "1" else 0) for one in self._encoders]

    def _open(self, widths: list[int]) -> tuple[int, bool, list[int]]:
        """From e1 to the last bit. @return the moment of e1, CDS, the bits of each"""
        self._bit()
        latched = self._at
        self._bit()
        self._answered = self._answered and int(self._lib.dg_bus_edges_fell(self._bus)) >= self._at
        for _ in range(START_CLOCKS):
            if self._bit():
                break
        return latched, self._bit(), [self._bits(width) for width in widths]

    def _close(self, cdm: bool) -> None:
        if cdm:
            self._edge(False)
        self._at += PAUSE_NS
        self._lib.dg_bus_step(self._bus, self._at)
        if cdm:
            self._edge(True)

    def frame(self) -> tuple[Frame, ...]:
        """A frame of all encoders, with the position of a microsecond from now."""
        with self.clock.lock:
            layouts = self._layouts()
            self._answered = True
            self._begin()
            at, _, bits = self._open([layout.width for layout in layouts])
            self._close(False)
            self._end()
        if not self._answered:
            raise EncoderError("nobody answers", SILENT)
        return tuple(layout.frame(at, self._at, own) for layout, own in zip(layouts, bits))

    # ------------------------------------------------------------ registers

    def _frame(self, cdm: bool) -> int:
        _, cds, _ = self._open(self._widths)
        self._close(cdm)
        return int(cds)

    def _send(self, bits: int, count: int) -> int:
        """@return what came back"""
        back = 0
        for place in range(count - 1, -1, -1):
            back = back << 1 | self._frame(bits >> place & 1 == 1)
        return back

    def _address(self, place: int, address: int, write: bool) -> int:
        """R and W, and how the encoder takes them. The last one of the line has ID 0."""
        bits = 1 << 10 | len(self._encoders) - 1 - place << 7 | address
        self._send(0, ZEROS)
        self._frame(True)
        locks = self._send(bits << 4 | remainder(bits, 11, CRC4), 15)
        self._frame(not write)
        answer = 2 * self._frame(write)
        answer += self._frame(True)
        if answer == (1 if write else 2):
            return 0
        return REFUSED if locks else SILENT

    def _await_start(self) -> bool:
        """The frame that S comes back in stays open."""
        begin = self._at
        while not self._open(self._widths)[1]:
            self._close(True)
            if self._at - begin > BUSY_NS:
                return False
        return True

    def _exchange(self, byte: int | None, last: bool) -> tuple[int, bool, bool]:
        """@return the byte that came back, whether its check sum is right, P"""
        word = 0 if byte is None else byte << 4 | remainder(byte, 8, CRC4)
        self._close(word >> 11 & 1 == 1)
        back = self._send(word << 1 & 0xFFF, 12)
        stop = self._open(self._widths)[1]
        self._close(not last and not stop)
        return back >> 4, back & 0xF == remainder(back >> 4, 8, CRC4), stop

    def _transfer(self, place: int, address: int, data: list[int | None], got: bytearray) -> int:
        """One control frame for as many as the encoder takes. @return how many, or an error"""
        result = self._address(place, address, data[0] is not None)
        early = self._encoders[place].get("stop_bit") == "early"
        done = 0
        for index, byte in enumerate(data if result == 0 else ()):
            if not self._await_start():
                return SILENT
            value, good, stop = self._exchange(byte, index + 1 == len(data))
            if not good:
                return DAMAGED
            if not stop or early:
                done += 1
                got.append(value)
            if stop:
                break
        return result or done or REFUSED

    def _registers(self, place: int, address: int, data: list[int | None]) -> bytes:
        place = whole(place, 0, len(self._encoders) - 1, "place")
        address = whole(address, 0, 127, "address")
        if not 1 <= len(data) <= 64:
            raise RangeError(f"{len(data)} registers: expected 1..64")
        got, result = bytearray(), 1
        with self.clock.lock:
            self._widths = [layout.width for layout in self._layouts()]
            self._answered = True
            self._begin()
            while result > 0 and len(got) < len(data):
                result = self._transfer(place, address + len(got), data[len(got) :], got)
                result = result if self._answered else SILENT
            self._end()
        if not got or not self._answered:
            checked(result, f"{len(data)} registers from {address:02X}h")
        return bytes(got)

    def register(self, place: int, address: int, count: int = 1) -> bytes:
        """Read registers of the encoder at a place, 0 is the first one; less than `count` where it refuses one."""
        return self._registers(place, address, [None] * whole(count, 1, 64, "count"))

    def write_register(self, place: int, address: int, data: bytes) -> int:
        """Write registers. How many it took."""
        return len(self._registers(place, address, list(octets(data, "registers"))))
