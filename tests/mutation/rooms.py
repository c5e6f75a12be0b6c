# SPDX-License-Identifier: MIT
"""The rooms whose sources are broken, their floors, and which tests judge a file."""

import re
from typing import NamedTuple


class Room(NamedTuple):
    name: str  # its folder
    floor: float  # percent of the last WINDOW verdicts of its log that are killed
    tree: str  # below build/: whose objects are exchanged, and whose tests judge
    sources: tuple  # patterns of its files
    library: str = ""  # of the tree, linked of all objects of the room; a room without one relinks programs


WINDOW = 300
ROOMS = (
    Room("src", 93, "mutation", ("src/*/*.c", "src/*/*.def"), "tests/support/libdg_mutable.so"),
    Room("platform/linux", 80, "release", ("platform/linux/*/*.c",)),
    Room("platform/fmu", 80, "release", ("platform/fmu/*.c",)),
    Room("tools/drehgeber", 80, "release", ("tools/drehgeber/*.c", "tools/drehgeber/*/*.c")),
    Room("tools/python", 90, "release", ("tools/python/drehgeber/*.py",)),
)

# These run where the kernel has CAN and gpio-sim only: in the guest, which takes minutes to boot.
GUEST = re.compile(r"platform/linux/(can/can_(socket|link)\.c|clocked/gpio_(bus|lines_v\d)\.c)")

# The whole suite of the core in virtual time, which all of src/ is judged by.
VIRTUAL = r"unit\.|conformance\."

# All tests of the Python package, which judge each module behind its own ones: what takes seconds comes last.
PACKAGE = (r"python\.package/(?!can|encoder|package|rig)", r"python\.package/(?!package|rig_readers)",
           r"python\.package/")

# Beginning of a path: which tests judge the file, in this order, as patterns of names of ctest. The longest
# beginning wins. A test that runs a folder of pytest is a test for each of its files here: e2e.control/faults.
JUDGES = {
    "src/": [VIRTUAL],
    "src/core/": [r"unit\.(angle|bits|crc|store|time|world|ram_nvm)|unit\.(hf_memory|co_storage|ib_memory)", VIRTUAL],
    "src/bus/": [r"unit\.bus_", VIRTUAL],
    "src/bus/rfc2217": [r"unit\.rfc2217"],
    "src/motion/": [r"unit\.(motion|shaft|steer)", VIRTUAL],
    "src/hiperface/": [r"unit\.(hf_|words)|conformance\.hiperface", VIRTUAL],
    "src/biss/": [r"unit\.biss|conformance\.biss", VIRTUAL],
    "src/ssi/": [r"unit\.ssi|conformance\.ssi", VIRTUAL],
    "src/canopen/": [r"unit\.(co_|eds|words)|conformance\.(canopen|cia406)", VIRTUAL],
    "src/cia406/": [r"unit\.(406_|eds_)|conformance\.cia406", VIRTUAL],
    "src/interbus/": [r"unit\.(ib_|words)|conformance\.interbus", VIRTUAL],
    "src/words/": [r"unit\.words", VIRTUAL],
    "src/host/": [r"unit\.host", VIRTUAL],
    "src/scpi/": [r"unit\.scpi_", VIRTUAL],
    "src/control/": [r"unit\.(control|fault|agree|scpi_random)", VIRTUAL],
    "src/rig/": [r"unit\.(plan|rig_|engine_|course_words|motion_words|refused)", r"golden\.verdicts", VIRTUAL],
    "src/devices/": [r"conformance\.|unit\.agree", VIRTUAL],
    "platform/linux/base/": [
        r"unit\.(access|clock|csv|key|refused|say|tap|trace|virtual_timer|nvm_file|socketcand)", r"golden\.",
        r"realtime\.(scarce|stall)",
        r"e2e\.(cli|virtual_time|commands)", r"e2e\.(ctl|watch|stall|csv)", r"e2e\.(rig|files|access|abuse|life)",
    ],
    "platform/linux/base/peers": [r"unit\.(peers|refused|socketcand)", r"golden\.", r"realtime\.(net_wires|scarce)",
                                  r"e2e\.(abuse|net_serial)"],
    "platform/linux/base/csv": [r"unit\.csv|golden\.", r"e2e\.csv"],
    "platform/linux/nvm/": [r"unit\.(image|nvm_file|golden)", r"golden\.", r"realtime\.scarce", r"realtime\.nvm_writer",
                            r"e2e\.(golden|senses|life|kill|files)", r"e2e\.slow_disk"],
    "platform/linux/plan/": [r"unit\.(plan|key|course_words|motion_words|refused|rig_client)", r"golden\.",
                             r"realtime\.scarce", r"e2e\.cli_said",
                             r"e2e\.(cli|virtual_time|commands|rig|files)", r"e2e\.manual"],
    "platform/linux/wire/": [r"unit\.(characters|tap|clocked|com_port|refused)", r"golden\.",
                             r"realtime\.scarce", r"realtime\.serial", r"realtime\.(net_wires|hf_wire)",
                             r"e2e\.(cli|serial_control|master|rig|life)",
                             r"e2e\.line", r"e2e\.net_serial"],
    "platform/linux/wire/silkit": [r"unit\.silkit", r"e2e\.silkit", r"e2e\.cli"],
    "platform/linux/rig/silkit": [r"unit\.silkit", r"e2e\.silkit"],
    "platform/linux/rig/rig_silkit": [r"unit\.silkit", r"e2e\.silkit"],
    "platform/linux/interbus/ring_silkit": [r"unit\.silkit", r"e2e\.silkit"],
    "platform/linux/clocked/sim_silkit": [r"unit\.silkit", r"e2e\.silkit"],
    "platform/linux/can/silkit": [r"unit\.silkit", r"e2e\.silkit"],
    "platform/linux/line/": [r"unit\.(hf_neighbours|com_port|tap|characters|trace_uart|refused)",
                             r"golden\.(line|verdicts)", r"realtime\.scarce", r"realtime\.(hf_bus|hf_wire)",
                             r"e2e\.(virtual_time|senses|master)", r"e2e\.control/faults",
                             r"e2e\.(line|life|slow_disk)"],
    "platform/linux/can/": [r"unit\.(hub|bus_load|slcan|socketcand)", r"golden\.", r"realtime\.scarce",
                            r"realtime\.can_", r"realtime\.net_wires", r"e2e\.(cli|virtual_time|trace_tools)",
                            r"e2e\.canopen-slcan/(?!socketcan)",  # that file is the guest's
                            r"e2e\.control/", r"e2e\.(net_serial|stall)"],
    "platform/linux/clocked/": [r"unit\.(sim_frames|clocked|gpio_|sim_cable|ssi_wire|refused)", r"golden\.",
                                r"realtime\.scarce", r"realtime\.(gpio|sim_bus)",
                                r"e2e\.(biss|biss_settings|ssi|virtual_time)",
                                r"e2e\.(control/|rig|trace_tools)"],
    "platform/linux/interbus/": [r"unit\.(modbus|ib_map|ring_files|refused)", r"golden\.", r"realtime\.scarce",
                                 r"realtime\.ring_bus",
                                 r"e2e\.interbus", r"e2e\.(virtual_time|trace_tools)", r"e2e\.control/"],
    "platform/linux/trace/": [r"unit\.(tap|trace|trace_replaced|trace_uart|rig_client)", r"golden\.",
                              r"realtime\.scarce", r"realtime\.record",
                              r"e2e\.(virtual_time|trace_tools|ssi|biss)", r"e2e\.(interbus|sigrok|rig)"],
    "platform/linux/rig/": [r"unit\.(rig_client|rig_wires|rig_waits|ring_files|plan|refused)", r"golden\.",
                            r"realtime\.scarce", r"realtime\.(record|hf_bus|can_bus)",
                            r"e2e\.(virtual_time|watch|ctl|commands|rig|csv|courses)", r"e2e\.control/",
                            r"e2e\.(life|files|stall|serial_control)"],
    "platform/linux/rig/server": [r"unit\.(refused|default_address)", r"realtime\.scarce",
                                  r"e2e\.(ctl|watch|commands|serial_control)", r"e2e\.(access|abuse|life)"],
    "platform/fmu/": [r"unit\.fmu", r"e2e\.fmu/values", r"e2e\.fmu/"],
    "tools/drehgeber/": [r"e2e\.cli_said", r"e2e\.(cli|commands|virtual_time|ctl|watch|manual)",
                         r"e2e\.(rig|files|life)"],
    "tools/drehgeber/biss": [r"e2e\.(cli_said|biss|biss_settings|cli)"],
    "tools/drehgeber/ssi": [r"e2e\.(cli_said|ssi|cli)"],
    "tools/drehgeber/eds_": [r"e2e\.cli_said", r"e2e\.(cli|manual|model_eds_c)", r"e2e\.canopen-slcan/eds_file"],
    "tools/drehgeber/explain": [r"e2e\.cli_said", r"e2e\.explain"],
    "tools/drehgeber/model": [r"e2e\.cli_said", r"e2e\.model"],
    "tools/drehgeber/nvm_convert": [r"e2e\.cli_said", r"e2e\.models", r"e2e\.canopen-slcan/eds_file"],
    "tools/drehgeber/options_model": [r"e2e\.cli_said", r"e2e\.(models|cli)"],
    "tools/drehgeber/tty_open": [r"e2e\.serial_control", r"e2e\.verify(?!_everything)"],
    "tools/drehgeber/verify": [r"e2e\.cli_said", r"e2e\.verify(?!_everything)", r"e2e\.verify_everything"],
    "tools/drehgeber/verify/": [r"conformance\.", r"e2e\.verify(?!_everything)", r"e2e\.verify_everything"],
    "tools/drehgeber/ctl": [r"e2e\.(ctl|watch|commands|access|serial_control|files)"],
    "tools/drehgeber/wire_session": [r"e2e\.cli_said", r"e2e\.(biss_settings|biss|ssi|interbus)",
                                     r"e2e\.(ctl|watch|commands)"],
    "tools/drehgeber/rig_link": [r"unit\.top_client", r"e2e\.(ctl|watch|top|access)"],
    "tools/drehgeber/fmu_bundle": [r"e2e\.cli_said", r"e2e\.fmu/", r"e2e\.fmu-rebuild"],
    "tools/drehgeber/fmu_file": [r"e2e\.cli_said", r"e2e\.fmu/", r"e2e\.fmu-rebuild"],
    "tools/drehgeber/zip": [r"e2e\.fmu/"],
    "tools/drehgeber/top": [r"unit\.top_client", r"e2e\.top_screens", r"e2e\.top"],
    "tools/drehgeber/virtual_time": [r"e2e\.cli_said", r"golden\.", r"e2e\.(virtual_time|cli|csv|trace_tools)"],
    "tools/drehgeber/web": [r"e2e\.web", r"e2e\.cli"],
    "tools/python/": list(PACKAGE),
    "tools/python/drehgeber/__init__": [r"python\.package/package", *PACKAGE],
    "tools/python/drehgeber/_native": [r"python\.package/(encoder|values)", *PACKAGE],
    "tools/python/drehgeber/address": [r"python\.package/(serial|can)", *PACKAGE],
    "tools/python/drehgeber/can_interface": [r"python\.package/can", *PACKAGE],
    "tools/python/drehgeber/canbus": [r"python\.package/(wires|can)", *PACKAGE],
    "tools/python/drehgeber/chain": [r"python\.package/chain", *PACKAGE],
    "tools/python/drehgeber/clock": [r"python\.package/(serial|wires|encoder)", *PACKAGE],
    "tools/python/drehgeber/clocked": [r"python\.package/(wires|encoder)", *PACKAGE],
    "tools/python/drehgeber/control": [r"python\.package/(control|user)", *PACKAGE],
    "tools/python/drehgeber/course": [r"python\.package/(encoder|rig)$", *PACKAGE],
    "tools/python/drehgeber/encoder": [r"python\.package/(encoder|values)", *PACKAGE],
    "tools/python/drehgeber/fixture": [r"python\.package/user", *PACKAGE],
    "tools/python/drehgeber/instrument": [r"python\.package/(control|encoder)", *PACKAGE],
    "tools/python/drehgeber/model": [r"python\.package/model", *PACKAGE],
    "tools/python/drehgeber/plan": [r"python\.package/(verdicts|rig)$", *PACKAGE],
    "tools/python/drehgeber/protocol_drehgeber": [r"python\.package/serial", *PACKAGE],
    "tools/python/drehgeber/rigfile": [r"python\.package/(rig|rig_readers)$", *PACKAGE],
    "tools/python/drehgeber/ring": [r"python\.package/(ring|encoder)", *PACKAGE],
    "tools/python/drehgeber/rs485": [r"python\.package/(wires|serial)", *PACKAGE],
    "tools/python/drehgeber/running": [r"python\.package/(control|user)", *PACKAGE],
    "tools/python/drehgeber/shaft": [r"python\.package/(encoder|values)", *PACKAGE],
    "tools/python/drehgeber/wire": [r"python\.package/(wires|serial|can)", *PACKAGE],
    "tools/python/drehgeber/world": [r"python\.package/(encoder|values)", *PACKAGE],
}

# The command finds these beside itself.
BESIDE = {"drehgeber": ("drehgeber-web", "fmu-parts/fmi2.so", "fmu-parts/fmi3.so", "fmu-parts/sources",
                        "fmu-parts/sources.list", "fmu-parts/terms.txt", "share")}


def room_of(path):
    return next((room for room in ROOMS if path.startswith(room.name + "/")), None)


def judges_of(path):
    """Patterns of the names of tests, in their order."""
    begin = max((begin for begin in JUDGES if path.startswith(begin)), key=len, default=None)
    patterns = JUDGES[begin] if begin else []
    # Those that can try more do so at the end, but for the last pattern: that names everybody else's.
    return [*patterns, *(pattern.replace(r"unit\.", r"thorough\.") for pattern in patterns[:-1])]


def sources_of(room, root):
    """Paths of the room's files, as texts."""
    found = {str(path.relative_to(root)) for pattern in room.sources for path in root.glob(pattern)}
    return sorted(path for path in found if not GUEST.match(path))
