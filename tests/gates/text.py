# SPDX-License-Identifier: MIT
"""Every file says its licence, ends its lines properly, and knows no machine it was written on. A file
that is no UTF-8 would hide from this. Inputs of the fuzz targets may be anything; a name with an
ending is none.

usage: text.py TREE
"""

import re
import sys

from sources import files, finish, read

# Every file but these: they have no comments, are another program's input or output as a whole, or are told
# by their own lines.
UNMARKED = (
    ".eds", ".hex", ".install", ".dirs", ".json", ".links", ".list", ".md", ".properties", ".record", ".svg", ".trace",
    ".typed", ".wrap",
    "LICENSE", "LICENSES/MIT.txt", "debian/changelog", "debian/copyright", "debian/source/format",
    "platform/web/compile_flags.txt", "tests/green", "tests/conformance/refused/crowded.clauses", "tests/conformance/refused/crowded.rows",
)
INPUTS = "tests/fuzz/corpus/"
# Brackets keep this file from complaining about itself.
FORBIDDEN = {
    "a path of somebody's machine": re.compile(r"(?<![\w.}])/(wor[k]|hom[e]|roo[t]|User[s])/\w"),
    "something left to do": re.compile(r"\b(TOD[O]|FIXM[E]|XX[X])\b"),
    "white space at the end of the line": re.compile(r"[ \t\r]$"),
    "a tab": re.compile(r"\t"),
}
# What is written so in one folder only: ports say what is wrong, the command line says it with its options.
FORBIDDEN_IN = {
    "platform/": {"an option of the command line": re.compile(r'"--[a-z]')},
}


def main():
    tree = sys.argv[1]
    complaints = []
    paths = files(tree)
    for path in paths:
        if path.startswith(INPUTS) and "." not in path:
            continue
        try:
            text = read(tree, path)
        except UnicodeDecodeError:
            complaints.append(f"{path}: not UTF-8")
            continue
        forbidden = dict(FORBIDDEN)
        for folder, rules in FORBIDDEN_IN.items():
            forbidden |= rules if path.startswith(folder) and path.endswith((".c", ".h")) else {}
        head = text.split("\n", 2)[:2]
        if not path.endswith(UNMARKED) and not any("SPDX-License-Identifier: MIT" in line for line in head):
            complaints.append(f"{path}:1: no licence in the first two lines")
        for number, line in enumerate(text.split("\n"), 1):
            complaints += [
                f"{path}:{number}: {what}"
                for what, pattern in forbidden.items()
                if pattern.search(line)
            ]
    finish(len(paths), complaints)


main()
