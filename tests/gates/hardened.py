# SPDX-License-Identifier: MIT
"""A program that was linked with what makes exploits harder: position independent, relocations
read-only and bound at the start, stack protector, checked libc calls, and CET where the machine has
it. Read off the ELF file.

usage: hardened.py PROGRAM...
"""

import subprocess
import sys


def tool(*command):
    return subprocess.check_output(command, text=True)


def readelf(option, program):
    return tool("readelf", "-W", option, program)


def missing(program):
    """What the file lacks, in words."""
    head = readelf("-h", program)
    segments = readelf("-l", program)
    dynamic = readelf("-d", program)
    symbols = readelf("--dyn-syms", program)
    code = tool("objdump", "-d", "--disassemble=main", program)
    found = {
        "position independent code (PIE)": "Type:                              DYN" in head,
        "read-only relocations": "GNU_RELRO" in segments,
        "binding at the start": "BIND_NOW" in dynamic or "NOW" in dynamic.partition("FLAGS_1")[2],
        "a stack that is not executable": "GNU_STACK" in segments
        and not any("GNU_STACK" in line and "RWE" in line for line in segments.splitlines()),
        "stack protector": "__stack_chk_fail" in symbols,
        "checked libc calls": "_chk@" in symbols.replace("__stack_chk_fail", ""),
        # The linker's note is no proof: it wants all objects to have it, the C library's, too.
        "CET": "X86-64" not in head or "endbr64" in code,
    }
    return [what for what, there in found.items() if not there]


def main():
    programs = sys.argv[1:]
    lacking = [(program, what) for program in programs for what in missing(program)]
    for program, what in lacking:
        print(f"{program}: without {what}")
    if not programs or lacking:
        return 1
    print(f"{len(programs)} programs are hardened")
    return 0


sys.exit(main())
