#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Holds that four times the encoders cost the command about four times the instructions: to start, and to live in
virtual time. Lists that are walked for each of them would cost sixteen times.

usage: growth.py DREHGEBER
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

TIMES, MOST = 4, 4.2
PATIENCE_S = 120


def full_buses(count):
    """CAN buses with 125 nodes each."""
    return "".join(
        f"[bus b{i}]\nwire = slcan\n[encoder b{i}]\nmodel = f3668\nbus = b{i}\nnode = 1..125\n" for i in range(count)
    )


def wires(model, wire):
    """Encoders with a wire each, a section each."""
    return lambda count: "".join(f"[encoder e{i}]\nmodel = {model}\nwire = {wire}\n" for i in range(count))


# what, how many at first, the rig file of so many, how long it lives
ROWS = [
    ("full CAN buses, start", 4, full_buses, "1MS"),
    ("full CAN buses, 1 s", 4, full_buses, "1S"),
    ("BiSS, a wire each, start", 250, wires("s3684-biss", "sim"), "1MS"),
    ("BiSS, a wire each, 1 s", 250, wires("s3684-biss", "sim"), "1S"),
    ("RS485, a wire each, 1 s", 100, wires("s3684-rs485", "pty"), "1S"),
    ("CANopen, a wire each, 1 s", 100, wires("f3668", "slcan"), "1S"),
]


def instructions(program, text, span, folder):
    """Of a whole run, in callgrind's count."""
    file = Path(folder, "rig.ini")
    file.write_text(f"[rig]\ncontrol = unix:{folder}/control\n[shaft main]\nmotion = 60RPM\n{text}", encoding="ascii")
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, "run", "-q"]
    command += [str(file), f"--time=virtual:{span}"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    counted = re.search(r"Collected : (\d+)", ended.stderr)
    if ended.returncode != 0 or counted is None:
        sys.exit(f"growth.py: {' '.join(command)}: {ended.returncode}: {ended.stderr[-400:]}")
    return int(counted[1])


def main():
    """A row each."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    beyond = 0
    print(f"{'what':28} {'count':>7} {'instr.':>13} {'count':>7} {'instr.':>13} {'times':>6}")
    for what, count, rig, span in ROWS:
        with tempfile.TemporaryDirectory() as folder:
            few, many = (instructions(sys.argv[1], rig(n), span, folder) for n in (count, TIMES * count))
        remark = "" if many <= MOST * few else f"  BEYOND {MOST}"
        beyond += many > MOST * few
        print(f"{what:28} {count:7} {few:13} {TIMES * count:7} {many:13} {many / few:6.2f}{remark}", flush=True)
    sys.exit(1 if beyond else 0)


main()
