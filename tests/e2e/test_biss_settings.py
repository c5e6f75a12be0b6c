# SPDX-License-Identifier: MIT
"""What `--set` makes of a BiSS encoder, as a master on the simulated wire sees it."""
import re

import pytest

from rig import run, run_refused
from test_biss import assert_positions

S3674 = "s3674-biss"
S3684 = "s3684-biss"


def biss(*arguments) -> str:
    ended = run("biss", *arguments)
    assert ended.returncode == 0 and ended.stderr == "", ended.stderr
    return ended.stdout


def settings(*assignments) -> list:
    return [word for assignment in assignments for word in ("--set", assignment)]


@pytest.mark.parametrize("mt, st", [(0, 12), (12, 24), (24, 24)])
def test_widths(mt, st, tmp_path):
    trace = tmp_path / "biss.vcd"
    said = biss(S3684, "read", "registers", "0x7A", "2", "--shaft", "90DEG",
                *settings(f"mt={mt}", f"st={st}"), "--trace", trace)
    assert f"ST {1 << st - 2} " in said and "CRC valid" in said
    assert assert_positions(trace.read_text(), 1 << st - 2, width=mt + st) > 0
    assert said.splitlines()[1] == f"{0xC0 | mt:02X} {st:02X}"


@pytest.mark.parametrize("stop_bit", ["own", "early"])
def test_both_stop_bits_give_the_same_bytes(stop_bit):
    chosen = settings(f"stop_bit={stop_bit}")
    assert biss(S3674, "registers", "0x7E", "2", *chosen) == "4B 55\n"
    assert biss(S3674, "write", "0x22", "01", "02", "registers", "0x22", "2", *chosen) == "01 02\n"
    assert biss(S3674, "write", "31:0x3F", "A5", "registers", "31:0x3F", "1", *chosen) == "A5\n"
    assert "0x24 (36): refused" in run_refused(1, "biss", S3674, "registers", "0x22", "3", *chosen)
    assert "0x41 (65): refused" in run_refused(1, "biss", S3674, "write", "0x40", "03", "04", *chosen)


def test_a_command_that_is_not_taken():
    """Its own stop bit says so."""
    silent = settings("eeprom_acknowledges=0")
    assert "0x60 (96): refused" in run_refused(1, "biss", S3674, "write", "0x60", "01", *silent)


def test_status_of_a_healthy_encoder():
    assert biss(S3674, "registers", "0x60", "1") == "93\n"


def test_busy_is_told_in_the_data_sheet():
    """TBUSY_S in steps of 250 ns: 5.5 us at least."""
    assert biss(S3674, "registers", "3:0x0C", "1") == "16\n"
    assert biss(S3674, "registers", "3:0x0C", "1", *settings("busy_us=5", "busy_jitter_us=10")) == "3C\n"
    assert biss(S3674, "registers", "3:0x0C", "1", *settings("busy_us=5.5", "busy_jitter_us=0.1")) == "17\n"


def test_slo_at_the_start(tmp_path):
    """The first level of SLO that changes: up at e1, or down at e2."""
    for low, first in (("1", "1s"), ("0", "0s")):
        trace = tmp_path / f"{low}.vcd"
        biss(S3674, "read", "--trace", trace, *settings(f"sl_low_at_start={low}"))
        changes = trace.read_text().split("$end\n")[-1]
        rising = changes.index("\n1m\n")
        assert re.search(r"^[01]s$", changes[rising:], re.M)[0] == first


@pytest.mark.parametrize("assignment, right", [
    ("st=7", "a number in 8..32"), ("st=33", "a number in 8..32"), ("mt=33", "a number in 0..32"),
    ("busy_us=41", "a number in 0..40"), ("busy_jitter_us=40.001", "a number in 0..40"),
    ("busy_us=5.5555", "with at most 3 decimals"),
    ("busy_jitter_us=x", "a number in 0..40"), ("sl_low_at_start=2", "0 or 1"),
    ("stop_bit=late", "own or early"), ("stop_bit=", "own or early"), ("stop_bit=1", "own or early"),
    ("stop_bit", ""),
])
def test_refused_settings(assignment, right, tmp_path):
    line = run_refused(2, "biss", S3674, "read", "--set", assignment)
    assert assignment in line and right in line
    assert right in run_refused(2, "run", S3674, "--sim", "--set", assignment)


def test_a_mistyped_key_names_all_there_are():
    """Those of the encoder, not only those of its world, and those of the wire."""
    line = run_refused(2, "run", S3674, "--sim", "--set", "busy=3")
    said = line.split("valid: ")[1]
    for key in ("mt", "busy_us", "stop_bit", "init_ms", "temperature", "watchdog_fired"):
        assert key in said.split("; of the wire: ")[0].split()
    assert said.split("; of the wire: ")[1].split() == ["clock_hz", "line_delay_ns", "compensate"]


@pytest.mark.parametrize("model, own", [("f3658", False), ("f3668", True)])
def test_a_mistyped_key_of_a_canopen_encoder(model, own):
    said = run_refused(2, "run", model, "--slcan", "--set", "pase=1").split("valid: ")[1]
    assert ("mt_bits" in said.split()) == own and said.split("; of the wire: ")[1].split() == ["pace"]


def test_busy_and_its_jitter_together(tmp_path):
    """In any order, since each alone is in its range."""
    both = ["busy_us=30", "busy_jitter_us=11"]
    for chosen in (both, both[::-1]):
        line = run_refused(2, "biss", S3674, "read", *settings(*chosen))
        assert "busy_us 30 and busy_jitter_us 11; expected at most 40 together" in line
    line = run_refused(2, "biss", S3674, "read", *settings("busy_us=34.5", "busy_jitter_us=5.6"))
    assert "busy_us 34.5 and busy_jitter_us 5.6; expected at most 40 together" in line
    biss(S3674, "read", *settings("busy_jitter_us=5.5", "busy_us=34.5"))
    biss(S3674, "read", *settings("busy_jitter_us=40", "busy_us=0"))
    rig = tmp_path / "rig.ini"
    rig.write_text(f"[encoder a]\nmodel = {S3674}\nwire = sim\nbusy_us = 30\nbusy_jitter_us = 11\n",
                   encoding="ascii")
    line = run_refused(2, "run", rig)
    assert "rig.ini:1: " in line and "at most 40 together" in line


def test_a_timeout_is_for_gpio_lines(tmp_path):
    """The simulated wire has the encoder's own one."""
    words = "timeout_us: the simulated wire has the encoder's own timeout; only with gpio"
    for command in (("run", S3674, "--sim"), ("biss", S3674, "read")):
        assert words in run_refused(2, *command, *settings("timeout_us=100"))
    rig = tmp_path / "rig.ini"
    rig.write_text(f"[encoder a]\nmodel = {S3674}\nwire = sim\ntimeout_us = 100\n", encoding="ascii")
    line = run_refused(2, "run", rig)
    assert "rig.ini:4: " in line and "only with gpio" in line


def test_help_names_them():
    said = re.sub(r"\n {10,}", " ", run("--help").stdout)  # lines that go on
    for key in ("busy_us", "busy_jitter_us", "sl_low_at_start", "stop_bit"):
        assert re.search(rf"^  {key} .*\)$", said, re.M)
    assert "(own or early)" in said and "singleturn bits (8..32)" in said


HINT = ("SLO is low until the first MA pulse (BiSS C6, Bus reset); a master that waits for SLO = 1 hangs here: send a "
        "pulse, or set sl_low_at_start=0")


def hints(*arguments) -> list:
    """What a second of a rig tells."""
    ended = run("run", *arguments, "--time", "virtual:1S")
    assert ended.returncode == 0, ended.stderr
    return ended.stderr.splitlines()


def test_a_line_without_a_pulse_is_told_once(tmp_path):
    """The master of the simulated wire clocks when the encoder is initialised, which here is late."""
    late = ("--set", "init_ms=600")
    assert hints(S3684, "--sim", *late) == [f"drehgeber: {S3684}: {HINT}"]
    rig_file = tmp_path / "rig.ini"
    rig_file.write_text("[bus b]\nwire = sim\n" + "".join(
        f"[encoder {name}]\nmodel = {S3674}\nbus = b\ninit_ms = 600\n" for name in "xyz"), encoding="ascii")
    assert hints(rig_file) == [f"drehgeber: x: {HINT}"]
    for never in (late + ("--set", "hint_us=0"), late + ("--set", "sl_low_at_start=0"), late + ("--set", "hint_us=700000"),
                  late + ("-q",), ()):
        assert hints(S3684, "--sim", *never) == []
