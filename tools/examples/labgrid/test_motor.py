# SPDX-License-Identifier: MIT
"""pytest --lg-env environment.yaml test_motor.py"""
import pytest
import serial

ASK_POSITION = bytes.fromhex("40 42 02")
LED_CURRENT = bytes.fromhex("40 d0 1d 8d")


@pytest.fixture
def rig(target):
    return target.get_driver("EncoderRigDriver")


@pytest.fixture
def port(rig):
    with serial.Serial(rig.encoder("motor").address, 9600, timeout=0.3) as port:
        yield port


def test_the_shaft_is_where_it_was_turned(rig, port):
    rig.move("motor", 90)
    port.write(ASK_POSITION)
    assert port.read(7)[2:6] == (16384).to_bytes(4, "big")


def test_a_worn_led_is_reported(rig, port):
    rig.fail("motor", "led_current_high", duration_ms=60000)
    port.write(ASK_POSITION)
    assert port.read(7) == LED_CURRENT
