# SPDX-License-Identifier: MIT
"""RS485 of an encoder in this process: characters with their moments."""

from __future__ import annotations

import functools
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from ._native import EncoderError, checked
from .clock import SECOND_NS

if TYPE_CHECKING:
    from .encoder import Encoder

RUN = 16
WITHOUT_PARITY = 10


class Uart(NamedTuple):
    """The setting in force."""

    baud: int
    parity: str  # "N", "E" or "O"
    timeout_bits: int  # end of a frame


@functools.cache
def character_ns(baud: int, parity: str) -> int:
    """Time of a character on the line."""
    bits = WITHOUT_PARITY + (parity != "N")
    return -(-bits * SECOND_NS // baud)


class Rs485:
    """A master's side of the line."""

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._event = encoder._ffi.new("struct dg_host_event *")
        self._data = encoder._ffi.buffer(self._event.data)
        self._uart = encoder._ffi.new("struct dg_host_uart *")
        self._arrived: deque[tuple[int, int]] = deque()  # end of the character, what it is
        self._free_ns = 0  # the master's own characters are on the line until then

    @property
    def uart(self) -> Uart:
        """The encoder's."""
        encoder, to = self._encoder, self._uart
        checked(encoder._lib.dg_host_uart(encoder._host, to), "the line")
        return Uart(to.baud, chr(to.parity), to.timeout_bits)

    def _send(self, data: bytes, baud: int | None = None, parity: str | None = None) -> int:
        """From the present on, or behind what is being sent. With another setting than the
        encoder's every character arrives damaged. @return the end of it"""
        encoder, event = self._encoder, self._event
        uart = self.uart
        baud, parity = baud or uart.baud, parity or uart.parity
        right = baud == uart.baud and parity == uart.parity
        one = character_ns(baud, parity)
        at = max(encoder.clock._sync(), self._free_ns)
        for done in range(0, len(data), RUN):
            run = data[done : done + RUN]
            event.at, event.id, event.kind = at, one, encoder._lib.DG_HOST_BYTES
            event.flags = 0 if right else encoder._lib.DG_HOST_DAMAGED
            event.length = len(run)
            self._data[:] = run.ljust(RUN, b"\0")
            checked(encoder._lib.dg_host_send(encoder._host, event), "more than can be sent at once")
            at += one * len(run)
        encoder._deadline = min(encoder._deadline, encoder._lib.dg_host_next(encoder._host))
        self._free_ns = at
        return at

    def _fetch(self) -> None:
        """What the encoder has said so far."""
        encoder, event = self._encoder, self._event
        while encoder._lib.dg_host_receive(encoder._host, event) > 0:
            if event.kind == encoder._lib.DG_HOST_BYTES:
                for i, byte in enumerate(self._data[: event.length]):
                    self._arrived.append((event.at + (i + 1) * event.id, byte))

    def _until_said(self, until_ns: int) -> bool:
        """Time goes on deadline by deadline until the encoder says something. The lock is held."""
        clock = self._encoder.clock
        self._fetch()
        while not self._arrived and clock._sync() < until_ns:
            clock._wait_until(min(max(self._encoder._next(), clock._ns + 1), until_ns))
            self._fetch()
        return bool(self._arrived)

    def _heard(self, by_ns: int, most: int) -> bytes:
        """Take what has arrived by then."""
        taken = bytearray()
        while self._arrived and self._arrived[0][0] <= by_ns and len(taken) < most:
            taken.append(self._arrived.popleft()[1])
        return bytes(taken)

    def request(self, data: bytes, timeout: float = 0.1) -> bytes:
        """A frame there and what comes back, b"" after `timeout` of silence; time goes on to the
        end of it."""
        encoder = self._encoder
        if not data:
            raise EncoderError("a request has one character or more")
        with encoder.clock.lock:
            encoder.clock._sync()
            self._fetch()
            self._arrived.clear()
            end = self._send(data)
            encoder.clock._wait_until(end)
            if not self._until_said(end + round(timeout * SECOND_NS)):
                return b""
            last = max(at for at, _ in self._arrived)
            encoder.clock._wait_until(last)
            self._fetch()
            return self._heard(1 << 63, len(self._arrived))
