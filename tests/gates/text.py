# SPDX-License-Identifier: MIT
"""Every file says its licence, ends its lines properly, and knows no machine it was written on. A file
that is no UTF-8 would hide from this. Inputs of the fuzz targets may be anything; a name with an
ending is none.

usage: text.py TREE
"""

import re
import sys

from sources import files, finish, read

LICENSED = (".c", ".h", ".def", ".py", ".txt", ".cmake", ".in", ".sh", ".ini")
# They have no comments.
UNMARKED = ("LICENSE", "tools/python/LICENSE", "debian/changelog", "debian/copyright", "debian/source/format",
            "platform/web/compile_flags.txt")
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


def licensed(path):
    name = path.rsplit("/", 1)[-1]
    named = path.endswith(LICENSED) and not path.startswith("LICENSES/")
    return (named or "." not in name) and path not in UNMARKED


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
        if licensed(path) and not any("SPDX-License-Identifier: MIT" in line for line in head):
            complaints.append(f"{path}:1: no licence in the first two lines")
        for number, line in enumerate(text.split("\n"), 1):
            complaints += [
                f"{path}:{number}: {what}"
                for what, pattern in forbidden.items()
                if pattern.search(line)
            ]
    finish(len(paths), complaints)


main()
