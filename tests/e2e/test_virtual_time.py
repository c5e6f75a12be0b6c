# SPDX-License-Identifier: MIT
"""run --time virtual:SPAN: a whole rig lives from deadline to deadline, and ends."""
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rig import MULTITURN, PATIENCE_S, PROGRAM, run, run_refused

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/python"))
import drehgeber  # noqa: E402

RIG = """
[rig]
control = unix:{folder}/rig.sock
[shaft motor]
motion = 60RPM
[encoder a]
model = s3684-rs485
wire = pty
trace = {folder}/a.vcd
[encoder b]
model = f3668
wire = slcan
nvm = {folder}/b.nvm
[encoder c]
model = s3684-biss
wire = sim
[encoder d]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
trace = {folder}/d.csv
"""
BISS = ("run", "s3684-biss", "--sim", "--shaft", "60RPM")


@pytest.fixture
def rig(tmp_path):
    path = tmp_path / "rig.ini"
    path.write_text(RIG.format(folder=tmp_path))
    return path


def test_a_minute_of_every_wire_passes_in_seconds(rig):
    """With a ring that cycles each millisecond, and traces; also with sanitizers."""
    begin = time.monotonic()
    ended = run("run", rig, "--time", "virtual:1MIN")
    assert ended.returncode == 0 and ended.stderr == "", ended.stderr
    assert ended.stdout.splitlines()[-1] == "ready rig"
    assert time.monotonic() - begin < PATIENCE_S
    last = re.findall(r"^#(\d+)$", (rig.parent / "a.vcd").read_text(), re.M)[-1]
    assert 59e6 < int(last) <= 60e6 + 1  # us; a file ends behind its last event
    assert (rig.parent / "b.nvm").stat().st_size


@pytest.mark.parametrize("span, seconds", [("2500MS", 2), ("2.5s", 2), ("1MIN", 59), ("1H", 3599)])
def test_it_ends_when_the_span_is_over(span, seconds):
    """The master of the simulated wire says once a second where it is."""
    rows = run(*BISS, "--time", f"virtual:{span}").stdout.splitlines()
    assert rows[-1].startswith(f"MT {seconds} "), rows[-1]
    assert abs(len(rows) - 1 - seconds) <= 1


def test_the_same_comes_out_each_time():
    assert run(*BISS, "--time=virtual:5MIN").stdout == run(*BISS, "--time=virtual:5MIN").stdout


def test_the_world_goes_on(tmp_path):
    """The master reads once a second."""
    (tmp_path / "lost.csv").write_text("0,1\n2.5,0\n4.5,1\n6,1\n")
    rows = run(*BISS, "--time=virtual:20S", "--set", f"singleturn_ok={tmp_path}/lost.csv,LOOP").stdout.splitlines()
    lost = [second for second, row in enumerate(rows[1:]) if "nERR 0" in row]
    assert lost == [second for second in range(20) if 2.5 <= second % 6 < 4.5]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_before(number):
    process = subprocess.Popen([PROGRAM, *BISS, "--time", "virtual:8760H"], stdout=subprocess.PIPE)
    process.stdout.readline()
    process.send_signal(number)
    assert process.stdout.read() is not None
    assert process.wait(PATIENCE_S) == 0


def test_clients_are_served_on_the_way(rig):
    address = f"unix:{rig.parent}/rig.sock"
    process = subprocess.Popen([PROGRAM, "run", rig, "--time", "virtual:8760H"], stdout=subprocess.PIPE, text=True)
    try:
        for line in process.stdout:
            if line == "ready rig\n":
                break
        control = drehgeber.Control(address)
        before = float(control.ask("TIME?"))
        end = time.monotonic() + PATIENCE_S
        while float(control.ask("TIME?")) < before + 20:
            assert time.monotonic() < end
        control.close()
    finally:
        process.terminate()
        assert process.wait(PATIENCE_S) == 0
        process.stdout.close()


RIGHT = "expected virtual:10MIN, virtual:2.5S or virtual:1H, for example"


@pytest.mark.parametrize(
    "time_, right",
    [(time_, RIGHT) for time_ in ("10MIN", "virtual", "virtual:", "virtual:10", "virtual:0S", "virtual:-1S",
                                  "virtual:1.0005S", "virtual:8761H", "real:1S", "virtual:1E3S")],
)
def test_what_is_no_span(time_, right):
    assert right in run_refused(2, "run", MULTITURN, "--pty", "--time", time_)


def test_real_wires_have_real_time():
    said = run_refused(2, "run", MULTITURN, "--tty", "/dev/null", "--time", "virtual:1S")
    assert "tty has real time; expected pty, rs485, sim, slcan, " in said


def test_who_does_not_run_has_no_time():
    assert "no option --time" in run_refused(2, "list", "--time", "virtual:1S")
