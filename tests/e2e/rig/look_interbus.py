# SPDX-License-Identifier: MIT
"""What a master behind the coupler sees of each fault: OCD INTERBUS manual, chapters 2, 3.3, 9."""
import time

from bench import PATIENCE_S, Coupler, eventually
from looks import Target, power_cycle, stays

POSITION_90DEG = 4096 // 4
SELF_TEST, LOST, RELEASE = 0xA0000000, 0x86000000, 0x80000000
ID_WORDS = [0x0136, 0x0236, 0x0237]
K3_PLACE = 2


def position(target: Target) -> int:
    return target.master.words(target.at, target.words)


def ring_fine(target: Target) -> bool:
    return position(target) == POSITION_90DEG and target.master.status() == Coupler.RUN


def fresh_interbus(target: Target):
    ring = target.master
    ring.out(0, 3)
    eventually(lambda: ring.status() == Coupler.RUN
               and [ring.words(*at) for at in ((0, 1), (1, 2), (3, 2))] == [POSITION_90DEG] * 3, 5)
    assert ring.id_word(target.place) == ID_WORDS[target.place]


def position_lost(target):
    """9.3: a K3 has a bit for it, K1 and K2 only a module error."""
    yield
    if target.place == K3_PLACE:
        eventually(lambda: position(target) >> 31)
        assert target.master.status() == Coupler.RUN
    else:
        eventually(lambda: target.master.status() == Coupler.RUN | Coupler.MODULE_ERROR)
    yield
    eventually(lambda: ring_fine(target))


def interbus_restart(target: Target):
    power_cycle(target)
    eventually(lambda: target.master.status() & Coupler.RUN and
               position(target) not in (SELF_TEST, 0), 5)


def interbus_eeprom_silent(target):
    ring = target.master
    yield
    ring.out(0x08000123, target.at)
    eventually(lambda: position(target) == LOST)  # a parameter that cannot be stored
    ring.out(RELEASE, target.at)
    eventually(lambda: position(target) == POSITION_90DEG)
    ring.out(0, target.at)
    interbus_restart(target)
    eventually(lambda: position(target) == LOST)
    yield
    stays(lambda: position(target) == LOST)  # until the next start
    interbus_restart(target)
    eventually(lambda: ring_fine(target))


def interbus_drop(target):
    yield
    target.scpi.do("SHAF:POS 180")
    stays(lambda: position(target) == POSITION_90DEG)
    yield
    eventually(lambda: position(target) == 2 * POSITION_90DEG)


def interbus_damage(target):
    ring = target.master
    before = ring.crc_errors(target.place)
    yield
    eventually(lambda: ring.crc_errors(target.place) > before)
    eventually(lambda: ring.status() & Coupler.BUS_ERROR)
    target.scpi.do("SHAF:POS 180")
    stays(lambda: position(target) == POSITION_90DEG)
    yield
    eventually(lambda: position(target) == 2 * POSITION_90DEG and ring.status() == Coupler.RUN)
    before = ring.crc_errors(target.place)
    stays(lambda: ring.crc_errors(target.place) == before)


# By the words of a position: two of which every half differs, and what half of each makes.
TORN = {1: (0x0AA, 0xF55, {0x055, 0xFAA}),
        2: (0x0000FFFF, 0x00010000, {0x0001FFFF, 0x00000000})}


def interbus_tear(target):
    first, second, halves = TORN[target.words]
    seen = set()

    def jump():
        """Back and forth; what shows up in between. It has arrived then, however busy the machine is."""
        for steps in (first, second):
            target.scpi.do(f"SHAF:POS {(steps + 0.5) / 4096} REV")
            begin, at = time.monotonic(), None
            while at != steps or time.monotonic() < begin + 0.03:
                assert time.monotonic() < begin + PATIENCE_S, (at, steps)
                at = position(target)
                seen.add(at)

    jump()
    seen.clear()
    jump()
    assert seen == {first, second}
    yield
    for _ in range(30):
        jump()
        if seen & halves:
            break
    assert seen & halves and seen <= halves | {first, second}, seen
    yield
    seen.clear()
    target.scpi.do(f"SHAF:POS {(second + 0.5) / 4096} REV")
    time.sleep(0.05)
    for _ in range(3):
        jump()
    assert seen == {first, second}


def interbus_break(target):
    ring = target.master
    yield
    eventually(lambda: ring.status() & (Coupler.RUN | Coupler.BUS_ERROR) == Coupler.BUS_ERROR)
    target.scpi.do("SHAF:POS 180")
    stays(lambda: position(target) == POSITION_90DEG)
    if target.place > 0:
        assert ring.leds(target.place - 1) & Coupler.LED_RD
    yield
    eventually(lambda: position(target) == 2 * POSITION_90DEG and ring.status() == Coupler.RUN)
    assert ring.leds(target.place) & Coupler.LED_RD == 0
    assert ring.id_word(target.place) == ID_WORDS[target.place]


def interbus_region(target):
    """9.4: a parameter is lost."""
    yield
    assert ring_fine(target)
    interbus_restart(target)
    eventually(lambda: position(target) == LOST)
    yield
    interbus_restart(target)
    eventually(lambda: ring_fine(target))


def interbus_time(target):
    """The operating time is no parameter: it begins anew."""
    yield
    interbus_restart(target)
    eventually(lambda: ring_fine(target))
    target.master.out(0x20210008, target.at)
    eventually(lambda: position(target) == 0xA0000000)
    target.master.out(0, target.at)
    yield
    interbus_restart(target)
    eventually(lambda: ring_fine(target))


K1 = {  # no multiturn sensor, no EEPROM
    "singleturn_lost": position_lost,
    "wire_drop": interbus_drop,
    "wire_damage": interbus_damage,
    "wire_tear": interbus_tear,
    "wire_break": interbus_break,
}
K2 = {
    **K1,
    "multiturn_amplitude": position_lost,
    "multiturn_sync": position_lost,
    "multiturn_vector": position_lost,
}
K3 = {
    **K2,
    "eeprom_silent": interbus_eeprom_silent,
    "eeprom_time": interbus_time,
    **{f"eeprom_{region}": interbus_region
       for region in ["steps", "revolutions", "direction", "preset", "shift", "mode", "shift_iw",
                      *(f"cams_{program}" for program in range(1, 9))]},
}
