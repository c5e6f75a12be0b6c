# SPDX-License-Identifier: MIT
"""Writes drehgeber/_abi.py: types and functions of the library's headers, as cffi calls them.

usage: make_abi.py HEADERS OUTPUT
"""
import re
import sys
from pathlib import Path

import cffi

# Of other headers, so much is needed.
OTHERS = """
typedef uint64_t dg_ns;
typedef int64_t dg_angle;
const char *dg_version(void);
struct dg_device;
struct dg_co_sheet;
const struct dg_device *dg_device_find(const char *name);
const struct dg_model_file *dg_model_file_of(const char *name);
const struct dg_host_wire *dg_host_wire_of(const struct dg_device *model);
struct dg_bus_side;
const struct dg_bus_side *dg_bus_side_of(const struct dg_device *model);
void dg_host_take_side(struct dg_host *self, const struct dg_bus_side *side);
const struct dg_co_sheet *dg_cia406_sheet_of(const struct dg_device *model);
void dg_co_eds(const struct dg_co_sheet *, void (*)(void *, const char *, size_t), void *);
struct dg_encoder *dg_host_panel_encoder(struct dg_host_panel *self);
/* Objects that nobody looks into: struct dg_bus_medium, struct dg_bus_ops, struct dg_master_protocol. */
extern const char dg_bus_characters[], dg_bus_edges[], dg_bus_frames[], dg_bus_words[], dg_bus_queue_ops[], dg_biss_master[];
struct dg_bus_master;
struct dg_biss_access;
int dg_biss_access(struct dg_bus_master *master, struct dg_biss_access *access);
"""
HEADERS = (
    "host.h", "motion.h", "shaft.h", "course.h", "frame.h", "tap.h", "bus.h", "bus_characters.h", "bus_edges.h", "bus_frames.h",
    "bus_master.h", "bus_words.h", "bus_queue.h", "key.h", "rig.h",
)  # fmt: skip
INCLUDE = re.compile(r'^#include "drehgeber/(\w+\.h)"$', re.M)
STRUCT = re.compile(r"^struct \w+ \{[^}]*\};", re.M)
# Of these headers, so much: results, what a model is called, what travels on its wire, files that are models, registers of BiSS.
PARTS_OF = ("hal.h", "stack.h", "model.h", "biss.h")
PARTS = re.compile(r"^(?:enum dg_result|enum dg_medium|enum dg_biss_failure|struct dg_biss_access|struct dg_stack|struct dg_device|struct dg_model_(?!text)\w+) \{[^}]*\};", re.M)


def read(path: Path) -> str:
    """A header without its comments."""
    return re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)


def members(folder: Path) -> list[str]:
    """The structs of what the headers include: members of theirs may be some of them."""
    included = {name for header in HEADERS for name in INCLUDE.findall(read(folder / header))}
    return [row for name in sorted(included - set(HEADERS)) for row in STRUCT.findall(read(folder / name))]


def declarations(text: str) -> str:
    """A header without directives and marks; numbers that arrays are as long as stay."""
    lengths = re.findall(r"^(#define \w+ \d+)u$", text, re.M)
    text = re.sub(r"^#ifdef __cplusplus\n.*?^#endif$", "", text, flags=re.S | re.M)
    text = re.sub(r"^[ \t]*#(\\\n|.)*$", "", text, flags=re.M)
    text = re.sub(r"DG_API extern const struct [^;]*;", "", text)
    text = re.sub(r"^static inline [^{]*\{.*?^\}$", "", text, flags=re.S | re.M)
    return "\n".join([*lengths, text.replace("DG_API ", "")])


def main() -> None:
    headers, output = Path(sys.argv[1]), Path(sys.argv[2])
    builder = cffi.FFI()
    parts = [row for name in PARTS_OF for row in PARTS.findall(read(headers / name))]
    rows = [OTHERS, *parts, *members(headers), *(declarations(read(headers / name)) for name in HEADERS)]
    builder.cdef("\n".join(rows))
    builder.set_source("drehgeber._abi", None)
    builder.emit_python_code(str(output))


main()
