# SPDX-License-Identifier: MIT
"""A program that names one model links the stack of that model and no other, and no control plane unless it
has one: no symbol of an image is one that a library of a folder beside FOLDERS defines.

usage: one_stack.py NM FOLDER,FOLDER... IMAGE LIBRARY...
"""

import re
import subprocess
import sys

from sources import finish


def symbols(nm, binary):
    """What has external linkage in `binary`, and is defined there."""
    lines = subprocess.check_output([nm, "--extern-only", "--defined-only", "--format=posix", binary], text=True)
    return {line.split()[0] for line in lines.splitlines() if line and not line.endswith(":")}


def main():
    nm, folders, image, *libraries = sys.argv[1:]
    allowed, complaints = set(folders.split(",")), []
    linked = symbols(nm, image)
    for library in libraries:
        folder = re.search(r"libdg_(\w+)\.a$", library).group(1)
        if folder not in allowed:
            complaints += [f"{image} has {name} of {folder}" for name in sorted(linked & symbols(nm, library))]
        elif not linked & symbols(nm, library):
            complaints.append(f"{image} has nothing of {folder}")
    finish(len(linked), complaints)


main()
