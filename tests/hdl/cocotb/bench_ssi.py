# SPDX-License-Identifier: MIT
"""SsiEncoder, in whatever simulator runs this."""

import random

import cocotb
from cocotb.triggers import Timer, with_timeout
from drehgeber.cocotb import SsiEncoder
from masters import SsiMaster

limited = cocotb.test(timeout_time=1, timeout_unit="sec")  # simulated
# model     settings                                          bits behind the position, Gray
MODELS = [
    ("ssi-13", {},                                            0, True),
    ("ssi-25", {},                                            0, True),
    ("ssi-25", {"code": "binary", "mt": 0, "st": 24},         0, False),
    ("ssi-28", {},                                            2, False),
]  # fmt: skip
HERTZ = (100_000, 500_000, 1_500_000)


def binary(gray):
    value = 0
    while gray:
        value, gray = value ^ gray, gray >> 1
    return value


@limited
@cocotb.parametrize(row=range(len(MODELS)), hertz=HERTZ)
async def words(dut, row, hertz):
    model, settings, behind, gray = MODELS[row]
    dut.ma.value = 1
    await Timer(100, "us")
    encoder = SsiEncoder(dut.ma, dut.slo, model, clock_to_output_ns=50, line_delay_ns=20, **settings)
    master = SsiMaster(dut, hertz)
    turns, st = random.Random(row), int(encoder.get("st"))
    width = int(encoder.get("mt")) + st
    for _ in range(6):
        degrees = turns.uniform(0, 360)
        encoder.shaft.position = degrees
        word = await master.word(width + behind)
        latch = encoder.latch
        position = word >> behind
        position = binary(position) if gray else position
        assert position == latch.position == latch.multiturn << st | latch.singleturn
        assert abs(position / (1 << st) * 360 - degrees) <= 360 / (1 << st)
        if behind:  # error bit, even parity
            assert word >> 1 & 1 == 0 and bin(word).count("1") % 2 == 0


@limited
async def data_is_late_enough_for_a_master_that_looks_for_the_1(dut):
    """More than 100 ns behind the edge (TR-ECE-BA-DGB-0131): shortly behind the first rising one data is still high."""
    dut.ma.value = 1
    await Timer(100, "us")
    encoder = SsiEncoder(dut.ma, dut.slo, "ssi-25")  # at 0: all bits are 0
    assert encoder.position() == 0
    dut.ma.value = 0
    await Timer(1, "us")
    dut.ma.value = 1
    await Timer(100, "ns")
    assert dut.slo.value == 1
    await Timer(100, "ns")
    assert dut.slo.value == 0


@limited
async def the_latch_is_the_first_falling_edge(dut):
    dut.ma.value = 1
    await Timer(100, "us")
    encoder = SsiEncoder(dut.ma, dut.slo, shaft="6000RPM")
    awaited = cocotb.start_soon(encoder.latched())
    begin = int(cocotb.utils.get_sim_time("ps"))
    await SsiMaster(dut, 1_000_000).word(25)
    latch = await with_timeout(awaited, 1, "us")
    assert latch.at_ps == begin and latch.position == encoder.position(begin)


@limited
async def errors_and_power(dut):
    dut.ma.value = 1
    await Timer(100, "us")
    encoder = SsiEncoder(dut.ma, dut.slo, "ssi-28")
    master = SsiMaster(dut, 1_000_000)
    with encoder.fault("led_current_high"):
        assert await master.word(30) >> 1 & 1 == 1
    assert await master.word(30) >> 1 & 1 == 0
    encoder.power(False)
    await Timer(1, "us")
    assert dut.slo.value == 0
