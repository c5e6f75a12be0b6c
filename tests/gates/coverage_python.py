# SPDX-License-Identifier: MIT
"""How much of the Python package its tests ran: lines and branches of all of it, and of each file.

usage: coverage_python.py TREE FOLDER...    each with what one run has counted by tests/python/coverage.ini; the Python
                                            that runs this has coverage
"""

import json
import os
import subprocess
import sys
import tempfile

from sources import files, finish

SETTINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../python/coverage.ini")
PACKAGE = "tools/python/drehgeber"
FLOOR, FILE_FLOOR = 90.0, 80.0


def measure(tree, folders):
    """{file: what coverage.py's JSON says of it}"""
    with tempfile.TemporaryDirectory() as scratch:
        here = {"cwd": tree, "env": {**os.environ, "PACKAGE_COVERAGE": scratch}}
        command = [sys.executable, "-m", "coverage"]
        options = ["--rcfile", SETTINGS, "--data-file", f"{scratch}/lines"]
        subprocess.run([*command, "combine", "-q", "--keep", *options, *folders], check=True, **here)
        if subprocess.run([*command, "json", "-q", *options, "-o", f"{scratch}/json"], check=False, **here).returncode:
            sys.exit("nothing was measured")
        with open(f"{scratch}/json", encoding="utf-8") as file:
            return json.load(file)["files"]


def percent(rows):
    total = sum(row["num_statements"] + row["num_branches"] for row in rows)
    return 100 * sum(row["covered_lines"] + row["covered_branches"] for row in rows) / total if total else 100.0


def main():
    tree, *folders = (os.path.realpath(path) for path in sys.argv[1:])
    empty = [f"{folder}: nothing was measured" for folder in folders if not os.path.isdir(folder) or not os.listdir(folder)]
    if empty:
        finish(len(folders), empty)
    measured, complaints, rows = measure(tree, folders), [], []
    for path in files(tree, PACKAGE, suffixes=(".py",)):
        if path not in measured:
            complaints.append(f"{path}: no test has loaded it")
            continue
        rows.append(measured[path]["summary"])
        share = percent(rows[-1:])
        print(f"{path}: {share:.1f} % ran; not the lines {measured[path]['missing_lines']}")
        if share < FILE_FLOOR:
            complaints.append(f"{path}: {share:.1f} % ran, at least {FILE_FLOOR:.0f} % wanted")
    print(f"{PACKAGE}: {percent(rows):.1f} % ran")
    if percent(rows) < FLOOR:
        complaints.append(f"{PACKAGE}: {percent(rows):.1f} % ran, at least {FLOOR:.0f} % wanted")
    finish(len(rows), complaints)


main()
