# SPDX-License-Identifier: MIT
"""`drehgeber verify` as a master on the kernel's lines, with libgpiod 1.x and 2.x. Lines belong to one program, so master and
encoder have a chip each, and a thread is the cable."""
import os
import subprocess
import threading
import time

import pytest

import rig
from conftest import MA as CLOCK
from conftest import PATIENCE_S, Chip
from conftest import SLO as DATA

LOOK_S = 0.0001  # between looks at lines that rest; the guest has one processor for all three
ATTEMPTS = 5
MONOFLOP_US = 60000  # a busy machine holds up its guest for 20 ms and more
CLAUSE = "R-2"  # a word of 13 bits comes again after 14 clocks


class Cable(threading.Thread):
    """Carries the clock from one chip to the other, and data back."""

    def __init__(self, master: Chip, encoder: Chip):
        super().__init__(daemon=True)
        self.ways = [(os.open(source.line(line) / "value", os.O_RDONLY), os.open(sink.line(line) / "pull", os.O_WRONLY))
                     for source, sink, line in ((master, encoder, CLOCK), (encoder, master, DATA))]
        self.stopping = threading.Event()

    def run(self):
        levels = [b"", b""]
        while not self.stopping.is_set():
            for way, (value, pull) in enumerate(self.ways):
                level = os.pread(value, 1, 0)
                if level != levels[way]:
                    levels[way] = level
                    os.pwrite(pull, b"pull-up" if level == b"1" else b"pull-down", 0)
            time.sleep(LOOK_S)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stopping.set()
        self.join(PATIENCE_S)
        for value, pull in self.ways:
            os.close(value)
            os.close(pull)


@pytest.fixture
def other():
    made = Chip("drehgeber-master")
    yield made
    made.remove()


@pytest.fixture
def encoder(chip, library):
    """The command tries fast clocks first, of which the encoder complains."""
    one = rig.Encoder(["ssi-13", "--gpio", f"{chip.name}:{CLOCK},{DATA}", "--quiet", "--set", f"monoflop_us={MONOFLOP_US}",
                       "--shaft", "90DEG"])
    yield one
    assert [line for line in one.clean_up() if "too fast" not in line and "were lost" not in line] == []


def ask(master: Chip) -> subprocess.CompletedProcess:
    """Again, if the guest was held up for so long that no clock was slow enough."""
    for _ in range(ATTEMPTS):
        ended = subprocess.run([rig.PROGRAM, "verify", "ssi-13", f"--gpio={master.name}:{CLOCK},{DATA}", CLAUSE],
                               stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S)
        if "no word that ends with a 0" not in ended.stderr:
            break
    return ended


def test_a_word_that_comes_again(chip, other, encoder):
    with Cable(other, chip):
        ended = ask(other)
    assert ended.returncode == 0, (ended.stdout, ended.stderr)
    assert f"agrees   {CLAUSE}" in ended.stdout
    assert encoder.end() == 0
