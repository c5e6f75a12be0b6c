# SPDX-License-Identifier: MIT
"""What other build systems are told is what CMake builds: the version of the header, and every source of
src/. Meson has a list; the others have wild cards, see tests/package/frameworks.

usage: packages.py TREE
"""

import json
import re
import sys

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


def main():
    tree = sys.argv[1]
    sources = files(tree, "src", suffixes=(".c",))
    json.loads(read(tree, "library.json"))
    finish(len(sources) + len(VERSIONS), versions(tree) + meson(tree, sources))


main()
