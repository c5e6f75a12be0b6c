# SPDX-License-Identifier: MIT
"""What the gates have in common: which files there are, and C without its comments."""

import os
import re
import sys

# Not part of the source: what is built, and what tools leave behind.
IGNORED = {".git", "build", ".cache", "__pycache__", ".pytest_cache", ".mypy_cache"}


def files(tree, *folders, suffixes=("",)):
    """Paths below `folders` of `tree`, relative to it, sorted; the caller may rely on one or more."""
    found = []
    for folder in folders or ("",):
        for parent, names, leaves in os.walk(os.path.join(tree, folder)):
            names[:] = [name for name in names if name not in IGNORED]
            found += [os.path.join(parent, leaf) for leaf in leaves
                      if leaf.endswith(suffixes) and leaf not in IGNORED]
    if not found:
        sys.exit(f"nothing to check in {tree}: {folders} {suffixes}")
    return sorted(os.path.relpath(path, tree) for path in found)


def read(tree, path):
    with open(os.path.join(tree, path), encoding="utf-8") as file:
        return file.read()


TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def blank(text, strings=True):
    """`text` with comments, and string literals unless told otherwise, blanked; lines stay."""

    def hide(match):
        token = match.group()
        if token[0] != "/" and not strings:
            return token
        return "\n" * token.count("\n") or " "

    return TOKEN.sub(hide, text)


def finish(checked, complaints):
    """Print every complaint and leave with the gate's verdict."""
    for complaint in complaints:
        print(complaint)
    print(f"{checked} checked, {len(complaints)} complaints")
    sys.exit(1 if complaints or not checked else 0)
