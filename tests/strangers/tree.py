# SPDX-License-Identifier: MIT
"""Makes a copy of the tree that has the strangers in it, as somebody would add them: new files, and rows in files that
are there. What is the same since the last call is left alone, so that little is built anew.

usage: tree.py TREE [TO]    prints which existing files each stranger touches, and how long the board is; more than MOST
                            and BOARD_MOST are refused, and so is a row without its place. Without TO nothing is written
"""

import os
import sys
from pathlib import Path

MOST = {"eleven": 8, "tenbit": 8, "udp": 2}  # existing files: a protocol, a wire
BOARD, BOARD_MOST = "board/board.c", 60  # lines that are not empty
LEFT_OUT = {".git", "build", "__pycache__", ".pytest_cache", ".mypy_cache", ".ruff_cache", ".cache"}
APART = Path("tests/strangers")

CHECK_ELEVEN = """static void check_eleven(const struct host_rig_model *row)
{
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    struct heard heard;

    sends(self,
          (struct dg_host_event){.at = READY, .kind = DG_HOST_BYTES, .length = 1, .data = {0x02}},
          READY + MS, &heard);
    ASSERT_HEARD(heard, 0x02, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0x42);
}

"""
CHECK_TENBIT = """static void check_tenbit(const struct host_rig_model *row)
{
    struct dg_host *self = host_rig_start(&host_rig_here, row->name);
    uint64_t bits = 0;

    for (uint8_t i = 0; i < row->width; i++) {
        (void)dg_host_clock(self, READY + i * 1000u, false);
        bits = bits << 1 | (uint64_t)dg_host_clock(self, READY + i * 1000u + 500u, true);
    }
    assert_int_equal(bits, row->position);
}

"""
DOOR_UDP = """    {
        .name = "udp",
        .make = lx_can_bus_make,
        .open_can = lx_udp_can_open,
        .help = "CAN in UDP datagrams, a frame each; the encoders answer whoever has spoken last",
    },
"""
KIND_UDP = """    {
        .name = "udp",
        .stations_max = DG_BUS_FRAMES_ENCODERS,
        .media = DG_PLAN_CARRIES(FRAMES),
        .where = "HOST:PORT",
        .usual = "127.0.0.1:20000",
        .keys = &pace_keys,
        .settings = &dg_plan_pace_usual,
    },
"""
PROTOCOLS, MESON, WIRES = "include/drehgeber/protocols.h", "meson.build", "platform/linux/rig/wires.c"
KINDS = "src/rig/plan_wires.c"
PAGE, SUITES = "README.md", "tests/conformance/conformance.c"
MODELS, EXCHANGES = "tests/support/host_rig.c", "tests/unit/test_host.c"
# stranger: (file, what stands there, what is put in front of it)
ROWS = {
    "eleven": [
        (PROTOCOLS, '#include "drehgeber/hiperface.h"\n', '#include "drehgeber/eleven.h"\n'),
        (PROTOCOLS, "\n\n/** ROW(PREFIX) for those that have dg_PREFIX_words", " ROW(eleven)"),
        (PROTOCOLS, "ROW(hf) ROW(cia406)", "ROW(eleven) "),
        (PROTOCOLS, "ROW(f3658) ", "ROW(eleven_24) "),
        (MESON, "  'src/devices/f36x8.c',\n", "  'src/devices/eleven.c',\n"),
        (MESON, "  'src/hiperface/check.c',\n",
         "".join(f"  'src/eleven/{name}.c',\n" for name in ("host", "instrument", "keys", "side", "stack", "words"))),
        (WIRES, "&lx_hf_stack,", "&lx_eleven_stack, "),
        (PAGE, "| `f3658` |", "| `eleven-24` | nobody's, 24 bit | eleven characters | [about it](src/eleven/README.md) |\n"),
        (SUITES, "\nstatic struct cf_suite suite;", '#include "eleven_steps.h"\n'),
        (SUITES, '        {"cia406", ', '        {"eleven", cf_eleven, prove},\n'),
        (MODELS, "\nstruct host_rig_place host_rig_here;", '#include "drehgeber/eleven.h"\n'),
        (MODELS, "#define BISS ", '#define ELEVEN "eleven", &dg_eleven_wire, DG_HOST_MEDIUM_CHARACTERS, "slot"\n'),
        (MODELS, '    {"f3658", ', '    {"eleven-24", "24 bit, singleturn", false, false, ELEVEN, 1u << 22, 0},\n'),
        (EXCHANGES, '#include "host_rig.h"\n', '#include "drehgeber/eleven.h"\n'),
        (EXCHANGES, "/* What is done with the encoders of each wire. */\n", CHECK_ELEVEN),
        (EXCHANGES, "    {&dg_hf_wire, check_hiperface},", "    {&dg_eleven_wire, check_eleven},\n"),
    ],
    "tenbit": [
        (PROTOCOLS, "\n/** ROW(PREFIX) for each protocol:", '#include "drehgeber/tenbit.h"\n'),
        (PROTOCOLS, "\n\n/** ROW(PREFIX) for those that have dg_PREFIX_words", " ROW(tenbit)"),
        (PROTOCOLS, "ROW(f3658) ", "ROW(tenbit_low) ROW(tenbit_high) "),
        (MESON, "  'src/eleven/host.c',\n", "  'src/devices/tenbit.c',\n"),
        (MESON, "  'src/words/line.c',\n",
         "".join(f"  'src/tenbit/{name}.c',\n" for name in ("host", "instrument", "master", "stack"))),
        (WIRES, "&lx_hf_stack,", "&lx_tenbit_stack, "),
        (PAGE, "| `f3658` |", "| `tenbit-low`, `tenbit-high` | nobody's, 10 bit | ten bits | [about it](src/tenbit/README.md) |\n"),
        (SUITES, "\nstatic struct cf_suite suite;", '#include "tenbit_steps.h"\n'),
        (SUITES, '        {"cia406", ', '        {"tenbit", cf_tenbit, prove},\n'),
        (MODELS, "\nstruct host_rig_place host_rig_here;", '#include "drehgeber/tenbit.h"\n'),
        (MODELS, "#define BISS ", '#define TENBIT "tenbit", &dg_tenbit_wire, DG_HOST_MEDIUM_EDGES, NULL\n'),
        (MODELS, '    {"f3658", ', '    {"tenbit-low", "10 bit, singleturn; low without a driver", false, false, TENBIT, 1u << 8, 10},\n'
                                   '    {"tenbit-high", "10 bit, singleturn; high without a driver", false, false, TENBIT, 1u << 8, 10},\n'),
        (EXCHANGES, '#include "host_rig.h"\n', '#include "drehgeber/tenbit.h"\n'),
        (EXCHANGES, "/* What is done with the encoders of each wire. */\n", CHECK_TENBIT),
        (EXCHANGES, "    {&dg_hf_wire, check_hiperface},", "    {&dg_tenbit_wire, check_tenbit},\n"),
    ],
    "udp": [
        (KINDS, '    {\n        .name = "silkit",', KIND_UDP),
        (WIRES, "\nconst struct lx_stack *const lx_stacks[]", '#include "udp_can.h"\n'),
        (WIRES, '    {\n        .name = "silkit",', DOOR_UDP),
    ],
}


def below(folder):
    """Paths of the files of a folder, relative to it."""
    for parent, names, leaves in os.walk(folder):
        names[:] = [name for name in names if name not in LEFT_OUT]
        yield from (Path(parent, leaf).relative_to(folder) for leaf in leaves)


def added(path, text, rows):
    """A file of the tree with the rows of the strangers in it."""
    for file, place, row in rows:
        if file == path and text.count(place) != 1:
            sys.exit(f"{file}: expected {place!r} once, for a row of {APART}/tree.py; it stands there {text.count(place)} times")
        text = text.replace(place, row + place) if file == path else text
    return text


def contents(tree):
    """path: the file of the copy, and its content if that is another one."""
    rows = [row for stranger in ROWS.values() for row in stranger]
    found = {path: (tree / path, None) for path in below(tree) if not path.is_relative_to(APART)}
    for path in {Path(file) for file, *_ in rows}:
        found[path] = (tree / path, added(str(path), (tree / path).read_text("utf-8"), rows).encode())
    for stranger in ROWS:
        for path in below(tree / APART / stranger):
            if path in found:
                sys.exit(f"{path} of {stranger} is there already")
            found[path] = (tree / APART / stranger / path, None)
    return found


def put(source, content, target):
    """A file, unless it is as it was."""
    if source.is_symlink():
        return
    content = source.read_bytes() if content is None else content
    if not target.exists() or target.read_bytes() != content:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
    target.chmod(source.stat().st_mode)


def write(found, to):
    """The copy."""
    if to.exists():
        for path in set(below(to)) - set(found):
            (to / path).unlink()
    for path, (source, content) in found.items():
        put(source, content, to / path)


def main():
    tree, *to = map(Path, sys.argv[1:])
    found = contents(tree)
    if to:
        write(found, to[0])
    touched = {stranger: sorted({file for file, *_ in rows}) for stranger, rows in ROWS.items()}
    for stranger, files in touched.items():
        print(f"figure: adding {APART}/{stranger} touches {len(files)} existing files: {' '.join(files)}")
    lines = sum(line.strip() != "" for line in (tree / APART / BOARD).read_text("utf-8").splitlines())
    print(f"figure: a board is {lines} lines")
    sys.exit(lines > BOARD_MOST or any(len(files) > MOST[stranger] for stranger, files in touched.items()))


main()
