# SPDX-License-Identifier: MIT
"""Causes from outside, and the codes by which the encoder tells of them (5.1.2, 5.1.3)."""
import time

import pytest

from hiperface_master import EncoderError
from rig import MULTITURN, SINGLETURN, Client

POSITION_FAULTS = [
    ("led_current_ua=1000000", 0x1D),
    ("singleturn_ok=0", 0x20),
    ("multiturn_amplitude_ok=0", 0x21),
    ("multiturn_sync_ok=0", 0x22),
    ("multiturn_vector_ok=0", 0x23),
]


# What a drive knows that does not read the type label: type code, then periods a turn and turns.
# 32 steps a period; 22h and 27h as a public master has them, the others from data sheets.
KNOWN = {0x22: (1024, 1), 0x27: (1024, 4096), 0x32: (128, 1), 0x37: (128, 4096), 0x42: (16, 1)}


def angle_as_a_drive_sees_it(master) -> float:
    """Turns, from 42h and what is known of the type code."""
    periods, turns = KNOWN[master.type_label().type_code]
    return master.read_position() / (periods * 32) % turns


@pytest.mark.parametrize("model, settings, turns", [
    (SINGLETURN, ["periods=1024"], 0.25),
    (MULTITURN, ["periods=1024"], 5.25),
    (SINGLETURN, ["type=32h", "periods=128"], 0.25),
    (MULTITURN, ["type=37h", "periods=128"], 5.25),
    (SINGLETURN, ["type=42h", "periods=16"], 0.25),
])
def test_drives_that_know_the_type_code(start, model, settings, turns):
    options = [word for setting in settings for word in ("--set", setting)]
    master = start("--shaft", "5.25REV", *options, model=model).master()
    assert angle_as_a_drive_sees_it(master) == turns


def test_drives_that_know_the_type_code_see_double_as_delivered(start):
    master = start("--shaft", "5.25REV").master()
    assert angle_as_a_drive_sees_it(master) == 10.5


def test_twenty_bits_in_a_turn(start, nvm):
    """Example 5.1.4.19, and the steps are kept in the EEPROM."""
    options = ["--set", "steps=512", "--nvm", nvm]
    for _ in range(2):
        encoder = start("--shaft", "0.25REV", *options, model=SINGLETURN)
        master = encoder.master()
        assert master.set_position_synchronised(0x05D2C7) % 512 == 0
        master.set_position(0xFFFFF)
        assert master.read_position() == 0xFFFFF
        assert encoder.end() == 0


def test_implemented_memory(start):
    master = start("--set", "implemented=128").master()
    assert master.type_label().memory_bytes == 2048
    assert master.available_memory() == (1792, 0)


def test_a_cause_between_two_requests(start):
    encoder = start("--control", "tcp:127.0.0.1:0")
    master = encoder.master()
    with Client(int(encoder.out.wait().rsplit(":", 1)[1])) as client:
        client.do("FAUL:SET temperature_high,DUR 300MS")
        deadline = time.monotonic() + 5
        while client.ask("FAUL:ACT?") != '""':
            assert time.monotonic() < deadline
            time.sleep(0.02)
        assert client.ask("WORL:TEMP?") == "37.000"
        assert "errors=1E" in client.ask("STAT?").split(",")
    assert master.read_position() == 0 and master.warning
    assert master.read_status() == 0x1E and master.read_status() == 0


def test_process_channel_in_the_state(start):
    encoder = start("--control", "tcp:127.0.0.1:0", "--shaft", "0.25REV")
    with Client(int(encoder.out.wait().rsplit(":", 1)[1])) as client:
        state = dict(part.split("=") for part in client.ask("STAT?").split(","))
    assert state["position"] == "16384"
    assert [int(state[key]) for key in ("sin_plus_uv", "sin_minus_uv", "cos_plus_uv",
                                        "cos_minus_uv")] == [2500000, 2500000, 2750000, 2250000]


def code_of(command, *arguments) -> int:
    with pytest.raises(EncoderError) as refused:
        command(*arguments)
    return refused.value.code


@pytest.mark.parametrize("cause, code", POSITION_FAULTS)
def test_position_faults(start, cause, code):
    master = start("--set", cause).master()
    assert code_of(master.read_position) == code
    assert code_of(master.set_position, 0) == code
    assert code_of(master.set_position_synchronised, 0) == code
    assert master.type_label().type_code == 0x27  # the rest works


def test_position_faults_are_not_stored(start):
    master = start("--set", "singleturn_ok=0").master()
    assert code_of(master.read_position) == 0x20
    assert not master.warning and master.read_status() == 0


def test_several_faults(start):
    master = start("--set", "singleturn_ok=0", "--set", "multiturn_sync_ok=0").master()
    assert code_of(master.read_position) == 0x20 and master.warning
    assert list(master.read_all_status()) == [0x22]


def test_led_current_is_also_a_warning(start):
    master = start("--set", "led_current_ua=1000000").master()
    assert code_of(master.read_position) == 0x1D
    assert master.type_label() and master.warning
    assert master.read_status() == 0x1D
    assert code_of(master.read_position) == 0x1D
    assert master.type_label() and not master.warning  # told once


@pytest.mark.parametrize("degrees", ["200", "-100"])
def test_temperature_is_a_warning(start, degrees):
    master = start("--shaft", "90DEG", "--set", f"temperature={degrees}").master()
    assert master.read_position() == 16384 and master.warning
    assert master.read_analog(0x48) == int(degrees)
    assert list(master.read_all_status()) == [0x1E]


@pytest.mark.parametrize("model", [MULTITURN, SINGLETURN])
def test_too_fast(start, model):
    master = start("--shaft", "100000RPM", model=model).master()
    assert code_of(master.read_position) == 0x1F


def test_silent_eeprom(start):
    master = start("--set", "eeprom_acknowledges=0").master()
    for command in (master.identity, master.increment_counter, master.type_label):
        assert code_of(command) == 0x05
