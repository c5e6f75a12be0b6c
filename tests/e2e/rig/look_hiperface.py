# SPDX-License-Identifier: MIT
"""What a master on RS485 sees of each fault: S36 manual, chapters 5.1.2 and 5.1.3."""
import time

import pytest

from bench import PATIENCE_S, Master, assert_silent, assert_takes, eventually
from hiperface_master import CHARACTER_BITS, EncoderError, HiperfaceError, frame
from looks import Target, flipped, power_cycle, seconds

POSITION_90DEG = 65536 // 4
SINE_PEAK_DEG, COSINE_PEAK_DEG = "0.0439453125", "0"  # of 2048 periods
TEMPERATURE, LED_CURRENT, VECTOR = 0x48, 0x49, 0x4A


def code_of(command, *arguments) -> int:
    with pytest.raises(EncoderError) as refused:
        command(*arguments)
    return refused.value.code


def fresh_hiperface(target: Target):
    """In operation, the error stack empty."""
    target.master.grace_s = 0.4
    target.master.wait_for_line()
    answers = eventually(lambda: position_or_none(target.master) is not None or None, 5)
    assert answers
    target.master.read_all_status()
    assert target.master.read_position() == POSITION_90DEG
    assert target.master.read_status() == 0


def position_or_none(master: Master):
    try:
        return master.read_position()
    except HiperfaceError:
        return None


def hiperface_restart(target: Target):
    """A power cycle, waited for."""
    power_cycle(target)
    time.sleep(0.12)


def position_codes(master: Master) -> set:
    """What the commands on the position are answered with."""
    return {code_of(master.read_position), code_of(master.set_position, 0),
            code_of(master.set_position_synchronised, 0)}


def position_refused(code: int, stored=()):
    def look(target):
        master = target.master
        yield
        assert position_codes(master) == {code}
        assert master.type_label().type_code == 0x27  # the rest works
        assert list(master.read_all_status()) == list(stored)
        yield
        master.read_all_status()
        assert master.read_position() == POSITION_90DEG
        assert master.read_status() == 0 and not master.warning
    return look


def analog(channel: int, faulty: int, fine: int, degrees: str = "90", stored=()):
    """A value of 44h; `stored` is what 50h tells as well."""
    def look(target):
        master = target.master
        target.scpi.do(f"SHAF:POS {degrees}")
        assert master.read_analog(channel) == fine
        yield
        assert master.read_analog(channel) == faulty
        position = master.read_position()
        assert position == int(float(degrees) / 360 * 65536)
        assert master.warning == bool(stored)
        assert list(master.read_all_status()) == list(stored)
        yield
        master.read_all_status()
        assert master.read_analog(channel) == fine
        assert master.read_position() == position and not master.warning
    return look


def hiperface_eeprom_silent(target):
    master = target.master
    count = master.read_counter()
    yield
    assert code_of(master.read_counter) == code_of(master.identity) == 0x05
    assert master.read_position() == POSITION_90DEG  # it was read at the start
    hiperface_restart(target)
    assert code_of(master.read_position) == 0x02
    assert 0x05 in master.read_all_status()
    assert code_of(master.identity) == 0x05
    yield
    assert code_of(master.read_position) == 0x02  # until the next start
    hiperface_restart(target)
    assert master.read_position() == POSITION_90DEG
    assert master.read_all_status() == {} and master.read_counter() == count


def raw_reply(master: Master, n: int = 7, patience_s: float = PATIENCE_S) -> bytes:
    """What comes back for 42h, as it is: so much at least, and what follows it."""
    master.send(frame(master.address, 0x42))
    return master.receive(n, patience_s) + master.receive(21 - n, 0.05)


def silent(master: Master) -> bool:
    return raw_reply(master, patience_s=0.15) == b""


def answers(master: Master) -> bool:
    return raw_reply(master) != b""


def hiperface_drop(target):
    master = target.master
    count = master.read_counter()
    yield
    assert_silent(master, Master.increment_counter)
    yield
    assert master.read_counter() == count + 1  # it was heard


def hiperface_deaf(target):
    master = target.master
    count = master.read_counter()
    yield
    assert_silent(master, Master.increment_counter)
    yield
    assert master.read_counter() == count


def assert_position_takes(target: Target, nominal_s: float):
    """42h, and nothing of the encoder's: the margin is for a machine that is emulated, as the guest is."""
    def position_s():
        target.master.wait_for_line()
        return seconds(target.master.read_position)

    assert_takes(nominal_s, 0.05, position_s, lambda: int(target.scpi.state()["wire_late"]), 5)


def hiperface_delay(target):
    usual_s = (10 * CHARACTER_BITS + 44) / 9600 + 0.001  # 3 + 7 characters, the silence between them, a reaction
    assert_position_takes(target, usual_s)
    yield
    assert_position_takes(target, usual_s + 0.3)
    yield
    assert_position_takes(target, usual_s)


def hiperface_damage(target):
    good = raw_reply(target.master)
    yield
    bad = [raw_reply(target.master, len(good)) for _ in range(8)]
    assert [flipped(good, one) for one in bad] == [1] * 8
    assert len(set(bad)) > 1  # not always the same
    yield
    assert raw_reply(target.master) == good


def hiperface_duplicate(target):
    good = raw_reply(target.master)
    assert len(good) == 7
    yield
    assert raw_reply(target.master, 14) == good + good
    yield
    assert raw_reply(target.master) == good


def start_error(code: int, check):
    """5.1.3, initialisation: `code` and 06h, and what `check` finds locked."""
    def look(target):
        yield
        assert target.master.read_position() == POSITION_90DEG  # read at the start only
        hiperface_restart(target)
        check(target.master)
        assert set(target.master.read_all_status()) == {code, 0x06}
        yield
        hiperface_restart(target)
        assert target.master.read_all_status() == {}
        assert target.master.read_position() == POSITION_90DEG
    return look


def position_locked(master: Master):
    assert position_codes(master) == {0x02}


def fields_locked(master: Master):
    assert code_of(master.field_status, 0) == 0x03
    assert master.read_position() == POSITION_90DEG


def line_locked(master: Master):
    assert code_of(master.assign_address, 0x41) == code_of(master.configure_uart, 0xE5) == 0x03
    assert code_of(master.modify_access_code, 0, 0x55, 0x66) == 0x06


def codes_locked(master: Master):
    assert code_of(master.modify_access_code, 0, 0x55, 0x66) == 0x03
    assert code_of(master.assign_address, 0x41) == 0x06


def eeprom_locked(master: Master):
    assert code_of(master.identity) == code_of(master.type_label) == 0x05


def counter_locked(master: Master):
    assert code_of(master.read_counter) == code_of(master.increment_counter) == 0x06


def label_locked(master: Master):
    assert code_of(master.read_position) == code_of(master.set_position, 0) == 0x02


HIPERFACE = {
    "led_current_high": position_refused(0x1D, stored=[0x1D]),
    "led_current_low": analog(LED_CURRENT, 0, 12),
    "temperature_high": analog(TEMPERATURE, 125, 37, stored=[0x1E]),
    "temperature_low": analog(TEMPERATURE, -45, 37, stored=[0x1E]),
    "sin_amplitude_low": analog(VECTOR, 500, 1000, SINE_PEAK_DEG),
    "sin_amplitude_high": analog(VECTOR, 1500, 1000, SINE_PEAK_DEG),
    "cos_amplitude_low": analog(VECTOR, 500, 1000, COSINE_PEAK_DEG),
    "cos_amplitude_high": analog(VECTOR, 1500, 1000, COSINE_PEAK_DEG),
    "sin_offset": analog(VECTOR, 1500, 1000, SINE_PEAK_DEG),
    "cos_offset": analog(VECTOR, 1500, 1000, COSINE_PEAK_DEG),
    "singleturn_lost": position_refused(0x20),
    "multiturn_amplitude": position_refused(0x21),
    "multiturn_sync": position_refused(0x22),
    "multiturn_vector": position_refused(0x23),
    "eeprom_silent": hiperface_eeprom_silent,
    "wire_drop": hiperface_drop,
    "wire_deaf": hiperface_deaf,
    "wire_delay": hiperface_delay,
    "wire_damage": hiperface_damage,
    "wire_duplicate": hiperface_duplicate,
    "eeprom_resolution": start_error(0x01, position_locked),
    "eeprom_calibration": start_error(0x01, position_locked),
    "eeprom_offset": start_error(0x02, position_locked),
    "eeprom_sync": start_error(0x02, position_locked),
    "eeprom_uart": start_error(0x03, line_locked),
    "eeprom_memory": start_error(0x03, fields_locked),
    "eeprom_codes": start_error(0x03, codes_locked),
    "eeprom_fields": start_error(0x03, fields_locked),
    "eeprom_type": start_error(0x05, eeprom_locked),
    "eeprom_counter": start_error(0x08, counter_locked),
    "eeprom_label": start_error(0x12, label_locked),
    "eeprom_steps": start_error(0x01, position_locked),
    "eeprom_implemented": start_error(0x03, fields_locked),
}
