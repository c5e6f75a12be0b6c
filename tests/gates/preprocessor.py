# SPDX-License-Identifier: MIT
"""No #if inside braces in src/: optional parts are whole files or NULL operations.

usage: preprocessor.py TREE
"""

import re
import sys

from sources import blank, files, finish, read

CONDITION = re.compile(r"\s*#\s*(if|ifdef|ifndef|elif|else)\b")


def main():
    tree = sys.argv[1]
    complaints = []
    paths = files(tree, "src", suffixes=(".c", ".h", ".def"))
    for path in paths:
        depth = 0
        for number, line in enumerate(blank(read(tree, path)).split("\n"), 1):
            if CONDITION.match(line):
                if depth:
                    complaints.append(f"{path}:{number}:{line.rstrip()} inside braces")
            elif not line.lstrip().startswith("#"):
                depth += line.count("{") - line.count("}")
    finish(len(paths), complaints)


main()
