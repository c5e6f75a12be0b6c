# SPDX-License-Identifier: MIT
"""The masters in Verilog against the models in Icarus Verilog (wires.v): nine wires that have every pair of clock,
cable and busy time, chains of one to three. A simulator that is missing fails.

usage: with DREHGEBER_HDL, the folder of libdrehgeber_hdl.so
"""

import os
import re
import subprocess
from pathlib import Path

import pytest

BENCH = Path(__file__).parent / "wires.v"
MODELS = Path(__file__).parents[2] / "platform" / "hdl"
LIBRARY = os.environ["DREHGEBER_HDL"]
# Half a period in 10 ns, cable in ns, busy, chain.
WIRES = [(50, 10, "0", 1), (50, 30, "3", 2), (50, 50, "20", 1), (5, 10, "3", 3), (5, 30, "20", 1), (5, 50, "0", 2),
         (20, 10, "20", 2), (20, 30, "0", 1), (20, 50, "3", 1)]


def call(folder, *command):
    done = subprocess.run(command, cwd=folder, env=os.environ | {"LD_LIBRARY_PATH": LIBRARY}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.mark.parametrize("half,delay,busy,chain", WIRES)
def test_positions_and_registers(tmp_path, half, delay, busy, chain):
    call(tmp_path, "iverilog-vpi", "--name=drehgeber", f"-I{MODELS}", MODELS / "drehgeber_vpi.c", f"-L{LIBRARY}",
         "-ldrehgeber_hdl")
    wire = {"HALF": half, "DELAY_NS": f"{delay}.0", "CHAIN": chain, "SETTINGS": f'"busy_us={busy}"', "SEED": half + delay}
    call(tmp_path, "iverilog", "-g2005-sv", f"-I{MODELS}", "-s", "wires", *(f"-Pwires.{key}={is_}" for key, is_ in wire.items()),
         "-o", "wires.vvp", BENCH, *sorted(MODELS.glob("drehgeber_*.v")), *sorted(MODELS.glob("master/*.v")))
    said = call(tmp_path, "vvp", "-M.", "-mdrehgeber", "wires.vvp")
    assert re.search(r"^passed [1-9]\d* checks in \d+ us$", said, re.M), said
