# SPDX-License-Identifier: MIT
"""What include/drehgeber/host.h promised is still there: every line of the list is a prototype, a struct, a
value or an object of the header as it is now, and each symbol is exported. What was added since is told, and
goes into the list with a release. Layouts in bytes are held by src/host/layout.c.

usage: abi.py TREE SHARED        compare
       abi.py TREE --print       what the list would be
"""

import re
import subprocess
import sys
from pathlib import Path

from sources import blank, finish, read

HEADER, LIST = "include/drehgeber/host.h", "tests/abi/host.list"
FUNCTION = re.compile(r"DG_API ([\w ]+?[ *]+)(\w+)\(((?:[^()]|\([^()]*\))*)\);")
OBJECT = re.compile(r"DG_API extern ([\w ]+?)((?:\w+, )*\w+);")
STRUCT = re.compile(r"struct (\w+) \{([^}]*)\};")
ENUM = re.compile(r"enum (\w+) \{([^}]*)\};")
VALUE = re.compile(r"^#define (DG_HOST_\w+)[ ]+(\S+)$", re.M)
# The name of a parameter, which is nobody's business but the header's.
NAME = re.compile(r"(?<=[ *])\w+(?=(?:\[\d+\])?$)")


def squeeze(text):
    return re.sub(r"\s+", " ", text).strip()


def parameters(text):
    """Types without names, but for those of functions that are handed over."""
    parts = re.split(r", (?![^()]*\))", text)
    return ", ".join(part if "(" in part or part == "void" else NAME.sub("", part).strip() for part in parts)


def promises(tree):
    """What the header promises, a line each."""
    text = re.sub(r"[ \t]+", " ", blank(read(tree, HEADER)))
    lines = [f"value {name} {value}" for name, value in VALUE.findall(text)]
    text = squeeze(re.sub(r"^#.*$", "", text, flags=re.M))
    for kind, name, inside in FUNCTION.findall(text):
        lines.append(f"function {squeeze(kind)} {name}({parameters(squeeze(inside))})")
    for kind, names in OBJECT.findall(text):
        lines += [f"object {squeeze(kind)} {name}" for name in names.split(", ")]
    for name, inside in STRUCT.findall(text):
        lines.append(f"struct {name} {{{squeeze(inside)}}}")
    for name, inside in ENUM.findall(text):
        lines += [f"enum {name}: {line}" for line in enumerators(inside)]
    return lines


def enumerators(inside):
    """NAME = VALUE of each, also of those that only count on."""
    last, lines = -1, []
    for part in filter(None, map(squeeze, inside.split(","))):
        name, _, value = part.partition(" = ")
        last = int(value, 0) if value else last + 1
        lines.append(f"{name} = {value or last}")
    return lines


def exported(shared):
    lines = subprocess.check_output(["nm", "-D", "--defined-only", "--format=posix", shared], text=True)
    return {line.split()[0] for line in lines.splitlines()}


def main():
    tree, shared = sys.argv[1:]
    now = promises(tree)
    if shared == "--print":
        print("\n".join(now))
        return
    listed = (Path(tree) / LIST).read_text().splitlines()
    symbols = exported(shared)
    complaints = [f"{HEADER} has not any more: {line}" for line in listed if line not in now]
    for line in now:
        name = re.search(r"(dg_\w+)(?:\(|$)", line) if line.startswith(("function", "object")) else None
        if name and name.group(1) not in symbols:
            complaints.append(f"{shared} does not export {name.group(1)}")
    print(f"{len(set(now) - set(listed))} added since the list was made")
    finish(len(listed), complaints)


main()
