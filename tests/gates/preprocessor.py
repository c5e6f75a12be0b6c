# SPDX-License-Identifier: MIT
"""No #if chooses between two programs: optional parts are whole files or NULL operations. None stands inside
a function; outside there are include guards, what C++ needs to read a header, and what the table names.

usage: preprocessor.py TREE
"""

import re
import sys

from sources import blank, files, finish, read

# header: what it cannot say otherwise
CONDITIONAL = {
    "include/drehgeber/api.h":  "each compiler has its own words for what a library exports",
    "include/drehgeber/wide.h": "a product of 64 bits in C where the processor has no instruction for it",
    "platform/fmu/fmi.h":       "each compiler has its own words for what a library exports",
    "platform/hdl/hdl.h":       "each compiler has its own words for what a library exports",
    "src/core/wide.c":          "a product of 128 bits in C where the processor has no instruction for it",
}
CONDITION = re.compile(r"\s*#\s*(?:if|ifdef|ifndef|elif|else)\b")
GUARD = re.compile(r"\s*#\s*ifndef\s+(\w+)\s*\n\s*#\s*define\s+\1\s*(?:\n|$)")
FOR_CPP = re.compile(r"^#ifdef __cplusplus\n(?:extern\s+\{|\})\n#endif$", re.M)


def conditions(text):
    """Number and text of each line with a condition, and whether it is inside braces."""
    bare = FOR_CPP.sub("\n\n", blank(text))
    guard = GUARD.match(bare)
    bare = "\n" * guard.group().count("\n") + bare[guard.end():] if guard else bare
    depth = 0
    for number, line in enumerate(bare.split("\n"), 1):
        if CONDITION.match(line):
            yield number, line.strip(), depth > 0
        elif not line.lstrip().startswith("#"):
            depth += line.count("{") - line.count("}")


def main():
    tree = sys.argv[1]
    complaints = []
    paths = files(tree, "include", "src", "platform", "tools", suffixes=(".c", ".h", ".def", ".cpp"))
    for path in paths:
        for number, line, inside in conditions(read(tree, path)):
            if inside:
                complaints.append(f"{path}:{number}: {line} inside braces")
            elif path not in CONDITIONAL:
                complaints.append(f"{path}:{number}: {line} is not in this gate's table")
    finish(len(paths), complaints)


main()
