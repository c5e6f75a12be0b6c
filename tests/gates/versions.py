# SPDX-License-Identifier: MIT
"""Every place where the version stands. The header has it; CMake, the Python package and the Arduino library read it from
there, manual pages and EDS files are generated, and all others are rows here. gate.packages and tools/release compare
them."""

import re

from sources import read

HEADER = "include/drehgeber/version.h"
# file, a pattern that finds every one in it, how much of the version it is
PLACES = (
    ("meson.build", r"^project\(.*\bversion: '([^']*)'", "version"),
    ("library.json", r'^  "version": "([^"]*)"', "version"),
    ("idf_component.yml", r'^version: "([^"]*)"', "version"),
    ("debian/changelog", r"\A\S+ \(([^)]*)\)", "version"),
    ("CHANGELOG.md", r"\A(?:(?!^## \d).*\n)*## (\d\S*)", "version"),
    ("tools/examples/consumers/find-package/CMakeLists.txt", r"find_package\(drehgeber (\S+)", "minor"),
    ("tools/examples/consumers/meson/meson.build", r"dependency\('drehgeber', version: '>=([^']*)'", "minor"),
    ("docs/install.md", r"find_package\(drehgeber (\S+)", "minor"),
    ("docs/install.md", r"/drehgeber(?:@v|:)([\d.]+)", "version"),
    ("docs/install.md", r"^ +version: (\S+)", "version"),
    ("docs/install.md", r"libdrehgeber\{([\d.]+)", "soname"),
    ("debian/control", r"\blibdrehgeber(\d[\d.]*)", "soname"),
)


def version_of(tree):
    """The version as a string, and a complaint when the numbers beside it are others."""
    text = read(tree, HEADER)
    version = re.search(r'^#define DG_VERSION "([^"]*)"', text, re.M)[1]
    numbers = re.findall(r"^#define DG_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", text, re.M)
    same = ".".join(numbers) == version
    return version, [] if same else [f"{HEADER}: {'.'.join(numbers)} is not {version}"]


def parts(version):
    """What each of PLACES may have. The SONAME is as CMakeLists.txt makes it."""
    major, minor, _ = version.split(".")
    return {"version": version, "minor": f"{major}.{minor}", "soname": major}


def compare_days(tree):
    """The header has the day of the release as EDS files do: month-day-year."""
    day = re.search(r'^#define DG_RELEASED "(\d+)-(\d+)-(\d+)"', read(tree, HEADER), re.M)
    wanted = f"{day[3]}-{day[1]}-{day[2]}"
    found = re.search(r"^## \d\S* - (\S+)", read(tree, "CHANGELOG.md"), re.M)
    return [] if found and found[1] == wanted else \
        [f"CHANGELOG.md: released on {found and found[1]}, not on {wanted} as {HEADER} says"]


def compare(tree):
    """A complaint for each number that is not the header's."""
    version, complaints = version_of(tree)
    for path, pattern, part in PLACES:
        wanted = parts(version)[part]
        found = re.findall(pattern, read(tree, path), re.M) or [None]
        complaints += [f"{path}: {part} {one} is not {wanted} of {HEADER}" for one in set(found) - {wanted}]
    return complaints + compare_days(tree)
