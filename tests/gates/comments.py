# SPDX-License-Identifier: MIT
"""The share of comment lines. Public headers are the contract and mostly comment: 45-70 % of all
of them together. For sources the share is printed; 10-20 % is what to aim at.

usage: comments.py TREE
"""

import sys

from sources import blank, files, finish, read

PUBLIC_PERCENT = (45, 70)


def count(tree, path):
    """Lines with a comment (the licence left out), and lines that are not empty."""
    text = read(tree, path).split("\n", 1)[1]
    commented = lines = 0
    for raw, bare in zip(text.split("\n"), blank(text, strings=False).split("\n")):
        lines += bool(raw.strip())
        commented += "".join(raw.split()) != "".join(bare.split())
    return commented, lines


def share(tree, paths):
    counts = [count(tree, path) for path in paths]
    for path, (commented, lines) in zip(paths, counts):
        print(f"{100 * commented / lines:5.1f} %  {lines:5d} lines  {path}")
    total = 100 * sum(c for c, _ in counts) / sum(n for _, n in counts)
    print(f"{total:5.1f} %  all of them\n")
    return total


def main():
    tree = sys.argv[1]
    share(tree, files(tree, "src", "platform", "tools/drehgeber", suffixes=(".c", ".h")))
    publics = files(tree, "include", suffixes=(".h",))
    total = share(tree, publics)
    low, high = PUBLIC_PERCENT
    wrong = [] if low <= total <= high else [f"public headers: {total:.1f} % is not {low}-{high} %"]
    finish(len(publics), wrong)


main()
