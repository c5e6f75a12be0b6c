# SPDX-License-Identifier: MIT
"""Coverage by the tests that ran in this tree: of all of src/ and each of its files, and of the Linux
ports, of which these tests see what needs neither a kernel with CAN nor a whole program. The counters
are deleted: the next run counts from zero.

usage: coverage.py TREE BUILD
"""

import json
import os
import subprocess
import sys

from sources import finish

# folder            lines  branches  lines of each file, all in percent
FLOORS = {
    "src/":            (99.5, 98.0, 95.0),
    "platform/linux/": (74.0, 65.0, 0.0),
}


def measure(tree, build):
    """file: (lines, covered lines, branches, covered branches)"""
    filters = [word for folder in FLOORS for word in ("--filter", os.path.join(tree, folder))]
    command = ["gcovr", "--root", tree, *filters, "--object-directory", build, "--delete",
               "--json-summary", "-", build]
    said = json.loads(subprocess.check_output(command, text=True))
    return {
        os.path.normpath(file["filename"]): (
            file["line_total"], file["line_covered"], file["branch_total"], file["branch_covered"])
        for file in said["files"]
    }


def percent(covered, total):
    return 100 * covered / total if total else 100.0


def check(folder, measured):
    """Complaints about the files of a folder."""
    lines_floor, branches_floor, file_floor = FLOORS[folder]
    mine = {path: figures for path, figures in measured.items() if path.startswith(folder)}
    if not mine:
        return [f"{folder}: nothing was measured"]
    sums = [sum(figures[i] for figures in mine.values()) for i in range(4)]
    lines, branches = percent(sums[1], sums[0]), percent(sums[3], sums[2])
    print(f"{folder} {len(mine)} files, lines {lines:.1f} % ({sums[1]} of {sums[0]}), "
          f"branches {branches:.1f} % ({sums[3]} of {sums[2]})")
    complaints = []
    for what, value, floor in (("lines", lines, lines_floor), ("branches", branches, branches_floor)):
        if value < floor:
            complaints.append(f"{folder}: {value:.2f} % of the {what}, at least {floor} % wanted")
    for path, (total, covered, _, _) in sorted(mine.items()):
        if percent(covered, total) < file_floor:
            complaints.append(
                f"{path}: {percent(covered, total):.1f} % of the lines, at least {file_floor} % wanted")
    return complaints


def main():
    tree, build = (os.path.realpath(path) for path in sys.argv[1:])
    measured = measure(tree, build)
    finish(len(measured), [text for folder in FLOORS for text in check(folder, measured)])


main()
