# SPDX-License-Identifier: MIT
"""Who may include whom. A folder of src/ uses its own headers, the public headers of the folders
in its row, and the freestanding C headers plus string.h; a public header likewise. A room of
platform/ and a folder of tools/ use their own headers, those of the rooms in their row, and the
public headers of the folders in it; of system headers whichever they like. A folder's headers declare what
it defines, and no source declares what another one does, so that there is no way around an include.

usage: include_direction.py TREE
"""

import re
import sys
from os.path import normpath

from sources import blank, files, finish, read

# A folder with a stack.c is a protocol, and this is what it says travels on its wire.
MEDIUM = re.compile(r"\.medium = DG_MEDIUM_(\w+)")
# protocol: what it stands on beside the core; a folder that is one of these belongs to the protocol.
BESIDE = {"cia406": {"canopen"}}
# medium: the room of platform/linux with the ports of its protocols
ROOM = {"CHARACTERS": "linux/line", "FRAMES": "linux/can", "EDGES": "linux/clocked", "WORDS": "linux/interbus"}
# folder: the folders whose public headers it may include beside its own; add_protocols() has the rest
ALLOWED = {
    "core":        set(),
    "motion":      {"core"},
    "devices":     {"core"},
    "scpi":        {"core"},
    "control":     {"core", "motion", "scpi"},
    "instruments": {"core", "control", "devices"},
    "host":        {"core", "motion", "devices", "control", "instruments"},
    "bus":         {"core", "devices", "control", "host"},
    "rig":         {"core", "motion", "devices", "host", "bus", "scpi", "control"},
    "words":       {"core", "devices"},
}
# The lists of all protocols: they see each.
LISTS = ("devices", "instruments", "host", "words")
# Files that stand in a protocol's folder and belong to other libraries: the view of the control plane, its side of a
# handle and of a bus, what its wire looks like in words. No other file of the folder knows that there is one.
SEEN_FROM_OUTSIDE = {
    "instrument": {"core", "scpi", "control", "instruments"},
    "host":       {"core", "host"},
    "side":       {"core", "host"},
    "master":     {"core", "bus"},
    "coupler":    {"core", "bus"},
    "words":      {"core", "words"},
}
# room of platform/, folder of tools/: the same, and the rooms whose headers it may include:
# base < nvm, trace, plan < wires < rig < tools. Private headers of src/ stand there as src/FOLDER.
BELOW = {"core", "control", "devices", "instruments", "host", "bus", "rig", "words",
         "linux/base", "linux/nvm", "linux/trace", "linux/plan", "linux/wire"}
WIRES = set(ROOM.values())
ROOMS = {
    "linux/base":      {"core", "motion", "rig"},
    "linux/nvm":       {"core", "devices", "bus", "linux/base"},
    "linux/trace":     {"core", "words", "linux/base"},
    "linux/plan":      {"core", "motion", "devices", "host", "rig", "linux/base"},
    "linux/wire":      {"core", "control", "host", "bus", "rig", "linux/base", "linux/nvm", "linux/trace", "linux/plan"},
    "linux/rig":       {"motion"} | BELOW | WIRES,
    "hdl":             {"core", "motion", "host", "bus", "rig", "linux/base", "linux/nvm", "linux/plan"},
    "rp2040":          set(), # an image is an encoder with all that belongs to it
    "web":             {"core", "control", "devices", "instruments", "host", "bus", "rig", "words"},
    "web/libc":        set(),
    "web/libc/sys":    set(),
    "fmu":             {"core", "motion", "devices", "scpi", "control", "instruments", "host", "bus", "rig"},
    "tools/drehgeber": {"tools/drehgeber", "motion", "linux/rig", "fmu"} | BELOW | WIRES, # web/ is a program of its own
    "tools/manual":    {"core", "devices", "tools/drehgeber"} | BELOW,
    "tools/reference": {"core", "control", "devices", "instruments", "rig", "src/rig"},
    "tools/examples":  set(), # and what is below it: each the whole of a user's program
}
ROOMS |= {room: set(BELOW) for room in WIRES}
SPEAKING = ("linux/rig", "tools/drehgeber", "tools/manual", "tools/reference") # with every protocol
ANYTHING = ("rp2040", "tools/examples") # with all of src/


def add_protocols(tree):
    """The rows of the protocols that `tree` has, and of who may see them."""
    folders = set()
    for path in files(tree, "src", suffixes=("stack.c",)):
        folder = path.split("/")[1]
        own = {folder} | BESIDE.get(folder, set())
        folders |= own
        ALLOWED[folder] = {"core"} | own - {folder}
        ALLOWED.update({beside: {"core"} for beside in own - {folder}})
        ROOMS[ROOM[MEDIUM.search(read(tree, path))[1]]] |= own
    for folder in folders:
        own = {folder} | BESIDE.get(folder, set())
        ALLOWED.update({f"{folder}/{file}": own | seen for file, seen in SEEN_FROM_OUTSIDE.items()})
        OWNER.setdefault(f"{folder}.h", folder)
    for place in LISTS:
        ALLOWED[place] |= folders
    for place in SPEAKING:
        ROOMS[place] |= folders
    ROOMS["tools/reference"] |= {f"src/{folder}" for folder in folders}
    for place in ANYTHING:
        ROOMS[place] |= set(ALLOWED)
    ROWS.update(ALLOWED | ROOMS)


# public header: the folder that implements it
OWNER = {
    "angle.h":     "core",
    "api.h":       "core",
    "bits.h":      "core",
    "crc.h":       "core",
    "frame.h":     "core",
    "hal.h":       "core",
    "stack.h":     "core",
    "store.h":     "core",
    "tap.h":       "core",
    "text.h":      "core",
    "time.h":      "core",
    "version.h":   "core",
    "wide.h":      "core",
    "world.h":     "core",
    "course.h":    "core",
    "quantity.h":  "core",
    "motion.h":    "motion",
    "eds.h":       "canopen",
    "eds_rows.h":  "canopen",
    "slcan.h":     "canopen",
    "devices.h":   "devices",
    "protocols.h": "devices",
    "shaft.h":     "motion",
    "scpi.h":      "scpi",
    "fault.h":     "control",
    "line_fault.h": "control",
    "wire_fault.h": "control",
    "instrument.h": "control",
    "instruments.h": "instruments",
    "words.h":     "words",
    "control.h":   "control",
    "key.h":       "core",
    "model.h":     "core",
    "host.h":      "host",
    "host_wire.h": "host",
    "bus.h":       "bus",
    "rig.h":       "rig",
    "rig_engine.h": "rig",
    "figure.h":    "core",
    "form.h":      "core",
    "stamp.h":     "core",
    "bus_characters.h": "bus",
    "bus_edges.h": "bus",
    "bus_frames.h": "bus",
    "bus_master.h": "bus",
    "bus_queue.h": "bus",
    "bus_reader.h": "bus",
    "bus_words.h": "bus",
    "rfc2217.h":   "bus",
    "ring_master.h": "bus",
    "ring_coupler.h": "interbus",
}
ROWS = {}
# The header for users that includes all others; the core only implements its dg_version().
UMBRELLA = "drehgeber.h"
MAY_INCLUDE_UMBRELLA = "src/core/version.c"
SYSTEM = {"limits.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
INCLUDE = re.compile(r'^\s*#\s*include\b(?:\s*(?:<([^>\n]+)>|"([^"\n]+)"))?', re.M)


# What a file declares or defines, from the beginning of a line on: a function, with ';' or '{' behind it, or an object.
FUNCTION = re.compile(r"^[ \t]*(?!static\b|typedef\b|return\b|else\b)(?:extern )?(?:[A-Za-z_]\w*[ *\n]+)+?"
                      r"(?:__attribute__\(\(.*?\)\)\s*)?(\w+)\((?:[^;{}()]|\([^;{}()]*\))*\)\s*(;|\{)", re.M)
OBJECT = re.compile(r"^[ \t]*extern\b[^;{(]*?\b(\w+)(?:\[[^\]]*\])*(;)|"
                    r"^(?!static\b|extern\b|typedef\b)(?:\w+[ *]+)+(\w+)(?:\[[^\]]*\])*( =|;)", re.M)
DIRECTIVE = re.compile(r"^[ \t]*#(?:\\\n|[^\n])*", re.M)
# header: why it declares what a room above it defines
ABOVE = {
    "platform/linux/plan/stacks.h": "a plan goes through the list of stacks, which the rig makes of those it has",
    "platform/linux/plan/wire.h":   "a plan goes through the list of wires, likewise",
}
# A C library's headers, whose functions stand in two places: of the board and of the web page.
LIBRARY = "platform/web/libc/"


def is_seen_from_outside(path):
    """A file of a protocol's folder that belongs to another library."""
    return path.endswith(tuple(f"/{file}.c" for file in SEEN_FROM_OUTSIDE))


def place_of(path):
    """Its row: a folder of src/ or tools/, a room of platform/."""
    parts = path.split("/")[:-1]
    if parts[0] == "include":
        return OWNER.get(path.rsplit("/", 1)[1])
    if path.startswith("src/") and is_seen_from_outside(path):
        return path[len("src/"):-len(".c")]
    return "/".join(parts[:2] if parts[0] == "tools" else parts[1:])


def public(path, place, header):
    """Why `path` must not include this public header, or None."""
    if header == UMBRELLA:
        return None if path == MAY_INCLUDE_UMBRELLA or place in ROOMS else f"drehgeber/{header} is for users"
    owner = OWNER.get(header)
    if owner is None:
        return f"drehgeber/{header} has no owner in this gate's table"
    return None if owner in ROWS[place] | {place} else f"{place} must not use {owner}"


def private(path, place, header, at):
    """Why `path` must not include a header that is no public one, or None."""
    folder = path.rsplit("/", 1)[0]
    if place in ALLOWED and "/" in place:
        return f"{place} sees the public headers only"
    if f"{folder}/{header}" in at.get(header, ()):
        return None
    if place in ALLOWED:
        return f'"{header}" is not a file of this folder'
    found = at.get(header.rsplit("/", 1)[1] if "/" in header else header, ())
    if "/" in header:
        found = [other for other in found if other == normpath(f"{folder}/{header}")]
    owners = {f"src/{place_of(other)}" if other.startswith("src/") else place_of(other) for other in found}
    if not owners:
        return f'"{header}" is nowhere'
    return None if owners <= ROWS[place] else f"{place} must not use {', '.join(sorted(owners))}"


def complaint(path, place, at, system, local):
    """Why `path` must not include this header, or None."""
    if not system and not local:
        return "includes what a macro says, which nobody can follow"
    if system:
        return None if system in SYSTEM or place in ROOMS else f"<{system}> is not for the core"
    if local.startswith("drehgeber/"):
        return public(path, place, local[len("drehgeber/"):])
    return private(path, place, local, at)


def ambiguous(at):
    """A file of a room has a name of its own, so that a name says which one is meant."""
    for name, paths in sorted(at.items()):
        named = [path for path in paths if not path.startswith("tools/")]
        if len(named) > 1 and any(path.startswith("platform/") for path in named):
            yield f"{name} is the name of several: {' '.join(named)}"


def names(text):
    """Name, line, and whether it is only declared, of each function and object with external linkage."""
    bare = DIRECTIVE.sub(lambda match: "\n" * match.group().count("\n"), blank(text))
    for match in FUNCTION.finditer(bare):
        yield match[1], bare.count("\n", 0, match.start(1)) + 1, match[2] == ";"
    for match in OBJECT.finditer(bare):
        yield match[1] or match[3], bare.count("\n", 0, match.end()) + 1, match[1] is not None


def strangers(path, declared, defined):
    """Complaints about what is declared beside the headers of where it is defined."""
    place = place_of(path)
    for name, line in declared:
        at = defined.get(name, ())
        places = {place_of(other) for other in at}
        # A protocol's view for the control plane, for a handle, or for traces is declared by these, or by the protocol.
        places |= {part for other in places if other in ALLOWED and "/" in other for part in other.split("/")}
        if path.endswith(".c") and at and path not in at and name != "main":
            yield f"{path}:{line}: declares {name}, which is for a header of {' '.join(at)}"
        elif at and place not in places:
            yield f"{path}:{line}: declares {name} of {' '.join(at)}"


def main():
    tree = sys.argv[1]
    add_protocols(tree)
    sources = files(tree, "src", "platform", "tools", suffixes=(".c", ".h", ".def"))
    publics = files(tree, "include/drehgeber", suffixes=(".h",))
    at = {}
    for path in sources:
        at.setdefault(path.rsplit("/", 1)[1], []).append(path)
    complaints = list(ambiguous(at))
    declared, defined = {}, {}
    for path in sources + publics:
        for name, line, only in names(read(tree, path)):
            if only:
                declared.setdefault(path, []).append((name, line))
            else:
                defined.setdefault(name, []).append(path)
    for path in declared:
        if not path.endswith(UMBRELLA) and not path.startswith(LIBRARY) and path not in ABOVE:
            complaints += strangers(path, declared[path], defined)
    for path in sources + publics:
        if path.rsplit("/", 1)[1] == UMBRELLA:
            continue
        place = place_of(path)
        if place not in ROWS:
            complaints.append(f"{path}: not in this gate's tables")
            continue
        # Comments may name headers; strings are what is looked for.
        for match in INCLUDE.finditer(blank(read(tree, path), strings=False)):
            why = complaint(path, place, at, match.group(1), match.group(2))
            if why:
                complaints.append(f"{path}: {why}")
    finish(len(sources) + len(publics), complaints)


main()
