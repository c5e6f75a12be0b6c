# SPDX-License-Identifier: MIT
"""The player of rigs in virtual time: a rig file for each script. README.md has the language.

usage: play_command.py [EMULATOR...] RIG, the program of rig/main.c, which is `drehgeber run`, or of engine/main.c"""

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

from scpi import result_of, state_of, steer
from script import SHARED, read_scripts, word_of

BEGIN = 1_000_000_000  # of virtual time
LINE, BUS, RING = "rs485:tcp:127.0.0.1:0", "slcan:tcp:127.0.0.1:0", "modbus"
WIRES = {"rs485": LINE, "f3658": BUS, "f3668": BUS, "biss": "sim", "ssi": "sim", "line": LINE, "can": BUS, "chain": "sim", "ring": RING}
# A handle stores the address that it is made with, a rig one that is said.
ADDRESSES = {"rs485": "address = 0x40\n"}
# A rig counts serial numbers up where none is said.
DELIVERED = {"ring": {"serial": "1234567"}}
# What lets the master clock a frame, and how long after it the position is taken: at its first rising edge, falling edge.
FRAMES = {"biss": ("BISS:FRAM?", 1000), "chain": ("BISS:FRAM?", 1000), "ssi": ("SSI:FRAM?", 500)}
CHANNEL = b"O\r"  # of SLCAN: open it, at any bit rate
GRID, FRAME = 5_000_000, 200_000  # ns
NO_POWER, SILENT, REFUSED = -9, -14, -13
FNV = 2166136261, 16777619

Lines = list[str]


def kind_of(model: str) -> str:
    return next(word for word in (model, *model.split("-")) if word in WIRES)


# ------------------------------------------------------------ what an operation is for the rig

def say(words: bytes) -> str:
    return f"send {words.hex().upper()}"


def frame(identifier: str, data: str) -> Lines:
    body = data.strip("-")
    return [say(f"t{int(identifier):03x}{len(body) // 2}{body}\r".encode())]


def remote(identifier: str, dlc: str) -> Lines:
    return [say(f"r{int(identifier):03x}{dlc}\r".encode())]


def read(address: str, count: str) -> Lines:
    return [f"scpi BISS:REG? {address},{count}"]


def write(address: str, data: str) -> Lines:
    values = ",".join(str(byte) for byte in bytes.fromhex(data))
    return [f"scpi BISS:REG {address},{values}"]


REQUESTS = ("bytes", "meet", "over", "twin")
WORDS: dict[str, Callable[..., Lines]] = {
    "can": frame, "remote": remote, "write": write, "read": read,
    "cycle": lambda words: [f"cycle {words}"], "identify": lambda: ["identify"],
    **dict.fromkeys(REQUESTS, lambda data: [say(bytes.fromhex(data))]),
}


# ------------------------------------------------------------ what the rig's answer is for the log

def write_count(answer: str, words: Lines) -> int:
    """Registers in front of the one that the error names."""
    refused = re.search(r"register ([0-9A-F]+)h", answer)
    if not refused:
        return len(words[1]) // 2 if answer.startswith("0") else fail(answer)
    return int(refused[1], 16) - int(words[0]) or fail(answer)


def fail(answer: str) -> int:
    return REFUSED if "refus" in answer or "not implemented" in answer else SILENT


def sum_memory(answer: str) -> str:
    total, factor = FNV
    for byte in bytes.fromhex("" if answer.startswith("-") else answer.strip('"#').replace(" ", "")):
        total = (total ^ byte) * factor & 0xFFFFFFFF
    return f" {total:08x}"


def position(answer: str) -> str:
    state = state_of(answer)
    return f" 0 {int(state['position']):x}" if state["power"] == "1" else f" {NO_POWER} 0"


def sincos(answer: str) -> str:
    state = state_of(answer)
    if state["power"] == "0":
        return f" {NO_POWER} 0 0 0 0"
    return " 0 " + " ".join(state[f"{line}_uv"] for line in ("sin_plus", "sin_minus", "cos_plus", "cos_minus"))


def latch(answer: str, levels: list[tuple[int, int]]) -> str:
    """The master takes what data is behind its rising edges: BiSS has Ack, start bit and CDS in front of the frame, SSI
    one edge more behind it."""
    fields = [int(word) for word in answer.split(",")] if not answer.startswith("-") else []
    if not fields:
        return f" {SILENT} 0/0 0 000"
    bits = "".join(str(data) for (before, _), (clock, data) in pairwise(levels) if clock > before)
    if len(fields) == 3:  # SSI: position, error, right
        bits, error, warning, good = bits[:-1], fields[1], 0, fields[2]
    else:
        bits = bits[bits.index("1", bits.index("0")) + 2 :]
        error, warning, good = 1 - fields[1], 1 - fields[2], fields[4]
    return f" 0 {int(bits, 2):x}/{len(bits)} {fields[0]:x} {error}{warning}{good}"


ANSWERS: dict[str, Callable[[str], str]] = {
    **dict.fromkeys((*REQUESTS, "can", "remote"), lambda _: " 0"),
    **dict.fromkeys(("cycle", "identify"), lambda answer: f" {answer}"),
    "shaft": lambda _: "", "eeprom": sum_memory, "position": position, "sincos": sincos,
}


# ------------------------------------------------------------ a script

def write_rig(path: Path, model: str, settings: Iterable[Lines]) -> None:
    kind = kind_of(model)
    words = "".join(f"{key} = {value}\n" for key, value in settings)
    path.write_text(f"[encoder it]\nmodel = {model}\nwire = {WIRES[kind]}\n{ADDRESSES.get(kind, '')}{words}")


def write_shared_rig(path: Path, wire: str, script: list[Lines]) -> Lines:
    """One with several encoders. @return their numbers"""
    kind, _, address = WIRES[wire].partition(":")
    sections = {"": {"wire": kind} | ({"address": address} if address else {})}
    for _, name, *words in script:
        number, _, word = name.rpartition(":")
        if word == "encoder":
            sections[number] = {"shaft": f"s{number}", "bus": "it", "model": words[0]} | DELIVERED.get(wire, {})
        elif word == "set":
            sections[number][words[0]] = words[1]
    heads = {number: f"[shaft s{number}]\n[encoder e{number}]\n" if number else "[bus it]\n" for number in sections}
    path.write_text("".join(heads[number] + "".join(f"{key} = {value}\n" for key, value in section.items())
                            for number, section in sections.items()))
    return list(sections)[1:]


def find_pause(script: list[Lines]) -> int:
    """The master of a simulated wire reads a frame by itself each 100 ms, from init_ms on, a multiple of 5 ms. What the
    script wants from it must not wait for that: all of the script is so much later."""
    moments = [int(words[0]) for words in script if word_of(words[1]) in ("latch", "read", "write")]
    return next(later for later in range(0, GRID, FRAME // 2) if all((at + later) % GRID > FRAME for at in moments))


class Player:
    """A rig, to which a script happens; `numbers` are those of its encoders, "" of one that is alone."""

    def __init__(self, rig: Lines, path: Path, kind: str, script: list[Lines], numbers: Lines) -> None:
        self.kind = kind
        self.number = ""  # of the encoder that lines of SCPI are for
        self.later = find_pause(script) if numbers == [""] else 0
        self.rig = subprocess.Popen([*rig, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.levels: list[tuple[int, int]] = []
        self.on = False
        # An encoder of a rig has power from the first moment on: here it has had none before the script says so.
        for self.number in numbers:
            self.order(BEGIN - self.later, "scpi POW OFF")
        if WIRES[kind] == BUS:
            self.order(BEGIN - self.later, say(CHANNEL))

    def order(self, at: int, line: str) -> str:
        """Let the rig do it, and tell what the encoder has sent. @return its answer"""
        assert self.rig.stdin and self.rig.stdout
        how, _, text = line.partition(" ")
        if self.number and how != "send":
            line = f"{how} INST:SEL e{self.number};:{text}"
        self.rig.stdin.write(f"{at + self.later} {line}\n")
        self.rig.stdin.flush()
        self.levels = []
        for said in self.rig.stdout:
            if not said.startswith("@"):
                return said.partition(" ")[2].strip()
            moment, kind, *words = said.split()
            if kind == "levels":
                self.levels.append((int(words[0]), int(words[1])))
            else:
                print(f"  @{int(moment[1:]) - self.later}", kind, *words)
        raise EOFError

    def perform(self, at: int, name: str, words: Lines) -> str:
        """@return the operation's answer"""
        self.number, _, name = name.rpartition(":")
        if name == "latch":
            line, later = FRAMES[self.kind]
            return latch(self.order(at - later, f"clock {line}"), self.levels)
        self.on = words[0] == "1" if name == "power" else self.on
        if name in ("read", "write") and not self.on and not self.number:
            return f" {NO_POWER}{' ;' if name == 'read' else ''}"
        lines = WORDS[name](*words) if name in WORDS else [f"scpi {line}" for line in steer(name, *words)]
        answer = [self.order(at, line) for line in lines][-1]
        if name == "read":
            return self.read_on(at, answer, int(words[0]))
        if name == "write":
            return f" {write_count(answer, words)}"
        return ANSWERS[name](answer) if name in ANSWERS else f" {result_of(answer)}"

    def read_on(self, at: int, answer: str, address: int) -> str:
        """The rig answers all or an error, which names the register: then those in front of it."""
        refused = re.search(r"register ([0-9A-F]+)h", answer)
        if refused and int(refused[1], 16) > address:
            answer = self.order(at, read(str(address), str(int(refused[1], 16) - address))[0])
        if answer.startswith("-"):
            return f" {fail(answer)} ;"
        data = bytes(int(word, 0) for word in answer.split(","))
        return f" {len(data)} {data.hex()};"

    def close(self) -> None:
        assert self.rig.stdin
        self.rig.stdin.close()
        if self.rig.wait() != 0:
            raise SystemExit(self.rig.returncode)


def play(rig: Lines, head: Lines, script: list[Lines], path: Path) -> None:
    print(" ".join(head))
    numbers = [""]
    if head[1] in SHARED:
        numbers = write_shared_rig(path, head[1], script)
    else:
        write_rig(path, head[1], [words[2:] for words in script if words[1] == "set"])
    player = Player(rig, path, kind_of(head[1]), script, numbers)
    for number, (at, name, *words) in enumerate(script, 1):
        answer = player.perform(int(at), name, words) if word_of(name) not in ("set", "encoder") else " 0"
        print(f"{number} {name}{answer}", flush=True)
    player.close()


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for head, *script in read_scripts(sys.stdin):
            play(sys.argv[1:], head, script, Path(folder, "it.ini"))


if __name__ == "__main__":
    main()
