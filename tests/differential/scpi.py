# SPDX-License-Identifier: MIT
"""What happens to an encoder as lines of SCPI, for hosts that are steered so, and what their answers say."""

import re

TURN = 1 << 32
WORLD = {
    "temperature": ("TEMP", "DEGC", 1000), "led_current_ua": ("LED:CURR", "UA", 1), "supply_mv": ("SUPP", "MV", 1),
    "battery_mv": ("BATT", "MV", 1), "sin_amplitude_permille": ("AMPL:SIN", "", 1),
    "cos_amplitude_permille": ("AMPL:COS", "", 1), "sin_offset_permille": ("OFFS:SIN", "", 1),
    "cos_offset_permille": ("OFFS:COS", "", 1), "singleturn_ok": ("SING", "", 1), "multiturn_sync_ok": ("MULT:SYNC", "", 1),
    "multiturn_amplitude_ok": ("MULT:AMPL", "", 1), "multiturn_vector_ok": ("MULT:VECT", "", 1),
    "eeprom_acknowledges": ("EEPR", "", 1), "watchdog_fired": ("WATC", "", 1),
}
# Codes of SCPI, as results of host.h.
RESULTS = {0: 0, -224: -8, -241: -8}


def steer(name: str, *words: str) -> list[str]:
    """The lines of an operation that is no wire's; what the last one answers is the operation's."""
    return LINES[name](*words)


def turn(angle: str, mrpm: str) -> list[str]:
    """A speed begins at what the shaft has come to: the angle comes first."""
    # 2^-16 turns are 45 / 2^13 degrees: 13 places, exact.
    steps = int(angle) // (TURN >> 16) * 45
    degrees = f"{'-' if steps < 0 else ''}{abs(steps) >> 13}.{(abs(steps) & 0x1FFF) * 5 ** 13:013d}"
    return [f"SHAF:POS {degrees}DEG", f"SHAF:VEL {int(mrpm) / 1000}RPM"]


def sense(name: str, value: str) -> list[str]:
    words, unit, parts = WORLD[name]
    number = value if parts == 1 else str(int(value) / parts)
    return [f"WORL:{words} {number}{unit}"]


LINES = {
    "power": lambda on: ["POW OFF", "POW ON"] if on == "1" else ["POW OFF"],  # on while it is on is a restart
    "shaft": turn,
    "world": sense,
    "fault": lambda name, on: [f"FAUL:{'SET' if on == '1' else 'CLE'} {name}"],
    "position": lambda: ["STAT?"],
    "sincos": lambda: ["STAT?"],
    "eeprom": lambda: ["NVM:DATA?"],
}


def result_of(answer: str) -> int:
    """Of a line that only does something."""
    code = int(answer.partition(",")[0])
    return RESULTS.get(code, code)


def state_of(answer: str) -> dict[str, str]:
    return dict(re.findall(r"(\w+)=([^,]*)", answer))
