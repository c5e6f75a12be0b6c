# SPDX-License-Identifier: MIT
"""How much of every script of the product ran in a browser, in percent of its characters: blanks and lines that are
comments do not count. Lines would be kinder to scripts with much on a line.

usage: coverage_javascript.py TREE FILE...    each as tests/e2e/script_coverage.py writes it
"""

import json
import os
import re
import sys

from sources import files, finish, read

FLOOR = 80.0
COMMENT = re.compile(r"[ \t]*//[^\n]*")


def code(text):
    """Where its characters are that count."""
    comments = {at for match in COMMENT.finditer(text) for at in range(*match.span())
                if match.start() == 0 or text[match.start() - 1] == "\n"}
    return {at for at, character in enumerate(text) if not character.isspace() and at not in comments}


def load(paths):
    """{text of a script: where its characters are that ran}, and complaints."""
    ran, complaints = {}, []
    for path in paths:
        if not os.path.exists(path):
            complaints.append(f"{path}: nothing was measured")
            continue
        with open(path, encoding="utf-8") as file:
            kept = json.load(file)
        if not kept:
            complaints.append(f"{path}: nothing was measured")
        for text, spans in kept.items():
            ran.setdefault(text, set()).update(at for span in spans for at in range(*span))
    return ran, complaints


def lines(text, missed):
    """The lines of these characters, as ranges: 3-5,9."""
    found = []
    for line in sorted({text.count("\n", 0, at) + 1 for at in missed}):
        if found and found[-1][1] == line - 1:
            found[-1][1] = line
        else:
            found.append([line, line])
    return ",".join(f"{first}-{last}" if last > first else f"{first}" for first, last in found)


def judge(path, text, ran):
    """Complaints about a script; says what has not run."""
    counted = code(text)
    missed = counted - ran
    share = 100 * (1 - len(missed) / len(counted))
    print(f"{path}: {share:.1f} % ran" + (f"; not all of the lines {lines(text, missed)}" if missed else ""))
    return [f"{path}: {share:.1f} % ran, at least {FLOOR:.0f} % wanted"] if share < FLOOR else []


def main():
    tree, *paths = sys.argv[1:]
    ran, complaints = load(paths)
    ours = {path: read(tree, path) for path in files(tree, suffixes=(".js", ".mjs")) if not path.startswith("tests/")}
    for path, text in ours.items():
        if text in ran:
            complaints += judge(path, text, ran[text])
        else:
            complaints.append(f"{path}: no test has loaded it as it is here")
    complaints += [f"a test has loaded a script that is none of this tree: {text[:200]}"
                   for text in ran if text not in ours.values()]
    finish(len(ours), complaints)


main()
