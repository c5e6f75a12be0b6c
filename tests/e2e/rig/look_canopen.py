# SPDX-License-Identifier: MIT
"""What a CANopen master sees of each fault: F36x8 manual, chapters 14, 15, 25, 26, 29."""
import time

from bench import CanMaster, assert_takes, eventually
from looks import Target, power_cycle, seconds

NODE_ID = 63
POSITION_90DEG = 65536 // 4
HEARTBEAT_MS = 20
OPERATIONAL, PRE_OPERATIONAL = 0x05, 0x7F
HARDWARE_ABORT = 0x06060000
SAVE = int.from_bytes(b"save", "little")
LOAD = int.from_bytes(b"load", "little")
SCALING, USF = 0x0004, 0x1000


def fresh_can(target: Target):
    master = target.master
    eventually(master.answers, 5)
    master.nmt(0x80)  # whatever a test before left behind
    master.write(0x1017, 0, 0, 2)
    eventually(lambda: master.read(0x1001) == 0, 5)
    assert master.read(0x6004) == POSITION_90DEG
    master.write(0x1003, 0, 0, 1)
    master.tap.forget()


def can_restart(target: Target):
    target.master.tap.forget()
    power_cycle(target)
    target.master.booted()


def can_fine(master: CanMaster) -> bool:
    return [master.read(index) for index in (0x1001, 0x6503, 0x6505)] == [0, 0, 0]


def emergency(code: int, register: int, alarms: int = 0, warnings: int = 0, **values):
    """An EMCY, its registers, and objects (as i2125 or i2120_4)."""
    def look(target):
        master = target.master
        yield
        assert master.emergency(code)[2] == register
        assert master.read(0x1001) == register
        assert master.read(0x1003, 1) & 0xFFFF == code
        assert (master.read(0x6503), master.read(0x6505)) == (alarms, warnings)
        for name, value in values.items():
            assert master.read(*(int(part, 16) for part in name[1:].split("_"))) == value, name
        yield
        master.emergency(0x0000)
        assert can_fine(master)
    return look


def emergencies(master: CanMaster, *codes: int):
    """These, in any order."""
    missing = set(codes)
    while missing:
        missing.discard(int.from_bytes(master.tap.data(0x80 + NODE_ID)[:2], "little"))


def can_eeprom_silent(target):
    master = target.master
    yield
    emergencies(master, 0x5100, 0x1000)
    assert master.read(0x6503) == 0x0002
    assert master.write(0x1010, 1, SAVE, 4) == HARDWARE_ABORT
    assert master.write(0x1011, 1, LOAD, 4) == HARDWARE_ABORT
    assert master.write(0x2105, 0, SAVE, 4) == HARDWARE_ABORT
    can_restart(target)
    emergencies(master, 0x5100, 0x1000)
    yield
    eventually(lambda: master.read(0x6503) == 0)
    time.sleep(0.15)
    assert master.read(0x1001) == 0x01  # until the next start
    can_restart(target)
    assert can_fine(master)


def can_watchdog(target):
    master = target.master
    yield
    assert master.read(0x6505) == 0x0004 and master.read(0x1001) == 0
    time.sleep(0.25)
    assert master.tap.so_far(0x80 + NODE_ID) == []
    yield
    assert can_fine(master)


def heard(master: CanMaster) -> list:
    """What the heartbeats since the last time say."""
    return [data[0] for data in master.tap.so_far(0x700 + NODE_ID)]


def states(master: CanMaster, least: int) -> list:
    """What the heartbeats of a while say, until there are so many at least."""
    seen = []
    master.tap.forget()

    def come() -> bool:
        seen.extend(heard(master))
        return len(seen) >= least

    time.sleep(0.2)
    eventually(come)
    return seen


def says(master: CanMaster, fits, least: int):
    """What its heartbeats say fits. A frame that was under way when a fault came or went may be among the first
    ones; those after them have to fit."""
    if not fits(states(master, least)):
        seen = states(master, least)
        assert fits(seen), seen


def says_only(master: CanMaster, *expected: int):
    says(master, lambda seen: set(seen) == set(expected), 4 * len(expected))


def with_heartbeats(master: CanMaster):
    assert master.write(0x1017, 0, HEARTBEAT_MS, 2) == 0
    says_only(master, PRE_OPERATIONAL)


def can_drop(target):
    master = target.master
    with_heartbeats(master)
    yield
    says_only(master)
    master.nmt(0x01)
    yield
    says_only(master, OPERATIONAL)  # it was heard
    master.nmt(0x80)


def can_deaf(target):
    master = target.master
    with_heartbeats(master)
    yield
    assert not master.answers()
    master.nmt(0x01)
    says_only(master, PRE_OPERATIONAL)  # not heard
    yield
    master.read(0x1000)  # it answers
    says_only(master, PRE_OPERATIONAL)


def assert_upload_takes(target: Target, nominal_s: float):
    """An SDO upload, which an encoder answers at once: the margin is for a machine that is emulated, as the guest
    is, and for the client's threads."""
    assert_takes(nominal_s, 0.025, lambda: seconds(lambda: target.master.read(0x1000)),
                 lambda: int(target.scpi.state()["wire_late"]), 10)


def can_delay(target):
    assert_upload_takes(target, 0)
    yield
    assert_upload_takes(target, 0.05)
    yield
    time.sleep(0.06)
    assert_upload_takes(target, 0)


def can_damage(target):
    master = target.master
    with_heartbeats(master)
    yield
    says(master, lambda seen: all((state ^ PRE_OPERATIONAL).bit_count() == 1 for state in seen), 4)
    yield
    says_only(master, PRE_OPERATIONAL)


def answers_to_one_request(master: CanMaster, count: int) -> list:
    """So many, and what follows them."""
    master.tap.forget()
    master.send(0x600 + NODE_ID, bytes.fromhex("4000100000000000"))
    answers = [master.tap.data(0x580 + NODE_ID) for _ in range(count)]
    time.sleep(0.1)
    return [*answers, *master.tap.so_far(0x580 + NODE_ID)]


def can_duplicate(target):
    master = target.master
    (good,) = answers_to_one_request(master, 1)
    yield
    assert answers_to_one_request(master, 2) == [good, good]
    yield
    assert answers_to_one_request(master, 1) == [good]


def can_bus_off(target):
    master = target.master
    with_heartbeats(master)
    master.nmt(0x01)
    says_only(master, OPERATIONAL)
    yield
    says_only(master)
    assert not master.answers()
    master.tap.forget()
    yield
    master.emergency(0x8140)
    master.emergency(0x0000)
    says_only(master, PRE_OPERATIONAL)  # 1029h:1
    assert can_fine(master)


def can_overrun(target):
    master = target.master
    yield
    master.tap.forget()
    master.send(0x600 + NODE_ID, bytes.fromhex("4000100000000000"))
    assert master.emergency(0x8110)[2] & 0x11 == 0x11
    assert master.emergency(0x0000)
    assert master.tap.so_far(0x580 + NODE_ID) == []  # the frame is lost
    yield
    assert can_fine(master)  # it answers


def can_region(target):
    """Damaged memory: 5100h."""
    master = target.master
    yield
    assert can_fine(master)
    can_restart(target)
    master.emergency(0x5100)
    assert master.read(0x1001) & 1
    yield
    can_restart(target)
    time.sleep(0.15)
    assert can_fine(master)


def can_usf_region(target):
    """25: the offset is lost: 6200h until a preset, but only who uses it misses it."""
    master = target.master
    yield
    can_restart(target)
    time.sleep(0.15)
    assert can_fine(master)
    target.scpi.do("FAUL:CLE")
    assert master.write(0x6002, 0, 65536 * 100, 4) == 0
    assert master.write(0x6000, 0, SCALING | USF, 2) == 0
    assert master.write(0x1010, 1, SAVE, 4) == 0
    target.scpi.do("FAUL:SET eeprom_usf")
    can_restart(target)
    master.emergency(0x6200)
    assert master.read(0x1001) & 1
    yield
    can_restart(target)
    time.sleep(0.15)
    assert can_fine(master)
    assert master.write(0x1011, 1, LOAD, 4) == 0
    can_restart(target)


CAN = {
    "led_current_high": emergency(0x5200, 0x01),
    "temperature_high": emergency(0x4200, 0x09, warnings=0x8000, i2120_4=0xBD),
    "temperature_low": emergency(0x4200, 0x09, warnings=0x8000, i2120_4=0x13),
    "battery_low": emergency(0x3200, 0x01, warnings=0x0010, i2125=230),
    "battery_missing": emergency(0x3200, 0x05, warnings=0x0010, i2125=0x3FF),
    "singleturn_lost": emergency(0x1000, 0x01, alarms=0x0001),
    "multiturn_amplitude": emergency(0x1000, 0x01, alarms=0x0001),
    "multiturn_sync": emergency(0x1000, 0x01, alarms=0x0001),
    "multiturn_vector": emergency(0x1000, 0x01, alarms=0x0001),
    "eeprom_silent": can_eeprom_silent,
    "watchdog_fired": can_watchdog,
    "wire_drop": can_drop,
    "wire_deaf": can_deaf,
    "wire_delay": can_delay,
    "wire_damage": can_damage,
    "wire_duplicate": can_duplicate,
    "bus_off": can_bus_off,
    "error_passive": emergency(0x8120, 0x11),
    "overrun": can_overrun,
    "eeprom_usf": can_usf_region,
    **{f"eeprom_{region}": can_region
       for region in ["bus", "saved", "communication", "tpdo1", "tpdo2", "tpdo3", "tpdo4",
                      "serial", "profile", "time"]},
}
