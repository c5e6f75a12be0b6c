# SPDX-License-Identifier: MIT
"""SIL Kit, as much of its C API as the plant's master uses, by ctypes."""

import ctypes
import json
import os
import struct
import sys
import time
from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_int8, c_int16, c_size_t, c_uint8, c_uint64, c_void_p

MASTER = "master"


def version(service: int, kind: int, number: int = 1) -> int:
    """What its structs begin with."""
    return ord("S") << 56 | ord("K") << 48 | service << 40 | kind << 32 | number << 24


class Header(Structure):
    """Of all structs."""

    _fields_ = [("version", c_uint64), ("reserved", c_uint64 * 3)]


class Frame(Structure):
    """SilKit_CanFrame."""

    _fields_ = [
        ("header", Header), ("id", ctypes.c_uint32), ("flags", ctypes.c_uint32), ("dlc", ctypes.c_uint16),
        ("xl", c_uint8 * 6), ("data", c_char_p), ("size", c_size_t),
    ]  # fmt: skip


class Spec(Structure):
    """SilKit_DataSpec."""

    _fields_ = [
        ("header", Header), ("topic", c_char_p), ("media_type", c_char_p), ("label_count", c_size_t), ("labels", c_void_p)
    ]  # fmt: skip


class Bytes(Structure):
    """SilKit_ByteVector."""

    _fields_ = [("data", c_char_p), ("size", c_size_t)]


class Lifecycle(Structure):
    """SilKit_LifecycleConfiguration."""

    _fields_ = [("header", Header), ("mode", c_int8)]


class Strings(Structure):
    """SilKit_StringList."""

    _fields_ = [("count", c_size_t), ("strings", POINTER(c_char_p))]


class Workflow(Structure):
    """SilKit_WorkflowConfiguration."""

    _fields_ = [("header", Header), ("required", POINTER(Strings))]


ON_LIFE = CFUNCTYPE(None, c_void_p, c_void_p)
ON_ABORT = CFUNCTYPE(None, c_void_p, c_void_p, c_int16)
ON_STEP = CFUNCTYPE(None, c_void_p, c_void_p, c_uint64, c_uint64)
ON_FRAME = ON_DATA = CFUNCTYPE(None, c_void_p, c_void_p, c_void_p)
COORDINATED, RECEIVED = 10, 2
SHAFT = b"application/vnd.drehgeber.shaft.v1"
PACKED = b"application/vnd.drehgeber.can.v1"
# A packed message: moment of its first frame, number of frames, 0; then of each its offset, identifier, DLC, 0, and data.
PACK_HEAD, PACK_FRAME = struct.Struct("<QHH"), struct.Struct("<IHBB")
# Where a SilKit_CanFrameEvent has its frame, and that its identifier and bytes.
EVENT_FRAME = ctypes.sizeof(Header) + 8
FRAME_ID, FRAME_DATA = Frame.id.offset, Frame.data.offset
ID_AND_DATA = struct.Struct(f"=I{FRAME_DATA - FRAME_ID - 4}xQ")
# Where a SilKit_DataMessageEvent has its bytes: the address, how many.
EVENT_BYTES = ctypes.sizeof(Header) + 8
ADDRESS_AND_SIZE = struct.Struct("=QQ")


class Kit:
    """The library, and what a participant and a registry need of it."""

    def __init__(self, library: str):
        try:
            self.library = ctypes.CDLL(library)
        except OSError as error:
            sys.exit(f"plant: no SIL Kit library: {error}; $DREHGEBER_SILKIT_LIBRARY names one, see README.md")
        self.library.SilKit_GetLastErrorString.restype = c_char_p
        self.kept: list[object] = []

    def call(self, function: str, *arguments: object) -> None:
        """A function that answers with a code."""
        code = getattr(self.library, f"SilKit_{function}")(*arguments)
        if code != 0:
            sys.exit(f"plant: SIL Kit: {function}: {self.library.SilKit_GetLastErrorString().decode()}")

    def handle(self, function: str, service: c_void_p, handler: object, *more: object) -> None:
        """Set a handler, which lives from here on."""
        self.kept.append(handler)
        self.call(function, service, *(more or (None,)), handler)

    def configuration(self, uri: str = "", aggregate: bool = False) -> c_void_p:
        """Errors are told by the functions. With a registry on loopback, others are met there, too; else anywhere. What
        is sent in a step goes out together if it is to aggregate."""
        made = c_void_p()
        words: dict[str, dict[str, object]] = {"Logging": {"Sinks": []}}
        if aggregate:
            words["Experimental"] = {"TimeSynchronization": {"EnableMessageAggregation": "On"}}
        if uri.startswith(("silkit://127.", "silkit://localhost:")):
            place = f"/tmp/{MASTER}-{os.getpid()}-{time.monotonic_ns()}.silkit"
            words["Middleware"] = {"AcceptorUris": [f"local://{place}", "tcp://127.0.0.1:0"]}
        self.call("ParticipantConfiguration_FromString", ctypes.byref(made), json.dumps(words).encode())
        return made

    def registry(self, uri: str) -> c_void_p:
        """A registry in this process: it introduces the participants to each other."""
        made, listens = c_void_p(), c_char_p()
        self.call("Vendor_Vector_SilKitRegistry_Create", ctypes.byref(made), self.configuration())
        self.call("Vendor_Vector_SilKitRegistry_StartListening", made, uri.encode(), ctypes.byref(listens))
        return made
