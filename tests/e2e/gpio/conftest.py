# SPDX-License-Identifier: MIT
"""Fixtures of the GPIO tests: the program with either libgpiod, and a simulated chip (gpio-sim)."""
import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import rig  # noqa: E402

MASTER = os.environ.get("DREHGEBER_GPIO_MASTER", "")
PROGRAMS = {"1": rig.PROGRAM, "2": os.environ.get("DREHGEBER_GPIOD2_PROGRAM", "")}
LINES = 8
MA, SLO = 4, 5
PATIENCE_S = 120.0  # a master takes its time
TIMEOUT_US = 60000  # a busy machine holds up its guest for 20 ms and more


def pytest_sessionstart():
    for program in (MASTER, *PROGRAMS.values()):
        if not os.access(program, os.X_OK):
            pytest.exit(f"no program at '{program}': run tools/check, or build with "
                        "DREHGEBER_GPIOD2", returncode=1)


class Chip:
    """A chip of the kernel's simulator."""

    def __init__(self, name: str):
        self.label = f"{name}-label"
        self.config = Path("/sys/kernel/config/gpio-sim") / name
        (self.config / "bank").mkdir(parents=True)
        (self.config / "bank/num_lines").write_text(str(LINES))
        (self.config / "bank/label").write_text(self.label)
        self.live(True)

    def power_on_master(self):
        """MA is high when it is idle."""
        (self.line(MA) / "pull").write_text("pull-up")

    def live(self, on: bool):
        (self.config / "live").write_text(str(int(on)))
        self.name = (self.config / "bank/chip_name").read_text().strip()
        device = (self.config / "dev_name").read_text().strip()
        self.folder = Path("/sys/devices/platform") / device / self.name

    def line(self, offset: int) -> Path:
        return self.folder / f"sim_gpio{offset}"

    def remove(self):
        self.live(False)
        (self.config / "bank").rmdir()
        self.config.rmdir()


class Master:
    """A BiSS master on MA and SLO, in a process of its own."""

    def __init__(self, chip: Chip, half_us: int, pause_us: int):
        self.arguments = [MASTER, chip.line(MA), chip.line(SLO), half_us, pause_us]

    def _run(self, *action) -> subprocess.CompletedProcess:
        return subprocess.run([str(word) for word in (*self.arguments, *action)],
                              stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=PATIENCE_S)

    def attempt(self, *action) -> str:
        """What came of it, good or bad."""
        ended = self._run(*action)
        return (ended.stdout or ended.stderr).strip()

    def run(self, *action) -> str:
        ended = self._run(*action)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout.strip()


@pytest.fixture
def chip():
    made = Chip("drehgeber")
    made.power_on_master()
    yield made
    made.remove()


@pytest.fixture(params=sorted(PROGRAMS))
def library(request, monkeypatch) -> str:
    """Major version of libgpiod; rig's Encoder is the program with it."""
    monkeypatch.setattr(rig, "PROGRAM", PROGRAMS[request.param])
    return request.param


@pytest.fixture
def start(chip, library):
    """Start encoders on the chip; each is ended, and nothing unasked was said."""
    running = []

    def begin(*arguments, model="s3674-biss", timeout_us=TIMEOUT_US,
              chip=chip.name) -> rig.Encoder:
        timeout = [] if timeout_us is None else ["--set", f"timeout_us={timeout_us}"]
        timeout += ["--set", "hint_us=0"] if "biss" in model else []  # masters come late, or never, here
        running.append(rig.Encoder([model, "--gpio", f"{chip}:{MA},{SLO}", *timeout,
                                    *arguments]))
        return running[-1]

    yield begin
    said = [line for encoder in running for line in encoder.clean_up()]
    # The first frame of a cold program may be late on an emulated machine; what else is late is told of more frames.
    assert [line for line in said if "too fast" not in line or "of 1 frames" not in line] == []
