# SPDX-License-Identifier: MIT
"""The models of platform/hdl in the simulators that Debian has: what their lines do is the same in each of them,
defects and power included, with the same seed and with no other one; wrong settings end a simulation with one line.

usage: with DREHGEBER_HDL, the folder of libdrehgeber_hdl.so, and DREHGEBER, the command
"""

import os
import re
import resource
import subprocess
from pathlib import Path

import pytest

TESTS = Path(__file__).parent / "models"
MODELS = Path(__file__).parents[2] / "platform" / "hdl"
DECODERS = Path(__file__).parents[2] / "tools" / "sigrok"
LIBRARY = os.environ["DREHGEBER_HDL"]
# The VPI module's source as a user compiles it, or an object that counts what it runs.
VPI = os.environ.get("DREHGEBER_VPI", str(MODELS / "drehgeber_vpi.c")).split(" ")
ENVIRONMENT = os.environ | {"LD_LIBRARY_PATH": LIBRARY}


def call(folder, *command):
    """Build something. What it says is shown when it fails."""
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout


def verilator(folder, top, *more):
    models = [MODELS / f"drehgeber_{kind}.sv" for kind in ("biss", "ssi", "rs485")]
    call(folder, "verilator", "--binary", "--timing", "--top-module", top, "--Mdir", top, "-o", top,
         f"-I{MODELS}", "-CFLAGS", "-O0", *more, TESTS / f"{top}.sv", *models, "-LDFLAGS", f"-L{LIBRARY} -ldrehgeber_hdl")
    return [f"{top}/{top}"]


def icarus(folder, top):
    call(folder, "iverilog-vpi", "--name=drehgeber", f"-I{MODELS}", *VPI, f"-L{LIBRARY}", "-ldrehgeber_hdl")
    call(folder, "iverilog", "-g2005-sv", f"-I{MODELS}", "-s", top, "-o", f"{top}.vvp", TESTS / f"{top}.sv",
         *sorted(MODELS.glob("drehgeber_*.v")))
    return ["vvp", "-M.", "-mdrehgeber", f"{top}.vvp"]


def ghdl(folder, top):
    models = [MODELS / f"drehgeber_{kind}.vhd" for kind in ("hdl", "biss", "ssi", "rs485")]
    call(folder, "ghdl", "-a", "--std=08", *models, TESTS / f"{top}.vhd")
    call(folder, "ghdl", "-e", "--std=08", top)
    return ["ghdl", "-r", "--std=08", top]


POWER_ON = 1000  # ps
SIMULATORS = {"verilator": verilator, "icarus": icarus, "ghdl": ghdl}


def run(folder, command):
    return subprocess.run(command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=240, check=False)


def lines_of(text):
    """Name: its changes in their order, from the first moment on; what is undefined before it is no change."""
    changes = {}
    for name, us, ps, level in re.findall(r"^(\w+) (\d+) (\d+) ([01])$", text, re.M):
        changes.setdefault(name, []).append((int(us) * 1000000 + int(ps), int(level)))
    return {name: [change for change in rows if change[0] > 0] for name, rows in changes.items()}


@pytest.fixture(scope="module", name="traces")
def make_traces(tmp_path_factory):
    traces = {}
    for name, build in SIMULATORS.items():
        folder = tmp_path_factory.mktemp(name)
        done = run(folder, build(folder, "trace"))
        assert done.returncode == 0 and "done\n" in done.stdout, done.stdout
        traces[name] = lines_of(done.stdout)
    return traces


def test_a_line_does_the_same_in_every_simulator(traces):
    assert sorted(traces["verilator"]) == ["a", "b", "behind", "c", "data", "de", "near", "tx"]
    for name, rows in traces["verilator"].items():
        assert len(rows) > 1, name
        for other in ("icarus", "ghdl"):
            # A procedure in VHDL acts at the next look, which `POLL` bounds: 1 us.
            mine = [level for at, level in rows]
            assert [level for at, level in traces[other][name]] == mine, f"{name} in {other}"
            for (at, _), (there, _) in zip(rows, traces[other][name]):
                assert 0 <= there - at <= (1000000 if other == "ghdl" else 0), f"{name} in {other} at {at} ps"


def test_the_same_seed_is_the_same_trace_and_another_is_none(traces):
    for lines in traces.values():
        assert lines["a"] == lines["b"]
        assert lines["a"] != lines["c"]


HINT = ("SLO is low until the first MA pulse (BiSS C6, Bus reset); a master that waits for SLO = 1 hangs here: send a "
        "pulse, or set sl_low_at_start=0")


@pytest.mark.parametrize("name", SIMULATORS)
def test_what_registers_do_before_power_on_is_no_pulse(tmp_path, name):
    """`pulsing` alone sends one. The others are told why a master may hang, of a chain the last one only."""
    done = run(tmp_path, SIMULATORS[name](tmp_path, "start"))
    assert done.returncode == 0 and "done\n" in done.stdout, done.stdout
    levels = re.findall(r"^(zero|unknown|at_once|pulsing|late|near|data) ([01])$", done.stdout, re.M)
    assert dict(levels) == {"zero": "0", "unknown": "0", "at_once": "0", "pulsing": "1", "late": "0", "near": "0", "data": "1"}
    hints = [line for line in done.stdout.splitlines() if HINT in line]
    assert len(hints) == 5 and len(set(hints)) == 5, done.stdout


@pytest.mark.parametrize("name", SIMULATORS)
def test_a_simulation_that_ends_early_has_the_hint_at_its_end(tmp_path, name):
    done = run(tmp_path, SIMULATORS[name](tmp_path, "short"))
    assert done.returncode == 0 and done.stdout.count(HINT) == 1, done.stdout
    assert done.stdout.index("done\n") < done.stdout.index(HINT)


@pytest.mark.parametrize("name", SIMULATORS)
def test_ssi_is_late_enough_for_a_master_that_looks_for_the_1(tmp_path, name):
    """TR-ECE-BA-DGB-0131, p. 69: tV > 100 ns, so that a 'pause 1' is read behind the first rising edge. 90 degrees are
    2048 of 8192, C00h in Gray code."""
    done = run(tmp_path, SIMULATORS[name](tmp_path, "pause"))
    assert done.returncode == 0 and re.search(r"^word 0*c00$", done.stdout, re.M | re.I), done.stdout


def test_sigrok_decodes_what_a_simulator_dumps(tmp_path):
    """In steps of 1 ps, of which `downsample` makes 10 ns."""
    run(tmp_path, [*icarus(tmp_path, "pause"), "+vcd"])
    done = subprocess.run(["sigrok-cli", "-i", "pause.vcd", "-I", "vcd:downsample=10000", "-P", "ssi:clock=clock:data=data",
                           "-A", "ssi=position"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=os.environ | {"SIGROKDECODE_DIR": str(DECODERS), "PYTHONDONTWRITEBYTECODE": "1"}, timeout=60,
                          check=False)
    assert done.stdout == "ssi-1: MT 0 ST 2048\n"


def test_a_master_that_looks_for_the_1_needs_the_delay(tmp_path):
    done = run(tmp_path, verilator(tmp_path, "pause", "-DTCO_NS=10.0"))
    assert "no pause" in done.stdout


def test_delays_are_what_was_asked_for(traces):
    """MA rises at 1500 ns for the first time: SLO of `near` and `behind`, low before, follows by its TCO alone."""
    lines = {name: [change for change in rows if change[0] > POWER_ON] for name, rows in traces["verilator"].items()}
    assert lines["near"][0] == (1500000 + 10000, 1)
    assert lines["behind"][0] == (1500000 + 7250, 1)
    earliest = 1500000 + 12500 + 10000 + 33300
    assert earliest <= lines["a"][0][0] <= earliest + 8000


def test_the_driver_is_on_while_the_encoder_sends(traces):
    lines = traces["verilator"]
    (on, first), (off, last) = lines["de"]
    assert (first, last) == (1, 0)
    assert on == lines["tx"][0][0]
    bit = 10**12 // 9600
    assert abs(off - on - 7 * 11 * bit) < bit


@pytest.mark.parametrize("name", SIMULATORS)
def test_wrong_settings_end_the_simulation_with_one_line(tmp_path, name):
    done = run(tmp_path, SIMULATORS[name](tmp_path, "bad"))
    assert done.returncode != 0
    assert [line for line in done.stdout.split("\n") if "st=99: expected 8..32" in line], done.stdout
    assert "done" not in done.stdout


def test_a_test_bench_steers_and_asks(tmp_path):
    """ST of 12 bits, a frame's first rising edge, 60000 RPM for 250 us; sine and cosine of 1 V from peak to peak, 2048 periods in
    a turn."""
    done = run(tmp_path, icarus(tmp_path, "asked"))
    assert done.returncode == 0, done.stdout
    assert re.findall(r"^(\w+) (-?[\d. ]+)$", done.stdout, re.M) == [
        ("latched", "-1"), ("turn", "2048"), ("latched", "2048"), ("at", "200000.5"), ("speed", "3072"), ("motion", "512"),
        ("temperature", "41.500"), ("hot", "1"), ("power", "0"), ("volts", "0.00 0.50"), ("volts", "0.50 0.00")]
    assert done.stdout.endswith("done\n")


def test_others_steer_over_a_socket(tmp_path):
    """`drehgeber ctl` while the simulation runs: each fault of the wire as a master sees it."""
    def ctl(line):
        done = subprocess.run([os.environ["DREHGEBER"], "ctl", "--control", f"unix:{tmp_path}/steered.sock", line],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stdout
        return done.stdout.strip()

    command = verilator(tmp_path, "steered")
    with subprocess.Popen(command, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as simulation:
        try:
            assert simulation.stdout.readline() == "good\n"
            assert "s3684-biss" in ctl("*IDN?")
            for fault, seen in (("drop", "silent"), ("delay", "late"), ("damage", "damaged"), ("break", "silent")):
                ctl(f"FAULt:SET wire_{fault}")
                assert simulation.stdout.readline() == f"{seen}\n"
                ctl("FAULt:CLEar")
                assert simulation.stdout.readline() == "good\n"
            assert ctl("SHAFt:MOVE 180,6000RPM;*OPC?;POSition?") == "1;180.000000"
            assert simulation.stdout.readline() == "moved\n"
            ctl("SHAFt:POSition 0")
            assert "done\n" in simulation.communicate(timeout=120)[0]
            assert simulation.returncode == 0
        finally:
            simulation.kill()


def cpu_of(folder, command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = run(folder, command)
    assert done.returncode == 0, done.stdout
    simulated, ones = re.search(r"simulated_us (\d+) ones (\d+)", done.stdout).groups()
    assert int(ones) > 0
    return int(simulated) / max(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, 0.001)


def test_speed(tmp_path, capsys):
    """Printed, not judged: a machine may be busy."""
    (tmp_path / "dummy").mkdir()
    encoder = cpu_of(tmp_path, verilator(tmp_path, "speed", "-O3"))
    dummy = cpu_of(tmp_path / "dummy", verilator(tmp_path / "dummy", "speed", "-O3", "-DDUMMY", TESTS / "dummy.sv"))
    with capsys.disabled():
        print(f"\nVerilator: {encoder:.0f} simulated us in a second of CPU with the encoder, {dummy:.0f} with a dummy")
