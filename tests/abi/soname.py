# SPDX-License-Identifier: MIT
"""What docs/versioning.md says of the SONAME, tried with other versions in the header: the name of the library, and which
version a project may ask find_package() for.

usage: soname.py TREE WORK
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

HEADER = "include/drehgeber/version.h"
# major, minor: SONAME; what else is asked for, and whether it is taken
ROWS = {
    (1, 0): ("libdrehgeber.so.1", {"1.0": True, "0.9": False}),
    (1, 4): ("libdrehgeber.so.1", {"1.0": True, "1.4": True, "1.5": False, "2.0": False}),
    (2, 0): ("libdrehgeber.so.2", {"2.0": True, "1.4": False}),
}
ASK = """set(PACKAGE_FIND_VERSION {asked}.0)
set(PACKAGE_FIND_VERSION_MAJOR {major})
set(PACKAGE_FIND_VERSION_MINOR {minor})
set(CMAKE_SIZEOF_VOID_P 8)
include(drehgeberConfigVersion.cmake)
message("taken: ${{PACKAGE_VERSION_COMPATIBLE}}")
"""


def configure(tree: Path, work: Path, major: int, minor: int) -> Path:
    """The tree with another version, as far as CMake reads it."""
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(tree / "include", work / "tree/include")
    for name in ("CMakeLists.txt", "LICENSE", "src", "tools", "platform"):
        (work / "tree" / name).symlink_to(tree / name)
    text = (work / "tree" / HEADER).read_text(encoding="utf-8")
    for what, number in (("MAJOR", major), ("MINOR", minor), ("PATCH", 0)):
        text = re.sub(rf"(DG_VERSION_{what}) \d+", rf"\g<1> {number}", text)
    text = re.sub(r'(DG_VERSION) "[^"]*"', rf'\g<1> "{major}.{minor}.0"', text)
    (work / "tree" / HEADER).write_text(text, encoding="utf-8")
    options = [f"-DDREHGEBER_{part}=OFF" for part in ("LINUX", "TESTS", "HDL")]
    subprocess.run(["cmake", "-G", "Ninja", "-S", work / "tree", "-B", work / "build", *options], check=True, stdout=subprocess.PIPE)
    return work / "build"


def is_taken(build: Path, asked: str) -> bool:
    major, minor = asked.split(".")
    (build / "ask.cmake").write_text(ASK.format(asked=asked, major=major, minor=minor), encoding="utf-8")
    said = subprocess.run(["cmake", "-P", "ask.cmake"], cwd=build, check=True, text=True, stderr=subprocess.PIPE).stderr
    return said.strip() == "taken: TRUE"


def main():
    tree, work = (Path(word).resolve() for word in sys.argv[1:])
    complaints = []
    for (major, minor), (soname, asked) in ROWS.items():
        build = configure(tree, work, major, minor)
        found = re.findall(r"^  SONAME = (\S+)$", (build / "build.ninja").read_text(encoding="utf-8"), re.M)
        if found != [soname]:
            complaints.append(f"{major}.{minor}: SONAME {found}, expected {soname}")
        complaints += [f"{major}.{minor}: find_package(drehgeber {one}) is {'not ' if taken else ''}taken"
                       for one, taken in asked.items() if is_taken(build, one) != taken]
    print(*complaints, f"{len(ROWS)} versions, {len(complaints)} complaints", sep="\n")
    sys.exit(1 if complaints else 0)


main()
