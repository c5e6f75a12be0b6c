# SPDX-License-Identifier: MIT
"""Scripts: what happens to an encoder, one operation a line. The same model and seed give the same script for ever."""

import functools
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

SECOND = 1_000_000_000
MS = 1_000_000
LINES = 120
# Words of scripts, and kinds of events in logs.
OPERATIONS = ("bus", "bytes", "can", "chain", "cycle", "edges", "encoder", "eeprom", "fault", "frame", "identify", "latch", "meet",
              "mount", "next", "over", "position", "power", "raw", "read", "remote", "set", "shaft", "sincos", "twin",
              "world", "write")
EVENTS = ("byte", "message", "edge")
PROTOCOLS = {
    "s3674-rs485": "hiperface", "s3684-rs485": "hiperface", "s3674-biss": "biss", "s3684-biss": "biss",
    "ssi-13": "ssi", "ssi-25": "ssi", "ssi-28": "ssi", "f3658": "canopen", "f3668": "canopen",
    "ocd-ib-k1": "interbus", "ocd-ib-k2": "interbus", "ocd-ib-k3": "interbus",
}
MODELS = tuple(PROTOCOLS)
# Wires with several encoders: wires.py writes their scripts, but for the ring.
SHARED = {"line": "hiperface", "can": "canopen", "chain": "biss", "ring": "interbus"}
SUBJECTS = PROTOCOLS | SHARED
NODE = 63
ADDRESS = 0x40

# Settings before the first power-on, and values of each.
SETTINGS: dict[str, dict[str, tuple[str, ...]]] = {
    "hiperface": {"reaction_us": ("0", "1000", "3000"), "init_ms": ("10", "100"), "memory": ("16", "112"),
                  "serial": ("123456789",)},
    "biss": {"busy_us": ("0", "4.5", "12"), "busy_jitter_us": ("0", "1.5"), "lc": ("0", "1"), "autostore": ("0", "1"),
             "timeout_us": ("13", "20"), "eeprom_write_us": ("5", "3000"), "init_ms": ("5", "60")},
    "ssi": {"code": ("gray", "binary"), "error_bit": ("none", "high", "low"), "parity": ("none", "even", "odd"),
            "once": ("0", "1"), "monoflop_us": ("12", "20"), "init_ms": ("0", "30")},
    "canopen": {"serial": ("1", "4294967295"), "mt_bits": ("12", "16")},
    "interbus": {"param_cycles": ("1", "3"), "self_test_ms": ("0", "200"), "loop": ("0", "1"), "serial": ("77",)},
}

# Quantities of the world: healthy, then what an encoder complains of.
WORLD = {
    "temperature": (37000, -60000, 130000, 84999), "led_current_ua": (12000, 0, 45000), "supply_mv": (5000, 4000),
    "battery_mv": (3610, 2200, 0), "sin_amplitude_permille": (1000, 400, 1500), "cos_offset_permille": (0, 500, -1000),
    "singleturn_ok": (1, 0), "multiturn_sync_ok": (1, 0), "multiturn_amplitude_ok": (1, 0),
    "eeprom_acknowledges": (1, 1, 0), "watchdog_fired": (0, 1),
}
FAULTS = {
    "hiperface": ("led_current_low", "temperature_high", "wire_drop", "wire_deaf", "wire_delay", "wire_damage",
                  "wire_duplicate"),
    "biss": ("led_current_high", "singleturn_lost", "eeprom_silent", "wire_drop", "wire_delay", "wire_damage",
             "wire_break"),
    "ssi": ("led_current_high", "singleturn_lost", "supply_low", "wire_drop", "wire_delay", "wire_damage",
            "wire_break"),
    "canopen": ("battery_low", "singleturn_lost", "wire_drop", "wire_deaf", "wire_delay", "wire_damage",
                "wire_duplicate", "bus_off", "error_passive", "overrun"),
    "interbus": ("singleturn_lost", "multiturn_sync", "eeprom_silent", "wire_drop", "wire_damage", "wire_tear",
                 "wire_break"),
}

# HIPERFACE: commands with the lengths of their data; the rest of a frame is made around them.
COMMANDS = ((0x42, 0), (0x43, 5), (0x44, 1), (0x46, 0), (0x47, 0), (0x49, 1), (0x4A, 4), (0x4B, 6), (0x4C, 1),
            (0x4D, 3), (0x4E, 0), (0x4F, 3), (0x50, 0), (0x52, 0), (0x53, 0), (0x56, 0), (0x6A, 5), (0x99, 2))
# CANopen: objects that are read and written, with what a write may bring; 5 ms is the fastest event.
OBJECTS = ((0x1000, 0), (0x1001, 0), (0x1003, 0), (0x1003, 1), (0x1008, 0), (0x100D, 0), (0x1018, 4), (0x1A00, 1),
           (0x1800, 1), (0x2110, 2), (0x2120, 4), (0x2160, 0), (0x6002, 0), (0x6004, 0), (0x6030, 1), (0x6500, 0),
           (0x6503, 0), (0x6505, 0), (0x6509, 0), (0x7777, 0), (0x6401, 9))
WRITES = ((0x1017, 0, 2, (0, 5, 100)), (0x1800, 2, 1, (1, 3, 254, 255)), (0x1800, 5, 2, (0, 7, 50)),
          (0x1801, 2, 1, (1, 255)), (0x1016, 1, 4, (0x050064, 0)), (0x6000, 0, 2, (0, 1, 4, 5)),
          (0x6001, 0, 4, (1, 360, 65536)), (0x6002, 0, 4, (360, 65536, 1 << 24)), (0x6003, 0, 4, (0, 17, 1 << 20)),
          (0x6200, 0, 2, (0, 9, 40)), (0x2140, 1, 4, (0xDEADBEEF,)), (0x1010, 1, 4, (0x65766173, 1)),
          (0x1011, 1, 4, (0x64616F6C,)), (0x1006, 0, 4, (0, 1000)), (0x6401, 1, 4, (5, 1 << 16)), (0x1000, 0, 4, (0,)))
WORDS = (0, 0, 0x80000000, 0x40000000, 0x60000000, 0x02000400, 0x02002710, 0x04000003, 0x06000003, 0x06000004,
         0x08000123, 0x0A000100, 0x0E000000, 0x20400000, 0x20400001, 0x20800001, 0x20210000, 0x20210003, 0x201000FF,
         0x20200000, 0x41000100, 0x61000200, 0xFFFFFFFF, 0x12345678)


@dataclass
class Encoder:
    """What a script has done to one."""

    on: bool = False
    on_at: int = SECOND
    broken: set[str] = field(default_factory=set)
    prefix: str = ""  # of words about it, where there are several


class Script:
    """The lines so far, and what has to be known to write more, about a model or a wire."""

    def __init__(self, subject: str, seed: int) -> None:
        self.protocol = SUBJECTS[subject]
        self.lines = [f"script {subject} {seed}"]
        self.now = SECOND
        self.encoder = Encoder()  # the one at hand
        self.faults = FAULTS[self.protocol]
        self.world = WORLD
        # Knuth's multiplicative hash, never 0: neighbours begin far from one another.
        self._state = ((tuple(SUBJECTS).index(subject) + 1) * 1000 + seed) * 2654435761 & 0xFFFFFFFF | 1
        for _ in range(8):
            self.draw(1)

    def draw(self, below: int) -> int:
        """A number from 0 on: Marsaglia's xorshift of 32 bits."""
        self._state ^= self._state << 13 & 0xFFFFFFFF
        self._state ^= self._state >> 17
        self._state ^= self._state << 5 & 0xFFFFFFFF
        return self._state % below

    def choose(self, among: Any) -> Any:
        return among[self.draw(len(among))]

    def bytes(self, count: int) -> bytes:
        return bytes(self.draw(256) for _ in range(count))

    def add(self, *words: object) -> None:
        """An operation of the encoder at hand."""
        self.add_for_all(f"{self.encoder.prefix}{words[0]}", *words[1:])

    def add_for_all(self, *words: object) -> None:
        """One of the wire."""
        self.lines.append(" ".join(str(word) for word in (self.now, *words)))

    def pass_time(self) -> None:
        """From a nanosecond to a third of a second."""
        most = self.choose((50, 20_000, 400_000, 3 * MS, 3 * MS, 20 * MS, 20 * MS, 20 * MS))
        self.now += 1 + self.draw(most)


# ------------------------------------------------------------ on every encoder

def switch(script: Script) -> None:
    """Off, usually for a moment, or on."""
    script.encoder.on = not script.encoder.on or script.draw(4) == 0
    script.encoder.on_at = script.now
    script.add("power", int(script.encoder.on))
    script.now += script.choose((1, 5 * MS, 300 * MS))
    if not script.encoder.on and script.draw(4) > 0:
        script.encoder.on, script.encoder.on_at = True, script.now
        script.add("power", 1)
        script.now += script.choose((1, 300 * MS, SECOND))


def turn(script: Script) -> None:
    # Multiples of these are whole numbers in every unit that a host counts in.
    angle = (script.draw(1 << 24) - (1 << 23)) << 16
    mrpm = (script.draw(1600) - 800) * 1875
    script.add("shaft", angle, script.choose((0, mrpm)))


def sense(script: Script) -> None:
    if script.draw(4) == 0:  # else nothing would be healthy for long
        for name, values in script.world.items():
            if script.draw(3) > 0:
                script.add("world", name, values[0])
        return
    name = script.choose(tuple(script.world))
    script.add("world", name, script.choose(script.world[name]))


def break_something(script: Script) -> None:
    """Or mend it. What is broken is not broken again: in an FMU a fault is there or not."""
    if script.encoder.on:
        name = script.choose(script.faults)
        script.encoder.broken ^= {name}
        script.add("fault", name, int(name in script.encoder.broken))


def look(script: Script) -> None:
    script.add(script.choose(("position", "position", "next", "eeprom", "eeprom")))


# ------------------------------------------------------------ wires

def frame_of_line(script: Script, addresses: tuple[int, ...]) -> bytes:
    code, length = script.choose(COMMANDS)
    if code in (0x43, 0x44, 0x4F, 0x6A) and script.draw(4) > 0:  # with the access code of a new encoder
        data = (script.bytes(length) if code in (0x43, 0x6A) else b"\0" * length)[:-1] + b"\x55"
    else:
        data = script.bytes(length)
    if code in (0x4A, 0x4B):  # a data field and an address in it
        data = bytes((script.draw(3), script.draw(16), script.draw(8))) + data[3:]
    frame = bytes((script.choose(addresses), code)) + data
    check = 0
    for byte in frame:
        check ^= byte
    if script.draw(8) == 0:
        check ^= 1 << script.draw(8)
    return frame + bytes((check,))


def request(script: Script) -> None:
    frame = frame_of_line(script, (ADDRESS, ADDRESS, ADDRESS, 0xFF, 0x41))
    if script.encoder.on and script.draw(4) > 0:
        script.add("bytes", frame.hex())
    else:
        delay, character = script.draw(1000), script.choose((0, 0, 1145834, 286459))
        script.add("raw", delay, character, script.choose((0, 0, 1, 2, 4)), frame[:16].hex())
    script.now += 30 * MS + script.draw(20 * MS)
    if script.draw(4) == 0:
        script.add("sincos")


def frame_of_can(script: Script, node: int) -> tuple[int, bytes]:
    kind = script.draw(12)
    if kind < 4:
        index, sub = script.choose(OBJECTS)
        return 0x600 + node, bytes((0x40, index & 255, index >> 8, sub, 0, 0, 0, 0))
    if kind < 8:
        index, sub, size, values = script.choose(WRITES)
        command = 0x23 | (4 - size) << 2
        return 0x600 + node, bytes((command, index & 255, index >> 8, sub)) + script.choose(values).to_bytes(4, "little")
    if kind < 10:
        return 0, bytes((script.choose((1, 1, 2, 0x80, 0x81, 0x82)), script.choose((0, node, 5))))
    if kind == 10:
        return 0x80, b""
    identifier = script.choose((0x7E5, 0x705, 0x600 + node, 0x123))
    return identifier, script.bytes(script.choose((8, 8, 0, 3)))


def send_can(script: Script) -> None:
    kind = script.draw(16)
    if kind == 0:
        script.add("bus", script.choose((0, 1, 0, 1, 3, 4, 5, 2)))
    elif kind == 1:
        script.add("remote", script.choose((0x700 + NODE, 0x180 + NODE)), script.draw(2) * 8)
    else:
        identifier, data = frame_of_can(script, NODE)
        script.add("can", identifier, data.hex() or "-")


def clock(script: Script, more: Callable[[Script, int], None] | None = None) -> None:
    """A master's clock, and what only some protocols have there."""
    kind = script.draw(8)
    if kind < 3:
        initialised = script.encoder.on and script.now >= script.encoder.on_at + SECOND
        script.add(script.choose(("frame", "latch") if initialised else ("frame",)))
        script.now += MS  # longer than it takes
    elif kind < 5:
        # Whole periods; some end before the frame does, some frames are cut by a pause.
        half, count = script.choose((250, 500, 1000, 4000, 15000)), 2 * (1 + script.draw(60))
        script.add("edges", half, count)
        script.now += half * count
    elif more is not None:
        more(script, kind)
    script.now += 50 * MS * script.draw(2)


def chain_and_registers(script: Script, kind: int) -> None:
    if kind == 5:
        script.add("chain", script.draw(2))
        return
    address = script.choose((0, 0x23, 0x24, 0x40, 0x41, 0x43, 0x60, 0x70, 0x78, 0x7C, script.draw(128)))
    if kind == 6:
        script.add("read", address, 1 + script.draw(4))
    else:
        script.add("write", address, script.bytes(1 + script.draw(3)).hex())
    script.now += 100 * MS


def cycle(script: Script) -> None:
    if script.draw(8) == 0:
        script.add("identify")
        return
    out = script.choose(WORDS)
    for _ in range(1 + script.draw(5)):
        script.add("cycle", f"{out:#x}")
        script.now += MS


WIRES: dict[str, Callable[[Script], None]] = {
    "hiperface": request, "canopen": send_can, "biss": functools.partial(clock, more=chain_and_registers), "ssi": clock,
    "interbus": cycle,
}


def word_of(name: str) -> str:
    """Without the encoder's number, "2:power"."""
    return name.rpartition(":")[2]


def names_of(line: str) -> set[str]:
    """What a list of operations may call this one: by its word, or by that and the next one, "set:serial"."""
    name, *more = line.split()[1:3]
    return {word_of(name), ":".join((word_of(name), *more))}


@functools.cache
def write_whole_script(model: str, seed: int) -> tuple[str, ...]:
    script = Script(model, seed)
    for name, values in SETTINGS[script.protocol].items():
        if script.draw(3) == 0:
            script.add("set", name, script.choose(values))
    turn(script)
    script.now += 1
    script.add("power", 1)
    script.encoder.on = True
    script.now += SECOND
    others = (turn, turn, sense, break_something, break_something, look, look, look, switch)
    while len(script.lines) < LINES:
        script.pass_time()
        if not script.encoder.on and script.draw(4) == 0:
            switch(script)
        else:
            (WIRES[script.protocol] if script.draw(8) < 5 else script.choose(others))(script)
    script.now += 100 * MS
    for last in ("position", "eeprom", "mount"):
        script.add(last)
    return tuple(script.lines)


def end_of(line: str) -> int:
    """When it is done, ns: edges last, all others are moments."""
    at, word, *arguments = line.split()  # nobody has edges but an encoder alone
    return int(at) + (int(arguments[0]) * int(arguments[1]) if word == "edges" else 0)


def thin(lines: list[str], name: str, behind: str, ns: int) -> list[str]:
    """Without operations of this name that come less than `ns` behind the end of one called `behind`, "any": of any other.
    "*" is each of them."""
    left: list[str] = []
    latest = -ns
    for line in lines:
        at, word = line.split()[0], word_of(line.split()[1])
        if name not in (word, "*") or int(at) - latest >= ns:
            left.append(line)
        if word == behind or (behind == "any" and word != name):
            latest = end_of(line)
    return left


def leave_out(script: tuple[str, ...], without: frozenset[str]) -> list[str]:
    """A script's lines, but for operations that a host does not have. There "set:KEY=VALUE" is: with this setting, and no other;
    "read:93..103": words from ... to; "power~bytes:NS": none so short behind the other one."""
    head, *lines = script
    fixed = [word.removeprefix("set:").split("=") for word in sorted(without) if word.startswith("set:") and "=" in word]
    ranges = [re.fullmatch(r"(\w+:)(\d+)\.\.(\d+)", word) for word in without]
    pauses = [re.fullmatch(r"(\w+|\*)~(\w+):(\d+)", word) for word in sorted(without)]
    without |= {f"{found[1]}{number}" for found in ranges if found for number in range(int(found[2]), int(found[3]) + 1)}
    without |= {f"set:{key}" for key, _ in fixed}
    lines = [line for line in lines if not without & names_of(line)]
    for found in pauses:
        lines = thin(lines, found[1], found[2], int(found[3])) if found else lines
    return [head, *(f"{SECOND} set {key} {value}" for key, value in fixed), *lines]


def read_scripts(lines: Iterable[str]) -> list[list[list[str]]]:
    """The words of each line of each script, whose first line is its head."""
    scripts: list[list[list[str]]] = []
    for line in lines:
        words = line.split()
        if words[0] == "script":
            scripts.append([])
        scripts[-1].append(words)
    return scripts
