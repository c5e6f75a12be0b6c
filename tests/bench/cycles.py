#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints how many cycles things take on a Cortex-M0+: `FIGURE CYCLES` a line. An emulator (Unicorn) runs the
program; what an instruction takes is the table of Arm's manual, with memory that does not wait and the
multiplier of one cycle (Cortex-M0+ Technical Reference Manual, 3.3).

usage: cycles.py PROGRAM...    bench_* for a Cortex-M0+, each a whole image with its C library
"""

import struct
import subprocess
import sys

from unicorn import UC_ARCH_ARM, UC_HOOK_CODE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_SP, UC_CPU_ARM_CORTEX_M0

FLASH, RAM, SIZE = 0, 0x20000000, 0x800000
END = 0x10000000  # where main() returns to
LOAD = 1  # of a segment
COUNTED = "bench_counted"


def registers(mask):
    return bin(mask).count("1")


def cycles_of(code, taken):
    """What a 16-bit instruction takes."""
    top = code >> 12
    if code & 0xFF00 in (0x4400, 0x4600):  # ADD, MOV with high registers: a branch when the target is PC
        return 2 if taken else 1
    if code & 0xFF00 == 0x4700:  # BX, BLX
        return 2
    if code & 0xF800 == 0x4800 or top in (5, 6, 7, 8, 9):  # LDR, STR of all sizes
        return 2
    if code & 0xFE00 == 0xB400:  # PUSH, with LR
        return 1 + registers(code & 0x1FF)
    if code & 0xFE00 == 0xBC00:  # POP, with PC
        return registers(code & 0xFF) + (4 if code & 0x100 else 1)
    if top == 0xC:  # LDM, STM
        return 1 + registers(code & 0xFF)
    if top == 0xD and code >> 8 & 0xF < 0xE:  # B with a condition
        return 2 if taken else 1
    return 2 if code >> 11 == 0x1C else 1  # B; all others


def load(machine, path):
    """Put the segments of an ELF file where they belong."""
    with open(path, "rb") as file:
        elf = file.read()
    start, size, count = *struct.unpack_from("<I", elf, 28), *struct.unpack_from("<HH", elf, 42)
    for at in range(start, start + size * count, size):
        kind, offset, address, _physical, length = struct.unpack_from("<5I", elf, at)
        if kind == LOAD:
            machine.mem_write(address, elf[offset:offset + length])


def symbols(path):
    """Addresses of functions."""
    lines = subprocess.check_output(["arm-none-eabi-nm", "--format=posix", path], text=True).splitlines()
    return {line.split()[0]: int(line.split()[2], 16) & ~1 for line in lines if line.split()[1] in "tT"}


class Counter:
    """Adds up what is done in bench_counted()."""

    def __init__(self, machine, begin):
        self.machine = machine
        self.begin = begin
        self.total = None  # None: outside
        self.leave = 0
        self.before = None  # where the instruction before this one is, and its size
        self.figures = []
        self.codes = {}
        machine.hook_add(UC_HOOK_CODE, self.step)

    def step(self, machine, address, size, _user):
        """An instruction is about to be done."""
        if self.total is None:
            if address == self.begin:
                self.total, self.before = 0, None
                self.leave = machine.reg_read(UC_ARM_REG_LR) & ~1
            else:
                return
        if self.before is not None:
            self.total += self.cost(*self.before, address)
        self.before = address, size
        if address == self.begin:
            self.figures.append(self.figure())
        elif address == self.leave:
            name, parts = self.figures[-1]
            self.figures[-1] = name, self.total if parts == 1 else round(self.total / parts, 1)
            self.total = None

    def cost(self, address, size, following):
        if size == 4:  # BL takes 3, as do MSR, MRS and barriers
            return 3
        if address not in self.codes:
            self.codes[address] = struct.unpack("<H", self.machine.mem_read(address, 2))[0]
        return cycles_of(self.codes[address], following != address + size)

    def figure(self):
        """What struct bench says: its name, and of how many parts it is."""
        bench = self.machine.mem_read(self.machine.reg_read(UC_ARM_REG_R0), 20)
        name, _run, _what, _answers, parts = struct.unpack("<5I", bench)
        return self.machine.mem_read(name, 64).split(b"\0")[0].decode(), max(parts, 1)


def count(path):
    machine = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
    machine.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M0)
    machine.mem_map(FLASH, SIZE)
    machine.mem_map(RAM, SIZE)
    machine.mem_map(END & ~0xFFF, 0x1000)
    load(machine, path)
    at = symbols(path)
    counter = Counter(machine, at[COUNTED])
    machine.reg_write(UC_ARM_REG_SP, RAM + SIZE)
    machine.reg_write(UC_ARM_REG_LR, END | 1)
    machine.reg_write(UC_ARM_REG_R0, 0)
    machine.reg_write(UC_ARM_REG_R1, 0)
    machine.emu_start(at["main"] | 1, END)
    if machine.reg_read(UC_ARM_REG_R0) != 0 or not counter.figures:
        sys.exit(f"cycles.py: {path}: not all was answered")
    return counter.figures


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    for path in sys.argv[1:]:
        try:
            for name, cycles in count(path):
                print(name, cycles)
        except UcError as error:
            sys.exit(f"cycles.py: {path}: {error}")


main()
