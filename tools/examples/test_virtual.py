# SPDX-License-Identifier: MIT
"""A drive's position loop in virtual time, without a wire or a process: two encoders of different kinds on one
shaft, compared at one instant, while one of them fails."""
import drehgeber
import pytest

CYCLE_S = 0.001
ASK_POSITION = bytes.fromhex("40 42 02")
PER_TURN_RS485, PER_TURN_BISS = 1 << 16, 1 << 21


@pytest.fixture
def shaft(drehgeber_clock):
    return drehgeber.Shaft(drehgeber_clock)


@pytest.fixture
def motor(shaft):
    return drehgeber.Encoder("s3684-biss", shaft=shaft)


def turns(motor) -> float:
    return motor.biss.frame().position / PER_TURN_BISS


def test_a_loop_finds_its_position(drehgeber_clock, shaft, motor):
    shaft.acceleration = 60000
    for cycle in range(2000):
        drehgeber_clock.advance((cycle + 1) * CYCLE_S - drehgeber_clock.now)
        shaft.velocity = max(-300, min(300, 600 * (2.5 - turns(motor))))
    assert turns(motor) == pytest.approx(2.5, abs=0.001)


def test_two_kinds_agree(shaft, motor):
    other = drehgeber.Encoder("s3684-rs485", shaft=shaft)
    shaft.position = 1234.5
    reply = other.request(ASK_POSITION)
    assert int.from_bytes(reply[2:6], "big") / PER_TURN_RS485 == pytest.approx(turns(motor), abs=1 / PER_TURN_RS485)


def test_a_worn_led_is_seen_in_the_next_cycle(drehgeber_clock, motor):
    with motor.fault("led_current_high"):
        drehgeber_clock.advance(0.01)
        assert motor.biss.frame().error
    drehgeber_clock.advance(0.01)
    assert not motor.biss.frame().error


def test_an_hour_of_a_loop_of_4_khz(drehgeber_clock, shaft, motor):
    shaft.play("sine:90DEG,2S")
    seen = [max(motor.positions(minute * 60, 1 / 4000, 240000)) for minute in range(60)]
    assert len(set(seen)) == 1  # period by period, the same
