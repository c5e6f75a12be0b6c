# SPDX-License-Identifier: MIT
"""Coverage by the tests that have run in this tree: `src`, of src/, before any end-to-end test, as what those
happen to reach is not counted as covered; `ports`, of what stands between the core and the world, behind all tests.
Files that run in the guest alone are named in `coverage/elsewhere`, each with the test that runs it there; they are
not counted, and one that reaches the floor here is refused. `ports` deletes the counters: the next run begins at zero.

usage: coverage.py TREE BUILD src|ports
"""

import json
import os
import subprocess
import sys

from sources import files, finish, read

# folder               lines  branches  lines of each file, all in percent
FLOORS = {
    "src": {
        "src/":             (99.5, 98.0, 95.0),
    },
    "ports": {
        "platform/linux/":  (95.5, 86.5, 85.0),
        "platform/fmu/":    (95.0, 84.0, 85.0),
        "platform/hdl/":    (95.0, 79.0, 90.0),
        "tools/drehgeber/": (95.0, 84.0, 80.0),
    },
}
ELSEWHERE = "tests/gates/coverage/elsewhere"


def measure(tree, build, what):
    """file: (lines, covered lines, branches, covered branches)"""
    filters = [word for folder in FLOORS[what] for word in ("--filter", os.path.join(tree, folder))]
    # Two threads that count the same branch lose some counts. gcov takes one count from another, and gcovr does not
    # read what is below zero: it leaves such a line out. Counters that lose nothing make the tests of src/ six times
    # slower.
    last = ["--gcov-ignore-parse-errors"] + (["--delete"] if what == "ports" else [])
    command = ["gcovr", "--root", tree, *filters, "--object-directory", build, *last, "--json-summary", "-", build]
    said = json.loads(subprocess.check_output(command, text=True))
    return {
        os.path.normpath(file["filename"]): (
            file["line_total"], file["line_covered"], file["branch_total"], file["branch_covered"])
        for file in said["files"]
    }


def percent(covered, total):
    return 100 * covered / total if total else 100.0


def read_built(tree, build):
    """Files that are compiled in this tree, also those that have nothing to run."""
    commands = os.path.join(build, "compile_commands.json")
    if not os.path.exists(commands):
        return set()
    with open(commands, encoding="utf-8") as file:
        return {os.path.relpath(row["file"], tree) for row in json.load(file)}


def read_elsewhere(tree):
    """file: the test that runs it"""
    lines = [line.split() for line in read(tree, ELSEWHERE).splitlines()]
    return dict(words for words in lines if words and words[0] != "#")


def judge_elsewhere(tree, folder, elsewhere, measured):
    """Complaints about the files of a folder that are said to run elsewhere."""
    floor = FLOORS["ports"][folder][2]
    complaints = []
    for path, test in elsewhere.items():
        if not path.startswith(folder):
            continue
        total, covered, _, _ = measured.get(path, (1, 0, 0, 0))
        if percent(covered, total) >= floor:
            complaints.append(f"{ELSEWHERE}: {path} has {percent(covered, total):.1f} % here: take it out")
        for name in path, test:
            if not os.path.exists(os.path.join(tree, name)):
                complaints.append(f"{ELSEWHERE}: there is no {name}")
    return complaints


def check(folder, floors, measured, elsewhere, unbuilt):
    """Complaints about the files of a folder."""
    lines_floor, branches_floor, file_floor = floors
    mine = {path: figures for path, figures in measured.items() if path.startswith(folder) and path not in elsewhere}
    if not mine:
        return [f"{folder}: nothing was measured"]
    sums = [sum(figures[i] for figures in mine.values()) for i in range(4)]
    lines, branches = percent(sums[1], sums[0]), percent(sums[3], sums[2])
    print(f"{folder} {len(mine)} files, lines {lines:.1f} % ({sums[1]} of {sums[0]}), "
          f"branches {branches:.1f} % ({sums[3]} of {sums[2]})")
    complaints = [f"{path}: is not built in this tree, and not in {ELSEWHERE}" for path in unbuilt
                  if path.startswith(folder) and path not in elsewhere]
    for what, value, floor in (("lines", lines, lines_floor), ("branches", branches, branches_floor)):
        if value < floor:
            complaints.append(f"{folder}: {value:.2f} % of the {what}, at least {floor} % wanted")
    for path, (total, covered, _, _) in sorted(mine.items()):
        if percent(covered, total) < file_floor:
            complaints.append(
                f"{path}: {percent(covered, total):.1f} % of the lines, at least {file_floor} % wanted")
    return complaints


def main():
    tree, build = (os.path.realpath(path) for path in sys.argv[1:3])
    what = sys.argv[3]
    measured = measure(tree, build, what)
    elsewhere = read_elsewhere(tree) if what == "ports" else {}
    built = read_built(tree, build) | set(measured)
    unbuilt = [path for path in files(tree, *FLOORS[what], suffixes=(".c",)) if path not in built]
    complaints = []
    for folder, floors in FLOORS[what].items():
        complaints += check(folder, floors, measured, elsewhere, unbuilt)
        if what == "ports":
            complaints += judge_elsewhere(tree, folder, elsewhere, measured)
    finish(len(measured), complaints)


main()
