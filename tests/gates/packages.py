# SPDX-License-Identifier: MIT
"""What other build systems and pages are told is what CMake builds: the version of the header (versions.py), and every
source of src/. Meson has a list; the others have wild cards, see tests/package/frameworks. Debian's packages can be
installed together: no path is in the lists of two.

usage: packages.py TREE
"""

import json
import os
import re
import sys
from fnmatch import fnmatchcase
from itertools import combinations

import versions
from sources import files, finish, read


def meson(tree, sources):
    listed = re.findall(r"^  '(.*)',$", read(tree, "meson.build"), re.M)
    missing, unknown = sorted(set(sources) - set(listed)), sorted(set(listed) - set(sources))
    order = [] if listed == sorted(set(listed)) else ["meson.build: the sources are not in order, each once"]
    return order + [f"meson.build: {path} is missing" for path in missing] + \
        [f"meson.build: there is no {path}" for path in unknown]


def installed(path, line):
    """Where dh_install or dh_link puts what a line names; a pattern."""
    words = line.split()
    if path.endswith(".links"):
        return words[1]
    return words[0] if len(words) == 1 else f"{words[1]}/{os.path.basename(words[0])}"


def meet(one, other):
    """A path may match both, or lie below one that does."""
    return all(fnmatchcase(a, b) or fnmatchcase(b, a) for a, b in zip(one.split("/"), other.split("/")))


def debian(tree):
    rows = [(os.path.splitext(path)[0], path, installed(path, line))
            for path in files(tree, "debian", suffixes=(".install", ".links"))
            for line in read(tree, path).splitlines()]
    return [f"{path}: {row} may be in {other_path}, too: {other}"
            for (package, path, row), (other_package, other_path, other) in combinations(rows, 2)
            if package != other_package and meet(row, other)]


def main():
    tree = sys.argv[1]
    sources = files(tree, "src", suffixes=(".c",))
    json.loads(read(tree, "library.json"))
    finish(len(sources) + len(versions.PLACES), versions.compare(tree) + meson(tree, sources) + debian(tree))


main()
