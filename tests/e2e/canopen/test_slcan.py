# SPDX-License-Identifier: MIT
"""What only SLCAN has: the pty, the adapter's own commands, bit rates that must agree."""
import os
import time

import can
import pytest
import serial
from can_rig import PATIENCE_S, SAVE, Client, assert_one_line, free_port, open_bus, wait_for_leds


@pytest.fixture
def adapter(start):
    """The pty without a client, its channel closed."""
    with serial.Serial(start(client=False).link, 115200, timeout=PATIENCE_S) as port:
        yield port


def ask(port, command: bytes) -> bytes:
    """The answer, up to CR or BEL."""
    port.write(command + b"\r")
    said = b""
    while not said.endswith((b"\r", b"\a")):
        byte = port.read(1)
        assert byte, (command, said)
        said += byte
    return said


def test_link_is_a_pty(rig):
    assert os.path.realpath(rig.link).startswith("/dev/pts/")


def test_boot_up_of_a_reset_reaches_the_adapter(adapter):
    assert ask(adapter, b"S5") == b"\r"
    assert ask(adapter, b"O") == b"\r"
    assert ask(adapter, b"t00028100") in (b"z\r", b"\r")
    assert adapter.read_until(b"\r") == b"t73F100\r"


def test_bad_lines_are_answered_with_bel(adapter):
    assert ask(adapter, b"S9") == b"\a"
    assert ask(adapter, b"X") == b"\a"
    assert ask(adapter, b"t63F") == b"\a"
    assert ask(adapter, b"S5") == b"\r"
    assert ask(adapter, b"O") == b"\r"
    assert ask(adapter, b"t63F9") == b"\a"
    assert ask(adapter, b"t8001AA") == b"\a"
    assert ask(adapter, b"t63F2ZZZZ") == b"\a"


def test_adapter_identity(adapter):
    assert ask(adapter, b"V").startswith(b"V")
    assert ask(adapter, b"N").startswith(b"N")


def test_remote_frame_by_hand(adapter):
    ask(adapter, b"S5")
    ask(adapter, b"O")
    assert ask(adapter, b"r73F1") in (b"z\r", b"\r")
    assert adapter.read_until(b"\r") == b"t73F17F\r"


def test_another_bit_rate_is_silence_and_one_line(start):
    rig = start(quiet=False, client=False)
    request = can.Message(arbitration_id=0x63F, data=bytes.fromhex("4000100000000000"),
                          is_extended_id=False)
    with open_bus(rig.link, 500_000) as bus:
        for _ in range(5):
            bus.send(request)
        assert bus.recv(0.3) is None
    assert_one_line(rig.encoder, "250", "500")
    rig.connect()
    rig.use(63)
    rig.barrier()


def test_bit_rate_of_2100h(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x2100, 0, 6, 1)
    rig.sdo.download(0x2105, 1, SAVE)
    rig.kill()
    rig = start("--nvm", nvm, bit_rate=500_000)
    assert rig.read(0x2100) == 6


def test_bit_rate_of_lss(start):
    rig = start()
    rig.network.lss.send_switch_state_global(1)
    rig.network.lss.configure_bit_timing(4)
    rig.network.lss.send_switch_state_global(0)
    rig.connect(125_000)
    rig.use(63)
    assert rig.read(0x2100) == 4


def test_leds_show_the_channel(start):
    """A closed channel, and one at another bit rate, are no bus to the encoder."""
    port = free_port()
    rig = start("--control", f"tcp:127.0.0.1:{port}", client=False)
    with Client(port) as control, serial.Serial(rig.link, timeout=PATIENCE_S) as adapter:
        wait_for_leds(control, "bus:off/err:blink")
        for rate, leds in [(b"S5", "bus:blink/err:off"), (b"S6", "bus:off/err:off")]:
            assert ask(adapter, rate) + ask(adapter, b"O") == b"\r\r"
            wait_for_leds(control, leds)
            assert ask(adapter, b"C") == b"\r"
            wait_for_leds(control, "bus:off/err:off")
        control.do("POW CYCL")
        wait_for_leds(control, "bus:off/err:blink")


def test_client_that_comes_and_goes(rig):
    for _ in range(5):
        rig.connect()
        rig.use(63)
        rig.barrier()


def test_quick_answers(rig):
    begin = time.monotonic()
    for _ in range(100):
        rig.barrier()
    assert time.monotonic() - begin < 5.0
