# SPDX-License-Identifier: MIT
"""The command and Rig have one reader of rig files: they take and refuse the same ones, and for the same line."""
import os
import re
import subprocess
from pathlib import Path

import pytest
from drehgeber import EncoderError, Rig

TREE = Path(__file__).resolve().parents[2]
# The others are of other programs; tests/golden has what some of them were, so the same one is there twice.
TEXTS = {path.read_bytes(): path for path in sorted(TREE.glob("[tdp]*/**/*.ini"))}
FILES = [path for text, path in TEXTS.items() if b"[encoder " in text]
ENCODER = "[encoder a]\nmodel = f3668\nwire = slcan\n"
RATIO = "[shaft a]\n[shaft b]\ndriver = a\nratio = {}\n" + ENCODER
GEARS = "[shaft s0]\n" + "".join(f"[shaft s{i}]\ndriver = s{i - 1}\n" for i in range(1, 10))
ON_BUS = "[encoder {}]\nmodel = f3668\nbus = b\n"
BUS = "[bus b]\nwire = slcan\n"

GOOD = {
    "other tools": "\ufeff[encoder a]\r\n  model = f3668\r\n\twire:slcan ; no CAN here\r\n\r\n  # the end\r\nnode=7",
    "comments": "; a\n[shaft a] ; b\n[shaft b] # c\nmotion = 0 ;d\n" + ENCODER,
    "two of [rig]": "[rig]\nname = a\n[rig]\nfiles = .\n" + ENCODER,
    "controls": "[rig]\ncontrol = unix:a\ncontrol = unix:b\n" + ENCODER,
    "names": "[shaft A-1]\n[encoder B_2]\nmodel = f3668\nwire = slcan\nshaft = a-1\n",
    "gears": GEARS.rpartition("[shaft")[0] + ENCODER,
    "a negative gear": RATIO.format("-1:10"),
    "a sign": RATIO.format("+1:-10"),
    "a long line": ENCODER + "; " + "x" * 196,
    "a bus": BUS + "pace = 1\n" + ON_BUS.format("x") + "node = 1\n" + ON_BUS.format("y") + "node = 2\n",
    "many": BUS + ON_BUS.format("x") + "node = 1..127\nserial = 1000\n",
    "many addresses": "[bus b]\nwire = pty\n[encoder a]\nmodel = s3684-rs485\nbus = b\naddress = 0x40..42h\n",
    "keys of a wire": "[encoder a]\nmodel = s3684-biss\nwire = sim\nclock_hz = 100000\n",
    "no value": ENCODER + "; node =\n",
}

# A file, and the line that is wrong; 0: all of it.
BAD = {
    "nothing": ("", 0),
    "a comment": ("; nothing\n", 0),
    "no encoder": ("[shaft a]\n", 0),
    "no section": ("model = f3668\n", 1),
    "unknown section": ("\n[foo]\n", 2),
    "section of another case": ("[Encoder a]\n", 1),
    "no word": ("[]\n", 1),
    "no name": ("[encoder]\n", 1),
    "two names": ("[encoder a b]\n", 1),
    "a dot": ("[encoder a.b]\n", 1),
    "a long name": (f"[encoder {'a' * 33}]\n", 1),
    "a rig's name": ("[rig bench]\n", 1),
    "no bracket": ("[encoder a\nmodel=f3668\n", 1),
    "more behind it": ("[encoder a] wire = can\n", 1),
    "a comment for a value": ("[encoder a]\nmodel ; = f3668\n", 2),
    "no word at the end": (ENCODER + "so be it", 4),
    "no key": (ENCODER + " = 5\n", 4),
    "a key of another case": ("[encoder a]\nModel = f3668\nwire = slcan\n", 2),
    "an unknown key of [rig]": ("[rig]\ncolour = red\n", 2),
    "an unknown key of [shaft]": ("[shaft a]\nspeed = 1\n", 2),
    "an unknown key of [bus]": ("[bus b]\nwire = modbus\ncolour = 1\n", 3),
    "an unknown setting": (ENCODER + "nod = 5\n", 4),
    "a value": (ENCODER + "temperature = hot\n", 4),
    "out of range": (ENCODER + "node = 200\n", 4),
    "no such model": ("[encoder a]\nmodel = s3685\nwire = pty\n", 2),
    "no model": ("[encoder a]\nwire = pty\n", 1),
    "empty": (ENCODER + "serial =\n", 4),
    "empty name": ("[rig]\nname =\n", 2),
    "a name with a blank": ("[rig]\nname = a b\n", 2),
    "two names of a rig": ("[rig]\nname = a\n[rig]\nname = b\n", 4),
    "twice": ("[shaft a]\nmotion = 60RPM\nmotion = 70RPM\n", 3),
    "a shaft twice": ("[shaft a]\n[shaft A]\n", 2),
    "a bus twice": (BUS + "[bus B]\nwire = pty\n", 3),
    "an encoder twice": (ENCODER + "[encoder A]\nmodel = f3668\nwire = slcan\n", 4),
    "a bus's name": ("[bus A]\nwire = pty\n" + ENCODER, 3),
    "motion": ("[shaft a]\nmotion = fast\n", 2),
    "no time": ("[shaft a]\nmotion = ramp:3000RPM,0S\n", 2),
    "no driver": ("[shaft a]\ndriver = b\n", 2),
    "itself": ("[shaft a]\ndriver = a\n", 2),
    "a ratio of nothing": ("[shaft a]\nratio = 1:2\n", 2),
    "motion and driver": ("[shaft a]\n[shaft b]\nmotion = 60RPM\ndriver = a\n", 3),
    "too many gears": (GEARS, 19),
    "shafts behind encoders": (ENCODER + "[shaft x]\n", 4),
    "no shaft": (ENCODER + "shaft = x\n", 4),
    "a bus without a wire": ("[bus b]\n", 1),
    "a bus without encoders": (BUS, 1),
    "no bus": (ON_BUS.format("a"), 3),
    "somebody's wire": (ENCODER + "[encoder b]\nmodel = f3668\nbus = a\n", 6),
    "a bus and a wire": (BUS + ENCODER + "bus = b\n", 6),
    "kind and address": ("[bus b]\nwire = slcan:/x\n" + ON_BUS.format("a"), 2),
    "another bus": (BUS + "[encoder a]\nmodel = s3684-rs485\nbus = b\n", 5),
    "another address": (ENCODER + "address = 0x41\n", 4),
    "no number": ("[encoder a]\nmodel = ocd-ib-k3\nwire = modbus\nnode = 5\n", 4),
    "the same node": (BUS + ON_BUS.format("x") + "node = 5\n" + ON_BUS.format("y") + "node = 5\n", 10),
    "a range from behind": (BUS + ON_BUS.format("x") + "node = 3..2\n", 6),
    "a range of no number": (BUS + ON_BUS.format("x") + "node = 1..x\n", 6),
    "a range without an end": (BUS + ON_BUS.format("x") + "node = 1..\n", 6),
    "a range beyond": (BUS + ON_BUS.format("x") + "node = 120..130\n", 6),
    "a range without a bus": (ENCODER + "node = 1..3\n", 3),
    "a range with a long name": (BUS + ON_BUS.format("x" * 31) + "node = 1..3\n", 3),
    "a range across another": (BUS + ON_BUS.format("x") + "node = 1..3\n" + ON_BUS.format("y") + "node = 3..4\n", 10),
    "as delivered": (BUS + ON_BUS.format("x") + ON_BUS.format("y"), 6),
    "an EEPROM of two": (ENCODER + "nvm = x\n[encoder b]\nmodel = f3668\nwire = slcan\nnvm = x\n", 8),
    "a trace of a bus": (BUS + ON_BUS.format("a") + "trace = x.log\n", 6),
    "a key of a bus": (BUS + ON_BUS.format("a") + "pace = 1\n", 6),
    "an encoder without a wire": ("[encoder a]\nmodel = f3668\n", 1),
    "a kind of wire": ("[bus b]\nwire = rope\n" + ON_BUS.format("a"), 2),
    "a wire that it has not": ("[encoder a]\nmodel = f3668\nwire = pty\n", 3),
    "a wire's address": ("[encoder a]\nmodel = f3668\nwire = can\n", 3),
    "a key of another wire": (BUS + "cycle = 1000\n" + ON_BUS.format("a"), 3),
    "a wire's value": (BUS + "pace = often\n" + ON_BUS.format("a"), 3),
    "a private wire's value": ("[encoder a]\nmodel = ssi-25\nwire = sim\nclock_hz = 5\n", 4),
    "a control address": ("[rig]\ncontrol = tcp\n" + ENCODER, 2),
    "an included file": ("[rig]\ninclude = none.ini\n" + ENCODER, 2),
    "a long line": (ENCODER + "; " + "x" * 197, 4),
    "a zero": (ENCODER + "\0\n", 4),
} | {f"ratio {text}": (RATIO.format(text), 4) for text in ("0:1", "1:0", "1", "1.5:1", "1:2:3", "x:1", ":", "1:", "3000000000:1")}

def told_by_command(path):
    """Whether the command takes it, and what it says of it. Nothing is opened."""
    ended = subprocess.run(
        [os.environ["DREHGEBER"], "run", path.name, "--time", "virtual:1MS", "--control", f"unix:{path.parent}/s"],
        cwd=path.parent, capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    return ended.returncode == 0, ended.stderr.removeprefix("drehgeber: ").removesuffix("\n")


def told_by_rig(path):
    try:
        Rig(path)
    except EncoderError as error:
        return False, str(error)
    return True, ""


def line_of(text):
    found = re.search(r"\.ini:(\d+): ", text)
    return int(found[1]) if found else 0


@pytest.fixture
def rig_file(tmp_path):
    def write(text):
        path = tmp_path / "rig.ini"
        path.write_bytes(text.encode())
        return path

    return write


@pytest.mark.parametrize("name", GOOD)
def test_both_take(name, rig_file):
    path = rig_file(GOOD[name])
    assert told_by_command(path)[0] and told_by_rig(path)[0]


@pytest.mark.parametrize("name", BAD)
def test_both_refuse_for_the_same_line(name, rig_file):
    """In the same words."""
    text, line = BAD[name]
    path = rig_file(text)
    taken, said = told_by_command(path)
    assert (taken, line_of(said)) == (False, line)
    assert told_by_rig(path) == (False, said)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_files_of_the_tree(path, tmp_path):
    """Without making their wires: as an FMU the command reads one whole."""
    ended = subprocess.run(
        [os.environ["DREHGEBER"], "fmu", path, "--output", tmp_path / "a.fmu"], capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr
    assert Rig(path).encoders
