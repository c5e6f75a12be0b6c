# SPDX-License-Identifier: MIT
"""The reference master itself, against bytes of the manual and against bad replies."""
import os
import struct
import threading

import pytest

from hiperface_master import (COMMANDS, STATUS, BadReply, EncoderError, ExtendedLabel, FieldStatus,
                              Master, NoReply, UartSetting, checksum, frame)


@pytest.fixture
def answered():
    """answered(bytes): a master whose next request is answered with exactly these bytes."""
    far, near = os.openpty()
    threads, masters = [], []

    def answer(reply: bytes) -> Master:
        master = Master(os.ttyname(near), grace_s=0.1)
        masters.append(master)

        def slave():
            os.read(far, 256)
            os.write(far, reply)

        threads.append(threading.Thread(target=slave, daemon=True))
        threads[-1].start()
        return master

    yield answer
    for thread in threads:
        thread.join(5)
    for master in masters:
        master.close()
    os.close(far)
    os.close(near)


def test_frames_of_the_manual():
    assert frame(0x40, 0x42).hex() == "404202"
    assert frame(0x40, 0x57, b"\xe4\x55").hex() == "4057e455a6"
    assert checksum(bytes.fromhex("40 4E 70 00 7E")) == 0


def test_the_table_has_all_commands():
    assert len(COMMANDS) == 19
    assert set(COMMANDS) == {0x42, 0x43, 0x44, 0x46, 0x47, 0x49, 0x4A, 0x4B, 0x4C, 0x4D, 0x4E, 0x4F,
                             0x50, 0x52, 0x53, 0x55, 0x56, 0x57, 0x6A}


def test_uart_setting():
    assert UartSetting.decode(0xE4) == (9600, "E", 44, False)
    for setting in (0xE4, 0xE5, 0xA6, 0x40, 0xF1):
        assert UartSetting.decode(setting).encode() == setting


def test_field_status():
    assert FieldStatus.decode(0xC8) == FieldStatus(16)
    assert FieldStatus.decode(0xB7) == FieldStatus(128, False, 3, False)
    for status in (0xC8, 0xB7, 0x48):
        assert FieldStatus.decode(status).encode() == status


def test_extended_label():
    body = struct.pack(">BII18sHHhhHHHHHHHH8x4x", 3, 2048, 4096, b"S3684", 0x0407,
                       0x48, -40, 120, 1, 2, 3, 4, 5, 6, 7, 50)
    label = ExtendedLabel.decode(bytes([checksum(body)]) + body)
    assert label.checksum_ok and label.linear and label.bipolar
    assert (label.periods, label.turns, label.designation) == (2048, 4096, "S3684")
    assert (label.temperature_channel, label.temperature_min_degc) == (0x48, -40)
    assert (label.temperature_max_degc, label.acceleration_max_krad_s2) == (120, 50)
    assert label.led_channel is None and label.speed_max_rpm is None
    assert not ExtendedLabel.decode(b"\x00" + body).checksum_ok


def test_reply(answered):
    master = answered(bytes.fromhex("40 42 00 27 25 51 51"))
    assert master.read_position() == 0x00272551 and not master.warning


def test_warning_bit(answered):
    master = answered(bytes.fromhex("40 C2 00 27 25 51 D1"))
    assert master.read_position() == 0x00272551 and master.warning


@pytest.mark.parametrize("reply, warning", [("40 50 0B 1B", False), ("40 D0 0B 9B", True)])
def test_error_response(answered, reply, warning):
    master = answered(bytes.fromhex(reply))
    with pytest.raises(EncoderError) as refused:
        master.read_position()
    assert (refused.value.code, refused.value.name) == (0x0B, STATUS[0x0B])
    assert master.warning == warning


def test_no_reply(answered):
    with pytest.raises(NoReply):
        answered(b"").read_position()


@pytest.mark.parametrize("reply", [
    "40", "40 42 00 00", "40 42 00 00 00 00 03", "41 42 00 00 00 00 03", "40 43 00 00 00 00 03",
    "40 50 0B 1A", "40 50",
])
def test_bad_reply(answered, reply):
    with pytest.raises(BadReply):
        answered(bytes.fromhex(reply)).read_position()
