# SPDX-License-Identifier: MIT
"""Whoever looks at a BiSS line sees frames, and through them register accesses. Nothing of a simulator in here."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

ZEROS = 14  # before a control frame
CTS_BITS, CRC4_BITS, DATA_BITS = 11, 4, 8
CRC6, CRC4 = (6, 0x43), (4, 0x13)


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


class Frame(NamedTuple):
    """A frame as the encoder sent it and the master ended it."""

    at_ps: int  # the position is of this moment
    position: int  # multiturn and singleturn, right-aligned, binary
    error: bool  # nERR is low
    warning: bool  # nWARN is low
    life: int  # 0 without a life counter
    good: bool  # the check sum is right, and no bit is missing
    cds: bool
    cdm: bool  # as the slave takes it: MA inverted while the timeout runs


class Access(NamedTuple):
    """A register that the master has accessed, or tried to."""

    at_ps: int  # of the frame that ended it
    slave: int  # its ID in the control frame
    address: int
    write: bool
    value: int | None  # as read or written; None: the access was refused before
    refused: bool
    good: bool  # the check sum behind the value is right


def number(bits: list[bool]) -> int:
    value = 0
    for bit in bits:
        value = value << 1 | bit
    return value


class BissLine:
    """Tell it of each edge of MA, with SLO behind it, and of the end of the timeout."""

    def __init__(self, layout: Layout, framed: Callable[[Frame], None], accessed: Callable[[Access], None]) -> None:
        self._layout = layout
        self._framed = framed
        self._control = Control(accessed)
        self.open = False  # a timeout runs
        self._e1_ps: int | None = None
        self._ma = True
        self._levels: list[bool] = []

    def edge(self, at_ps: int, ma: bool, slo: bool) -> None:
        """MA has another level."""
        idle = not self.open
        returns, self._ma = idle and ma, ma
        if returns:  # behind a CDM of 1
            return
        self.open = True
        if ma:
            self._e1_ps = at_ps if self._e1_ps is None else self._e1_ps
            self._levels.append(slo)

    def end(self) -> None:
        """The timeout is over."""
        at_ps, levels = self._e1_ps, self._levels
        self.open, self._e1_ps, self._levels = False, None, []
        if at_ps is None or len(levels) < 2:  # no frame yet: that needs Ack
            return
        cds, data = self._data(levels)
        frame = self._taken_apart(at_ps, data, cds)
        self._control.frame(frame)
        self._framed(frame)

    @staticmethod
    def _data(levels: list[bool]) -> tuple[bool, list[bool]]:
        """CDS, and what is behind it; 0 and nothing in a frame that has no start bit."""
        behind = [place for place in range(2, len(levels)) if levels[place]]
        if not behind:
            return False, []
        rest = levels[behind[0] + 1 :]
        return bool(rest and rest[0]), rest[1:]

    def _taken_apart(self, at_ps: int, data: list[bool], cds: bool) -> Frame:
        width, (mt, st, life) = self._layout.width, self._layout
        sent = data[:width]
        bits = number(sent) << width - len(sent)
        word = bits >> CRC6[0]
        good = len(sent) == width and remainder(word, width - CRC6[0], CRC6) == bits & 0x3F
        flags = word >> life
        return Frame(
            at_ps, flags >> 2 & (1 << mt + st) - 1, not flags & 2, not flags & 1, word & (1 << life) - 1,
            good, cds, not self._ma,
        )  # fmt: skip


class Control:
    """Control frames: CDM of a frame, and CDS of the next one, which answers it."""

    def __init__(self, accessed: Callable[[Access], None]) -> None:
        self._accessed = accessed
        self._asked: bool | None = None
        self._zeros = 0
        self._take: Callable[[bool, bool], None] | None = None
        self._bits: list[bool] = []
        self._at_ps = 0
        self._slave = self._address = 0
        self._request: list[bool] = []
        self._write = False

    def frame(self, frame: Frame) -> None:
        """Another one."""
        if self._asked is not None:
            self._at_ps = frame.at_ps
            self._pair(self._asked, frame.cds)
        self._asked = frame.cdm

    def _pair(self, cdm: bool, cds: bool) -> None:
        ready, self._zeros = self._zeros >= ZEROS, 0 if cdm else self._zeros + 1
        if ready and not cdm:
            self._become(None)
        elif ready:
            self._become(self._on_address)
        elif self._take is not None:
            self._take(cdm, cds)

    def _become(self, take: Callable[[bool, bool], None] | None) -> None:
        self._take, self._bits = take, []

    def _on_address(self, cdm: bool, _: bool) -> None:
        self._bits.append(cdm)
        if len(self._bits) < CTS_BITS + CRC4_BITS:
            return
        word = number(self._bits)
        cts, self._slave, self._address = word >> 14 & 1, word >> 11 & 7, word >> 4 & 0x7F
        good = remainder(word >> CRC4_BITS, CTS_BITS, CRC4) == word & 0x0F
        self._become(self._on_way if cts and good else None)

    def _on_way(self, cdm: bool, cds: bool) -> None:
        """R, then W; refused: R comes back for W."""
        self._bits.append(cdm)
        self._bits.append(cds)
        if len(self._bits) < 4:
            return
        r, r_back, w, w_back = self._bits
        self._write = w
        accepted = r != w and (r, w) == (r_back, w_back)
        self._become(self._on_start if accepted else None)
        if not accepted:
            self._tell(None, True, True)

    def _on_start(self, cdm: bool, cds: bool) -> None:
        """S, until it comes back."""
        if not cdm:
            self._become(None)
        elif cds:
            self._become(self._on_data)

    def _on_data(self, cdm: bool, cds: bool) -> None:
        """Data, its check sum, P."""
        self._bits.append(cds)
        if len(self._bits) <= DATA_BITS + CRC4_BITS:
            return
        word = number(self._bits[:-1])
        value = word >> CRC4_BITS
        self._tell(value, cds, remainder(value, DATA_BITS, CRC4) == word & 0x0F)
        self._address = self._address + 1 & 0x7F
        self._become(None if cds else self._on_start)

    def _tell(self, value: int | None, refused: bool, good: bool) -> None:
        self._accessed(
            Access(self._at_ps, self._slave, self._address, self._write, value, refused, good)
        )
