# SPDX-License-Identifier: MIT
"""Who may include whom. A folder of src/ uses its own headers, the public headers of the folders
in its row, and the freestanding C headers plus string.h; a public header likewise.

usage: include_direction.py TREE
"""

import re
import sys

from sources import blank, files, finish, read

# folder: the folders whose public headers it may include beside its own
ALLOWED = {
    "core":      set(),
    "motion":    {"core"},
    "hiperface": {"core"},
    "biss":      {"core"},
    "canopen":   {"core"},
    "cia406":    {"core", "canopen"},
    "interbus":  {"core"},
    "devices":   {"core", "hiperface", "biss", "cia406", "interbus"},
    "scpi":      {"core"},
    "control":   {"core", "motion", "scpi", "hiperface", "biss", "canopen", "cia406", "interbus", "devices"},
}
# public header: the folder that implements it
OWNER = {
    "angle.h":     "core",
    "api.h":       "core",
    "bits.h":      "core",
    "crc.h":       "core",
    "hal.h":       "core",
    "store.h":     "core",
    "time.h":      "core",
    "world.h":     "core",
    "motion.h":    "motion",
    "hiperface.h": "hiperface",
    "biss.h":      "biss",
    "canopen.h":   "canopen",
    "cia406.h":    "cia406",
    "interbus.h":  "interbus",
    "devices.h":   "devices",
    "shaft.h":     "motion",
    "scpi.h":      "scpi",
    "fault.h":     "control",
    "control.h":   "control",
}
# The header for users that includes all others; the core only implements its dg_version().
UMBRELLA = "drehgeber.h"
MAY_INCLUDE_UMBRELLA = "src/core/version.c"
SYSTEM = {"limits.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
INCLUDE = re.compile(r'^\s*#\s*include\b(?:\s*(?:<([^>\n]+)>|"([^"\n]+)"))?', re.M)


def complaint(path, folder, own, system, local):
    """Why `path` of `folder` must not include this header, or None."""
    if not system and not local:
        return "includes what a macro says, which nobody can follow"
    if system:
        return None if system in SYSTEM else f"<{system}> is not for the core"
    if local.startswith("drehgeber/"):
        header = local[len("drehgeber/"):]
        if header == UMBRELLA:
            return None if path == MAY_INCLUDE_UMBRELLA else f"{local} is for users"
        owner = OWNER.get(header)
        if owner is None:
            return f"{local} has no owner in this gate's table"
        return None if owner in ALLOWED[folder] | {folder} else f"{folder} must not use {owner}"
    return None if local in own else f'"{local}" is not a file of this folder'


def main():
    tree = sys.argv[1]
    sources = files(tree, "src", suffixes=(".c", ".h", ".def"))
    publics = files(tree, "include/drehgeber", suffixes=(".h",))
    complaints = []
    for path in sources + publics:
        place, name = path.rsplit("/", 1)
        if name == UMBRELLA:
            continue
        folder = OWNER.get(name) if path in publics else path.split("/")[1]
        if folder not in ALLOWED:
            complaints.append(f"{path}: not in this gate's tables")
            continue
        own = {other.rsplit("/", 1)[1] for other in sources if other.startswith(place + "/")}
        # Comments may name headers; strings are what is looked for.
        for match in INCLUDE.finditer(blank(read(tree, path), strings=False)):
            why = complaint(path, folder, own, match.group(1), match.group(2))
            if why:
                complaints.append(f"{path}: {why}")
    finish(len(sources) + len(publics), complaints)


main()
