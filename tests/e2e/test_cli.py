# SPDX-License-Identifier: MIT
"""The command line: what it prints, what it refuses, and how."""
import os
import re
import time

import pytest

from rig import MULTITURN, SINGLETURN, STEPS_PER_TURN, run, run_refused

# Arguments, and what the one line has to name: what would be right.
USAGE_ERRORS = [
    ([], r"run"),
    (["turn"], r"run"),
    (["list", "everything"], r"list"),
    (["run"], r"MODEL|list|" + MULTITURN),
    (["run", "s3685-rs485"], r"list|" + MULTITURN),
    (["run", MULTITURN, "--can", "vcan0"], r"--pty"),
    (["run", MULTITURN, "--tty"], r"--tty"),
    (["run", MULTITURN, "--pty", "--tty", "/dev/null"], r"--pty|--tty"),
    (["run", MULTITURN, "--pty", "--frobnicate"], r"--help|--"),
    (["run", MULTITURN, "--pty", "--nvm"], r"--nvm"),
    (["run", MULTITURN, "--pty", "--shaft"], r"--shaft"),
    (["run", MULTITURN, "--pty", "--shaft", "fast"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "90"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "90DEGREES"], r"DEG|RPM|REV"),
    (["run", MULTITURN, "--pty", "--shaft", "sine:90DEG"], r"sine:|DEG"),
    (["run", MULTITURN, "--pty", "--shaft", "ramp:3000RPM,0S"], r"ramp:|RPM"),
    (["run", MULTITURN, "--pty", "--shaft", "1e999RPM"], r"RPM"),
    (["run", MULTITURN, "--pty", "--set", "pace"], r"KEY=VALUE|pace="),
    (["run", MULTITURN, "--pty", "--set", "colour=red"], r"pace|init_ms|line"),
    (["run", MULTITURN, "--pty", "--set", "init_ms=soon"], r"\d"),
    (["run", MULTITURN, "--pty", "--set", "init_ms=-1"], r"\d"),
    (["run", MULTITURN, "--pty", "--set", "line=maybe"], r"any"),
    (["run", MULTITURN, "--pty", "--serial", "1234567890"], r"9"),
    (["run", MULTITURN, "--pty", "--control"], r"--control ADDRESS"),
    (["run", MULTITURN, "--pty", "--control", "5025"], r"unix:PATH|tcp:HOST:PORT"),
    (["run", MULTITURN, "--pty", *["--control", "tcp:127.0.0.1:0"] * 5], r"4"),
    (["run", MULTITURN, "--node", "5"], r"--node 5"),
    (["run", "f3668", "--slcan", "--node", "5..4"], r"1\.\.127"),
    (["run", "f3668", "--slcan", "--node", "1..128"], r"1\.\.127"),
]

BAD_CSV = [
    ("0,0\n1,90\n2,banana\n", 3),
    ("0,0\n1,90\n0.5,180\n", 3),
    ("0,0\n1\n", 2),
]


def test_list():
    ended = run("list")
    assert (ended.returncode, ended.stderr) == (0, "")
    lines = ended.stdout.splitlines()
    assert {MULTITURN, SINGLETURN} <= {line.split()[0] for line in lines}
    for line in lines:
        if line.split()[0] in (MULTITURN, SINGLETURN):
            assert "RS485" in line and "2048" in line


def test_help():
    ended = run("--help")
    assert (ended.returncode, ended.stderr) == (0, "")
    for word in ["list", "run", "--pty", "--tty", "--nvm", "--serial", "--shaft", "--set"]:
        assert word in ended.stdout


def test_version():
    ended = run("--version")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert re.fullmatch(r"drehgeber \d+\.\d+\.\d+\S*\n", ended.stdout)


@pytest.mark.parametrize("arguments, right", USAGE_ERRORS, ids=lambda value: " ".join(value)
                         if isinstance(value, list) else "")
def test_usage_errors(arguments, right):
    line = run_refused(2, *arguments)
    assert re.search(right, line), line


def test_missing_device():
    line = run_refused(1, "run", MULTITURN, "--tty", "/dev/does-not-exist")
    assert "/dev/does-not-exist" in line


def test_ready_line(start, tmp_path):
    link = tmp_path / "encoder"
    for wire in [["--pty"], [f"--pty={link}"]]:
        encoder = start(wire=wire)
        found = re.fullmatch(rf"ready {MULTITURN} pty:(/\S+)", encoder.ready_line)
        assert found, encoder.ready_line
        assert re.fullmatch(r"/dev/pts/\d+", os.path.realpath(found[1]))
        assert encoder.out.so_far() == []
    assert os.path.realpath(link) == os.path.realpath(found[1])


def test_control_line(start):
    encoder = start("--control", "tcp:127.0.0.1:0")
    assert re.fullmatch(r"control tcp:127\.0\.0\.1:\d+", encoder.out.wait())


def turned(master, seconds: float) -> tuple[int, float, float]:
    """Counts turned over some time, and the bounds of that time."""
    def sample():
        before = time.monotonic()
        position = master.read_position()
        return before, position, time.monotonic()
    first = sample()
    time.sleep(seconds)
    last = sample()
    return last[1] - first[1], last[0] - first[2], last[2] - first[0]


@pytest.mark.parametrize("speed, counts_per_s", [("60RPM", 65536), ("-60RPM", -65536)])
def test_constant_speed(start, speed, counts_per_s):
    master = start("--shaft", speed, "--set", "pace=0").master()
    master.set_position(1 << 27)
    counts, shortest, longest = turned(master, 1.5)
    assert 0.99 * shortest * abs(counts_per_s) <= abs(counts) <= 1.01 * longest * abs(counts_per_s)
    assert (counts > 0) == (counts_per_s > 0)


def test_ramp(start):
    encoder = start("--shaft", "ramp:3000RPM,1S")
    master = encoder.master()
    time.sleep(max(0.0, encoder.ready + 1.05 - time.monotonic()))
    before = time.monotonic()
    turns = master.read_position() / STEPS_PER_TURN
    after = time.monotonic()
    # 25 turns in the first second, then 50 a second; it began between start and ready.
    assert 50 * (before - encoder.ready) - 26 <= turns <= 50 * (after - encoder.started) - 24
    counts, shortest, longest = turned(master, 0.5)
    assert 0.99 * shortest * 50 <= counts / STEPS_PER_TURN <= 1.01 * longest * 50


def test_sine(start):
    master = start("--shaft", "sine:90DEG,1S").master()
    master.set_position(1 << 27)
    positions = []
    end = time.monotonic() + 2.2
    while time.monotonic() < end:
        positions.append(master.read_position())
    # The preset was somewhere on the sine: only the span is known, twice 90 degrees.
    assert 0.95 * STEPS_PER_TURN / 2 <= max(positions) - min(positions) <= STEPS_PER_TURN / 2 + 1


def test_csv(start, tmp_path):
    motion = tmp_path / "motion.csv"
    motion.write_text("0,90\n0.001,180\n")
    encoder = start("--shaft", motion)
    assert encoder.master().read_position() == STEPS_PER_TURN // 2  # at rest behind its end


@pytest.mark.parametrize("text, number", BAD_CSV)
def test_csv_error_names_the_line(tmp_path, text, number):
    motion = tmp_path / "motion.csv"
    motion.write_text(text)
    ended = run("run", MULTITURN, "--pty", "--shaft", motion)
    assert ended.returncode in (1, 2) and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1
    assert re.search(rf"motion\.csv\D+{number}\b", ended.stderr), ended.stderr


def test_csv_with_byte_order_mark(start, tmp_path):
    motion = tmp_path / "motion.csv"
    motion.write_bytes(b"\xef\xbb\xbf0,90\r\n1,90\r\n")
    assert start("--shaft", motion).master().read_position() == 65536 // 4


def test_csv_missing(tmp_path):
    ended = run("run", MULTITURN, "--pty", "--shaft", tmp_path / "none.csv")
    assert ended.returncode in (1, 2) and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1 and "none.csv" in ended.stderr
