# SPDX-License-Identifier: MIT
"""All 19 commands of chapter 5.1.2 over the wire."""
import pytest

from hiperface_master import (BROADCAST, EXTENDED_LABEL, STATUS, EncoderError, FieldStatus,
                              checksum, frame)
from rig import MULTITURN, SINGLETURN, STEPS_PER_TURN, assert_silent

# The examples of chapter 5.1.4, in an order in which one encoder can give them all. Two misprinted
# check sums are corrected (4Ch reply, 57h request). 53h and 6Ah have tests of their own.
EXAMPLES = [
    ("40 4E 0E", "40 4E 16 00 18"),
    ("40 52 12", "40 52 E4 22 16 00 C2"),
    ("40 56 16", "40 56 31 32 33 34 35 36 37 38 39 76 31 2E 30 2E 38" + " 00" * 14
     + " 31 32 30 37 32 30 31 39 66"),
    ("40 42 02", "40 42 00 00 00 00 02"),
    ("40 43 00 00 00 00 55 56", "40 43 03"),
    ("40 44 48 4C", "40 44 48 00 25 69"),
    ("40 46 06", "40 46 00 00 00 06"),
    ("40 47 07", "40 47 07"),
    ("40 49 55 5C", "40 49 09"),
    ("40 4D 00 C8 55 90", "40 4D 00 C8 C5"),
    ("40 4C 00 0C", "40 4C 00 C8 C4"),
    ("40 4A 00 00 10 55 4F", "40 4A 00 00 10" + " FF" * 16 + " 1A"),
    ("40 4B 00 00 08 55 FF 00 FF 00 FF 00 FF 00 56", "40 4B 00 00 08 03"),
    ("40 50 10", "40 50 00 10"),
    ("40 4F 02 55 66 3E", "40 4F 02 0D"),
    ("40 57 E4 55 A6", "40 57 E4 F3"),
    ("40 55 41 55 01", "41 55 14"),
]
# The encoder of the examples: 352 bytes for the user, and this identity.
EXAMPLE_ENCODER = ["--serial", "123456789", "--set", "memory=22", "--set", "version=v1.0.8",
                   "--set", "date=12072019"]

# What an encoder as delivered refuses: request without check sum, status code.
REFUSED = [
    ("40 41", 0x0B),
    ("40 45", 0x0B),
    ("40 7F", 0x0B),
    ("40 42 00", 0x0C),
    ("40 44", 0x0C),
    ("40 43 00 00 00 00", 0x0C),
    ("40 4B 00 00 02 55 AA", 0x0C),
    ("40 44 47", 0x0D),
    ("40 43 00 00 00 00 56", 0x0F),
    ("40 43 10 00 00 00 55", 0x0D),
    ("40 6A 10 00 00 00 55", 0x0D),
    ("40 49 56", 0x0F),
    ("40 4A 00 00 10 55", 0x12),
    ("40 4B 00 00 01 55 AA", 0x12),
    ("40 4C 00", 0x12),
    ("40 4D 01 C8 55", 0x12),
    ("40 4D 00 C8 56", 0x0F),
    ("40 4D 00 48 55", 0x12),
    ("40 4D FF C8 55", 0x10),
    ("40 4B FF 00 01 55 AA", 0x0E),
    ("40 4A FF 40 01 55", 0x11),
    ("40 4A FF 00 41 55", 0x11),
    ("40 4F 04 55 66", 0x0D),
    ("40 4F 00 54 66", 0x0F),
    ("40 55 3F 55", 0x0D),
    ("40 55 60 55", 0x0D),
    ("40 55 41 56", 0x0F),
    ("40 57 E7 55", 0x0D),
    ("40 57 D4 55", 0x0D),
    ("40 57 E4 56", 0x0F),
]


def reply_to(master, request: bytes, length: int) -> bytes:
    """The reply byte by byte, and nothing behind it."""
    master.send(request)
    reply = master.receive(length, 2)
    return reply + master.receive(1, 0.02)


def fails_with(code: int):
    return pytest.raises(EncoderError, match=f"{code:02X}h {STATUS[code]}")


def test_examples_of_the_manual(start):
    master = start(*EXAMPLE_ENCODER, "--shaft", "0", model=SINGLETURN).master()
    for request, expected in EXAMPLES:
        expected = bytes.fromhex(expected)
        reply = reply_to(master, bytes.fromhex(request), len(expected))
        assert reply.hex(" ") == expected.hex(" "), request


def test_refused_requests(start):
    master = start().master()
    for body, code in REFUSED:
        body = bytes.fromhex(body)
        reply = reply_to(master, body + bytes([checksum(body)]), 4)
        expected = bytes([0x40, 0x50, code, 0x10 ^ code])
        assert reply.hex(" ") == expected.hex(" "), body.hex(" ")
    assert master.read_status() == 0  # protocol and data errors are not stored


def test_wrong_check_sum(start):
    master = start().master()
    assert reply_to(master, bytes.fromhex("40 42 03"), 4) == bytes.fromhex("40 50 0A 1A")
    assert master.read_position() == 0


@pytest.mark.parametrize("model, turns, type_code",
                         [(MULTITURN, 4096, 0x27), (SINGLETURN, 1, 0x22)])
def test_who_it_is(start, model, turns, type_code):
    master = start(model=model).master()
    assert master.type_label() == (0xE4, type_code, 1792, 0)
    label = master.extended_label()
    assert label.checksum_ok and not label.linear and not label.bipolar
    assert (label.periods, label.turns) == (2048, turns)
    assert label.designation != ""
    assert (label.temperature_channel, label.led_channel) == (0x48, 0x49)
    assert label.vector_channel == 0x4A
    assert label.temperature_min_degc < 0 < label.temperature_max_degc
    assert label.led_min_ma < label.led_max_ma and label.vector_min < label.vector_max
    assert label.speed_max_rpm > 0 and label.acceleration_max_krad_s2 > 0
    assert label.selector == 0x07FF
    identity = master.identity()
    assert len(identity.serial_number) == 9 and identity.version and len(identity.date) == 8


def test_extended_label_piece_by_piece(start):
    master = start().master()
    whole = master.read_data(EXTENDED_LABEL, 0, 64)
    assert b"".join(master.read_data(EXTENDED_LABEL, at, 1) for at in range(64)) == whole
    assert master.read_data(EXTENDED_LABEL, 63, 1, code=0x00) == whole[63:]


def test_serial_number_option(start):
    master = start("--serial", "123456789").master()
    assert master.identity().serial_number == "123456789"


def test_positions(start):
    multiturn = start("--shaft", "2.5REV").master()
    assert multiturn.read_position() == 5 * STEPS_PER_TURN // 2
    singleturn = start("--shaft", "2.5REV", model=SINGLETURN).master()
    assert singleturn.read_position() == STEPS_PER_TURN // 2


def test_set_position(start):
    master = start("--shaft", "90DEG").master()
    master.set_position(0x0FFFFFFF)
    assert master.read_position() == 0x0FFFFFFF
    master.set_position(0)
    assert master.read_position() == 0


def test_set_position_synchronised(start):
    # Example 5.1.4.19: one step off the sine period's start, ..C7h becomes ..C1h.
    master = start("--shaft", "0.0056DEG").master()
    assert master.read_position() == 1
    assert reply_to(master, bytes.fromhex("40 6A 00 05 D2 C7 55 6F"), 7) == \
        bytes.fromhex("40 6A 00 05 D2 C1 3C")
    assert master.read_position() == 0x0005D2C1
    assert master.set_position_synchronised(0x11) == 0x21  # half way: up
    assert master.set_position_synchronised(0x10) == 0x01


def test_counter(start):
    master = start().master()
    for _ in range(3):
        master.increment_counter()
    assert master.read_counter() == 3
    master.erase_counter()
    assert master.read_counter() == 0


def test_data_fields(start):
    master = start().master()
    assert master.available_memory() == (1792, 0)
    master.create_field(0, FieldStatus(128))
    master.create_field(1, FieldStatus(16, code_enabled=False))
    assert master.available_memory() == (1792 - 144, 2)
    assert master.field_status(0) == FieldStatus(128)
    data = bytes(range(128))
    master.save_data(0, 0, data)
    assert master.read_data(0, 0, 128) == data
    assert master.read_data(0, 100, 28) == data[100:]
    master.save_data(1, 12, b"free", code=0x00)
    assert master.read_data(1, 0, 16, code=0xAA) == b"\xff" * 12 + b"free"
    with fails_with(0x0F):
        master.read_data(0, 0, 1, code=0x54)
    with fails_with(0x11):
        master.read_data(1, 12, 5)
    with fails_with(0x12):
        master.create_field(0, FieldStatus(64))  # only the last one can change its size
    master.create_field(1, FieldStatus(32, code_enabled=False, writable=False))
    with fails_with(0x0E):
        master.save_data(1, 0, b"x")
    assert master.read_data(1, 12, 4) == b"free"
    master.create_field(1, FieldStatus(32, code_enabled=False, writable=False, exists=False))
    assert master.available_memory() == (1792 - 128, 1)
    with fails_with(0x12):
        master.read_data(1, 0, 1)


def test_memory_is_finite(start):
    master = start().master()
    for number in range(14):
        master.create_field(number, FieldStatus(128))
    assert master.available_memory() == (0, 14)
    with fails_with(0x10):
        master.create_field(14, FieldStatus(16))


def test_access_codes(start):
    master = start().master()
    master.modify_access_code(0, 0x55, 0x12)
    master.set_position(7)  # the master uses the new code
    master.code0 = 0x55
    with fails_with(0x0F):
        master.set_position(8)
    assert master.read_position() == 7
    master.modify_access_code(3, 0x55, 0x34)
    with fails_with(0x0F):
        master.create_field(0, FieldStatus(16, code_number=3))
    master.create_field(0, FieldStatus(16, code_number=3), code=0x34)


def test_sensor_values(start):
    master = start().master()
    label = master.extended_label()
    assert master.read_analog(label.temperature_channel) == 37
    assert master.read_analog(label.led_channel) > 0
    assert label.vector_min <= master.read_analog(label.vector_channel) <= label.vector_max


def test_address(start):
    encoder = start()
    master = encoder.master()
    master.assign_address(0x5F)
    assert master.read_position() == 0
    master.address = 0x40
    assert_silent(master)
    master.address = 0x5F
    master.reset()
    assert master.read_position() == 0  # 53h does not change the address


def test_broadcast(start):
    master = start("--shaft", "90DEG").master()
    master.assign_address(0x47)
    master.address = BROADCAST
    assert master.read_position() == STEPS_PER_TURN // 4
    assert master.reply_address == 0x47


def test_others_are_not_answered(start):
    master = start().master()
    for address in [0x00, 0x41, 0x5F, 0xC0, 0xFE]:
        master.address = address
        assert_silent(master)
    master.address = 0x40
    assert master.read_position() == 0


def test_reset_has_no_reply(start):
    master = start().master()
    master.set_position(1234)
    master.send(frame(0x40, 0x53))
    assert master.receive(1, 0.25) == b""
    assert master.read_position() == 1234
