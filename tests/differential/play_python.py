# SPDX-License-Identifier: MIT
"""The player of the Python package's encoders: scripts come in, logs go out. README.md has the language."""

import contextlib
import sys
import warnings
from collections import deque
from collections.abc import Callable

import drehgeber
import drehgeber.chain
import drehgeber.ring
from script import SHARED

SECOND = 1_000_000_000
LEAD = SECOND  # a clock of the package begins a second after 0 of the library
TURN = 1 << 32
CONTROLLER, COMPANY = ("active", "passive", "off", "overrun"), {4: "nobody", 5: "somebody"}
EVERY = 100_000_000  # ns from one frame that the master of a rig reads by itself to the next one
LATCH = 1000  # ns from the beginning of a frame of a chain to its first rising edge
SILENT, FAILED = -14, (-4,)  # of a rig: what is damaged is no answer
CLOSED = "the first line of a script is missing"


def ns_of(seconds: float) -> int:
    return round(seconds * SECOND) + LEAD


def sum_of(memory: bytes) -> str:
    """FNV-1a."""
    total = 2166136261
    for byte in memory:
        total = (total ^ byte) * 16777619 & 0xFFFFFFFF
    return f"{total:08x}"


class Player:
    """An encoder, or several on a wire, to which a script happens."""

    def __init__(self, subject: str) -> None:
        self.encoders: dict[str, drehgeber.Encoder] = {}
        self.settings: dict[str, str] = {}
        self.port: drehgeber.CanPort | None = None
        self.sent: deque[drehgeber.CanFrame] | None = None  # all frames, on a bus where they wait for their time
        self.levels: deque[drehgeber.clocked.Level] = deque()  # of the line of one that is clocked
        self.frames = 0  # that the master of a chain has read by itself
        self.number = 0
        self.shared = subject in SHARED
        self.chained = subject == "chain"
        self._ring: drehgeber.ring.Ring | None = None
        self._chain: drehgeber.chain.Chain | None = None
        self.clock = drehgeber.Clock()
        # The wire of all its encoders, as its settings say.
        self.wires: dict[str, drehgeber.Line | drehgeber.CanBus] = {}
        self.wire = {"line": ("line", drehgeber.Line), "can": ("bus", drehgeber.CanBus)}.get(subject)
        if not self.shared:
            self.put("", subject)

    def put(self, number: str, model: str) -> None:
        """An encoder, on the wire of the others."""
        if self.wire is not None and not self.wires:
            word, kind = self.wire
            self.wires = {word: kind(clock=self.clock, **{key: int(value) for key, value in self.settings.items()})}
        first = not self.encoders
        self.encoder = self.encoders[number] = drehgeber.Encoder(model, clock=self.clock, power=False, **self.wires)
        if first and self.encoder.medium is drehgeber.Medium.FRAMES:
            self.port = self.encoder.can
            if self.wires and "pace" in self.settings:
                self.sent = self.encoder.bus.watch()
        if not self.shared and self.encoder.medium is drehgeber.Medium.EDGES:
            self.levels = self.encoder.clocked.watch()

    # ------------------------------------------------------------ time

    @property
    def now(self) -> int:
        return ns_of(self.clock.now)

    def pass_time(self, ns: int) -> None:
        until = self.now + max(0, ns)
        while self.chained and self.encoders and (due := self.next_frame()) <= until:
            self.clock.advance((due - self.now) / SECOND)
            with contextlib.suppress(drehgeber.EncoderError):
                self.line.frame()
            self.frames += 1
        self.clock.advance(max(0, until - self.now) / SECOND)

    def next_frame(self) -> int:
        """The master of a rig reads one each 100 ms, from the end of initialisation on, when its line is free."""
        init = max(int(one.get("init_ms")) for one in self.encoders.values()) * 1_000_000
        return max(self.now, LEAD + init + self.frames * EVERY)

    def tell(self) -> None:
        """What the encoder has sent."""
        if not self.encoders:
            return
        if self.encoder.medium is drehgeber.Medium.CHARACTERS:
            arrived = self.encoder.rs485._arrived  # as the port of pyserial does
            while arrived:
                at, byte = arrived.popleft()
                print(f"  @{at} byte {byte:02x}")
        while self.levels:
            at, level = self.levels.popleft()
            print(f"  @{ns_of(at)} edge {level:d}")
        heard = list(iter(self.port.recv, None)) if self.port is not None else []
        for frame in heard if self.sent is None else self.sent:
            remote = 8 if frame.remote else 0
            print(f"  @{ns_of(frame.at)} message {frame.id:x} {remote:x} {frame.data.hex()};")
        if self.sent is not None:
            self.sent.clear()

    def perform(self, words: list[str]) -> None:
        at, name, *arguments = words
        number, _, word = name.rpartition(":")
        self.number += 1
        if word == "encoder":
            self.put(number, *arguments)
            print(f"{self.number} {name} 0")
            return
        operation, refused = OPERATIONS[word]
        if self.encoders:
            self.encoder = self.encoders.get(number, self.encoder)
        self.pass_time(int(at) - (LATCH if word == "latch" and self.chained else 0) - self.now)
        self.tell()
        try:
            answer = operation(self, *arguments)
        except drehgeber.EncoderError as error:
            answer = refused.format(SILENT if self.chained and error.code in FAILED else error.code)
        self.pass_time(0)
        self.tell()
        print(f"{self.number} {name}{answer}")

    # ------------------------------------------------------------ physics

    def set(self, key: str, value: str) -> str:
        if self.encoders:
            self.encoder.set(key, value)
        self.settings[key] = value
        return " 0"

    def power(self, on: str) -> str:
        self.encoder.power(on == "1")
        return " 0"

    def shaft(self, angle: str, mrpm: str) -> str:
        self.encoder.shaft.position = int(angle) * 360 / TURN
        self.encoder.shaft.velocity = int(mrpm) / 1000
        return ""

    def world(self, name: str, value: str) -> str:
        parts = 1000 if name == "temperature" else 1
        setattr(self.encoder.world, name, int(value) / parts)
        return " 0"

    def fault(self, name: str, on: str) -> str:
        if on == "1":
            self.encoder.set_fault(name)
        else:
            self.encoder.clear_fault(name)
        return " 0"

    # ------------------------------------------------------------ wires

    def bytes(self, data: str) -> str:
        self.encoder.rs485._send(bytes.fromhex(data))  # as the port of pyserial does
        return " 0"

    def can(self, identifier: str, data: str) -> str:
        assert self.port is not None
        self.port.send(int(identifier), bytes.fromhex(data.strip("-")))
        self.forget_own()
        return " 0"

    def forget_own(self) -> None:
        """Who looks at the bus sees the master, too."""
        if self.sent is not None:
            self.sent.popleft()

    def remote(self, identifier: str, dlc: str) -> str:
        assert self.port is not None
        self.port.send(int(identifier), remote=True, dlc=int(dlc))
        self.forget_own()
        return " 0"

    def bus(self, state: str) -> str:
        """enum dg_host_bus."""
        bus = self.encoder.bus
        if int(state) < len(CONTROLLER):
            bus.controller(CONTROLLER[int(state)])
        else:
            bus.company(COMPANY[int(state)])
        return " 0"

    @property
    def ring(self) -> drehgeber.ring.Ring:
        """Of all encoders there are; its first cycle is when all were on."""
        if self._ring is None:
            self._ring = drehgeber.ring.Ring(list(self.encoders.values()))
        return self._ring

    def cycle(self, word: str) -> str:
        if self.shared:
            out_words = [int(word[i : i + 4], 16) for i in range(0, len(word), 4)]
            return f" 0 {''.join(f'{word:04x}' for word in self.ring.cycle(out_words))};"
        out = int(word, 0)
        words = self.encoder.ring.cycle((out >> 16, out & 0xFFFF))
        return f" 0 {''.join(f'{word:04x}' for word in words)};"

    def identify(self) -> str:
        if self.shared:
            return f" 0 {''.join(f'{word:04x}' for word in self.ring.identify_all())};"
        return f" 0 {self.encoder.ring.identify():04x};"

    @property
    def master(self) -> "drehgeber.clocked.Clocked":
        return self.encoder.clocked

    def frame(self) -> str:
        got = self.master.frame()
        return (f" 0 {ns_of(got.at)} {ns_of(got.end)} {got.bits:x}/{got.width} {got.position:x} {got.multiturn:x} "
                f"{got.singleturn:x} {got.error:d}{got.warning:d}{got.good:d} {got.life}")

    @property
    def line(self) -> drehgeber.chain.Chain:
        """Of all encoders there are."""
        if self._chain is None:
            self._chain = drehgeber.chain.Chain(list(self.encoders.values()))
        return self._chain

    @property
    def place(self) -> int:
        return list(self.encoders.values()).index(self.encoder)

    def latch(self) -> str:
        line = self.line.frame() if self.chained else (self.master.frame(),)
        got = line[self.place if self.chained else 0]
        bits = "".join(f"{one.bits:0{one.width}b}" for one in line)
        return f" 0 {int(bits, 2):x}/{len(bits)} {got.position:x} {got.error:d}{got.warning:d}{got.good:d}"

    def edges(self, half: str, count: str) -> str:
        levels = ""
        for i in range(int(count)):
            self.pass_time(int(half))
            levels += str(int(self.master.clock(i % 2 == 1)))
        return f" {levels}"

    def read(self, address: str, count: str) -> str:
        if self.chained:
            data = self.line.register(self.place, int(address), int(count))
            if len(data) < int(count):  # a rig answers all or an error, and is asked again for those in front of it
                data = self.line.register(self.place, int(address), len(data))
            return f" {len(data)} {data.hex()};"
        data = self.encoder.biss.register(int(address), int(count))
        return f" {len(data)} {self.now} {data.hex()};"

    def write(self, address: str, data: str) -> str:
        if self.chained:
            return f" {self.line.write_register(self.place, int(address), bytes.fromhex(data))}"
        count = self.encoder.biss.write_register(int(address), bytes.fromhex(data))
        return f" {count} {self.now}"

    def chain(self, level: str) -> str:
        return f" {self.encoder.biss.sli(level == '1'):d}"

    # ------------------------------------------------------------ looks

    def position(self) -> str:
        return f" 0 {self.encoder.position:x}"

    def sincos(self) -> str:
        return " 0 " + " ".join(str(round(volts * 1e6)) for volts in self.encoder.sincos)

    def eeprom(self) -> str:
        return f" {sum_of(self.encoder.memory)}"

    def mount(self) -> str:
        other = drehgeber.Encoder(self.encoder.model, power=False, memory=self.encoder.memory)
        for key, value in self.settings.items():
            other.set(key, value)
        other.power(True)
        other.clock.advance(1)
        return f" 0 {sum_of(other.memory)}"


# What the operation does, and what it answers when the encoder refuses it.
OPERATIONS: dict[str, tuple[Callable[..., str], str]] = {
    "set": (Player.set, " {}"), "power": (Player.power, " {}"), "shaft": (Player.shaft, " {}"),
    "world": (Player.world, " {}"), "fault": (Player.fault, " {}"), "bytes": (Player.bytes, " {}"),
    "meet": (Player.bytes, " {}"), "over": (Player.bytes, " {}"), "twin": (Player.bytes, " {}"), "bus": (Player.bus, " {}"),
    "can": (Player.can, " {}"), "remote": (Player.remote, " {}"), "cycle": (Player.cycle, " {}"),
    "identify": (Player.identify, " {}"), "frame": (Player.frame, " {}"), "edges": (Player.edges, " {}"),
    "chain": (Player.chain, " {}"), "latch": (Player.latch, " {} 0/0 0 000"),
    "read": (Player.read, " {} ;"), "write": (Player.write, " {}"), "position": (Player.position, " {} 0"),
    "sincos": (Player.sincos, " {} 0 0 0 0"), "eeprom": (Player.eeprom, " {}"), "mount": (Player.mount, " {}"),
}


def main() -> None:
    warnings.simplefilter("ignore", UserWarning)  # hints to the user
    player = None
    for line in sys.stdin:
        words = line.split()
        if words[0] == "script":
            print(line.strip())
            player = Player(words[1])
            continue
        assert player is not None, CLOSED
        player.perform(words)


main()
