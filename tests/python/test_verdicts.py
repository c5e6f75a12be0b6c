# SPDX-License-Identifier: MIT
"""Rig files and mutants of them: Python says what the record of the command's reader says (tests/golden)."""
import os
import re
import subprocess
from pathlib import Path

from drehgeber import EncoderError
from drehgeber.plan import Plan

RIGS = Path(__file__).resolve().parents[1] / "golden" / "rigs"
NAME = "rig.ini"
SHOWN = 10
SECTION = re.compile(rb"\[(.*)\]\n")
TEXT = re.compile(rb"(\d+) (\d+)\n")


def texts():
    """The file, the seed and the text of each."""
    command = [os.environ["DREHGEBER_VERDICTS"], "--texts", RIGS]
    data, at, name = subprocess.run(command, capture_output=True, check=True, timeout=60).stdout, 0, ""
    while at < len(data):
        if section := SECTION.match(data, at):
            name, at = section[1].decode(), section.end()
        else:
            seed = TEXT.match(data, at)
            end = seed.end() + int(seed[2])
            yield name, int(seed[1]), data[seed.end():end]
            at = end + 1


def recorded():
    """What is said of each; '@3' stands for the third of what would be right."""
    lines, right, name = {}, {}, ""
    for line in (RIGS / "verdicts.record").read_text(encoding="ascii").splitlines():
        if line.startswith("["):
            name = line[1:-1]
        elif name == "right":
            number, right[number] = line.split(" ", 1)
        else:
            seed, said = line.split(" ", 1)
            lines[name, int(seed)] = said
    return {place: re.sub(r"@\d+$", lambda found: right[found[0]], said) for place, said in lines.items()}


def verdict(text):
    """Printable, and without the name of the file."""
    try:
        Plan(NAME, text, RIGS)
    except EncoderError as error:
        data = str(error).encode("utf-8", "surrogateescape").replace(NAME.encode(), b"")
        return "".join(chr(byte) if b" "[0] <= byte <= b"~"[0] else f"\\x{byte:02X}" for byte in data)
    return "taken"


def test_every_verdict_is_the_record():
    was = recorded()
    now = {(name, seed): verdict(text) for name, seed, text in texts()}
    differ = [(place, was.get(place), said) for place, said in now.items() if was.get(place) != said]
    assert now.keys() == was.keys() and len(now) > 5000
    assert not differ, f"{len(differ)} differ: {differ[:SHOWN]}"
