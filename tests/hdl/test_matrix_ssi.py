# SPDX-License-Identifier: MIT
"""The SSI master of platform/hdl/master against the encoders in Verilator: one program (ssi_bench.sv), which does what
a script says on a wire that its arguments say. Clock x cable x kind of word; everything that can happen to the encoder,
as the master sees it.

usage: as test_matrix.py

A script has lines `COMMAND TEXT A B`; what is not named is 0:

  word A, random A, spin A   so many words: as it stands, each at a random angle, each at a random angle and speed
  broken - A                 a word that ends with this status
  bent TEXT                  a word that is all zero, late, flip: with one bit flipped
  wrong A                    the error bit says so from now on
  fault TEXT A, power A      of the encoder
  pause A                    microseconds between words; the monoflop time is 20 us
  stuck A B                  data is stuck at B, whatever drives it
  data A; wait A             data is at this level; microseconds
"""

import itertools
import json
import os
import subprocess
from typing import NamedTuple

import pytest
from matrix import compiled, run, run_all

HALVES = (500, 100, 50, 25)  # 100 kHz, 500 kHz, 1 MHz, 2 MHz, in clocks of 10 ns
DELAYS = (10, 50, 200, 450)  # the last one: an answer comes back two clocks late, at 2 MHz
NOT_READY, NO_STOP, NO_PAUSE = 1, 2, 3


class Layout(NamedTuple):
    bits: tuple[int, int]
    gray: int
    error: int
    parity: int

    def settings(self):
        error, parity = ("none", "high", "low")[self.error], ("none", "even", "odd")[self.parity]
        code = ("binary", "gray")[self.gray]
        return f"mt={self.bits[0]} st={self.bits[1]} code={code} error_bit={error} parity={parity}"


# Each is compiled, which takes its time: every value is in one of them.
LAYOUTS = [Layout((0, 13), 1, 0, 0), Layout((12, 13), 1, 2, 1), Layout((12, 16), 0, 1, 2), Layout((8, 24), 1, 1, 1)]
FULL = 2  # turns, an error bit, parity


def command(op, *numbers, text="-"):
    return " ".join([op, text, *map(str, [*numbers, 0, 0][:2])])


@pytest.fixture(scope="module", name="bench")
def make_bench(tmp_path_factory):
    """The program, compiled once."""
    folder = tmp_path_factory.mktemp("ssi_bench")
    encoders = [f'  drehgeber_ssi #(.SETTINGS("{layout.settings()}")) e{i} (.clock(far_clock || kind != {i}), .data(levels[{i}]));'
                for i, layout in enumerate(LAYOUTS)]
    steered = [f"      {i}: case (what) 0: begin e{i}.turn(turns); e{i}.speed(rpm); end 1: e{i}.fault(text, on); "
               f"default: e{i}.power(on); endcase" for i in range(len(LAYOUTS))]
    (folder / "layouts.svh").write_text("\n".join([
        f"  logic [{len(LAYOUTS) - 1}:0] levels;", *encoders, "  assign data_of_it = levels[kind];",
        "  task automatic steer(int what, real turns, real rpm, string text, bit on);", "    case (kind)", *steered,
        "      default: ;", "    endcase", "  endtask"]) + "\n", encoding="ascii")
    return compiled(folder, "ssi")


def of(kind):
    layout = LAYOUTS[kind]
    return {"kind": kind, "mt": layout.bits[0], "st": layout.bits[1], "gray": layout.gray, "error": layout.error,
            "parity": layout.parity}


def test_every_wire(bench, tmp_path, capsys):
    """Random angles, at rest and turning."""
    script = [command("data", 1), command("random", 20), command("spin", 5), command("random", 1)]
    run_all(list(itertools.product(HALVES, DELAYS, range(len(LAYOUTS)))),
            lambda i, wire: run(bench, tmp_path, script, half=wire[0], delay=wire[1], seed=i + 1, **of(wire[2])), capsys)


def sensed(name):
    """The error bit says so, and the position goes on."""
    return [command("fault", 1, text=name), command("wrong", 1), command("random", 2), command("fault", 0, text=name),
            command("wrong", 0), command("random", 2)]


def on_the_wire(name, *bent):
    """The word that it happens to, and what comes behind it when it is over."""
    return [command("fault", 1, text=name), *bent, command("fault", 0, text=name), command("wait", 30), command("random", 2)]


SENSED = ("led_current_high", "temperature_high", "temperature_low", "supply_low", "sin_amplitude_low", "sin_amplitude_high",
          "cos_amplitude_low", "cos_amplitude_high", "sin_offset", "cos_offset", "singleturn_lost", "multiturn_amplitude",
          "multiturn_sync", "multiturn_vector", "watchdog_fired")
FAULTS = {name: sensed(name) for name in SENSED} | {
    "wire_drop": on_the_wire("wire_drop", command("bent", text="zero")),
    "wire_delay": on_the_wire("wire_delay", command("bent", text="late")) * 4,
    "wire_damage": on_the_wire("wire_damage", command("bent", text="flip")) * 4,
    "wire_break": on_the_wire("wire_break", command("wait", 2), command("data", 0), command("broken", NOT_READY)),
}


def test_every_fault(bench, tmp_path):
    """At 500 kHz a late bit is one clock late."""
    catalogue = json.loads(subprocess.run([os.environ["DREHGEBER"], "faults", "ssi-28", "--json"], check=True,
                                          stdout=subprocess.PIPE, timeout=60).stdout)
    assert sorted(FAULTS) == sorted(row["name"] for row in catalogue)
    run(bench, tmp_path, [command("random", 1), *itertools.chain(*FAULTS.values())], half=100, delay=50, **of(FULL))


def bent(begin, status, end):
    """A word that fails, and some when it is over."""
    return [*begin, command("wait", 1), command("broken", status), *end, command("wait", 100), command("data", 1),
            command("random", 2)]


def test_a_line_that_is_disturbed(bench, tmp_path):
    """And power that goes and comes, and a master that does not wait."""
    script = [
        command("random", 1),
        *bent([command("stuck", 1, 0)], NOT_READY, [command("stuck")]),
        *bent([command("stuck", 1, 1)], NO_STOP, [command("stuck")]),
        *bent([command("power", 0)], NOT_READY, [command("power", 1)]),
        *bent([command("pause", 12)], NO_PAUSE, [command("pause", 22)]),
    ]
    run(bench, tmp_path, script, half=25, delay=50, **of(FULL))
