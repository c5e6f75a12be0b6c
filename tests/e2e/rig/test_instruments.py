# SPDX-License-Identifier: MIT
"""The programs that talk to test instruments anyway: PyVISA and lxi-tools."""
import contextlib
import subprocess
import time

import pytest
import pyvisa

from bench import PATIENCE_S

RIG = """
[rig]
control = tcp:127.0.0.1:0
[encoder a]
model = s3684-biss
wire = sim
[encoder b]
model = s3674-biss
wire = sim
"""


@pytest.fixture(scope="module")
def port(start_once) -> str:
    return start_once(RIG).address("tcp").rpartition(":")[2]


@pytest.fixture
def instrument(port):
    with contextlib.closing(pyvisa.ResourceManager("@py")) as manager:
        with manager.open_resource(f"TCPIP::127.0.0.1::{port}::SOCKET", read_termination="\n",
                                   write_termination="\n", timeout=PATIENCE_S * 1000) as opened:
            yield opened


def test_pyvisa_identity(instrument):
    assert len(instrument.query("*IDN?").split(",")) == 4


def test_pyvisa_moves_a_shaft(instrument):
    begin = time.monotonic()
    instrument.write("SHAF:POS 0")
    instrument.write("SHAF:MOVE 90 DEG,60 RPM")
    assert instrument.query("*OPC?") == "1"
    assert time.monotonic() - begin >= 0.24
    assert instrument.query_ascii_values("SHAF:POS?") == [90.0]


def test_pyvisa_errors_and_lists(instrument):
    instrument.write("NONSENSE")
    assert instrument.query("SYST:ERR?").startswith('-113,"Undefined header')
    assert instrument.query("SYST:ERR?") == '0,"No error"'
    names = instrument.query_ascii_values("INST:CAT?", converter="s")
    assert [name.strip('"') for name in names] == ["a", "b"]


def lxi(port: str, command: str) -> str:
    ended = subprocess.run(["lxi", "scpi", "--raw", "--address", "127.0.0.1", "--port", port,
                            command], capture_output=True, text=True, timeout=PATIENCE_S)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_lxi(port):
    assert len(lxi(port, "*IDN?").split(",")) == 4
    lxi(port, "SHAF:POS 12.5")
    assert lxi(port, "SHAF:POS?").strip() == "12.500000"
