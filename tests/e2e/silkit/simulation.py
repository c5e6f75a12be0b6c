# SPDX-License-Identifier: MIT
"""The other side of a SIL Kit simulation: a registry, and a participant through the C API of libSilKit.so by ctypes."""
import ctypes
import os
import signal
import socket
import struct
import subprocess
import threading
import time
from ctypes import (CFUNCTYPE, POINTER, Structure, c_char_p, c_int8, c_int16, c_int32, c_size_t, c_uint8, c_uint16,
                    c_uint32, c_uint64, c_void_p)
from pathlib import Path

from rig import PROGRAM, Lines, end_process, free_port

HERE = Path(os.environ.get("DREHGEBER_SILKIT", Path(__file__).resolve().parents[3] / "build/silkit/SilKit_py"))
LIBRARY = HERE / "libSilKit.so"
PATIENCE_S = 30.0
COORDINATED, AUTONOMOUS = 10, 20
RECEIVE = 2
STEP_NS = 1_000_000


def version(service: int, kind: int, number: int = 1) -> int:
    return ord("S") << 56 | ord("K") << 48 | service << 40 | kind << 32 | number << 24


class Header(Structure):
    _fields_ = [("version", c_uint64), ("reserved", c_uint64 * 3)]


class Bytes(Structure):
    _fields_ = [("data", POINTER(c_uint8)), ("size", c_size_t)]

    def get(self) -> bytes:
        return ctypes.string_at(self.data, self.size) if self.size else b""


class Frame(Structure):
    _fields_ = [("header", Header), ("id", c_uint32), ("flags", c_uint32), ("dlc", c_uint16), ("sdt", c_uint8),
                ("vcid", c_uint8), ("af", c_uint32), ("data", Bytes)]


class FrameEvent(Structure):
    _fields_ = [("header", Header), ("timestamp", c_uint64), ("frame", POINTER(Frame)), ("direction", c_uint8),
                ("user", c_void_p)]


class DataEvent(Structure):
    _fields_ = [("header", Header), ("timestamp", c_uint64), ("data", Bytes)]


class Spec(Structure):
    _fields_ = [("header", Header), ("topic", c_char_p), ("media_type", c_char_p), ("label_count", c_size_t),
                ("labels", c_void_p)]


class Lifecycle(Structure):
    _fields_ = [("header", Header), ("mode", c_int8)]


class Strings(Structure):
    _fields_ = [("count", c_size_t), ("strings", POINTER(c_char_p))]


class Workflow(Structure):
    _fields_ = [("header", Header), ("required", POINTER(Strings))]


ON_LIFE = CFUNCTYPE(None, c_void_p, c_void_p)
ON_ABORT = CFUNCTYPE(None, c_void_p, c_void_p, c_int16)
ON_STEP = CFUNCTYPE(None, c_void_p, c_void_p, c_uint64, c_uint64)
ON_FRAME = CFUNCTYPE(None, c_void_p, c_void_p, POINTER(FrameEvent))
ON_DATA = CFUNCTYPE(None, c_void_p, c_void_p, POINTER(DataEvent))


def as_bytes(content: bytes) -> Bytes:
    array = (c_uint8 * max(1, len(content))).from_buffer_copy(content or b"\0")
    return Bytes(ctypes.cast(array, POINTER(c_uint8)), len(content))


PACK_HEAD, PACK_FRAME = struct.Struct("<QHH"), struct.Struct("<IHBB")


def pack(at, *frames):
    """A packed message of frames, (identifier, data), that are all sent at that moment."""
    return PACK_HEAD.pack(at, len(frames), 0) + b"".join(
        PACK_FRAME.pack(0, identifier, len(data), 0) + data for identifier, data in frames)


def unpack(message):
    """Its frames, (moment, identifier, data); 8000h in the identifier of a remote one."""
    begin, count, zero = PACK_HEAD.unpack_from(message)
    frames, at = [], PACK_HEAD.size
    for _ in range(count):
        offset, identifier, dlc, reserved = PACK_FRAME.unpack_from(message, at)
        end = at + PACK_FRAME.size + (0 if identifier & 0x8000 else dlc)
        frames.append((begin + offset, identifier, message[at + PACK_FRAME.size:end]))
        assert reserved == 0
        at = end
    assert zero == 0 and at == len(message) and frames != []
    return frames


class Registry:
    """A registry as a process of its own."""

    def __init__(self):
        self.uri = f"silkit://127.0.0.1:{free_port()}"
        self.process = subprocess.Popen([HERE / "bin/sil-kit-registry", "--listen-uri", self.uri, "--log", "error"],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        host, port = self.uri.removeprefix("silkit://").split(":")
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                socket.create_connection((host, int(port)), 1).close()
                return
            except OSError:
                assert time.monotonic() < end and self.process.poll() is None, "no registry"
                time.sleep(0.05)

    def end(self):
        self.process.kill()
        self.process.wait(PATIENCE_S)


class Rig:
    """drehgeber run ... with the library. It may say what `heard` matches; all else is a failure of clean_up()."""

    def __init__(self, *arguments, **environment):
        self.process = subprocess.Popen([PROGRAM, "run", *map(str, arguments)], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        env={**os.environ, "DREHGEBER_SILKIT_LIBRARY": str(LIBRARY), **environment})
        self.out, self.errors = Lines(self.process.stdout), Lines(self.process.stderr)

    def ready(self, last="ready "):
        """Lines up to the one that begins so."""
        lines = []
        while not lines or not lines[-1].startswith(last):
            lines.append(self.out.wait(PATIENCE_S))
        return lines

    def end(self, number=signal.SIGTERM) -> int:
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)

    def wait(self) -> int:
        return self.process.wait(PATIENCE_S)

    def close(self):
        end_process(self.process)
        self.process.stdout.close()
        self.process.stderr.close()


class Participant:
    """Somebody else in the simulation. `step(self, now)` is called in each of its steps, on a thread of the library;
    what has come in until then is in .frames and .data, as (time, id, bytes) and (time, topic, bytes)."""

    def __init__(self, uri: str, name: str, step=None, mode=COORDINATED, required=(), step_ns=STEP_NS):
        self.library = ctypes.CDLL(str(LIBRARY))
        self.library.SilKit_GetLastErrorString.restype = c_char_p
        self.frames, self.data, self.kept, self.failed = [], [], [], None
        self.publishers, self.controllers, self.on_step, self.ended = {}, [], step, threading.Event()
        self.is_ready = False
        self.participant, self.life, self.clock, self.system = c_void_p(), c_void_p(), c_void_p(), c_void_p()
        config = c_void_p()
        self.call("ParticipantConfiguration_FromString", ctypes.byref(config), b'{"Logging":{"Sinks":[]}}')
        self.call("Participant_Create", ctypes.byref(self.participant), config, name.encode(), uri.encode())
        self.call("ParticipantConfiguration_Destroy", config)
        if required:
            self._require(required)
        setup = Lifecycle(Header(version(7, 2)), mode)
        self.call("LifecycleService_Create", ctypes.byref(self.life), self.participant, ctypes.byref(setup))
        self._handle("LifecycleService_SetCommunicationReadyHandler", self.life, ON_LIFE(self._ready))
        self._handle("LifecycleService_SetShutdownHandler", self.life, ON_LIFE(lambda *_: self.ended.set()))
        self._handle("LifecycleService_SetAbortHandler", self.life, ON_ABORT(lambda *_: self.ended.set()))
        if step is not None:
            self.call("TimeSyncService_Create", ctypes.byref(self.clock), self.life)
            handler = ON_STEP(self._step)
            self.kept.append(handler)
            self.call("TimeSyncService_SetSimulationStepHandler", self.clock, None, handler, c_uint64(step_ns))

    def call(self, function: str, *arguments):
        code = getattr(self.library, f"SilKit_{function}")(*arguments)
        assert code == 0, f"{function}: {self.library.SilKit_GetLastErrorString().decode()}"

    def _handle(self, function: str, service, handler):
        self.kept.append(handler)
        self.call(function, service, None, handler)

    def _require(self, names):
        controller = self.system
        array = (c_char_p * len(names))(*[name.encode() for name in names])
        self.kept.append(array)
        workflow = Workflow(Header(version(7, 3, 3)), ctypes.pointer(Strings(len(names), array)))
        self.call("Experimental_SystemController_Create", ctypes.byref(controller), self.participant)
        self.call("Experimental_SystemController_SetWorkflowConfiguration", controller, ctypes.byref(workflow))

    def _ready(self, *_):
        for controller in self.controllers:
            self.call("CanController_Start", controller)
        self.is_ready = True

    def until(self, condition):
        """Look again and again; the library's threads do the rest."""
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, "it does not happen"
            time.sleep(0.01)

    def _step(self, _ctx, _service, now, _duration):
        try:
            self.on_step(self, now)
        except BaseException as failure:  # noqa: B902 # the library is in between
            self.failed = failure
            self.on_step = lambda *_: None
            self.stop()

    def can(self, network: str):
        """A controller; its number for send()."""
        controller, identifier, number = c_void_p(), c_uint64(), len(self.controllers)

        def came(_ctx, _controller, event):
            frame = event.contents.frame.contents
            self.frames.append((event.contents.timestamp, frame.id, frame.data.get(), number))

        self.call("CanController_Create", ctypes.byref(controller), self.participant, f"can{number}".encode(),
                  network.encode())
        handler = ON_FRAME(came)
        self.kept.append(handler)
        self.call("CanController_AddFrameHandler", controller, None, handler, c_uint8(RECEIVE),
                  ctypes.byref(identifier))
        self.controllers.append(controller)
        return number

    def send(self, identifier: int, content: bytes, flags=0, number=0, dlc=None):
        frame = Frame(Header(version(1, 1)), identifier, flags, len(content) if dlc is None else dlc)
        frame.data = as_bytes(content)
        self.call("CanController_SendFrame", self.controllers[number], ctypes.byref(frame), None)

    def subscribe(self, topic: str, media_type: str):
        subscriber = c_void_p()

        def came(_ctx, _subscriber, event):
            self.data.append((event.contents.timestamp, topic, event.contents.data.get()))

        handler = ON_DATA(came)
        self.kept.append(handler)
        spec = Spec(Header(version(5, 2)), topic.encode(), media_type.encode())
        self.call("DataSubscriber_Create", ctypes.byref(subscriber), self.participant, topic.encode(),
                  ctypes.byref(spec), None, handler)

    def publish(self, topic: str, media_type: str, content=None):
        """Make the publisher; with content, publish."""
        if topic not in self.publishers:
            publisher, spec = c_void_p(), Spec(Header(version(5, 2)), topic.encode(), media_type.encode())
            self.call("DataPublisher_Create", ctypes.byref(publisher), self.participant, topic.encode(),
                      ctypes.byref(spec), c_uint8(0))
            self.publishers[topic] = publisher
        if content is not None:
            data = as_bytes(content)
            self.call("DataPublisher_Publish", self.publishers[topic], ctypes.byref(data))

    def start(self):
        self.call("LifecycleService_StartLifecycle", self.life)

    def stop(self):
        self.library.SilKit_LifecycleService_Stop(self.life, b"done")

    def abort(self):
        self.call("Experimental_SystemController_AbortSimulation", self.system)

    def wait(self, timeout_s=PATIENCE_S):
        """Until it has ended; what its step() has raised is raised."""
        over = self.ended.wait(timeout_s)
        if self.failed is not None:
            raise self.failed
        assert over, "the simulation does not end"

    def close(self):
        self.library.SilKit_Participant_Destroy(self.participant)
