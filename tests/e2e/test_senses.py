# SPDX-License-Identifier: MIT
"""Causes from outside, and the codes by which the encoder tells of them (5.1.2, 5.1.3)."""
import pytest

from hiperface_master import EncoderError
from rig import MULTITURN, SINGLETURN

POSITION_FAULTS = [
    ("led_current_ua=1000000", 0x1D),
    ("singleturn_ok=0", 0x20),
    ("multiturn_amplitude_ok=0", 0x21),
    ("multiturn_sync_ok=0", 0x22),
    ("multiturn_vector_ok=0", 0x23),
]


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
