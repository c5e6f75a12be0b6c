# SPDX-License-Identifier: MIT
"""BiSS over GPIO character devices: `--gpio CHIP:CLOCK,DATA`, with libgpiod 1.x and 2.x."""
import re
import subprocess
import time

import pytest

import rig
from conftest import LINES, MA, SLO, Master

HALF_US = 2000  # 250 Hz: an emulated machine takes a millisecond for what it does for the first time
PAUSE_US = 70000
DEFAULT_PAUSE_US = 25000  # a timeout of 20 ms
ATTEMPTS = 5
SINGLETURN = (0, 21, 6)
MULTITURN = (12, 21, 6)
QUARTER = 1 << 19


def read(master: Master, widths=SINGLETURN) -> tuple:
    """MT, ST, nERR, nWARN, LC of a frame whose CRC is right."""
    *numbers, verdict, rate_hz = master.run("position", *widths).split()
    assert verdict == "valid", f"at {rate_hz} Hz"
    return tuple(map(int, numbers))


@pytest.fixture
def master(chip) -> Master:
    return Master(chip, HALF_US, PAUSE_US)


def test_position(chip, library, start, master):
    encoder = start("--shaft", "90DEG")
    assert encoder.ready_line == f"ready s3674-biss gpio:{chip.name}:{MA},{SLO}"
    assert re.search(rf": libgpiod {library}\.\d", encoder.errors.wait())
    assert [read(master) for _ in range(3)] == [(0, QUARTER, 1, 1, life) for life in range(3)]
    # What the kernel took, it took for us.
    users = subprocess.run(["gpioinfo", chip.name], capture_output=True, text=True, check=True)
    assert users.stdout.count('"drehgeber"') == 2
    assert encoder.end() == 0


def test_slo_is_low_until_the_first_clock(chip, start, master):
    encoder = start("--quiet")
    slo = chip.line(SLO) / "value"
    assert slo.read_text().strip() == "0"
    assert read(master) == (0, 0, 1, 1, 0)
    assert slo.read_text().strip() == "1"
    assert encoder.end() == 0


def test_default_timeout(chip, start):
    """Frames 25 ms apart; a machine that is held up for 20 ms inside a frame may try again."""
    start("--quiet", timeout_us=None)
    master = Master(chip, HALF_US, DEFAULT_PAUSE_US)
    tried = [master.attempt("position", *SINGLETURN) for _ in range(ATTEMPTS)]
    assert [said for said in tried if re.fullmatch(r"0 0 1 1 \d+ valid \d+", said)], tried


def test_rate_is_measured_and_told(start, master):
    encoder = start(model="s3684-biss")
    encoder.errors.wait()
    for life in range(6):
        assert read(master, MULTITURN) == (0, 0, 1, 1, life)
    line = encoder.errors.wait()
    if "of 1 frames" in line:  # the first one of a cold program was late
        line = encoder.errors.wait()
    said = re.search(r"within (\d+) us of the kernel's time of an edge: a clock up to (\d+) Hz works "
                     r"for all of (\d+) frames seen \(99\.9 % is known after 3000\); .* unknown", line)
    reaction_us, rate_hz, frames = map(int, said.groups())
    print(line)
    assert frames in (5, 6)
    assert 500000 // (reaction_us + 1) <= rate_hz <= 500000 // max(reaction_us, 1)


def test_registers(start, master, tmp_path):
    arguments = ["--quiet", "--nvm", tmp_path / "encoder.nvm"]
    encoder = start(*arguments)
    assert master.run("read", "78", 8) == "04 00 C0 15 00 00 4B 55"
    master.run("write", "40", "07")
    master.run("write", "10", "01A5FF005A3C80")
    assert master.run("read", "0F", 9) == "FF 01 A5 FF 00 5A 3C 80 FF"
    assert encoder.end() == 0
    start(*arguments)
    master.attempt("position", *SINGLETURN)  # a cold program in an emulated machine may be late for it
    master.run("write", "40", "07")
    assert master.run("read", "10", 7) == "01 A5 FF 00 5A 3C 80"


def test_trace(start, master, tmp_path):
    """A frame has 33 clocks and the CDM bit: 2 levels of MA each."""
    trace = tmp_path / "gpio.vcd"
    encoder = start("--quiet", "--shaft", "90DEG", "--trace", trace)
    read(master)
    assert encoder.end() == 0
    names = dict(reversed(found) for found in
                 re.findall(r"\$var wire 1 (\S+) (\w+) ", trace.read_text()))
    changes = re.findall(rf"^[01]{re.escape(names['MA'])}$", trace.read_text(), re.M)
    assert len(changes) >= 66


def test_clock_that_is_too_fast(start, master):
    """Seven clocks before the encoder gets to run: they are caught up with, and it says so."""
    encoder = start("--quiet", "--shaft", "90DEG")
    assert read(master) == (0, QUARTER, 1, 1, 0)
    master.run("rush", 7)
    line = rig.assert_one_line(encoder, "too fast")
    assert re.search(r"6 times SLO was set later than half a period .* at most [1-9]\d* Hz "
                     r"for all of \d+ frames seen", line)
    # Not one clock was forgotten: that was one frame.
    assert read(master) == (0, QUARTER, 1, 1, 2)
    master.run("rush", 7)
    assert read(master) == (0, QUARTER, 1, 1, 4)


def test_lost_edges(library, start, master):
    """More edges than the kernel keeps: they are missed, and the next frame is a good one."""
    encoder = start("--quiet", "--shaft", "90DEG")
    read(master)
    master.run("rush", {"1": 40, "2": 2000}[library])
    assert "too fast" in encoder.errors.wait()
    assert "lost" in rig.assert_one_line(encoder)
    assert read(master) == (0, QUARTER, 1, 1, 2)


def test_chip_that_goes(chip, start, master):
    """It is said once, and the encoder goes on as soon as a chip with this label is back."""
    encoder = start("--shaft", "90DEG", chip=chip.label)
    assert encoder.ready_line == f"ready s3674-biss gpio:{chip.label}:{MA},{SLO}"
    assert read(master)[1] == QUARTER
    assert "libgpiod" in encoder.errors.wait()
    chip.live(False)
    assert "gone" in encoder.errors.wait()
    time.sleep(0.5)  # until the lines have been given back
    chip.live(True)  # with another number, perhaps
    chip.power_on_master()
    assert "back" in encoder.errors.wait()
    assert read(Master(chip, HALF_US, PAUSE_US))[1] == QUARTER


def refuse(where: str, status: int = 1, **options) -> str:
    return rig.run_refused(status, "run", "s3674-biss", "--gpio", where, **options)


@pytest.mark.parametrize("where", ["", "gpiochip0", "gpiochip0:4", "gpiochip0:4,4", "gpiochip0:4,",
                                   ":4,5", "gpiochip0:4,5,6", "gpiochip0:-4,5", "gpiochip0:4,65536"])
def test_wrong_words(library, where):
    assert "CHIP:CLOCK,DATA" in refuse(where, 2)


def test_lines_that_cannot_be_had(chip, library, start):
    assert "no /dev/gpiochip77" in refuse("gpiochip77:4,5")
    assert "no GPIO chip" in refuse("/dev/null:4,5")
    assert f"{LINES} lines" in refuse(f"{chip.name}:{MA},{LINES}")
    assert "permission" in refuse(f"{chip.name}:{MA},{SLO}", user=65534)
    start("--quiet")
    assert f"line {SLO} is in use" in refuse(f"{chip.name}:{MA},{SLO}")
    assert f"line {MA} is in use" in refuse(f"/dev/{chip.name}:{MA},{SLO + 1}")


def test_other_wires(library):
    """What is for the simulated wire is refused."""
    wire = ["s3674-biss", "--gpio", "gpiochip0:4,5"]
    assert "run s3674-biss --gpio" in rig.run_refused(2, "biss", *wire, "read")
    assert "wire" in rig.run_refused(2, "run", "f3668", "--gpio", "gpiochip0:4,5")
