#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares figures with those of `limits`, beside this file: one that is more than 3 % beyond what was
reached fails, one that has no row fails, a row whose figure was not measured fails, and so does one that
misses the aim of its row when the row does not say why.

usage: limits.py [--limits FILE] [--keep FILE] GROUP COMMAND...
       limits.py [--limits FILE] --update GROUP COMMAND...
COMMAND prints `FIGURE NUMBER` a line, the figures of GROUP. --keep writes what is printed into a file,
too. --update writes what was reached into the rows of GROUP instead: for whoever has made something
better, or says in his commit why it has become worse.
"""

import argparse
import subprocess
import sys
from pathlib import Path

PERCENT = 3
LAYOUT = "{:<14} {:<38} {:>9} {:>7}  {}"
NO_ROW = (None, "-", "")


def number(text):
    return float(text) if "." in text else int(text)


def rows_of(text):
    """(group, figure): what was reached, the aim, and why that is missed, as text, in the order of the file."""
    rows = {}
    for line in text.splitlines():
        if line and not line.startswith("#"):
            group, figure, reached, aim, *reason = line.split(maxsplit=4)
            if (group, figure) in rows:
                sys.exit(f"limits.py: two rows for {group} {figure}")
            rows[group, figure] = reached, aim, "".join(reason)
    return rows


def measure(command):
    """FIGURE: number, as text."""
    result = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"limits.py: {command[0]} has failed")
    measured = {}
    for line in result.stdout.splitlines():
        figure, reached = line.split()
        measured[figure] = reached
    if not measured:
        sys.exit(f"limits.py: {command[0]} has measured nothing")
    return measured


def judge(measured, rows):
    """A line for each figure, and what is wrong."""
    lines, complaints = [("figure", "now", "limit", "aim", "")], []
    for figure, now in measured.items():
        reached, aim, reason = rows.get(figure, NO_ROW)
        if reached is None:
            complaints.append(f"{figure} has no row in limits")
            lines.append((figure, now, "-", aim, ""))
            continue
        limit = number(reached) * (100 + PERCENT) / 100
        remark = "better than its row" if number(now) * (100 + PERCENT) / 100 < number(reached) else ""
        if number(now) > limit:
            remark = "BEYOND"
            complaints.append(f"{figure}: {now} is beyond {limit:.1f}, {PERCENT} % above {reached}")
        elif aim != "-" and number(now) > number(aim):
            remark = f"misses its aim: {reason}" if reason else "MISSES ITS AIM"
            complaints += [] if reason else [f"{figure}: {now} misses its aim of {aim}, and the row does not say why"]
        elif reason:
            remark = "reaches its aim; the row says why it would not"
        lines.append((figure, now, f"{limit:.1f}", aim, remark))
    complaints += [f"{figure} was not measured" for figure in rows if figure not in measured]
    return lines, complaints


def table(lines):
    return "".join("{:<38} {:>9} {:>9} {:>7}  {}".format(*line).rstrip() + "\n" for line in lines)


def update(path, group, measured):
    """Put what was measured into the file, where the rows of the group were, or behind all others."""
    text = path.read_text(encoding="utf-8")
    rows = rows_of(text)
    lines, place = [], None
    for line in text.splitlines():
        if line.split()[:1] == [group]:
            place = len(lines) if place is None else place
        else:
            lines.append(line)
    place = len(lines) if place is None else place
    lines[place:place] = [
        LAYOUT.format(group, figure, reached, *rows.get((group, figure), NO_ROW)[1:]).rstrip()
        for figure, reached in measured.items()
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1])
    parser.add_argument("--limits", type=Path, default=Path(__file__).parent / "limits")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--update", action="store_true")
    parser.add_argument("group")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    wanted = parser.parse_args()
    measured = measure(wanted.command)
    if wanted.update:
        update(wanted.limits, wanted.group, measured)
        return
    rows = rows_of(wanted.limits.read_text(encoding="utf-8"))
    lines, complaints = judge(measured, {name: row for (group, name), row in rows.items() if group == wanted.group})
    text = table(lines)
    if wanted.keep:
        wanted.keep.write_text(f"{wanted.group}\n{text}", encoding="utf-8")
    print(text, *(f"{complaint}\n" for complaint in complaints), sep="", end="")
    sys.exit(1 if complaints else 0)


main()
