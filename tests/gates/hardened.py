# SPDX-License-Identifier: MIT
"""Whatever is installed was built with what makes exploits harder. Programs and shared libraries, read off the ELF
file: position independent, relocations read-only and bound at the start, no executable stack. Each object that
any of them is made of: stack protector where its source has an array on the stack, no unchecked libc call that has
a checked one, and on x86-64 marked for CET. (The linker's own mark of CET wants the C library's objects to have it.)

usage: hardened.py TREE PREFIX BUILD    what is installed below PREFIX, as BUILD, a tree for ninja, has built it
"""

import re
import subprocess
import sys
from pathlib import Path

from sources import blank, finish, read

# With checked calls none of them is called as itself: those that have a format that is no literal, or no buffer.
CHECKED = {"printf", "fprintf", "vprintf", "vfprintf", "vsnprintf", "sprintf", "vsprintf", "dprintf", "vdprintf", "gets"}
BODY = re.compile(r"^\{\n(.*?)^\}$", re.M | re.S)
ARRAY = re.compile(r"^[ \t]+(?!static|typedef|return|extern)(?:const )?(?:struct |unsigned |signed )?\w+ \*?(?:const )?"
                   r"\w+(?:\[[^\]\n]*\])+(?: =|,|;)", re.M)


def tool(*command):
    return subprocess.check_output(command, text=True)


def of_each(paths, option):
    """What readelf says of each file, by path. It names none where there is only one, so that the first is said twice."""
    parts = re.split(r"^File: (.*)$", tool("readelf", "-W", option, *paths, paths[0]), flags=re.M)[1:]
    return dict(zip(parts[::2], parts[1::2]))


def unlinked(program):
    """What a program or shared library lacks, in words."""
    head, segments, dynamic = (tool("readelf", "-W", option, program) for option in ("-h", "-l", "-d"))
    found = {
        "position independent code": "Type:                              DYN" in head,
        "read-only relocations": "GNU_RELRO" in segments,
        "binding at the start": "BIND_NOW" in dynamic or "NOW" in dynamic.partition("FLAGS_1")[2],
        "a stack that is not executable": "GNU_STACK" in segments
        and not any("GNU_STACK" in line and "RWE" in line for line in segments.splitlines()),
    }
    return [what for what, there in found.items() if not there]


def source_of(tree, build, path):
    """Text of an object's source. CMake calls the object DIR/CMakeFiles/TARGET.dir/FILE.o, and `..` in it `__`."""
    name = re.sub(r"(^|/)CMakeFiles/[^/]*\.dir/", r"\1", path.removesuffix(".o")).replace("__/", "../")
    return read(tree if (tree / name).exists() else build, name)


def has_array(text):
    """Whether a function has an array on the stack."""
    return any(ARRAY.search(body) for body in BODY.findall(blank(text)))


def lacking(tree, build, objects):
    """Object, and what it lacks in words."""
    paths = [build / path for path in objects]
    notes, heads = of_each(paths, "-n"), of_each(paths, "-h")
    undefined = {}
    for line in tool("nm", "-Au", *paths).splitlines():
        path, _, name = line.rpartition(" ")
        undefined.setdefault(path.split(":")[0], set()).add(name)
    for path in objects:
        full = str(build / path)
        calls = undefined.get(full, set())
        if "X86-64" in heads[full] and not re.search(r"x86 feature:.*\bIBT\b.*\bSHSTK\b", notes[full]):
            yield path, "CET"
        if "__stack_chk_fail" not in calls and has_array(source_of(tree, build, path)):
            yield path, "stack protector"
        if calls & CHECKED:
            yield path, f"checks of {', '.join(sorted(calls & CHECKED))}"


def installed(prefix):
    """Programs and shared libraries, static ones."""
    binaries, archives = [], []
    for path in sorted(path for path in prefix.rglob("*") if path.is_file() and not path.is_symlink()):
        with path.open("rb") as file:
            magic = file.read(8)
        if magic.startswith(b"\x7fELF"):
            binaries.append(path)
        elif magic == b"!<arch>\n":
            archives.append(path)
    return binaries, archives


def main():
    tree, prefix, build = map(Path, sys.argv[1:])
    binaries, archives = installed(prefix)
    if not binaries:
        sys.exit(f"nothing is installed in {prefix}")
    complaints = [f"{path}: without {what}" for path in binaries for what in unlinked(path)]
    inputs = tool("ninja", "-C", build, "-t", "inputs", *(path.name for path in binaries + archives)).splitlines()
    objects = sorted({path for path in inputs if path.endswith(".o")})
    complaints += [f"{path}: without {what}" for path, what in lacking(tree, build, objects)]
    for path in binaries + archives:
        print(path.relative_to(prefix))
    finish(len(objects), complaints)


main()
