# SPDX-License-Identifier: MIT
"""Models for simulators of hardware, and the page, with two protocols that nobody has heard of (tests/strangers)."""
import ctypes
import json
import os
import subprocess
from pathlib import Path

import pytest

BUILT = Path(os.environ["STRANGERS"]) / "build/release"
QUARTER = bytes.fromhex("02 00 00 40 00 00 00 00 00 00 42")
US = 1_000_000  # ps


# ------------------------------------------------------------ HDL

@pytest.fixture(scope="module")
def hdl():
    library = ctypes.CDLL(str(BUILT / "platform/hdl/libdrehgeber_hdl.so"))
    library.dg_hdl_open.restype = ctypes.c_void_p
    library.dg_hdl_error.restype = library.dg_hdl_command.restype = ctypes.c_char_p
    library.dg_hdl_next.restype = library.dg_hdl_latched.restype = ctypes.c_int64
    for name, arguments in (("error", []), ("close", []), ("latched", []), ("next", []), ("wires", [ctypes.c_int64, ctypes.c_int]),
                            ("command", [ctypes.c_int64, ctypes.c_char_p])):
        getattr(library, f"dg_hdl_{name}").argtypes = [ctypes.c_void_p, *arguments]
    return library


def opened(hdl, model: str, settings: str = "", motion: str = "90DEG"):
    self = hdl.dg_hdl_open(model.encode(), settings.encode(), motion.encode(), b"")
    assert hdl.dg_hdl_error(self) == b""
    return self


def test_a_simulator_clocks_one(hdl):
    self, now, bits = opened(hdl, "tenbit-low"), 100 * US, 0
    hdl.dg_hdl_wires(self, 0, 1)
    hdl.dg_hdl_wires(self, now, 1)
    for _ in range(10):
        for level in (0, 1):
            now += US
            hdl.dg_hdl_wires(self, now, level)
        bits = bits << 1 | hdl.dg_hdl_wires(self, now + US // 2, 1) & 1
    assert (bits, hdl.dg_hdl_latched(self)) == (256, 256)
    hdl.dg_hdl_close(self)


def test_a_simulator_asks_the_other(hdl):
    """Bits of 400 ns: a request, and the reply sampled in their middle."""
    self, bit, now = opened(hdl, "eleven-24", "slot=3"), 400_000, 10 * US
    hdl.dg_hdl_wires(self, 0, 1)
    hdl.dg_hdl_wires(self, now, 1)
    for level in (0, *((0x1A >> i & 1) for i in range(8)), 1):
        hdl.dg_hdl_wires(self, now, level)
        now += bit
    while hdl.dg_hdl_wires(self, now, 1) & 1:
        now += 1000
    reply = []
    for _ in range(11):
        reply.append(sum((hdl.dg_hdl_wires(self, now + (2 * i + 3) * bit // 2, 1) & 1) << i for i in range(8)))
        now += 10 * bit
    assert bytes(reply) == b"\x1a" + QUARTER[1:10] + bytes([0x5A])
    assert b"frames=1" in hdl.dg_hdl_command(self, now, b"STAT?")
    hdl.dg_hdl_close(self)


# ------------------------------------------------------------ the page

def test_the_page_has_them():
    ended = subprocess.run(["node", Path(__file__).with_name("page.mjs"), BUILT / "playground"], capture_output=True, text=True,
                           timeout=60, check=False)
    assert ended.returncode == 0, ended.stderr
    found = json.loads(ended.stdout)
    assert found["media"] == [0, 0, 2, 2]
    assert found["positions"][1] == str(1 << 22) and found["positions"][3] == "256"
    assert found["faults"][0] == "singleturn_lost" and found["state"] == "01"
    said = [row for row in found["heard"] if row[0] == "eleven-24"]
    assert [row[3] for row in said] == ["request 02h", "02h -> position 4194304", "request 02h", "02h -> position 4194304, lost"]
    assert bytes(said[1][2]) == QUARTER
    assert any(row[0] == "s3684-rs485" and row[1] and "position 16384" in row[3] for row in found["heard"])
    assert found["bits"] == f"{256:010b}"
    assert "tenbit-low: it is no SSI encoder" in found["errors"][0]
