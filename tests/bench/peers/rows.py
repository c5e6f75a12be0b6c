#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints an EDS file as rows of C, one for each sub-index, for the dictionaries of peers.

usage: rows.py EDS NODE_ID
"""

import configparser
import re
import sys

OBJECT = re.compile(r"^([0-9A-Fa-f]{4})(?:sub([0-9A-Fa-f]+))?$")
BITS = {2: 8, 3: 16, 4: 32, 5: 8, 6: 16, 7: 32}
STRING = 9


def number(text, node):
    """A default, which may count from the node-ID."""
    return sum(node if part == "$NODEID" else int(part, 0) for part in (text or "0").split("+"))


def row(name, section, node):
    """One row, or None: an object that only has sub-indices."""
    match = OBJECT.match(name)
    if not match or "DataType" not in section:
        return None
    index, sub = int(match[1], 16), int(match[2] or "0", 16)
    kind, access = int(section["DataType"], 0), section["AccessType"]
    default = section.get("DefaultValue", "")
    text = f'"{default}"' if kind == STRING else "0"
    bits = 8 * len(default) if kind == STRING else BITS[kind]
    value = 0 if kind == STRING else number(default, node) & 0xFFFFFFFF
    readable, writable = int(access != "wo"), int(access in ("rw", "wo"))
    mappable = int(section.get("PDOMapping", "0"))
    return index, sub, f"{{0x{index:04X}, {sub}, {kind}, {bits}, {readable}, {writable}, {mappable}, 0x{value:X}u, {text}}},"


def main():
    eds = configparser.ConfigParser(strict=True, interpolation=None)
    eds.optionxform = str
    eds.read(sys.argv[1], encoding="utf-8")
    rows = [row(name, eds[name], int(sys.argv[2])) for name in eds.sections()]
    print(*(text for _index, _sub, text in sorted(found for found in rows if found)), sep="\n")


main()
