# SPDX-License-Identifier: MIT
"""SSI over GPIO character devices: `--gpio CHIP:CLOCK,DATA`, with libgpiod 1.x and 2.x. The master is
written from the public descriptions alone; it moves the clock through the simulated chip's `pull` file."""
import os
import time

import pytest

import rig
from conftest import MA as CLOCK
from conftest import SLO as DATA

HALF_S = 0.005  # the first bits of a cold program come late on an emulated machine
MONOFLOP_US = 60000  # a busy machine holds up its guest for 20 ms and more
PAUSE_S = 0.07
ATTEMPTS = 5


class Master:
    def __init__(self, chip):
        self.clock = os.open(chip.line(CLOCK) / "pull", os.O_RDWR)
        self.data = os.open(chip.line(DATA) / "value", os.O_RDONLY)

    def close(self):
        os.close(self.clock)
        os.close(self.data)

    def drive(self, level: int):
        os.pwrite(self.clock, b"pull-up" if level else b"pull-down", 0)
        time.sleep(HALF_S)

    def level(self) -> str:
        return os.pread(self.data, 1, 0).decode()

    def take(self, bits: int) -> str:
        """Data as it is when the clock is about to fall again."""
        taken = ""
        for _ in range(bits):
            self.drive(0)
            self.drive(1)
            taken += self.level()
        return taken

    def word(self, bits: int) -> str:
        """A single transmission: n + 1 clocks, and the monoflop time."""
        assert self.level() == "1", "data is low at rest: no supply"
        taken = self.take(bits + 1)
        time.sleep(PAUSE_S)
        assert taken[-1] == "0", f"no 0 behind the word {taken}"
        return taken[:-1]


def binary(gray: str) -> int:
    value = 0
    for bit in gray:
        value = value << 1 | (value & 1) ^ int(bit)
    return value


@pytest.fixture
def master(chip):
    made = Master(chip)
    yield made
    made.close()


@pytest.fixture
def encoder(start):
    def begin(model: str, *arguments) -> rig.Encoder:
        return start("--quiet", "--set", f"monoflop_us={MONOFLOP_US}", *arguments, model=model, timeout_us=None)

    return begin


def test_position(chip, library, encoder, master):
    device = encoder("ssi-13", "--shaft", "90DEG")
    assert device.ready_line == f"ready ssi-13 gpio:{chip.name}:{CLOCK},{DATA}"
    assert [binary(master.word(13)) for _ in range(3)] == [2048] * 3
    assert device.end() == 0


def test_multiturn_error_bit_and_parity(encoder, master):
    device = encoder("ssi-28", "--shaft", "3.5REV", "--set", "supply_mv=4000")
    word = master.word(30)
    assert int(word[:28], 2) == 3 << 16 | 1 << 15
    assert word[28] == "1" and word.count("1") % 2 == 0
    assert device.end() == 0


def test_the_word_comes_again_within_the_monoflop_time(encoder, master):
    device = encoder("ssi-25", "--shaft", "60RPM")
    for _ in range(ATTEMPTS):  # the guest may be held up for longer than the monoflop time
        both = master.take(52)
        time.sleep(PAUSE_S)
        if both[:26] == both[26:]:
            break
    assert both[:26] == both[26:] and both[25] == "0"
    assert binary(master.word(25)) > binary(both[:25])
    assert device.end() == 0


def test_an_interrupted_word_leaves_data_high(encoder, master):
    device = encoder("ssi-13", "--shaft", "90DEG")
    assert master.take(4) == "0110"
    time.sleep(PAUSE_S)
    assert master.level() == "1"
    assert binary(master.word(13)) == 2048
    assert device.end() == 0


def test_data_is_low_without_power(encoder, master, tmp_path):
    address = f"unix:{tmp_path}/ssi.sock"
    device = encoder("ssi-13", "--control", address)
    with rig.Client(address) as client:
        client.do("POW OFF")
        time.sleep(PAUSE_S)
        assert master.level() == "0"
        assert master.take(14) == "0" * 14
        client.do("POW ON")
        time.sleep(0.3)
        assert master.level() == "1"
        assert binary(master.word(13)) == 0
        state = dict(part.split("=") for part in client.ask("STAT?").split(","))
        assert (state["frames"], state["aborted"], state["wire_lost"]) == ("1", "0", "0")
    assert device.end() == 0
