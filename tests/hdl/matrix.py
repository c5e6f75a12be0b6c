# SPDX-License-Identifier: MIT
"""What the matrices share: benches compiled by Verilator, scripts, and few wires that have every pair of values."""

import itertools
import os
import re
import resource
import subprocess
from pathlib import Path

TESTS = Path(__file__).parent
MODELS = TESTS.parents[1] / "platform" / "hdl"
LIBRARY = os.environ["DREHGEBER_HDL"]
WHOLE = {"pairs": False, "whole": True}[os.environ["DREHGEBER_WIRES"]]


def compiled(folder, protocol):
    """The program of PROTOCOL_bench.sv."""
    done = subprocess.run(
        ["verilator", "--binary", "--timing", "-O3", "--top-module", f"{protocol}_bench", "--Mdir", folder, "-o", "bench",
         "-Wno-lint", "-Wno-INITIALDLY", "-CFLAGS", "-O1", f"-I{MODELS}", f"-I{folder}", TESTS / f"{protocol}_bench.sv",
         MODELS / f"drehgeber_{protocol}.sv", MODELS / "master" / f"{protocol}_master.v", "-LDFLAGS",
         f"-L{LIBRARY} -ldrehgeber_hdl -Wl,-rpath,{LIBRARY}"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stdout
    return folder / "bench"


def run(bench, folder, script, **wire):
    """What it says, checks, microseconds of simulated time; it fails when a check does."""
    (folder / "script").write_text("\n".join(script) + "\n", encoding="ascii")
    words = [f"+{key}={value}" for key, value in wire.items()]
    done = subprocess.run([bench, f"+script={folder}/script", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=1500, check=False)
    said = re.search(r"^passed ([1-9]\d*) checks in (\d+) us$", done.stdout, re.M)
    assert done.returncode == 0 and said, f"{words}\n{done.stdout[-3000:]}"
    return done.stdout, int(said[1]), int(said[2])


def pairs(cells):
    """Few cells that have every pair of values: greedy, the same each time."""
    pairs_of = lambda cell: set(itertools.combinations(enumerate(cell), 2))
    left = set().union(*map(pairs_of, cells))
    while left:
        best = max(cells, key=lambda cell: len(pairs_of(cell) & left))
        left -= pairs_of(best)
        yield best


def run_all(cells, one, capsys):
    """`one(i, cell)` for every wire, or for few that have every pair; says what that was."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    figures = [one(i, cell)[1:] for i, cell in enumerate(cells if WHOLE else pairs(cells))]
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    checks, us = map(sum, zip(*figures))
    with capsys.disabled():
        print(f"\n{len(figures)} wires: {checks} checks in {us} simulated us, {us / seconds:.0f} us in a second of CPU")
