# SPDX-License-Identifier: MIT
"""An RS485 encoder, read with pyserial as a drive would read it."""
import pytest
import serial

RIG = """
[encoder motor]
model = s3684-rs485
wire = pty
"""
STEPS_PER_TURN = 65536


def checked(*request: int) -> bytes:
    """A request with its check sum, the XOR of all bytes before."""
    check = 0
    for byte in request:
        check ^= byte
    return bytes([*request, check])


def ask(port, command: int, length: int) -> bytes:
    """Address 40h is the factory's; an error's reply is shorter and ends the read by its timeout."""
    port.write(checked(0x40, command))
    return port.read(length)


def read_position(port) -> float:
    """42h, in turns."""
    reply = ask(port, 0x42, 7)
    assert len(reply) == 7, reply.hex(" ")
    return int.from_bytes(reply[2:6], "big") / STEPS_PER_TURN


@pytest.fixture
def motor(drehgeber_rig):
    return drehgeber_rig(RIG).encoders["motor"]


@pytest.fixture
def port(motor):
    """A pseudo-terminal knows no parity; a real line would have parity="E"."""
    with serial.Serial(motor.address, 9600, timeout=0.3) as port:
        yield port


def test_the_shaft_is_where_it_was_put(motor, port):
    motor.shaft.position = 90
    assert read_position(port) == 0.25
    motor.shaft.move(3 * 360, rpm=600)  # waits until it is there
    assert read_position(port) == 3


def test_a_worn_led_is_reported(motor, port):
    with motor.fault("led_current_high"):
        # An error: 50h, with the warning bit since the code waits on the stack, too.
        assert ask(port, 0x42, 7) == checked(0x40, 0xD0, 0x1D)
        assert ask(port, 0x50, 4) == checked(0x40, 0x50, 0x1D)
    assert read_position(port) == 0


def test_a_disturbed_line_damages_one_reply(motor, port):
    motor.set_fault("wire_damage", count=1)
    assert ask(port, 0x42, 7) != checked(0x40, 0x42, 0, 0, 0, 0)
    assert ask(port, 0x42, 7) == checked(0x40, 0x42, 0, 0, 0, 0)
