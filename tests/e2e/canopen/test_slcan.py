# SPDX-License-Identifier: MIT
"""What only SLCAN has: the pty, the adapter's own commands, bit rates that must agree."""
import os
import time

import can
import pytest
import serial
from can_rig import (PATIENCE_S, SAVE, Client, assert_one_line, assert_takes, open_bus, state_of,
                     wait_for_leds)

ANYWHERE = "tcp:127.0.0.1:0"  # at a port that nobody else has


@pytest.fixture
def adapter(start):
    """The pty without a client, its channel closed."""
    with serial.Serial(start(client=False).link, 115200, timeout=PATIENCE_S) as port:
        yield port


def control_of(rig) -> Client:
    """Where its second line says."""
    return Client(rig.encoder.out.wait().removeprefix("control "))


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
    rig.sdo.download(0x2105, 0, SAVE)
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
    rig = start("--control", ANYWHERE, client=False)
    with control_of(rig) as control, serial.Serial(rig.link, timeout=PATIENCE_S) as adapter:
        wait_for_leds(control, "bus:off/err:blink")
        for rate, leds in [(b"S5", "bus:blink/err:off"), (b"S6", "bus:off/err:off")]:
            assert ask(adapter, rate) + ask(adapter, b"O") == b"\r\r"
            wait_for_leds(control, leds)
            assert ask(adapter, b"C") == b"\r"
            wait_for_leds(control, "bus:off/err:off")
        control.do("POW CYCL")
        wait_for_leds(control, "bus:off/err:blink")


def test_a_can_id_of_two_services_is_said_once(start, nvm):
    rig = start("--nvm", nvm, "--control", ANYWHERE, quiet=False)
    with control_of(rig) as control:
        assert state_of(control)["shared_ids"] == "-"
        rig.write(0x1800, 1, 0x800001BF, 4)
        rig.write(0x1800, 1, 0x2BF, 4)
        assert_one_line(rig.encoder, "/63", "CAN-ID 2BFh")
        assert state_of(control)["shared_ids"] == "2BF"
        rig.write(0x1017, 0, 0, 2)  # nothing new to say
        rig.write(0x1800, 1, 0x800002BF, 4)
        assert state_of(control)["shared_ids"] == "-"
        rig.write(0x1005, 0, 0x4BF, 4)
        assert_one_line(rig.encoder, "CAN-ID 4BFh")
        rig.sdo.download(0x1010, 1, SAVE)
        control.do("POW CYCL")
        assert state_of(control)["shared_ids"] == "4BF"
    rig.kill()
    rig = start("--nvm", nvm, quiet=False)
    assert_one_line(rig.encoder, "CAN-ID 4BFh")
    assert rig.read(0x1800, 1) == 0x800002BF


# A TPDO of 4 bytes takes up to 95 bits: 105 of them in a second at 10 kBd.
TPDO1_BITS, SLOW_BIT_RATE = 95, 10_000
MEASURED_S = 3.0


@pytest.fixture
def busy(start, nvm):
    """busy("pace=1"): an encoder at 10 kBd, as 2105h has saved it, with an event timer of 1 ms, in
    Operational; and its control plane."""
    controls = []

    def begin(*settings):
        rig = start("--nvm", nvm)
        rig.write(0x2100, 0, 0, 1)
        rig.sdo.download(0x2105, 0, SAVE)
        rig.kill()
        rig = start("--nvm", nvm, "--control", ANYWHERE,
                    *[word for setting in settings for word in ("--set", setting)],
                    bit_rate=SLOW_BIT_RATE, quiet=False)
        controls.append(control_of(rig))
        assert state_of(controls[-1])["wire_kbaud"] == "10"
        rig.write(0x1800, 5, 1, 2)
        rig.start()
        return rig, controls[-1]

    yield begin
    for control in controls:
        control.close()


def tpdos_per_s(rig) -> float:
    rig.tap.forget()
    begin = time.monotonic()
    time.sleep(MEASURED_S)
    return len(rig.tap.so_far(0x1BF)) / (time.monotonic() - begin)


def test_more_than_a_bus_carries_is_said_once(busy):
    rig, control = busy()
    assert tpdos_per_s(rig) > 300
    assert int(state_of(control)["wire_load_permille"]) > 2000
    assert_one_line(rig.encoder, "bus load", "10000 bit/s", "pace=1")


def test_frames_take_their_time_with_pace(busy):
    """The bus is full and not more, nothing is lost, and the encoder is not deaf."""
    rig, control = busy("pace=1")
    rate = SLOW_BIT_RATE / TPDO1_BITS
    assert 0.5 * rate < tpdos_per_s(rig) < 1.05 * rate
    state = state_of(control)
    assert 500 < int(state["wire_load_permille"]) <= 1040
    assert state["wire_lost"] == "0" and int(state["wire_stalls"]) > 0
    assert rig.read(0x1800, 5) == 1
    rig.nmt.send_command(0x80)
    rig.barrier()
    rig.tap.forget()
    rig.barrier()
    assert rig.tap.so_far(0x1BF) == []


def test_pace_is_of_the_bus(start):
    """Where there is room, nothing is slowed down."""
    rig = start("--set", "pace=1")
    begin = time.monotonic()
    for _ in range(20):
        rig.barrier()
    assert time.monotonic() - begin < 2.0


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


@pytest.mark.parametrize("request_id, request_data, answer_id", [
    (0x63F, bytes.fromhex("4004600000000000"), 0x5BF),
    (0x080, b"", 0x2BF),
], ids=["SDO", "SYNC"])
def test_an_answer_comes_at_once(start, tmp_path, request_id, request_data, answer_id):
    """The manual allows no time for it: the 10 ms are what the client's threads and a busy machine take."""
    control = f"unix:{tmp_path}/control.sock"
    rig = start("--control", control)

    def exchange():
        rig.tap.forget()
        begin = time.monotonic()
        rig.send(request_id, request_data)
        rig.tap.wait(answer_id)
        return time.monotonic() - begin

    with Client(control) as client:
        rig.start()
        assert_takes(0, 0.01, exchange, client.late)
