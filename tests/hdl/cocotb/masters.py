# SPDX-License-Identifier: MIT
"""Masters at the pins, for what HDL ones would need a long simulation for: exact delays, broken characters."""

import cocotb
from cocotb.triggers import Timer
from cocotb.utils import get_sim_time

ZEROS = 14
S_MOST = 400  # frames that a register may be busy


def now_ps():
    return int(get_sim_time("ps"))


async def until_ps(at_ps):
    if at_ps > now_ps():
        await Timer(at_ps - now_ps(), "ps")


def number(bits):
    return int("0" + "".join(str(bit) for bit in bits), 2)


def crc(value, width, polynomial, length):
    """Bit by bit, as a master's shift register does; inverted."""
    register = 0
    for place in reversed(range(width)):
        feedback = register >> length - 1 & 1 ^ value >> place & 1
        register = register << 1 & (1 << length) - 1 ^ (polynomial if feedback else 0)
    return register ^ (1 << length) - 1


class BissMaster:
    """Compensates the line: SLO is looked at `late_ps` behind each rising edge of MA. A frame has `start` clocks up
    to CDS at most, and `data` behind it; register accesses do without those."""

    def __init__(self, dut, hertz, late_ps, start, data):
        self.dut, self.late_ps, self.start, self.data = dut, late_ps, start, data
        self.half_ps = 500_000_000_000 // hertz
        dut.ma.value = 1

    async def _sample(self, begin, clocks, to):
        for clock in range(clocks):
            await until_ps(begin + (2 * clock + 1) * self.half_ps + self.late_ps)
            to.append(int(self.dut.slo.value))

    async def _clock(self, clocks):
        """@return CDS, and everything behind it"""
        samples, begin = [], now_ps()
        sampler = cocotb.start_soon(self._sample(begin, clocks, samples))
        for clock in range(clocks):
            self.dut.ma.value = 0
            await until_ps(begin + (2 * clock + 1) * self.half_ps)
            self.dut.ma.value = 1
            await until_ps(begin + (2 * clock + 2) * self.half_ps)
        await sampler
        start = samples.index(1, samples.index(0))
        return samples[start + 1], samples[start + 2 :]

    async def _end(self, cdm):
        self.dut.ma.value = 1 - cdm
        await Timer(14, "us")
        self.dut.ma.value = 1
        await Timer(1, "us")

    async def frame(self, cdm=0):
        """@return CDS, and everything behind it"""
        got = await self._clock(self.start + self.data)
        await self._end(cdm)
        return got

    async def _bit(self, cdm):
        cds, _ = await self._clock(self.start)
        await self._end(cdm)
        return cds

    async def _bits(self, value, width):
        """@return CDS of each of these frames"""
        return [await self._bit(value >> place & 1) for place in reversed(range(width))]

    async def _start(self, first):
        """S comes back in the frame that has the first bit of data: its CDM depends on its CDS."""
        cds = 0
        for _ in range(S_MOST):
            cds, _ = await self._clock(self.start)
            await self._end(first if cds else 1)
            if cds:
                break
        assert cds, "no start bit"

    async def register(self, address, data=None, slave=0):
        """Read one, or write it. @return what came back, None when it was refused"""
        write = data is not None
        await self._bits(0, ZEROS)
        word = 1 << 10 | slave << 7 | address
        await self._bits(1 << 15 | word << 4 | crc(word, 11, 0x3, 4), 16)
        await self._bit(not write)
        r, w = await self._bit(write), await self._bit(1)
        if (r, w) != (not write, write):
            await self._bit(0)
            return None
        sent = data << 4 | crc(data, 8, 0x3, 4) if write else 0
        await self._start(sent >> 11 & 1)
        back = number(await self._bits(sent << 1 & 0xFFF, 12))
        stop = await self._bit(0)
        assert back & 15 == crc(back >> 4, 8, 0x3, 4)
        return None if stop else back >> 4


class SsiMaster:
    """Looks just before the next falling edge."""

    def __init__(self, dut, hertz):
        self.dut = dut
        self.half_ps = 500_000_000_000 // hertz
        dut.ma.value = 1

    async def word(self, width, pause_us=40):
        bits, at = [], now_ps()
        for _ in range(width + 1):
            self.dut.ma.value = 0
            at += self.half_ps
            await until_ps(at)
            self.dut.ma.value = 1
            at += self.half_ps
            await until_ps(at - 1000)
            bits.append(int(self.dut.slo.value))
            await until_ps(at)
        assert bits.pop() == 0  # the monoflop time
        await Timer(pause_us, "us")
        assert self.dut.slo.value == 1
        return number(bits)


class Uart:
    """With driver enable; what comes back is looked at in the middle of its bits."""

    def __init__(self, dut, baud=9600, parity="E"):
        self.dut, self.parity = dut, parity
        self.bit_ps = 1_000_000_000_000 // baud
        self.heard = []
        dut.tx.value = 1
        dut.de.value = 0

    async def send(self, data, lead=1.0, hold=0.0, broken=None):
        """`lead` and `hold`: of DE, in bits; `broken`: of this character the parity is wrong."""
        self.dut.de.value = 1
        at = now_ps() + round(lead * self.bit_ps)
        await until_ps(at)
        end = at + len(data) * self._bits() * self.bit_ps + round(hold * self.bit_ps)
        release = cocotb.start_soon(self._release(end))
        for index, byte in enumerate(data):
            bits = [0, *(byte >> place & 1 for place in range(8))]
            if self.parity != "N":
                odd = bin(byte).count("1") & 1
                bits.append(odd ^ (self.parity == "O") ^ (index == broken))
            for level in (*bits, 1):
                self.dut.tx.value = level
                at += self.bit_ps
                await until_ps(at)
        await release

    async def _release(self, at):
        await until_ps(at)
        self.dut.de.value = 0

    def _bits(self):
        return 10 + (self.parity != "N")

    async def receive(self, most_us):
        """What comes, up to as long a silence."""
        data, until = bytearray(), now_ps() + most_us * 1_000_000
        while now_ps() < until:
            if self.dut.rx.value != 0:
                await Timer(self.bit_ps // 16, "ps")
                continue
            levels = []
            for place in range(self._bits()):
                await Timer(self.bit_ps // 2 if place == 0 else self.bit_ps, "ps")
                levels.append(str(self.dut.rx.value))
            assert levels[0] == "0" and levels[-1] == "1", levels
            byte = number(levels[8:0:-1])
            if self.parity != "N":
                assert int(levels[9]) == (bin(byte).count("1") & 1) ^ (self.parity == "O")
            data.append(byte)
            until = now_ps() + most_us * 1_000_000
        return bytes(data)
