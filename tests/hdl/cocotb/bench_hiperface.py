# SPDX-License-Identifier: MIT
"""HiperfaceEncoder, in whatever simulator runs this."""

import math

import cocotb
from cocotb.triggers import RisingEdge, Timer
from drehgeber.cocotb import HiperfaceEncoder
from masters import Uart, now_ps

limited = cocotb.test(timeout_time=1, timeout_unit="sec")  # simulated
POSITION = bytes.fromhex("40 42 02")  # manual R67057.0002, 5.1.3: read position, with its check sum
CHECKSUM = bytes.fromhex("40 50 0A 1A")  # the error status, 50h, with code 0Ah: also of a damaged character
HALF_A_TURN = bytes.fromhex("40 42 00 00 80 00 82")
SILENCE_US = 8_000


async def made(dut, baud=9600, parity="E", **options):
    encoder = HiperfaceEncoder(dut.rx, dut.tx, dut.de, shaft="180DEG", **options)
    uart = Uart(dut, baud, parity)
    await Timer(1, "ms")
    return encoder, uart


@limited
async def a_position(dut):
    encoder, uart = await made(dut, line_delay_ns=100, jitter_ns=500)
    replied, requested = cocotb.start_soon(encoder.replied()), cocotb.start_soon(encoder.requested())
    begin = now_ps()
    await uart.send(POSITION, lead=2, hold=0.5)
    assert await uart.receive(SILENCE_US) == HALF_A_TURN
    request, reply = await requested, await replied
    bit = uart.bit_ps
    assert request.data == POSITION and request.damaged == 0
    assert request.at_ps == begin + 2 * bit + 100_000
    assert abs(request.end_ps - request.at_ps - 33 * bit) < 1000
    assert request.lead_ps == 2 * bit and abs(request.hold_ps - bit / 2) < 2000
    assert reply.data == HALF_A_TURN and not reply.contended
    # 44 bits of silence, then the reaction time; both ends of the line are 100 ns away.
    assert abs(reply.at_ps - request.end_ps - 44 * bit - 1_000_000_000) < 3000
    assert abs(reply.end_ps - reply.at_ps - 77 * bit) < 1000
    assert encoder.reply == reply and encoder.request == request


@limited
async def bits_on_the_line(dut):
    """The answer begins with a start bit of its own length."""
    encoder, uart = await made(dut)
    await uart.send(POSITION)
    await dut.rx.value_change
    assert dut.rx.value == 0 and encoder.uart.baud == 9600
    begin = now_ps()
    await RisingEdge(dut.rx)  # 40h: six zeros behind the start bit
    assert abs(now_ps() - begin - 7 * uart.bit_ps) < 100


@limited
@cocotb.parametrize(options=[{"broken": 1}, {"broken": 2}, {"hold": -3}])
async def damage_is_answered(dut, options):
    """A wrong parity, or a driver that is switched off before the last character is over."""
    encoder, uart = await made(dut)
    await uart.send(POSITION, **options)
    assert await uart.receive(SILENCE_US) == CHECKSUM
    assert encoder.request.damaged == 1
    assert (encoder.request.data == POSITION) == ("broken" in options)


@limited
@cocotb.parametrize(setting=[(9600, "O"), (19200, "E"), (4800, "E")])
async def who_talks_otherwise_is_not_answered(dut, setting):
    encoder, uart = await made(dut, *setting)
    await uart.send(POSITION)
    await Timer(20, "ms")
    assert encoder.request is None and encoder.reply is None


@limited
@cocotb.parametrize(baud=[9400, 9800])
async def data_rates_may_be_off_by_two_percent(dut, baud):
    encoder, uart = await made(dut, baud)
    await uart.send(POSITION)
    assert await uart.receive(SILENCE_US) == HALF_A_TURN


@limited
async def a_driver_that_stays_on(dut):
    """Whoever keeps DE on does not hear the answer, and is told."""
    encoder, uart = await made(dut)
    await uart.send(POSITION, hold=200)
    assert encoder.reply is not None and encoder.reply.contended
    assert encoder.request.hold_ps is None


@limited
async def an_echo(dut):
    encoder, uart = await made(dut, echo=True)
    heard = cocotb.start_soon(uart.receive(SILENCE_US))
    await uart.send(POSITION)
    assert await heard == POSITION + HALF_A_TURN


@limited
async def a_spike_is_no_character(dut):
    encoder, uart = await made(dut)
    dut.de.value = 1
    dut.tx.value = 0
    await Timer(20, "us")
    dut.tx.value = 1
    await Timer(1, "ms")
    await uart.send(POSITION)
    assert await uart.receive(SILENCE_US) == HALF_A_TURN
    assert encoder.request.data == POSITION


@limited
async def sine_and_cosine(dut):
    """Phase-locked to what 42h tells: 2048 periods a turn, 32 steps each."""
    encoder, uart = await made(dut)
    for step in range(32):
        encoder.shaft.position = 360 / 65536 * (step + 0.5)
        levels = encoder.sincos()
        sine, cosine = levels.sin_plus - levels.sin_minus, levels.cos_plus - levels.cos_minus
        phase = math.atan2(sine, cosine) / math.tau % 1
        assert encoder.position() == step and abs(phase * 32 - step - 0.5) < 0.05, (step, phase)
    encoder.shaft.velocity = 60
    begin = now_ps()
    await Timer(1, "us")
    before, after = encoder.sincos(begin), encoder.sincos(begin + 1_000_000_000)
    assert before != after and encoder.sincos(begin) == before


@limited
async def power_and_world(dut):
    encoder, uart = await made(dut)
    encoder.power(False)
    await uart.send(POSITION)
    assert await uart.receive(SILENCE_US) == b"" and dut.rx.value == 1
    encoder.power(True)
    await Timer(150, "ms")
    await uart.send(POSITION)
    await dut.rx.value_change
    encoder.power(False)  # the answer ends in the middle
    await Timer(uart.bit_ps, "ps")
    for _ in range(50):
        await Timer(uart.bit_ps, "ps")
        assert dut.rx.value == 1
    encoder.power(True)
    await Timer(150, "ms")
    encoder.world.temperature = 130
    await uart.send(POSITION)
    assert (await uart.receive(SILENCE_US))[1] & 0x80
    assert encoder.scpi("WORL:TEMP?").startswith("130")
