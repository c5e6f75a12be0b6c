# SPDX-License-Identifier: MIT
"""What the public headers promised is still there: every line of the list is a prototype, an object, a type, a
macro or a value of one of them, as they are now, and each symbol is exported. What was added since is told, and goes
into the list with a release. The list's head counts it, so that a promise is struck off only with another SONAME.
Layouts of host.h in bytes are held by src/host/layout.c.

usage: abi.py TREE SHARED        compare
       abi.py TREE --print       what the list would be, for whoever adds to it or begins it anew
"""

import hashlib
import re
import subprocess
import sys
from pathlib import Path

from sources import blank, files, finish, read
from versions import parts, version_of

LIST = "tests/abi/promises.list"
DECLARED = r"([\w ]+?[ *]+)(\w+)\(((?:[^()]|\([^()]*\))*)\)"
FUNCTION = re.compile(rf"DG_API {DECLARED};")
TYPED = re.compile(r"DG_API (\w+) (\w+);")
INLINE = re.compile(rf"static inline {DECLARED} \{{")
TYPE = re.compile(r"typedef [^;]*;")
# How many elements a table has may grow.
OBJECT = re.compile(r"DG_API extern ([\w *]+?)((?:\w+(?:\[\w*\])?, )*\w+(?:\[\w*\])?);")
SIZE = re.compile(r"\[\w*\]")
# With unions and structs without a name in it, down to the third level.
STRUCT = re.compile(r"(struct|union) (\w+) \{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\};")
ENUM = re.compile(r"enum (\w+) \{([^}]*)\};")
VALUE = re.compile(r"^#define (DG_\w+) (\S.*?)\s*$", re.M)
MACRO = re.compile(r"^#define (DG_\w+\([^)]*\))", re.M)
BOUND = re.compile(r"\w+_COUNT(?=\])")
# No values that somebody computes with: what changes with each release, grows with each addition, or is no number.
# A count that a struct has an array of is one.
UNPROMISED = re.compile(r"DG_VERSION\w*|DG_API|\w+_COUNT")
# The name of a parameter, which is nobody's business but the header's.
NAME = re.compile(r"(?<=[ *])\w+(?=(?:\[\d+\])?$)")


def squeeze(text):
    return re.sub(r"\s+", " ", text).strip()


def parameters(text):
    """Types without names, but for those of functions that are handed over."""
    parts = re.split(r", (?![^()]*\))", text)
    return ", ".join(part if "(" in part or part == "void" else NAME.sub("", part).strip() for part in parts)


def promises(tree):
    """What the headers promise, a line each."""
    texts = [without_comments(read(tree, path)) for path in files(tree, "include", suffixes=(".h",))]
    lines = [line for text in texts for line in declarations(text)]
    bounds = {bound for line in lines if line.startswith(("struct", "union")) for bound in BOUND.findall(line)}
    lines += [line for text in texts for line in values(text, bounds)]
    return list(dict.fromkeys(lines))


def without_comments(text):
    """Of a macro of several lines one is left."""
    return re.sub(r"[ \t]+", " ", blank(text).replace("\\\n", " "))


def without_macros(text):
    return squeeze(re.sub(r"^#.*$", "", text, flags=re.M))


def is_promised(name, bounds):
    return name in bounds or not UNPROMISED.fullmatch(name)


def values(text, bounds):
    """Constants, macros and enumerators of a header."""
    yield from (f"value {name} {value}" for name, value in VALUE.findall(text) if is_promised(name, bounds))
    yield from (f"macro {macro}" for macro in MACRO.findall(text))
    for name, inside in ENUM.findall(without_macros(text)):
        yield from (f"enum {name}: {line}" for line in enumerators(inside) if is_promised(line.split()[0], bounds))


def declarations(text):
    """Functions, objects and types of a header."""
    text, lines = without_macros(text), []
    for how, pattern in (("function", FUNCTION), ("inline", INLINE)):
        lines += [f"{how} {squeeze(kind)} {name}({parameters(squeeze(inside))})" for kind, name, inside in pattern.findall(text)]
    lines += [f"function {kind} {name}" for kind, name in TYPED.findall(text)]
    for kind, names in OBJECT.findall(text):
        lines += [f"object {squeeze(kind)} {name}" for name in SIZE.sub("[]", names).split(", ")]
    return lines + TYPE.findall(text) + [f"{kind} {name} {{{squeeze(inside)}}}" for kind, name, inside in STRUCT.findall(text)]


def unread(tree):
    """A complaint for each header with declarations that these patterns do not know."""
    for path in files(tree, "include", suffixes=(".h",)):
        text = without_macros(without_comments(read(tree, path)))
        known = sum(len(pattern.findall(text)) for pattern in (FUNCTION, TYPED, OBJECT))
        there = len(re.findall(r"\bDG_API\b", text))
        if known != there:
            yield f"{path}: {there} declarations with DG_API, of which {known} can be read"


def enumerators(inside):
    """NAME = VALUE of each, also of those that only count on, from an expression, too."""
    last, ahead, lines = "", -1, []
    for part in filter(None, map(squeeze, inside.split(","))):
        name, _, value = part.partition(" = ")
        if not name.isidentifier(): # a macro makes them
            continue
        last, ahead = (value, 0) if value else (last, ahead + 1)
        number = re.fullmatch(r"(0x[0-9A-Fa-f]+|\d+)u?|", last)
        counted = int(number.group(1) or "0", 0) + ahead if number else f"{last} + {ahead}" if ahead else last
        lines.append(f"{name} = {counted}")
    return lines


def head(name, lines):
    digest = hashlib.sha256("\n".join(lines).encode()).hexdigest()
    return f"soname {name}: {len(lines)} promises, sha256 {digest[:16]}"


def struck(name, first, listed):
    """What is wrong with the list itself, as a list."""
    if not first.startswith(f"soname {name}:"):
        return [f"{LIST} is of another SONAME than {name}: begin it anew, with abi.py TREE --print"]
    if first != head(name, listed):
        return [f"{LIST} is not what its head says: a promise is changed or struck off only with another SONAME"]
    return []


def exported(shared):
    lines = subprocess.check_output(["nm", "-D", "--defined-only", "--format=posix", shared], text=True)
    return {line.split()[0] for line in lines.splitlines()}


def main():
    tree, shared = sys.argv[1:]
    now, name = promises(tree), parts(version_of(tree)[0])["soname"]
    first, *listed = (Path(tree) / LIST).read_text(encoding="utf-8").splitlines() or [""]
    complaints = struck(name, first, listed)
    if shared == "--print":
        if first.startswith(f"soname {name}:"):
            now = sys.exit(complaints[0]) if complaints else listed + [line for line in now if line not in listed]
        print("\n".join([head(name, now), *now]))
        return
    symbols = exported(shared)
    complaints += unread(tree)
    complaints += [f"the headers have not any more: {line}" for line in listed if line not in now]
    for line in now:
        symbol = re.search(r"(dg_\w+)(?:[(\[]|$)", line) if line.startswith(("function", "object")) else None
        if symbol and symbol.group(1) not in symbols:
            complaints.append(f"{shared} does not export {symbol.group(1)}")
    print(f"{len(set(now) - set(listed))} added since the list was made")
    finish(len(listed), complaints)


main()
