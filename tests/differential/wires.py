# SPDX-License-Identifier: MIT
"""Scripts of two or three encoders on a wire. Words about one of them have its number in front, "2:power"."""

import functools
from collections.abc import Callable

from script import (
    ADDRESS, LINES, MS, SECOND, SETTINGS, WORDS, WORLD, Encoder, Script, break_something, frame_of_can, frame_of_line, sense,
    switch, turn,
)  # fmt: skip

MODELS = {"line": ("s3684-rs485", "s3674-rs485"), "can": ("f3668", "f3658"), "chain": ("s3684-biss", "s3674-biss"),
          "ring": ("ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3", "ocd-ib-k3")}  # fmt: skip
# Not all of these sense them; and an encoder whose EEPROM is silent at its start has the address of the delivered one.
OTHERS = ("battery_mv", "multiturn_sync_ok", "multiturn_amplitude_ok", "eeprom_acknowledges")
# Faults that the command and a handle do alike when one is alone; in a chain there is the command only.
FAULTS = {
    "line": ("led_current_low", "temperature_high", "wire_deaf"),
    "can": ("singleturn_lost", "wire_drop", "wire_deaf"),
    "chain": ("led_current_high", "singleturn_lost", "eeprom_silent", "wire_damage"),
    "ring": ("singleturn_lost", "eeprom_silent", "wire_drop", "wire_damage", "wire_tear", "wire_break"),
}
NODES = (63, 5, 64, 1)
# How long an exchange takes at most, with the pause that ends a frame.
EXCHANGE = 80 * MS
# The master of a rig reads a chain each 100 ms, from the end of initialisation on, at a moment that is a multiple
# of this; nothing else happens so long: it would, for a host whose master has to end its frame first, be late.
GRID, FRAME = 5 * MS, 200_000


class Wire(Script):
    """A script with several encoders."""

    def __init__(self, name: str, seed: int) -> None:
        super().__init__(name, seed)
        self.name = name
        self.twins = name in MOVES and seed % 2 == 0  # the second one gets the address of the first
        self.faults = FAULTS[name]
        self.world = {name: WORLD[name] for name in WORLD if name not in OTHERS}
        self.encoders = [Encoder(prefix=f"{i}:") for i in range(1, 3 + self.draw(2))]
        self.addresses: list[int] = []  # of each; in a ring its words

    def choose_encoder(self) -> None:
        self.encoder = self.choose(self.encoders)

    def add_for_all(self, *words: object) -> None:
        if self.name == "chain" and self.now > SECOND + MS:
            self.now += max(0, FRAME - self.now % GRID)
        super().add_for_all(*words)

    def count(self, address: int) -> int:
        """Encoders that a request for this address finds."""
        return sum(one.on and address in (own, 0xFF) for one, own in zip(self.encoders, self.addresses, strict=True))


# ------------------------------------------------------------ before the first power-on

def place_on_line(script: Wire, index: int) -> None:
    script.addresses.append(ADDRESS + index)
    script.add("set", "address", script.addresses[-1])


def place_on_bus(script: Wire, index: int) -> None:
    script.addresses.append(script.choose([node for node in NODES if node not in script.addresses]))
    script.add("set", "node", script.addresses[-1])
    script.add("set", "serial", 1000 + index)  # a rig counts them up where none is said


def place_in_chain(script: Wire, index: int) -> None:
    """The order of encoders is that of the line."""
    script.addresses.append(index)


def place_in_ring(script: Wire, index: int) -> None:
    """The order of encoders is that of the ring; a K1 has one word."""
    script.addresses.append(1 if script.lines[-1].endswith("k1") else 2)


# ------------------------------------------------------------ two with one address: rig files refuse it, masters can do it

def move_on_line(script: Wire, of: int, to: int) -> None:
    script.add_for_all("twin", bytes((of, 0x55, to, 0x55, of ^ to)).hex())
    script.now += EXCHANGE


def move_on_bus(script: Wire, of: int, to: int) -> None:
    """Node number, "save" of the bus settings, reset node."""
    for identifier, data in (0x600 + of, f"2f012100{to:02x}000000"), (0x600 + of, "2305210073617665"), (0, f"81{of:02x}"):
        script.add_for_all("can", identifier, data)
        script.now += SECOND


def watch_second(script: Wire) -> None:
    """Its heartbeat, by the first one, which has something to say when there is none any more."""
    watcher, watched = script.addresses[:2]
    for node, data in (watched, "2b17100032000000"), (watcher, f"231610016400{watched:02x}00"):
        script.add_for_all("can", 0x600 + node, data)
        script.now += 100 * MS
    script.encoder = script.encoders[1]
    for state in 0, 1:
        script.add("power", state)
        script.now += SECOND


# Of encoders, those that all hosts with such a wire have.
KEYS = {
    "line": ("reaction_us", "init_ms", "memory", "serial"), "can": (),
    "chain": ("busy_us", "busy_jitter_us", "lc", "autostore", "eeprom_write_us", "init_ms"),
    "ring": ("param_cycles", "self_test_ms", "serial"),
}  # fmt: skip


def make_encoder(script: Wire, index: int) -> None:
    script.encoder = script.encoders[index]
    script.add("encoder", script.choose(MODELS[script.name]))
    PLACES[script.name](script, index)
    for key in KEYS[script.name]:
        if script.draw(3) == 0:
            script.add("set", key, script.choose(SETTINGS[script.protocol][key]))


# ------------------------------------------------------------ masters

def ask_line(script: Wire) -> None:
    """`meet`: several answer; `over`: one is asked while the answer to another request may be on the line."""
    addresses = tuple(script.addresses)
    frame = frame_of_line(script, (*addresses, *addresses, 0xFF, 0x50))
    if not any(one.on for one in script.encoders):
        return
    script.add_for_all("meet" if script.count(frame[0]) > 1 else "bytes", frame.hex())
    if script.draw(4) == 0:
        script.now += MS + script.draw(25 * MS)
        script.add_for_all("over", frame_of_line(script, addresses).hex())
    script.now += EXCHANGE


def ask_bus(script: Wire) -> None:
    node = script.choose(script.addresses)
    if script.draw(12) == 0:
        script.add_for_all("remote", script.choose((0x700 + node, 0x180 + node)), script.draw(2) * 8)
        return
    start, sync = (0, b"\1\0"), (0x80, b"")
    identifier, data = script.choose((start, sync, sync, *(frame_of_can(script, node) for _ in range(9))))
    script.add_for_all("can", identifier, data.hex() or "-")


def ask_chain(script: Wire) -> None:
    script.choose_encoder()
    kind = script.draw(4)
    address = script.choose((0, 0x23, 0x24, 0x40, 0x41, 0x43, 0x60, 0x70, 0x78, 0x7C, script.draw(128)))
    if kind < 2:
        script.now += 2000  # the master takes its position a microsecond before the moment
        script.add("latch")
        script.now += MS
    elif kind == 2:
        script.add("read", address, 1 + script.draw(4))
        script.now += 200 * MS
    else:
        script.add("write", address, script.bytes(1 + script.draw(3)).hex())
        script.now += 200 * MS


def ask_ring(script: Wire) -> None:
    """One gets a command, as long as it needs; the others get none, or it as well."""
    if script.draw(8) == 0:
        script.add_for_all("identify")
        return
    words, one = script.choose(WORDS), script.draw(len(script.addresses))
    for_all = script.draw(4) == 0
    image = "".join(f"{words if for_all or place == one else 0:08x}"[-4 * width:]
                    for place, width in enumerate(script.addresses))  # fmt: skip
    for _ in range(1 + script.draw(6)):
        script.add_for_all("cycle", image)
        script.now += MS


PLACES: dict[str, Callable[[Wire, int], None]] = {"line": place_on_line, "can": place_on_bus, "chain": place_in_chain, "ring": place_in_ring}
MOVES: dict[str, Callable[[Wire, int, int], None]] = {"line": move_on_line, "can": move_on_bus}
MASTERS: dict[str, Callable[[Wire], None]] = {"line": ask_line, "can": ask_bus, "chain": ask_chain, "ring": ask_ring}


def look(script: Script) -> None:
    script.add(script.choose(("position", "position", "eeprom")))


def begin(script: Wire) -> None:
    """All on, some at the same moment."""
    if script.name == "can" and script.draw(4) == 0:
        script.add_for_all("set", "pace", 1)
    for index in range(len(script.encoders)):
        make_encoder(script, index)
    for encoder in script.encoders:
        script.encoder = encoder
        turn(script)
        if script.draw(4) == 0:
            script.add("world", "singleturn_ok", 0)
    script.now += 1
    for encoder in script.encoders:
        script.encoder = encoder
        script.add("power", 1)
        encoder.on, encoder.on_at = True, script.now
        script.now += script.choose((0, 0, 1, MS))
    script.now += SECOND
    if script.twins:
        MOVES[script.name](script, script.addresses[1], script.addresses[0])
        script.addresses[1] = script.addresses[0]
    elif script.name == "can":
        watch_second(script)


@functools.cache
def write_whole_wire(name: str, seed: int) -> tuple[str, ...]:
    script = Wire(name, seed)
    begin(script)
    others = (turn, turn, sense, break_something, look, look, switch)
    while len(script.lines) < LINES:
        script.pass_time()
        script.choose_encoder()
        if not script.encoder.on and script.draw(4) == 0:
            switch(script)
        elif script.draw(8) < 5:
            MASTERS[name](script)
        else:
            script.choose(others)(script)
    script.now += 100 * MS
    for script.encoder in script.encoders:
        for last in ("position", "eeprom"):
            script.add(last)
    return tuple(script.lines)
