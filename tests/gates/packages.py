# SPDX-License-Identifier: MIT
"""What other build systems are told is what CMake builds: the version of the header, and every source of
src/. Meson has a list; the others have wild cards, see tests/package/frameworks. Debian's packages can be
installed together: no path is in the lists of two.

usage: packages.py TREE
"""

import json
import os
import re
import sys
from fnmatch import fnmatchcase
from itertools import combinations

from sources import files, finish, read

HEADER = "include/drehgeber/version.h"
# file: the version in it
VERSIONS = {
    "meson.build": r"^project\(.*\bversion: '([^']*)'",
    "library.json": r'^  "version": "([^"]*)"',
    "idf_component.yml": r'^version: "([^"]*)"',
}


def version_of(tree):
    """The version as a string, and a complaint when the numbers beside it are others."""
    text = read(tree, HEADER)
    version = re.search(r'^#define DG_VERSION "([^"]*)"', text, re.M)[1]
    numbers = re.findall(r"^#define DG_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", text, re.M)
    same = ".".join(numbers) == version
    return version, [] if same else [f"{HEADER}: {'.'.join(numbers)} is not {version}"]


def versions(tree):
    version, complaints = version_of(tree)
    for path, pattern in VERSIONS.items():
        found = re.search(pattern, read(tree, path), re.M)
        if not found or found[1] != version:
            complaints.append(f"{path}: version {found and found[1]} is not {version} of {HEADER}")
    return complaints


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
    finish(len(sources) + len(VERSIONS), versions(tree) + meson(tree, sources) + debian(tree))


main()
