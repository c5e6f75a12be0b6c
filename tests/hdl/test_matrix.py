# SPDX-License-Identifier: MIT
"""The BiSS-C master of platform/hdl/master against the encoders in Verilator: one program (biss_bench.sv), which does
what a script says on a wire that its arguments say. Clock x cable x processing time x chain; every register and bank;
everything that can happen to the encoder, as the master sees it; and the master in VHDL beside that in Verilog.

usage: with DREHGEBER_HDL, the folder of libdrehgeber_hdl.so; DREHGEBER, the program; DREHGEBER_WIRES: `pairs` (every
pair of values at least once, and of the user banks the first and the last one) or `whole`

A script has lines `COMMAND TEXT A B C D`; what is not named is 0:

  frame A, random A, spin A   so many frames: as it stands, each at a random angle, each at a random angle and speed
  broken - A                  one frame that ends with this status; TEXT crc: and with a wrong CRC
  expect A B C                nERR, nWARN from now on; C 0: words are not judged
  offset A                    counts, of the first encoder
  fault TEXT A, power A       of the first encoder with a processing time of 3 us
  read|write A B C D          ID, address, value (-1: told, as `TEXT ID address value status`), status
  read_on|write_on A B C D    the same for C registers, the status of the last one; written is address * 7 + 1
  damage A B C D              1: Ack, 2: start bit, 3: now, and B clocks later C ? a flipped bit : SL stuck at D
  mend; sl A; wait A          SL is whole again; is at this level; microseconds
"""

import itertools
import json
import os
import re
import subprocess

import pytest
from matrix import MODELS, TESTS, WHOLE, compiled, run, run_all

HALVES = (100, 50, 5)  # 500 kHz, 1 MHz, 10 MHz, in clocks of 10 ns
DELAYS = (10, 20, 30, 40, 50)
BUSY = (0, 1, 2, 3)  # 0, 3, 5.5, 20 us
CHAINS = (1, 2, 3)

REFUSED, NO_ANSWER, LINE = 1, 4, 5
NO_ACK, NO_START, NO_STOP, NO_TIMEOUT = 1, 2, 3, 4
AT_ACK, AT_START, NOW = 1, 2, 3
EMASK, WMASK, BANK, STATUS, ERRORS, TEMPERATURE = 0x22, 0x23, 0x40, 0x60, 0x69, 0x6A
HEALTHY = 0x93
EDS, USER = (3, 4), range(7, 32)


def command(op, *numbers, text="-"):
    return " ".join([op, text, *map(str, [*numbers, 0, 0, 0, 0][:4])])


def read(address, value, status=0, who=0, text="-"):
    return command("read", who, address, value, status, text=text)


def write(address, value, status=0, who=0):
    return command("write", who, address, value, status)


@pytest.fixture(scope="module", name="bench")
def make_bench(tmp_path_factory):
    """The program, compiled once."""
    return compiled(tmp_path_factory.mktemp("bench"), "biss")


def told(said, text):
    return [int(value) for value in re.findall(rf"^{text} \d+ \d+ (\d+) 0$", said, re.M)]


def test_every_wire(bench, tmp_path, capsys):
    """Random angles, at rest and turning; in one encoder a register is read, and one is written and read."""
    def one(i, cell):
        half, delay, busy, chain = cell
        slot = i % chain
        who = chain - 1 - slot  # the last one has ID 0
        script = [command("random", 20), command("spin", 5), command("random", 1), read(0x47, 0xE9 + slot, who=who),
                  write(EMASK, 0xA5 ^ i, who=who), read(EMASK, 0xA5 ^ i, who=who), read(0x47, 0, NO_ANSWER, chain)]
        return run(bench, tmp_path, script, half=half, delay=delay, busy=busy, chain=chain, seed=i + 1)

    run_all(list(itertools.product(HALVES, DELAYS, BUSY, CHAINS)), one, capsys)


# What page 5.2.2.2 has in bank 0 and outside of banks.
READABLE = {*range(0x1B, 0x24), *range(0x40, 0x48), *range(0x60, 0x6C), *range(0x78, 0x80)}
WRITABLE = {*range(0x1B, 0x24), BANK, STATUS, 0x7C}
HELD = {0x1B: 0xC7}  # the other bits read 0: README, 13
IDENTITY = {0x41: 0x03, 0x42: 0x62, 0x43: 35, 0x46: 0x03, 0x47: 0xE9, STATUS: HEALTHY, ERRORS: 0x00,
            **dict(zip(range(0x78, 0x80), (0x04, 0x00, 0xCC, 0x15, 0x00, 0x00, 0x4B, 0x55)))}


def test_every_register(bench, tmp_path):
    script = [command("random", 1)]
    for address in range(0x80):
        script.append(read(address, IDENTITY.get(address, -1), 0 if address in READABLE else REFUSED))
        if address not in WRITABLE:
            script.append(write(address, 0xA5, REFUSED))
    script.append(command("expect", 1, 1, 0))  # an offset acts from the last frame of the access on
    for address in sorted(WRITABLE - {BANK, STATUS, 0x7C, EMASK, WMASK}):
        script += [write(address, 0x5A), read(address, 0x5A & HELD.get(address, 0xFF)), write(address, 0x00)]
    for address in (EMASK, WMASK):
        script += [write(address, 0xA5), read(address, 0xA5)]
    # A quarter of a turn off.
    script += [write(0x1E, 0x40), command("offset", 0x80000), command("expect", 1, 1, 1), command("random", 2),
               command("expect", 1, 1, 0), write(0x1E, 0x00), command("offset", 0), command("expect", 1, 1, 1),
               command("random", 2)]
    script += [read(0x78, 0, NO_ANSWER, who) for who in range(1, 8)]
    run(bench, tmp_path, script, half=5, delay=10, busy=0)


def test_every_bank(bench, tmp_path):
    script = []
    whole = [*EDS, *USER] if WHOLE else [*EDS, USER[0]]
    for bank in range(256) if WHOLE else [*range(9), *range(30, 34), 255]:
        there = bank in EDS or bank in USER
        script += [write(BANK, bank), read(BANK, bank)]
        if there:
            script += [read(0x3F, 0xFF if bank in USER else -1), write(0x3F, bank, 0 if bank in USER else REFUSED)]
            script += [read(0x3F, bank)] if bank in USER else []
        elif bank != 0:
            script += [read(0x3F, 0, REFUSED), write(0x3F, bank, REFUSED)]
        if bank in whole and bank in USER:
            script += [command("write_on", 0, 0, 64), command("wait", 100)]
        if bank in whole:
            script.append(command("read_on", 0, 0, 64, text=f"bank{bank}"))
    script += [write(BANK, USER[-1]), command("read_on", 0, 0x3E, 3, REFUSED, text="beyond")]
    said, _, _ = run(bench, tmp_path, script, half=5, delay=10, busy=0)
    for bank in whole:
        data = told(said, f"bank{bank}")
        if bank in EDS:
            assert len(data) == 64 and data[63] == sum(data[:63]) % 256, bank
        else:
            assert data == [(i * 7 + 1) % 256 for i in range(64)], bank


def seen(on, off, errors, status, n_error=0, n_warning=1):
    """Frames and registers tell, and tell when it is over."""
    return [*on, command("expect", n_error, n_warning, 1), command("random", 2), read(ERRORS, errors), read(STATUS, status),
            *off, command("expect", 1, 1, 1), command("random", 2), read(ERRORS, 0), read(STATUS, HEALTHY)]


def fault(name, errors, status, n_error=0, n_warning=1):
    return seen([command("fault", 1, text=name)], [command("fault", 0, text=name)], errors, status, n_error, n_warning)


def checked(name):
    """A damaged region is found by command 04, and found to be good again by the next one."""
    find = [command("expect", 1, 1, 0), write(STATUS, 0x04), command("wait", 200)]
    return seen([command("fault", 1, text=name), command("random", 2), *find], [command("fault", 0, text=name), *find],
                0x10, 0xD3)


def hot(name, low, high):
    """Not monitored as delivered; with EMASK it is an error, with WMASK a warning."""
    return [command("fault", 1, text=name), command("random", 1), read(ERRORS, 0), read(TEMPERATURE, low),
            read(TEMPERATURE + 1, high), command("fault", 0, text=name),
            write(EMASK, 0x04), *fault(name, 0x04, 0xD3), write(EMASK, 0x00),
            write(WMASK, 0x04), *fault(name, 0x04, 0xB3, 1, 0), write(WMASK, 0x00), write(EMASK, 0xFB)]


def on_the_wire(name, status, text="-", at_rest=()):
    """The frame that it happens to, and what comes behind it when it is over."""
    return [command("expect", 1, 1, 0), command("fault", 1, text=name), *at_rest, command("broken", status, text=text),
            command("fault", 0, text=name), command("frame", 1), command("expect", 1, 1, 1), command("random", 2)]


SIGNALS = ("sin_amplitude_low", "sin_amplitude_high", "cos_amplitude_low", "cos_amplitude_high", "sin_offset", "cos_offset")
FAULTS = {
    "led_current_high": fault("led_current_high", 0x01, 0xD3),
    **{name: fault(name, 0x02, 0xD3) for name in SIGNALS},
    "temperature_high": hot("temperature_high", 0xE2, 0x04),
    "temperature_low": hot("temperature_low", 0x3E, 0xFE),
    "multiturn_sync": fault("multiturn_sync", 0x08, 0xD2),
    "eeprom_silent": fault("eeprom_silent", 0x10, 0xD3),
    "singleturn_lost": fault("singleturn_lost", 0x20, 0xD2),
    "multiturn_amplitude": fault("multiturn_amplitude", 0x40, 0xD0),
    "multiturn_vector": fault("multiturn_vector", 0x40, 0xD0),
    "watchdog_fired": fault("watchdog_fired", 0x80, 0xD3),
    "wire_drop": on_the_wire("wire_drop", NO_ACK),
    "wire_delay": on_the_wire("wire_delay", NO_START),
    "wire_damage": on_the_wire("wire_damage", 0, text="crc") * 4,
    "wire_break": on_the_wire("wire_break", NO_ACK, at_rest=[command("wait", 1), command("sl", 1)]),
    "eeprom_config": checked("eeprom_config"),
    **{f"eeprom_user{bank}": checked(f"eeprom_user{bank}") if WHOLE or bank in (USER[0], USER[-1]) else [] for bank in USER},
}


def test_every_fault(bench, tmp_path):
    catalogue = json.loads(subprocess.run([os.environ["DREHGEBER"], "faults", "s3684-biss", "--json"], check=True,
                                          stdout=subprocess.PIPE, timeout=60).stdout)
    assert sorted(FAULTS) == sorted(row["name"] for row in catalogue)
    # The simulated error: in the status and in nERR, not in 69h.
    simulated = seen([command("expect", 1, 1, 0), write(STATUS, 0x05)], [command("expect", 1, 1, 0), write(STATUS, 0x06)],
                     0x00, 0xD3)
    script = [command("random", 1), *itertools.chain(*FAULTS.values()), *simulated]
    run(bench, tmp_path, script, half=5, delay=20, busy=1)


def broken(status, *damage, text="-"):
    """The frame after a damage, and what comes behind it when the line is whole again."""
    return [command("expect", 1, 1, 0), command("damage", *damage), command("broken", status, text=text), command("mend"),
            command("wait", 50), command("frame", 1), command("expect", 1, 1, 1), command("random", 2)]


def test_a_line_that_is_disturbed(bench, tmp_path):
    """And power that goes and comes."""
    period = 10  # of MA, in clocks
    script = [
        command("random", 1),
        *broken(NO_ACK, NOW, 0, 0, 1),
        *broken(NO_ACK, NOW, 0, 0, 0),
        *broken(NO_START, AT_ACK, 5, 0, 0),
        *broken(NO_STOP, AT_ACK, 500, 0, 1, text="crc"),
        *broken(NO_TIMEOUT, AT_ACK, 900, 0, 0),
        *(line for bit in (2, 15, 35, 40, 46) for line in broken(0, AT_ACK, bit * period, 1, text="crc")),
        # A register when the line breaks, and when it is there again.
        command("expect", 1, 1, 0), command("damage", NOW, 40000, 0, 1), read(0x78, 0, LINE), command("mend"),
        command("wait", 50), command("frame", 1), command("expect", 1, 1, 1), read(0x78, 0x04),
        # Without power nobody acknowledges; behind it SL is low until e1, and the life counter begins with 0.
        command("expect", 1, 1, 0), command("power", 0), command("broken", NO_ACK), command("power", 1),
        command("wait", 100), command("sl", 0), command("expect", 1, 1, 1), command("random", 3), read(0x78, 0x04),
    ]
    run(bench, tmp_path, script, half=5, delay=20, busy=1)


def test_the_master_in_vhdl_is_the_same_at_every_clock(bench, tmp_path):
    """Replayed in GHDL; the delay keeps edges of SL and of the clock apart."""
    script = [command("random", 3), read(0x47, 0xE9, who=2), write(EMASK, 0xA5), command("read_on", 1, 0x78, 3),
              read(0x00, 0, REFUSED), read(0x78, 0, NO_ANSWER, 5), command("spin", 3),
              *broken(NO_ACK, NOW, 0, 0, 1), *broken(NO_START, AT_ACK, 5, 0, 0), *broken(NO_TIMEOUT, AT_ACK, 1500, 0, 0),
              *broken(0, AT_ACK, 150, 1, text="crc")]
    run(bench, tmp_path, script, half=5, delay=23, busy=1, chain=3, trace=tmp_path / "trace")
    master = MODELS / "master" / "biss_master.vhd"
    for step in (["-a", "--std=08", master, TESTS / "replay.vhd"], ["-e", "--std=08", "replay"],
                 ["-r", "--std=08", "replay", "-gTRACE=trace"]):
        done = subprocess.run(["ghdl", *step], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=400, check=False)
        assert done.returncode == 0, done.stdout
    clocks, words, registers = map(int, re.search(r"equal for (\d+) clocks with (\d+) words and (\d+) registers",
                                                  done.stdout).groups())
    assert clocks > 100000 and words > 100 and registers == 7
