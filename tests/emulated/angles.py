#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Asks an emulated Cortex-M0+ where shafts are, and compares each angle with unbounded integers: what is
compiled for processors that multiply 32 bits to 32 is seen to work nowhere else.

usage: angles.py PROGRAM
"""

import random
import struct
import subprocess
import sys

from unicorn import UC_ARCH_ARM, UC_MODE_MCLASS, UC_MODE_THUMB, Uc
from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_R0, UC_ARM_REG_SP, UC_CPU_ARM_CORTEX_M0

FLASH, RAM, SIZE = 0, 0x20000000, 0x800000
END = 0x10000000  # where main() returns to
LOAD = 1  # of a segment
QUESTION = struct.Struct("<QQQqqqiI")
SPEED, RAMP, SINE, STEERED = 1, 2, 3, 5
TRAVEL = 3662109375 * 4  # 0.001 rpm for 2^-20 ns is so many parts of 2^-32 turn
NEVER = 2**64 - 1


def turned(mrpm, time_q20):
    return mrpm * time_q20 // TRAVEL


def ramp(time, hold, now, mrpm):
    """floor of the time at full speed, then of the angle"""
    if now < time:
        return turned(mrpm, (now * now << 19) // time)
    if now <= time + hold:
        return turned(mrpm, (now - time << 20) + (time << 19))
    left = max(2 * time + hold - now, 0)
    return turned(mrpm, (hold + time << 20) - (left * left << 19) // time)


def sine_q30(phase):
    """dg_sin_q30(), with as many bits as it takes"""
    quadrant, u = divmod(phase, 1 << 30)
    u = (1 << 30) - u if quadrant & 1 else u
    z = u * u >> 28
    result = 14670
    for c in 688099, 20107380, 342277046, 2774394651, 6746518852:
        result = c - (result * z + (1 << 31) >> 32)
    result = result * u + (1 << 31) >> 32
    return -result if quadrant & 2 else result


def sine(time, amplitude, now):
    half_units = (now % time << 33) // time
    value = sine_q30((half_units + 1 >> 1) % 2**32)
    moved = abs(amplitude) * abs(value) >> 30
    return -moved if (value < 0) != (amplitude < 0) else moved


def expected(question):
    time, hold, now, start, amplitude, _, mrpm, kind = question
    if kind == RAMP:
        moved = ramp(time, hold, now, mrpm)
    elif kind == SINE:
        moved = sine(time, amplitude, now)
    else:
        moved = turned(mrpm, now << 20)
    return (start + moved) % 2**64


def length(bits):
    """1 .. 2^bits - 1, small ones as often as large ones"""
    return random.getrandbits(random.randint(1, bits)) or 1


def question(number):
    kind = (SPEED, RAMP, SINE, STEERED)[number % 4]
    time, hold = min(length(42), 3600 * 10**9), random.choice([0, length(42), length(63)])
    mrpm = min(length(30), 10**9) * random.choice([1, -1])
    now = random.choice([length(64), length(64), NEVER, 2**60, time, 2 * time + hold])
    if kind == RAMP and random.random() < 0.8:
        now = max(random.choice([0, time + hold]) + random.randrange(time + 1) - 1, 0)
    start = random.getrandbits(64) - 2**63
    return time, hold, now, start, (length(40)) * random.choice([1, -1]), 0, mrpm, kind


def machine_of(path):
    machine = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
    machine.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M0)
    for at, size in (FLASH, SIZE), (RAM, SIZE), (END & ~0xFFF, 0x1000):
        machine.mem_map(at, size)
    with open(path, "rb") as file:
        elf = file.read()
    start, size, count = *struct.unpack_from("<I", elf, 28), *struct.unpack_from("<HH", elf, 42)
    for at in range(start, start + size * count, size):
        kind, offset, address, _physical, filled = struct.unpack_from("<5I", elf, at)
        if kind == LOAD:
            machine.mem_write(address, elf[offset:offset + filled])
    return machine


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    random.seed(1)
    path = sys.argv[1]
    lines = [line.split() for line in subprocess.check_output(
        ["arm-none-eabi-nm", "--format=posix", path], text=True).splitlines()]
    at = {line[0]: [int(number, 16) for number in line[2:]] for line in lines}
    machine = machine_of(path)
    address, size = at["questions"]
    questions = [question(i) for i in range(size // QUESTION.size)]
    machine.mem_write(address, b"".join(QUESTION.pack(*asked) for asked in questions))
    machine.reg_write(UC_ARM_REG_SP, RAM + SIZE)
    machine.reg_write(UC_ARM_REG_LR, END | 1)
    machine.emu_start(at["main"][0] | 1, END)
    if machine.reg_read(UC_ARM_REG_R0) != 0:
        sys.exit(f"question {machine.reg_read(UC_ARM_REG_R0) - 1} was refused")
    answers = QUESTION.iter_unpack(machine.mem_read(address, size))
    wrong = [(asked, answer[5] % 2**64) for asked, answer in zip(questions, answers)
             if answer[5] % 2**64 != expected(asked)]
    for asked, angle in wrong[:10]:
        print(f"{asked}: {angle:#x} is not {expected(asked):#x}")
    print(f"{len(questions)} angles, {len(wrong)} wrong")
    sys.exit(1 if wrong or not questions else 0)


main()
