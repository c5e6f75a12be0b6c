# SPDX-License-Identifier: MIT
"""The masters against the models: those in Verilog in Icarus Verilog (wires.v), those in VHDL in GHDL (wires.vhd), on
twelve wires that have every pair of clock, cable, processing time and chain, with a register each. test_matrix.py has
the rest, in Verilator. Encoders of files of models have masters of other widths (sold.v). A simulator that is missing
fails.

usage: with DREHGEBER_HDL, the folder of libdrehgeber_hdl.so
"""

import os
import re
import subprocess
from pathlib import Path

import pytest

BENCHES = Path(__file__).parent
MODELS = BENCHES.parents[1] / "platform" / "hdl"
LIBRARY = os.environ["DREHGEBER_HDL"]
CLOCKS = ((50, 20), (50, 10), (10, 5))  # 500 kHz, 1 MHz, 10 MHz: clock in ns, half a period of MA in clocks
CABLES = (10, 30, 50)
BUSY = ("0", "3", "5.5", "20")
CHAINS = (1, 2, 3)
WIRES = [(CLOCKS[(i + j) % 3], cable, busy, CHAINS[(i + 2 * j) % 3])
         for i, cable in enumerate(CABLES) for j, busy in enumerate(BUSY)]


def call(folder, *command):
    done = subprocess.run(command, cwd=folder, env=os.environ | {"LD_LIBRARY_PATH": LIBRARY}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture(scope="module", name="icarus")
def make_icarus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("icarus")
    call(folder, "iverilog-vpi", "--name=drehgeber", f"-I{MODELS}", MODELS / "drehgeber_vpi.c", f"-L{LIBRARY}",
         "-ldrehgeber_hdl")

    def run(wire, top="wires"):
        parameters = [f"-P{top}.{key}={value}" for key, value in wire.items()]
        call(folder, "iverilog", "-g2005-sv", f"-I{MODELS}", "-s", top, *parameters, "-o", "wires.vvp",
             BENCHES / f"{top}.v", *sorted(MODELS.glob("drehgeber_*.v")), *sorted(MODELS.glob("master/*.v")))
        return call(folder, "vvp", "-M.", "-mdrehgeber", "wires.vvp")

    return run


@pytest.fixture(scope="module", name="ghdl")
def make_ghdl(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ghdl")
    models = [MODELS / f"drehgeber_{kind}.vhd" for kind in ("hdl", "biss", "ssi")]
    call(folder, "ghdl", "-a", "--std=08", *models, *sorted(MODELS.glob("master/*.vhd")), BENCHES / "wires.vhd")
    call(folder, "ghdl", "-e", "--std=08", "wires")

    def run(wire):
        return call(folder, "ghdl", "-r", "--std=08", "wires", *(f"-g{key}={value}" for key, value in wire.items()))

    return run


@pytest.mark.parametrize("simulator", ["icarus", "ghdl"])
@pytest.mark.parametrize("clock,cable,busy,chain", WIRES)
def test_positions_and_registers(request, simulator, clock, cable, busy, chain):
    quote = '"' if simulator == "icarus" else ""
    wire = {"CLOCK_NS": clock[0], "HALF": clock[1], "CABLE_NS": cable, "CHAIN": chain,
            "SETTINGS": f"{quote}busy_us={busy}{quote}", "SEED": clock[1] + cable + chain}
    said = request.getfixturevalue(simulator)(wire)
    assert re.search(r"\bpassed [1-9]\d* checks in \d+ us$", said, re.M), said


def test_encoders_of_files(icarus, tmp_path):
    """26 and 32 bits over BiSS, of the catalogue; 40 bits over SSI."""
    (tmp_path / "forty.ini").write_text("[model forty]\nbase = ssi-25\nmt = 16\nst = 24\n[model other]\nbase = ssi-13\n")
    sold = BENCHES.parents[1] / "tools" / "models" / "renishaw.ini"
    said = icarus({"NARROW": f'"{sold}:renishaw-resolute-26"', "WIDE": f'"{sold}"',
                   "SSI": f'"{tmp_path}/forty.ini:forty"', "SEED": 3}, "sold")
    assert re.search(r"^passed 67 checks in \d+ us$", said, re.M), said
