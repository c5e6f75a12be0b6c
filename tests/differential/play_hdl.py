# SPDX-License-Identifier: MIT
"""The player of the models for HDL simulators, in Icarus Verilog. README.md has the language.

usage: play_hdl.py FOLDER, which has libdrehgeber_hdl.so"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from scpi import result_of, steer
from script import read_scripts

HERE = Path(__file__).parent
MODELS = HERE.parents[1] / "platform" / "hdl"
BEGIN = 1_000_000_000
# The models' clock-to-output, ns: what they document is taken off moments.
LATE = {"biss": 10, "ssi": 150, "rs485": 10}
SAMPLE = 200  # ns behind an edge: the level is there, and the next edge is not
BIT = 1_000_000_000 / 9600
CHARACTER, BITS = 1_145_834, 11  # ns, as a handle's master sends it; start, 8, even parity, stop
NO_POWER = -9
LOW, HIGH, SCPI, POSITION, LEVEL = 0, 1, 4, 5, 6
BEHIND = 2  # and 3: it is high

Order = tuple[int, int, str]  # ns, kind, text
Asked = tuple[int, int, str, int]  # and the number of its line


def kind_of(model: str) -> str:
    return next(word for word in model.split("-") if word in LATE)


def build(folder: Path, library: str) -> None:
    subprocess.run(["iverilog-vpi", "--name=drehgeber", f"-I{MODELS}", MODELS / "drehgeber_vpi.c", f"-L{library}",
                    "-ldrehgeber_hdl"], cwd=folder, check=True, stdout=sys.stderr)


def simulate(folder: Path, model: str, settings: str, orders: list[Order]) -> list[str]:
    text = "".join(f"{round(at * 1000)} {kind} {words}\n" for at, kind, words in orders)
    (folder / "play.orders").write_text(text)
    subprocess.run(["iverilog", "-g2005-sv", f"-I{MODELS}", f"-D{kind_of(model).upper()}", f'-DMODEL="{model}"',
                    f'-DSETTINGS="{settings}"', "-s", "play", "-o", "play.vvp", HERE / "hdl" / "play.v",
                    MODELS / f"drehgeber_{kind_of(model)}.v"], cwd=folder, check=True)
    done = subprocess.run(["vvp", "-M.", "-mdrehgeber", "play.vvp"], cwd=folder, check=True, stdout=subprocess.PIPE,
                          text=True)
    return done.stdout.splitlines()


# ------------------------------------------------------------ what an operation is for the model

def send(at: int, data: bytes) -> list[Order]:
    """The levels of the characters' bits, least significant first."""
    orders = []
    for number, byte in enumerate(data):
        levels = [0, *(byte >> i & 1 for i in range(8)), byte.bit_count() & 1, 1]
        begin = at + number * CHARACTER
        orders += [(begin + i * BIT, level, "") for i, level in enumerate(levels)]
    return orders


def clock(at: int, half: int, count: int) -> list[Order]:
    orders: list[Order] = []
    for i in range(count):
        edge = at + (i + 1) * half
        orders += [(edge, i & 1, ""), (edge + SAMPLE, LEVEL, "")]
    return orders


def orders_of(at: int, name: str, words: list[str]) -> list[Order]:
    if name == "bytes":
        return send(at, bytes.fromhex(words[0]))
    if name == "edges":
        return clock(at, int(words[0]), int(words[1]))
    if name == "chain":
        return [(at, BEHIND + int(words[0]), "")]
    if name == "position":
        return [(at, POSITION, "")]
    lines = [line for line in steer(name, *words) for line in (line, "SYST:ERR?")]
    return [(at, SCPI, line) for line in lines]


# ------------------------------------------------------------ what it does, for the log

def characters(changes: list[tuple[int, int]]) -> list[tuple[int, str]]:
    """What a receiver of 8E1 takes: each bit in its middle."""
    found = []
    free = 0.0
    for number, (at, level) in enumerate(changes):
        if level or at < free:
            continue
        free = at + (BITS - 0.5) * BIT
        byte = 0
        for i in range(8):
            byte |= [high for when, high in changes[number : number + BITS + 1] if when <= at + (i + 1.5) * BIT][-1] << i
        found.append((round(at + BITS * BIT), f"byte {byte:02x}"))
    return found


def orders_of_script(script: list[list[str]]) -> list[Asked]:
    """What is done, in time, each with the number of its line; -1: no line of the script."""
    # A model has power from its first ns on: here it has none before the script says so.
    orders: list[Asked] = [(10, SCPI, "POW OFF", -1)]
    for number, (at, name, *words) in enumerate(script):
        orders += [(*order, number) for order in (orders_of(int(at), name, words) if name != "set" else [])]
    orders.append((int(script[-1][0]) + BEGIN // 10, POSITION, "", -1))
    return sorted(orders, key=lambda order: order[0])


def answers_of(said: list[str], orders: list[Asked]) -> dict[int, list[str]]:
    """What each line of the script was answered."""
    texts = [line[1:].strip() for line in said if line[0] == "="]
    answers: dict[int, list[str]] = {}
    for text, order in zip(texts, (order for order in orders if order[1] >= SCPI), strict=True):
        answers.setdefault(order[3], []).append(text)
    return answers


def events_of(said: list[str], kind: str) -> list[tuple[int, str]]:
    """What the wire did."""
    moves = [line[1:].split() for line in said if line[0] == "@" and line[-1] in "01"]
    changes = [(round(int(at) / 1000) - LATE[kind], int(level)) for at, level in moves]
    return characters(changes) if kind == "rs485" else [(at, f"edge {level}") for at, level in changes]


def play(folder: Path, head: list[str], script: list[list[str]]) -> None:
    model = head[1]
    settings = {"init_ms": "100"} | {words[2]: words[3] for words in script if words[1] == "set"}
    orders = orders_of_script(script)
    said = simulate(folder, model, " ".join(f"{key}={value}" for key, value in settings.items()),
                    [order[:3] for order in orders])
    events = events_of(said, kind_of(model))
    tell(head, script, answers_of(said, orders), [event for event in events if event[0] >= BEGIN])


def tell(head: list[str], script: list[list[str]], answers: dict[int, list[str]], events: list[tuple[int, str]]) -> None:
    """The log."""
    print(" ".join(head))
    on = False
    for number, (at, name, *words) in enumerate(script):
        while events and events[0][0] <= int(at):
            print("  @{} {}".format(*events.pop(0)))
        on = words[0] == "1" if name == "power" else on
        print(f"{number + 1} {name}{answer_of(name, answers.get(number, []), on)}")
    for event in events:
        print("  @{} {}".format(*event))


def answer_of(name: str, answers: list[str], on: bool) -> str:
    if name == "shaft":
        return ""
    if name == "edges":
        return " " + "".join(answers)
    if name == "position":
        return f" 0 {int(answers[0]):x}" if on else f" {NO_POWER} 0"
    return f" {result_of(answers[-1])}" if answers else " 0"


def main() -> None:
    library = os.path.abspath(sys.argv[1])
    os.environ["LD_LIBRARY_PATH"] = library
    with tempfile.TemporaryDirectory() as folder:
        build(Path(folder), library)
        for head, *script in read_scripts(sys.stdin):
            play(Path(folder), head, script)


main()
