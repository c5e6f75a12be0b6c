# SPDX-License-Identifier: MIT
"""HIPERFACE: the UART of the device under test, bit by bit, and its driver enable."""

from __future__ import annotations

from typing import Any, NamedTuple

from cocotb.handle import LogicObject
from cocotb.task import Task
from cocotb.types import Logic

from .._native import checked
from ..encoder import SinCos
from ..rs485 import Uart
from ..shaft import Shaft
from .simulation import (
    LEAD_PS, PS_PER_NS, Delay, News, SimulatedEncoder, drive, level_of, now_ps, ps_of, sincos_of, start, until_ps,
)  # fmt: skip

SECOND_PS = 1_000_000_000_000
DATA_BITS = 8
WITHOUT_PARITY = DATA_BITS + 2  # with start and stop bit


class Request(NamedTuple):
    """Characters as the encoder heard them: those without a pause before its answer."""

    at_ps: int  # the edge of the first start bit
    end_ps: int  # the end of the last stop bit
    data: bytes
    damaged: int  # characters with a wrong parity or stop bit
    lead_ps: int  # from DE on to the first start bit; 0 without a DE
    hold_ps: int | None  # from the last stop bit to DE off; negative: it cut that; None: still on, or no DE


class Reply(NamedTuple):
    """What the encoder has sent."""

    at_ps: int  # the edge of the first start bit
    end_ps: int  # the end of the last stop bit
    data: bytes
    contended: bool  # the device under test drove the line meanwhile


class HiperfaceEncoder(SimulatedEncoder):
    """An encoder with RS485 and SinCos on the pins of a UART: `HiperfaceEncoder(dut.rx, dut.tx, dut.de)`, named as
    the device under test names them: its `rx` is driven, its `tx` is heard while `de` is 1, and the line rests
    at 1 otherwise. `de` None: it drives whenever it sends. With `echo` it hears itself. Data rate and parity are those that the
    encoder has at that moment; another one is a damaged character, as on a line. For the other arguments see SimulatedEncoder."""

    PROTOCOL = "hiperface"

    def __init__(
        self,
        rx: LogicObject,
        tx: LogicObject,
        de: LogicObject | None = None,
        model: str = "s3684-rs485",
        *,
        echo: bool = False,
        shaft: Shaft | str = "0",
        output_delay_ns: float = 10,
        line_delay_ns: float = 0,
        jitter_ns: float = 0,
        seed: int = 1,
        power: bool = True,
        memory: bytes | None = None,
        **settings: str | float,
    ) -> None:
        super().__init__(
            model, shaft=shaft, line_delay_ns=line_delay_ns, jitter_ns=jitter_ns, seed=seed, power=power,
            memory=memory, settings=settings,
        )  # fmt: skip
        self._rx, self._tx, self._de, self._echo = rx, tx, de, echo
        self._uart: Any = self._ffi.new("struct dg_host_uart *")
        self._requests: News[Request] = News()
        self._replies: News[Reply] = News()
        self._own = True  # the encoder's level, where it gets to the device under test
        self._line = True  # that of the device under test, where it gets to the encoder
        self._character: Task[None] | None = None
        self._heard: tuple[int, int, int] | None = None  # byte, flags, end: complete, not yet told
        self._frame: list[tuple[int, int, int, int]] = []  # byte, flags, start, end
        self._answer = bytearray()
        self._answer_at = self._answer_end = 0
        self._contended = False
        self._driven_at = self._released_at = 0
        self._drives = self._enabled()
        self._out = Delay(self._arrived, max(1, ps_of(output_delay_ns) + self._line_ps), self._noise)
        self._in = Delay(self._level, self._line_ps)
        self._sent = True
        self._changed()
        self._watch(tx, self._changed)
        if de is not None:
            self._watch(de, self._switched)

    # ------------------------------------------------------------ the line

    def _enabled(self) -> bool:
        return self._de is None or level_of(self._de, False)

    def _switched(self) -> None:
        """DE has another level."""
        drives = self._enabled()
        if drives != self._drives:
            self._drives = drives
            if drives:
                self._driven_at = now_ps()
            else:
                self._released_at = now_ps()
        self._changed()

    def _changed(self) -> None:
        """The device under test may put another level on the line."""
        level = level_of(self._tx, self._sent) if self._drives else True
        if level != self._sent:
            self._sent = level
            self._in.put(level)
        self._show()

    def _arrived(self, level: bool) -> None:
        self._own = level
        self._show()

    def _show(self) -> None:
        """What its receiver sees. While both drive, nobody knows."""
        if self._de is None or not self._drives:
            drive(self._rx, self._own and self._sent)
            return
        sending = self._answer_at <= now_ps() < self._answer_end
        self._contended = self._contended or sending
        if self._echo and sending and self._own != self._sent:
            drive(self._rx, Logic("X"))
        else:
            drive(self._rx, self._sent if self._echo else True)

    # ------------------------------------------------------------ hearing

    @property
    def uart(self) -> Uart:
        """The setting in force."""
        checked(self._lib.dg_host_uart(self._host, self._uart), f"{self.model}: its UART")
        return Uart(self._uart.baud, chr(self._uart.parity), self._uart.timeout_bits)

    def _level(self, level: bool) -> None:
        self._line = level
        if level or self._character is not None:
            return
        self._deliver()
        if self.powered:
            self._character = start(self._receive(now_ps(), self.uart))

    async def _receive(self, begin: int, uart: Uart) -> None:
        """A character, each bit in its middle."""
        self._tell(self._lib.DG_HOST_START, begin, b"")
        bit = SECOND_PS / uart.baud
        levels = []
        for place in range(WITHOUT_PARITY + (uart.parity != "N")):
            await until_ps(begin + round((place + 0.5) * bit))
            levels.append(self._line)
            if levels[0]:  # no start bit, but a spike
                self._character = None
                return
        byte = sum(level << place for place, level in enumerate(levels[1 : 1 + DATA_BITS]))
        odd = sum(levels[1:-1]) % 2
        right = levels[-1] and (uart.parity == "N" or odd == (uart.parity == "O"))
        end = begin + round(len(levels) * bit)
        flags = self._lib.DG_HOST_ENDED | (0 if right else self._lib.DG_HOST_DAMAGED)
        self._heard = byte, flags, end
        if self._frame and begin - self._frame[-1][3] > uart.timeout_bits * bit:
            self._frame = []
        self._frame.append((byte, flags, begin, end))
        self._character = None
        await until_ps(end)
        if self._heard is not None and self._heard[2] == end:
            self._deliver()

    def _deliver(self) -> None:
        """A character is over: at its end, or when a faster master begins another one."""
        if self._heard is not None:
            (byte, flags, _), self._heard = self._heard, None
            self._tell(flags, now_ps(), bytes([byte]))

    def _tell(self, flags: int, at_ps: int, data: bytes) -> None:
        with self._clock.lock:
            self._serve()
            event = self._ffi.new("struct dg_host_event *")
            event.at, event.flags = (LEAD_PS + at_ps) // PS_PER_NS, flags
            event.kind, event.length = self._lib.DG_HOST_BYTES, len(data)
            event.data[0 : len(data)] = data
            checked(self._lib.dg_host_send(self._host, event), f"{self.model}: characters")
            self._encoder._run(self._clock._ns)

    # ------------------------------------------------------------ answering

    def _said(self, event: Any) -> None:
        """A run of characters; a longer answer is several of them, one behind the other."""
        at = max(now_ps(), event.at * PS_PER_NS - LEAD_PS)
        uart, data = self.uart, bytes(event.data[0 : event.length])
        if not self._answer:
            self._answer_at, self._contended = at, False
            self._answer_end = at
            self._requested()
            start(self._conclude())
        one = (WITHOUT_PARITY + (uart.parity != "N")) * SECOND_PS / uart.baud
        begin = self._answer_at + round(len(self._answer) * one)
        self._answer += data
        self._answer_end = begin + round(len(data) * one)
        start(self._send(begin, data, uart))

    async def _send(self, begin: int, data: bytes, uart: Uart) -> None:
        bit, place = SECOND_PS / uart.baud, 0
        for byte in data:
            bits = [byte >> i & 1 == 1 for i in range(DATA_BITS)]
            parity = [] if uart.parity == "N" else [sum(bits) % 2 == (uart.parity == "E")]
            for level in [False, *bits, *parity, True]:
                await until_ps(begin + round(place * bit))
                self._out.put(level or not self.powered)
                place += 1

    async def _conclude(self) -> None:
        """The last stop bit is over."""
        while now_ps() < self._answer_end:
            await until_ps(self._answer_end)
        data, self._answer = bytes(self._answer), bytearray()
        self._replies.tell(Reply(self._answer_at, self._answer_end, data, self._contended))

    def _requested(self) -> None:
        """What it answers."""
        frame, self._frame = self._frame, []
        if frame:
            begin, end = frame[0][2], frame[-1][3]
            damaged = sum(flags & self._lib.DG_HOST_DAMAGED != 0 for _, flags, _, _ in frame)
            driven = self._de is not None and self._driven_at <= begin
            lead = begin - self._driven_at - self._line_ps if driven else 0
            released = self._de is not None and not self._drives
            hold = self._released_at + self._line_ps - end if released else None
            data = bytes(byte for byte, _, _, _ in frame)
            self._requests.tell(Request(begin, end, data, damaged, lead, hold))

    # ------------------------------------------------------------ looks

    @property
    def request(self) -> Request | None:
        """What it answered last; None: nothing yet."""
        return self._requests.latest

    @property
    def reply(self) -> Reply | None:
        """The latest answer that is over; None: there was none yet."""
        return self._replies.latest

    async def requested(self) -> Request:
        """Wait until it begins to answer, and say what it heard."""
        return await self._requests.next()

    async def replied(self) -> Reply:
        """Wait until an answer is over."""
        return await self._replies.next()

    def sincos(self, at_ps: int | None = None) -> SinCos:
        """The process channel in volts at a moment; None: now."""
        return sincos_of(self, at_ps)
