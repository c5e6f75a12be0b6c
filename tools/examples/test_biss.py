# SPDX-License-Identifier: MIT
"""A BiSS encoder on a simulated wire. No hardware and no waiting: its time stands still until the test
lets it pass, so that every run gives the same bits."""
import pytest

RIG = """
[encoder axis]
model = s3684-biss
wire = sim
"""
STEPS_PER_TURN = 1 << 21
LED_CURRENT = 0x01  # bit 0 of register 69h


@pytest.fixture
def axis(drehgeber_rig):
    axis = drehgeber_rig(RIG).encoders["axis"]
    axis.ask("TIME:SCAL 0")
    axis.ask("TIME:STEP 1 S")  # it has started by then
    return axis


def frame(axis) -> tuple:
    """Clock a frame: the position in turns, nERR, and whether the CRC is right."""
    position, n_err, _n_warn, _life, crc_right = map(int, axis.ask("BISS:FRAM?").split(","))
    return position / STEPS_PER_TURN, n_err, crc_right


def test_half_a_second_is_half_a_turn(axis):
    axis.shaft.velocity = 60
    before = frame(axis)[0]
    axis.ask("TIME:STEP 500 MS")
    assert frame(axis)[0] - before == pytest.approx(0.5, abs=0.001)


def test_a_worn_led_pulls_n_err(axis):
    with axis.fault("led_current_high"):
        axis.ask("TIME:STEP 10 MS")
        assert frame(axis) == (0, 0, 1)
        assert int(axis.ask("BISS:REG? #H69")) & LED_CURRENT
    axis.ask("TIME:STEP 10 MS")
    assert frame(axis) == (0, 1, 1)


def test_temperature_register(axis):
    """6Ah and 6Bh: 0.1 degC, signed, low byte first."""
    axis.world("TEMP", "-12.5 DEGC")
    axis.ask("TIME:STEP 1 S")
    registers = map(int, axis.ask("BISS:REG? #H6A,2").split(","))
    assert int.from_bytes(bytes(registers), "little", signed=True) == -125
