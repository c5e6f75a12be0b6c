# SPDX-License-Identifier: MIT
"""RS485 in this process: characters with their moments."""

from __future__ import annotations

import functools
import struct
from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ._native import EncoderError, RangeError, load, octets
from .clock import SECOND_NS, Clock
from .wire import Wire, row_of

if TYPE_CHECKING:
    from .encoder import Encoder

BLOCK = 256  # less than the bus has room for on their way


class Uart(NamedTuple):
    """The setting in force."""

    baud: int
    parity: str  # "N", "E" or "O"
    timeout_bits: int  # end of a frame


@functools.cache
def character_ns(baud: int, parity: str) -> int:
    """Time of a character on the line."""
    ffi, lib = load()
    uart = ffi.new("struct dg_host_uart *", {"baud": baud, "parity": ord(parity)})
    return int(lib.dg_host_uart_ns(uart, 1))


class Line(Wire):
    """An RS485 line and its master. Several encoders may share one: `Encoder(..., line=line, address=0x41)`. They hear the
    master and each other, but for those that send; two at once make the AND of their characters."""

    MEDIUM = "characters"
    MOST = 32

    def __init__(self, clock: Clock | None = None) -> None:
        super().__init__(clock)
        self._uart = self._ffi.new("struct dg_host_uart *")
        self._event.kind = self._lib.DG_TAP_CHARACTER
        self._character = self._event.character
        self._arrived: deque[tuple[int, int]] = deque()  # end of the character, what it is
        self._latest: tuple[Any, ...] = (0, 1, b"N")  # its end, and the setting of who has said it
        self._free_ns = 0  # the master's own characters are on the line until then

    def _setup(self) -> Any:
        return self._ffi.new("struct dg_characters_setup *", {"size": self._ffi.sizeof("struct dg_characters_setup"), "paced": True})

    def _told_as(self) -> struct.Struct:
        return row_of(character__baud="I", character__parity="c", character__byte="B")

    def _hear(self, rows: Sequence[tuple[Any, ...]]) -> None:
        self._arrived.extend((at, byte) for at, _, _, byte, _ in rows)
        self._latest = rows[-1]

    @property
    def encoders(self) -> tuple[Encoder, ...]:
        """Those on it."""
        return tuple(self._encoders)

    @property
    def uart(self) -> Uart:
        """Of the first encoder that is on."""
        to = self._uart
        for encoder in self._encoders:
            if self._lib.dg_host_uart(encoder._host, to) == 0:
                return Uart(to.baud, chr(to.parity), to.timeout_bits)
        raise EncoderError("nobody on the line has power", self._lib.DG_HOST_ERR_STATE)

    def _send(self, data: bytes, baud: int | None = None, parity: str | None = None, damaged: bool = False) -> int:
        """From the present on, or behind what is being sent. Who has another setting gets every character
        damaged. Of much the last BLOCK is on its way yet, all before is over. @return the end of it"""
        at = max(self.clock._sync(), self._free_ns)
        if baud is None or parity is None:
            baud, parity, _ = self.uart
        one = character_ns(baud, parity)
        self._free_ns = at + one * len(data)
        self._character.baud, self._character.parity, self._character.damaged = baud, parity.encode(), damaged
        for done in range(0, len(data), BLOCK):
            if done > 0:
                self.clock._wait_until(at + done * one)
            self._send_now(data[done : done + BLOCK])
        return self._free_ns

    def _send_now(self, data: bytes) -> None:
        """To the bus, which paces it."""
        if self._bus is None:
            return
        rx, bus, event, character = self._lib.dg_bus_rx, self._bus, self._event, self._character
        event.at = self.clock._ns
        for byte in data:
            character.byte = byte
            rx(bus, event)
        self._read()

    def _until_said(self, until_ns: int) -> bool:
        """Time goes on until an encoder says something. The lock is held."""
        clock = self.clock
        while not self._arrived and clock._sync() < until_ns:
            if clock._has_only(self) and not self._panels and self._bus is not None:
                at = self._leap(until_ns, 0)
                clock._ns = at if self._arrived else until_ns
            else:
                clock._wait_until(min(max(self._next(), clock._ns + 1), until_ns))
        return bool(self._arrived)

    def _until_idle(self) -> None:
        """Time goes on to the end of what encoders are saying: a character follows the one before at once. The lock is
        held."""
        clock = self.clock
        one = character_ns(self._latest[1], self._latest[2].decode())
        while (due := self._next()) <= self._latest[0] + one:
            if clock._has_only(self) and not self._panels:
                clock._ns = self._leap(due, one)
            else:
                clock._wait_until(max(due, clock._ns + 1))

    def _leap(self, until_ns: int, gap_ns: int) -> int:
        """All at once, where nothing else goes by the clock: to what is said first, and to the end of what follows each within a
        gap. @return when it was the last time that anything happened"""
        at = int(self._lib.dg_bus_step_burst(self._bus, self._queue, until_ns, gap_ns))
        self._read()
        return max(at, self.clock._ns)

    def _until_free(self) -> None:
        """Encoders that have heard another one answer take what comes at once for more of that: as other masters, leave them the
        pause that ends a frame. The lock is held."""
        if len(self._encoders) > 1:
            over = [self._pause_of(one) for one in self._encoders]
            self.clock._wait_until(self._latest[0] + max(over) + 1)

    def _pause_of(self, encoder: Encoder) -> int:
        """How long nothing has to be on the line for its frame to end; 0: it is off."""
        to = self._uart
        on = self._lib.dg_host_uart(encoder._host, to) == 0
        return -(-to.timeout_bits * SECOND_NS // to.baud) if on else 0

    def _heard(self, most: int) -> bytes:
        """Take what has arrived."""
        arrived = self._arrived
        return bytes([arrived.popleft()[1] for _ in range(min(most, len(arrived)))])

    def request(self, data: bytes, timeout: float = 0.1) -> bytes:
        """A frame there and what comes back, b"" after `timeout` of silence; time goes on to the
        end of it. On a line with several it begins with the pause that ends a frame."""
        data = octets(data, "a request")
        if not data:
            raise RangeError("a request has one character or more")
        with self.clock.lock:
            self._until_free()
            silence = self.clock._ahead(self.clock._sync(), timeout, "timeout") - self.clock._ns
            self._arrived.clear()
            end = self._send(data)
            self.clock._wait_until(end)
            if not self._until_said(end + silence):
                return b""
            self._until_idle()
            return self._heard(len(self._arrived))
