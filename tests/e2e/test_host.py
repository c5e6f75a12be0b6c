# SPDX-License-Identifier: MIT
"""The library from another language, with no layout but those that host.h promises: every model is driven, and
a saved one goes on in another process byte for byte."""
import ctypes
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

LIBRARY = os.environ.get("LIBDREHGEBER", "")
MS, S = 10**6, 10**9
TURN = 1 << 32
BYTES, CAN, EDGE, WORDS = 1, 2, 4, 5
IDENTIFY = 16
STATE, WIRE, OTHER = -9, -10, -12


class Event(ctypes.Structure):
    _fields_ = [("at", ctypes.c_uint64), ("id", ctypes.c_uint32), ("flags", ctypes.c_uint16),
                ("kind", ctypes.c_uint8), ("length", ctypes.c_uint8), ("data", ctypes.c_uint8 * 16)]

    def text(self):
        return bytes(self.data[: self.length])


class Frame(ctypes.Structure):
    _fields_ = [("at", ctypes.c_uint64), ("end", ctypes.c_uint64), ("bits", ctypes.c_uint64),
                ("position", ctypes.c_uint64), ("multiturn", ctypes.c_uint32), ("singleturn", ctypes.c_uint32),
                ("count", ctypes.c_uint8), ("error", ctypes.c_uint8), ("warning", ctypes.c_uint8),
                ("good", ctypes.c_uint8), ("life", ctypes.c_uint8), ("reserved", ctypes.c_uint8 * 3)]


class Key(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("unit", ctypes.c_char_p), ("help", ctypes.c_char_p),
                ("min", ctypes.c_int64), ("max", ctypes.c_int64), ("type", ctypes.c_uint8),
                ("places", ctypes.c_uint8), ("always", ctypes.c_uint8), ("reserved", ctypes.c_uint8 * 5)]


def library():
    lib = ctypes.CDLL(LIBRARY)
    for name, result in (("name", ctypes.c_char_p), ("result_text", ctypes.c_char_p), ("protocol", ctypes.c_char_p),
                         ("make", ctypes.c_void_p), ("size_of", ctypes.c_size_t), ("state_size", ctypes.c_size_t),
                         ("step", ctypes.c_uint64)):
        getattr(lib, f"dg_host_{name}").restype = result
    return lib


LIB = library() if LIBRARY else None


class Encoder:
    """A handle, and the memory it lives in."""

    def __init__(self, model):
        size = LIB.dg_host_size_of(model.encode())
        self.memory = ctypes.create_string_buffer(size + 16)
        start = (ctypes.addressof(self.memory) + 15) // 16 * 16
        self.handle = ctypes.c_void_p(LIB.dg_host_make(ctypes.c_void_p(start), ctypes.c_size_t(size), model.encode()))
        assert self.handle

    def call(self, name, *args):
        return getattr(LIB, f"dg_host_{name}")(self.handle, *args)

    def start(self):
        """With power since 0, initialised, at rest at 3.25 turns."""
        self.call("shaft", ctypes.c_uint64(0), ctypes.c_int64(13 * TURN // 4), ctypes.c_int64(0))
        assert self.call("power", ctypes.c_uint64(0), True) == 0
        self.step(S)
        return self

    def step(self, now):
        return self.call("step", ctypes.c_uint64(now))

    def send(self, at, kind, data=b"", **more):
        event = Event(at=at, kind=kind, length=len(data), **more)
        event.data[: len(data)] = data
        return self.call("send", ctypes.byref(event))

    def received(self):
        events = []
        while True:
            event = Event()
            result = self.call("receive", ctypes.byref(event))
            if result != 1:
                assert result == 0, LIB.dg_host_result_text(result)
                return events
            events.append(event)

    def ask(self, at, kind, data=b"", **more):
        """What comes back, from a request on to 100 ms later."""
        self.received()
        assert self.send(at, kind, data, **more) == 0
        self.step(at + 100 * MS)
        return self.received()

    def position(self, at):
        counts = ctypes.c_uint64()
        assert self.call("position", ctypes.c_uint64(at), ctypes.byref(counts)) == 0
        return counts.value

    def save(self):
        to = ctypes.create_string_buffer(self.call("state_size"))
        assert self.call("save", to, ctypes.c_size_t(len(to))) == 0
        return to.raw

    def restore(self, state):
        return self.call("restore", state, ctypes.c_size_t(len(state)))


def hiperface(encoder, position):
    (reply,) = encoder.ask(S + MS, BYTES, b"\x40\x42\x02")
    frame = b"\x40\x42" + position.to_bytes(4, "big")
    total = 0
    for byte in frame:
        total ^= byte
    assert reply.text() == frame + bytes([total])
    levels = (ctypes.c_int32 * 4)()
    assert encoder.call("sincos", ctypes.c_uint64(S), levels) == 0
    assert levels[0] == levels[1] and levels[2] > levels[3]


def biss(encoder, position):
    encoder.received()
    frame, now, device = Frame(), ctypes.c_uint64(S + MS), ctypes.create_string_buffer(6)
    assert encoder.call("frame", now, ctypes.byref(frame)) == 0
    assert (frame.position, frame.good, frame.error, frame.at) == (position, 1, 0, S + MS)
    now.value = frame.end
    assert encoder.call("registers_read", ctypes.byref(now), ctypes.c_uint8(0x78), device, ctypes.c_size_t(6)) == 6
    assert device.raw[0] == 4
    assert now.value > frame.end


def canopen(encoder, position):
    (answer,) = encoder.ask(S + MS, CAN, b"\x40\x04\x60\0\0\0\0\0", id=0x63F)
    assert (answer.id, answer.text()) == (0x5BF, b"\x43\x04\x60\0" + position.to_bytes(4, "little"))
    encoder.ask(2 * S, CAN, b"\1\0", id=0)
    (pdo,) = [event for event in encoder.ask(3 * S, CAN, id=0x80) if event.id == 0x2BF]
    assert pdo.at == 3 * S and pdo.text()[:4] == position.to_bytes(4, "little")


def interbus(encoder, position):
    (identity,) = encoder.ask(S, WORDS, flags=IDENTIFY)
    (back,) = encoder.ask(2 * S, WORDS)
    assert identity.flags == IDENTIFY and (back.id, back.at) == (position, 2 * S)
    assert back.text() == position.to_bytes(back.length, "big")


def ssi(encoder, position):
    frame = Frame()
    assert encoder.call("frame", ctypes.c_uint64(S + MS), ctypes.byref(frame)) == 0
    assert (frame.position, frame.good) == (position, 1)


MODELS = {
    "s3674-rs485": (hiperface, 1 << 14),
    "s3684-rs485": (hiperface, 13 << 14),
    "s3674-biss": (biss, 1 << 19),
    "s3684-biss": (biss, 13 << 19),
    "f3658": (canopen, 1 << 14),
    "f3668": (canopen, 13 << 14),
    "ocd-ib-k1": (interbus, 1 << 10),
    "ocd-ib-k2": (interbus, 13 << 10),
    "ocd-ib-k3": (interbus, 13 << 10),
    "ssi-13": (ssi, 1 << 11),
    "ssi-25": (ssi, 13 << 11),
    "ssi-28": (ssi, 13 << 14),
}


def names():
    found = []
    while name := LIB.dg_host_name(ctypes.c_size_t(len(found))):
        found.append(name.decode())
    return found


def go_on(encoder):
    """Half a second of what every wire has: what is not of this one is refused."""
    for at in range(2 * S, 2 * S + S // 2, 50 * MS):
        for kind, data, more in ((BYTES, b"\x40\x42\x02", {}), (CAN, b"\1\0", {"id": 0}), (CAN, b"", {"id": 0x80}),
                                 (EDGE, b"\0", {}), (EDGE, b"\1", {}), (WORDS, b"", {})):
            assert encoder.send(at, kind, data, **more) in (0, WIRE)
        encoder.step(at + 49 * MS)
    return b"".join(bytes(event) for event in encoder.received()) + encoder.save()


def elsewhere():
    """The other process: a state comes in, what becomes of it goes out."""
    encoder = Encoder(sys.argv[1])
    assert encoder.restore(sys.stdin.buffer.read()) == 0
    sys.stdout.buffer.write(go_on(encoder))


if __name__ == "__main__":
    elsewhere()
    sys.exit()


def test_the_list_of_models_is_the_librarys():
    assert names() and set(names()) <= set(MODELS)


@pytest.mark.parametrize("model", names() if LIB else [])
def test_a_model_is_driven(model):
    drive, position = MODELS[model]
    encoder = Encoder(model).start()
    assert encoder.call("protocol").decode() == drive.__name__
    assert encoder.position(S) == position
    drive(encoder, position)


@pytest.mark.parametrize("model", names() if LIB else [])
def test_a_state_goes_on_in_another_process(model):
    encoder = Encoder(model).start()
    encoder.call("shaft", ctypes.c_uint64(S), ctypes.c_int64(TURN), ctypes.c_int64(3 * TURN + 1))
    assert encoder.call("world_set", ctypes.c_uint64(S), b"temperature", ctypes.c_int64(40123)) == 0
    state = encoder.save()
    other = subprocess.run([sys.executable, "-B", __file__, model], input=state, capture_output=True, timeout=60,
                           check=True)
    assert other.stdout == go_on(encoder)


def test_a_state_of_another_model_is_refused():
    assert Encoder("f3658").restore(Encoder("f3668").start().save()) == OTHER
    assert LIB.dg_host_result_text(OTHER) == b"the state is of another model, version or build"


def test_settings_by_name():
    encoder, key, keys = Encoder("f3668"), Key(), {}
    while encoder.call("key", ctypes.c_size_t(len(keys)), ctypes.byref(key)) == 0:
        keys[key.name.decode()] = (key.min, key.max)
    assert keys["node"] == (1, 127) and keys["temperature"][1] == 1000000
    assert encoder.call("set", b"node", b"5") == 0
    encoder.start()
    assert encoder.received()[0].id == 0x705
    assert encoder.call("set", b"node", b"6") == STATE


def test_the_example_of_the_page_is_right(tmp_path):
    tree = Path(__file__).resolve().parents[2]
    page = (tree / "src/host/README.md").read_text()
    (tmp_path / "example.c").write_text(re.search(r"^```c\n(.*?)^```$", page, re.M | re.S).group(1))
    library = Path(LIBRARY)
    subprocess.run([shutil.which("cc"), "-std=c11", "-Wall", "-Werror", f"-I{tree}/include", "-o", tmp_path / "example",
                    tmp_path / "example.c", library, f"-Wl,-rpath,{library.parent}"], check=True)
    printed = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=True).stdout
    assert printed == "705 00\n585 02\n"
    for line in printed.splitlines():
        assert f"`{line}`" in page
