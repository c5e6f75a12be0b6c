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
size_t dg_host_size_on_bus(const struct dg_device *model, const struct dg_bus_side *side);
struct dg_host *dg_host_init_on_bus(void *memory, size_t size, const struct dg_device *model, const struct dg_bus_side *side);
bool dg_host_made(const struct dg_host *self);
uint64_t dg_host_feed(struct dg_host *self, const struct dg_host_event *event);
void dg_host_take_side(struct dg_host *self, const struct dg_bus_side *side);
const struct dg_co_sheet *dg_cia406_sheet_of(const struct dg_device *model);
void dg_co_eds(const struct dg_co_sheet *, void (*)(void *, const char *, size_t), void *);
struct dg_encoder *dg_host_panel_encoder(struct dg_host_panel *self);
struct dg_rig *dg_host_panel_rig(struct dg_host_panel *self);
int dg_rig_follow(struct dg_rig *self, struct dg_encoder *encoder, struct dg_rig_course *course, dg_ns now);
void dg_rig_unfollow(struct dg_rig *self, struct dg_encoder *encoder, size_t quantity);
extern const struct dg_keys dg_world_keys;
/* Objects that nobody looks into: struct dg_bus_medium, struct dg_bus_ops, struct dg_master_protocol. */
extern const char dg_bus_characters[], dg_bus_edges[], dg_bus_frames[], dg_bus_words[], dg_bus_queue_ops[], dg_biss_master[];
struct dg_bus_master;
struct dg_biss_access;
int dg_biss_access(struct dg_bus_master *master, struct dg_biss_access *access);
"""
HEADERS = (
    "host.h", "motion.h", "shaft.h", "course.h", "frame.h", "tap.h", "bus.h", "bus_characters.h", "bus_edges.h", "bus_frames.h",
    "bus_master.h", "bus_words.h", "bus_queue.h", "key.h", "rig.h", "rig_engine.h",
)  # fmt: skip
INCLUDE = re.compile(r'^#include "drehgeber/(\w+\.h)"$', re.M)
STRUCT = re.compile(r"^struct \w+ \{[^}]*\};", re.M)
# Of these headers, so much: results, what a model is called, what travels on its wire, files that are models, registers of BiSS,
# shafts and courses of a rig.
PARTS_OF = ("hal.h", "stack.h", "model.h", "biss.h", "control.h")
PARTS = re.compile(
    r"^(?:enum dg_result|enum dg_medium|enum dg_biss_failure|struct dg_biss_access|struct dg_stack|struct dg_device"
    r"|struct dg_model_(?!text)\w+|struct dg_rig|struct dg_rig_shaft|struct dg_rig_course) \{[^}]*\};", re.M,
)  # fmt: skip


def read(path: Path) -> str:
    """A header without its comments."""
    return re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)


def members(folder: Path) -> list[str]:
    """The structs of what the headers include: members of theirs may be some of them."""
    included = {name for header in HEADERS for name in INCLUDE.findall(read(folder / header))}
    return [row for name in sorted(included.difference(HEADERS, PARTS_OF)) for row in STRUCT.findall(read(folder / name))]


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
