# SPDX-License-Identifier: MIT
"""RS485 in this process: characters with their moments."""

from __future__ import annotations

import functools
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from ._native import EncoderError, RangeError, checked, load, octets
from .clock import SECOND_NS, Clock

if TYPE_CHECKING:
    from .encoder import Encoder

RUN = 16
BLOCK = 16 * RUN  # less than a handle has room for
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


class Line:
    """An RS485 line and its master. Encoders with addresses of their own may share one:
    `Encoder(..., line=line, address=0x41)`."""

    def __init__(self, clock: Clock | None = None) -> None:
        self._ffi, self._lib = load()
        self.clock = clock or Clock()
        self._encoders: list[Encoder] = []
        self._event = self._ffi.new("struct dg_host_event *")
        self._data = self._ffi.buffer(self._event.data)
        self._uart = self._ffi.new("struct dg_host_uart *")
        self._arrived: deque[tuple[int, int]] = deque()  # end of the character, what it is
        self._free_ns = 0  # the master's own characters are on the line until then

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

    def _send(self, data: bytes, baud: int | None = None, parity: str | None = None) -> int:
        """From the present on, or behind what is being sent. Who has another setting gets every character
        damaged. Of much the last BLOCK is on its way yet, all before is over. @return the end of it"""
        at = max(self.clock._sync(), self._free_ns)
        if baud is None or parity is None:
            baud, parity, _ = self.uart
        one = character_ns(baud, parity)
        self._free_ns = at + one * len(data)
        for done in range(0, len(data), BLOCK):
            if done > 0:
                self.clock._wait_until(at + done * one)
                self._fetch()
            for encoder in self._encoders:
                if self._lib.dg_host_uart(encoder._host, self._uart) == 0:
                    right = self._uart.baud == baud and chr(self._uart.parity) == parity
                    flags = 0 if right else self._lib.DG_HOST_DAMAGED
                    self._send_to(encoder, data[done : done + BLOCK], at + done * one, one, flags)
        return self._free_ns

    def _send_to(self, encoder: Encoder, data: bytes, at: int, one: int, flags: int) -> None:
        event = self._event
        for done in range(0, len(data), RUN):
            run = data[done : done + RUN]
            event.at, event.id, event.flags = at + done * one, one, flags
            event.kind, event.length = self._lib.DG_HOST_BYTES, len(run)
            self._data[:] = run.ljust(RUN, b"\0")
            checked(self._lib.dg_host_send(encoder._host, event), "more than can be sent at once")
        encoder._deadline = min(encoder._deadline, self._lib.dg_host_next(encoder._host))

    def _fetch(self) -> None:
        """What the encoders have said so far; of several, in the order of time."""
        event, before = self._event, len(self._arrived)
        for encoder in self._encoders:
            while self._lib.dg_host_receive(encoder._host, event) > 0:
                if event.kind == self._lib.DG_HOST_BYTES:
                    for i, byte in enumerate(self._data[: event.length]):
                        self._arrived.append((event.at + (i + 1) * event.id, byte))
        if len(self._arrived) > before and len(self._encoders) > 1:
            self._arrived = deque(sorted(self._arrived, key=lambda row: row[0]))

    def _until_said(self, until_ns: int) -> bool:
        """Time goes on deadline by deadline until an encoder says something. The lock is held."""
        clock = self.clock
        self._fetch()
        while not self._arrived and clock._sync() < until_ns:
            due = min(encoder._deadline for encoder in self._encoders)
            clock._wait_until(min(max(due, clock._ns + 1), until_ns))
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
        data = octets(data, "a request")
        if not data:
            raise RangeError("a request has one character or more")
        with self.clock.lock:
            silence = self.clock._ahead(self.clock._sync(), timeout, "timeout") - self.clock._ns
            self._fetch()
            self._arrived.clear()
            end = self._send(data)
            self.clock._wait_until(end)
            if not self._until_said(end + silence):
                return b""
            self.clock._wait_until(max(at for at, _ in self._arrived))
            self._fetch()
            return self._heard(1 << 63, len(self._arrived))
