# SPDX-License-Identifier: MIT
"""What a BiSS master sees of each fault: S36 manual, chapters 5.2.1 and 5.2.3."""
import re

from bench import BissMaster, eventually
from looks import HARDWARE_ERROR, Target, power_cycle

POSITION_90DEG = (1 << 21) // 4
BANK, COMMAND, EMASK, WMASK = 0x40, 0x60, 0x22, 0x23
CHECK_CONFIGURATION = 0x04
POSITION_VALID = 0x01
EMASK_DEFAULT, TEMPERATURE_BIT = 0xFB, 0x04
USER_BANKS = range(7, 32)


def fresh_biss(target: Target):
    eventually(lambda: target.master.ready(), 5)
    target.master.write(BANK, 0)
    assert biss_fine(target.master)


def biss_fine(master: BissMaster) -> bool:
    position, n_error, n_warning, life, crc_ok = master.frame()
    return (position, n_error, n_warning, crc_ok) == (POSITION_90DEG, 1, 1, 1) and master.errors() == 0


def biss_restart(target: Target):
    power_cycle(target)
    eventually(lambda: target.master.ready(), 5)


def raised(bits: int, valid: bool = True):
    """Bits of 69h, and nERR is low."""
    def look(target):
        master = target.master
        yield
        position, n_error, n_warning, life, crc_ok = master.frame()
        assert (n_error, n_warning, crc_ok) == (0, 1, 1)
        assert master.errors() == bits
        assert bool(master.status() & POSITION_VALID) == valid
        yield
        assert biss_fine(master)
        assert master.status() & POSITION_VALID
    return look


def monitored_temperature(tenths: int):
    def look(target):
        master = target.master
        yield
        assert biss_fine(master)  # 'temperature monitoring is disabled as a standard'
        assert int.from_bytes(bytes(master.read(0x6A, 2)), "little", signed=True) == tenths
        master.write(EMASK, EMASK_DEFAULT | TEMPERATURE_BIT)
        assert master.errors() == TEMPERATURE_BIT and master.frame()[1:3] == [0, 1]
        master.write(EMASK, EMASK_DEFAULT)
        master.write(WMASK, TEMPERATURE_BIT)
        assert master.errors() == TEMPERATURE_BIT and master.frame()[1:3] == [1, 0]
        yield
        assert biss_fine(master)
        master.write(WMASK, 0)
        assert int.from_bytes(bytes(master.read(0x6A, 2)), "little", signed=True) == 370
    return look


def biss_eeprom_silent(target):
    master = target.master
    master.write(BANK, USER_BANKS[0])
    assert master.read(0x00) == [0xFF]
    yield
    assert master.errors() == 0x10 and master.frame()[1] == 0
    assert target.scpi.codes("BISS:REG? 0") == [HARDWARE_ERROR]
    biss_restart(target)
    assert master.errors() == 0x10
    yield
    assert master.errors() == 0x10  # what is in force is not what is stored
    master.write(COMMAND, CHECK_CONFIGURATION)
    eventually(lambda: master.errors() == 0)
    master.write(BANK, USER_BANKS[0])
    assert master.read(0x00) == [0xFF]
    biss_restart(target)
    assert biss_fine(master)


def biss_region(target):
    yield
    biss_restart(target)
    assert target.master.errors() == 0x10 and target.master.frame()[1] == 0
    yield
    biss_restart(target)
    assert biss_fine(target.master)


def biss_no_ack(target):
    """SLO stays high: no frame, no register access."""
    yield
    assert target.scpi.codes("BISS:FRAM?") == [HARDWARE_ERROR]
    assert target.scpi.codes("BISS:REG? 120") == [HARDWARE_ERROR]
    yield
    assert biss_fine(target.master)


def biss_delay(target):
    """The start bit comes after 100 us; 40 us are the longest. The rig's master waits, but tells."""
    def start_bit_us() -> int:
        target.master.frame()
        told = re.search(r"start bit after (\d+) us", target.scpi.name("TRAC:LAST?"))
        return int(told[1]) if told else 0
    target.scpi.parts("TRAC:LAST?")  # the first question begins the listening
    assert start_bit_us() == 0
    yield
    assert 100 <= start_bit_us() <= 110  # whole clocks
    yield
    assert start_bit_us() == 0


def biss_damage(target):
    yield
    frames = [target.master.frame() for _ in range(40)]
    wrong = [one for one in frames if one[-1] == 0]
    # The bit may be CDS, which no check sum covers.
    assert 30 <= len(wrong) <= 40
    assert all(one[:3] == [POSITION_90DEG, 1, 1] for one in frames if one[-1] == 1)
    assert any(one[0] != POSITION_90DEG for one in wrong)
    yield
    assert all(one[-1] == 1 for one in [target.master.frame() for _ in range(10)])


BISS = {
    "led_current_high": raised(0x01),
    "temperature_high": monitored_temperature(1250),
    "temperature_low": monitored_temperature(-450),
    "sin_amplitude_low": raised(0x02),
    "sin_amplitude_high": raised(0x02),
    "cos_amplitude_low": raised(0x02),
    "cos_amplitude_high": raised(0x02),
    "sin_offset": raised(0x02),
    "cos_offset": raised(0x02),
    "singleturn_lost": raised(0x20, valid=False),
    "multiturn_amplitude": raised(0x40, valid=False),
    "multiturn_sync": raised(0x08, valid=False),
    "multiturn_vector": raised(0x40, valid=False),
    "eeprom_silent": biss_eeprom_silent,
    "watchdog_fired": raised(0x80),
    "wire_drop": biss_no_ack,
    "wire_delay": biss_delay,
    "wire_damage": biss_damage,
    "wire_break": biss_no_ack,
    "eeprom_config": biss_region,
    **{f"eeprom_user{bank}": biss_region for bank in USER_BANKS},
}
