# SPDX-License-Identifier: MIT
"""What tests of `drehgeber verify` share: our own encoders in the place of real ones, several at a time since most of
the time is waiting, and a wire between that can spoil what goes over it."""
import contextlib
import json
import os
import re
import select
import socket
import subprocess
import tempfile
import threading
import tty
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rig import PROGRAM, REPOSITORY, Encoder

LIMIT_S = 120.0
SERIAL = "987654321"
# model: what makes it a wire; its own settings; the lists of its clauses; what ends a message on the wire.
WIRES = {
    "s3684-rs485": ("pty", ["--set", "pace=0"], ["hiperface"], b""),
    "f3668": ("slcan", [], ["canopen", "cia406"], b"\r\a"),
}
MODELS = list(WIRES)
# Every model that verify has clauses for, and the lists of them.
SUITES = {model: row[2] for model, row in WIRES.items()} | {"ocd-ib-k3": ["interbus"]}
# model: into how many parts its clauses are cut; how many agree at least; bytes of the image that may be others, which are
# the store's journal, and of an S36 what data fields had that do not exist any more, of an F36x8 the zero of USF behind its mark.
WRITTEN = {
    "s3684-rs485": (12, 260, [(24, 0xAE), (0x1C5, 0x9A5)]),
    "f3668": (8, 180, [(24, 0x156), (0x27C, 0x292)]),
}
# Of an F36x8: the byte that tells whether 1010h has saved since 1011h; and what is of no use then.
SAVED, UNUSED = 0x15B, [(0x15E, 0x237), (0x23D, 0x27B)]
# Objects that are lost without supply, and so are not in the image: index, subindices.
OBJECTS = [(0x1005, [0]), (0x100C, [0]), (0x100D, [0]), (0x1014, [0]), (0x1015, [0]), (0x1016, [1]), (0x1017, [0]), (0x1029, [1]),
           *((0x1800 + pdo, [1, 2, 3, 5]) for pdo in range(4)), *((0x1A00 + pdo, range(9)) for pdo in range(4)),
           (0x2120, [0]), (0x2140, [0]), (0x6000, [0]), (0x6001, [0]), (0x6002, [0]), (0x6003, [0]), (0x6004, [0]), (0x6031, [0]),
           (0x6200, [0]), (0x6401, [1]), (0x6402, [1]), (0x6509, [0])]

# Rows give two services one CAN-ID, as a master may, and PDOs more frames than a bus carries; the rig tells of it.
TOLD_OF_ROWS = ("two services of this node", "bus load")


def strange_lines(lines) -> list:
    """What a rig has said that rows do not explain."""
    return [line for line in lines if not any(told in line for told in TOLD_OF_ROWS)]


class Crowd:
    """Encoders of a file of tests, each in a folder of its own, and threads that ask them."""

    def __init__(self):
        # An encoder acknowledges a write when it is on the disk, for which a busy disk takes seconds: here there is none.
        memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
        self.place = tempfile.TemporaryDirectory(prefix="drehgeber-verify-", dir=memory)
        self.folder, self.running = Path(self.place.name), []
        self.pool = ThreadPoolExecutor(48)

    def begin(self, name: str, model: str, *arguments) -> Path:
        """Run one; its folder has its wire `link`, its `image`, and a `relay` that cuts its supply."""
        folder = self.folder / name
        folder.mkdir()
        control = f"unix:{folder}/ctl"
        relay = folder / "relay"
        relay.write_text(f"#!/bin/sh\necho $1 >>{folder}/switched\n"
                         f"exec {PROGRAM} ctl --control {control} \"POWer $1\" >/dev/null\n")
        relay.chmod(0o755)
        wire, settings, *_ = WIRES[model]
        self.running.append(Encoder([model, f"--{wire}={folder}/link", *settings, "--nvm", folder / "image", "--serial", SERIAL,
                                     "--shaft", "12.3DEG", "--control", control, *arguments]))
        return folder

    def end(self) -> list:
        self.pool.shutdown(cancel_futures=True)
        lines = [line for encoder in self.running for line in encoder.clean_up()]
        self.place.cleanup()
        return lines


def command(model: str, path, *arguments) -> list:
    return [PROGRAM, "verify", model, f"--{WIRES[model][0]}={path}", *map(str, arguments)]


def verify(model: str, path, *arguments, status: int = 0) -> subprocess.CompletedProcess:
    """Ask the encoder at this pseudo-terminal."""
    ended = subprocess.run(command(model, path, *arguments), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                           timeout=LIMIT_S)
    assert ended.returncode == status, (ended.stdout[-2000:], ended.stderr)
    return ended


def clauses(model: str) -> list:
    text = "".join((REPOSITORY / f"tests/conformance/{suite}.clauses").read_text("utf-8") for suite in SUITES[model])
    return re.findall(r"^(\S+) +\|", text, re.M)


def results(ended: subprocess.CompletedProcess) -> dict:
    """(suite, clause): what became of it, and why."""
    return {(row["suite"], row["clause"]): (row["result"], row["why"]) for row in json.loads(ended.stdout)}


def those(found: dict, result: str) -> set:
    return {clause for clause, (became, _) in found.items() if became == result}


def cut(model: str) -> list:
    """Its clauses in parts."""
    every, count = clauses(model), WRITTEN[model][0]
    return [every[len(every) * part // count:len(every) * (part + 1) // count] for part in range(count)]


def uploads(link) -> list:
    """The answers of a CANopen encoder, by an adapter of our own."""
    near = os.open(link, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(near)
    os.write(near, b"C\rS5\rO\r")
    answers = []
    for index, subs in OBJECTS:
        for sub in subs:
            os.write(near, b"t63F840%02X%02X%02X00000000\r" % (index & 0xFF, index >> 8, sub))
            answer = b""
            while not answer.startswith(b"t5BF") or not answer.endswith(b"\r"):
                assert select.select([near], [], [], 5.0)[0], (index, sub)
                byte = os.read(near, 1)
                answer = byte if answer[-1:] in (b"\r", b"\a") else answer + byte
            answers.append(answer)
    os.write(near, b"C\r")
    os.close(near)
    return answers


def state(model: str, folder) -> tuple:
    """What an encoder keeps, without what may be otherwise."""
    kept = bytearray((folder / "image").read_bytes())
    unused = UNUSED if model == "f3668" and kept[SAVED] == 0 else []
    for first, end in WRITTEN[model][2] + unused:
        kept[first:end] = bytes(end - first)
    return bytes(kept), uploads(folder / "link") if model == "f3668" else []


class Server(threading.Thread):
    """Talks with one client on a port of its own, `where`, in run()."""

    def __init__(self):
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.where = f"127.0.0.1:{self.listener.getsockname()[1]}"

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError):
            self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.join(LIMIT_S)
        assert not self.is_alive()


class Between(threading.Thread):
    """A wire between the command and an encoder, which alters answers: alter(request, answer) returns what is sent, and
    what it returns None for is lost. hear(request) is told of what goes to the encoder before it does, and returns
    whether it may. Without an encoder it answers alone."""

    def __init__(self, path, alter=lambda _, answer: answer, ends: bytes = b"", hear=lambda _: True):
        super().__init__(daemon=True)
        self.alter, self.ends, self.hear = alter, ends, hear
        self.near, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.path = os.ttyname(self.slave)
        self.far = os.open(path, os.O_RDWR | os.O_NOCTTY) if path else None
        if self.far is not None:
            tty.setraw(self.far)
        self.stopping = False
        self.request = b""

    def pieces(self, data: bytes) -> list:
        """Lines of an adapter are apart, whatever read() makes of them."""
        if not self.ends:
            return [data]
        return re.findall(b"[^" + self.ends + b"]*[" + self.ends + b"]?", data)[:-1]

    def answer(self, data: bytes):
        for piece in self.pieces(data):
            sent = self.alter(self.request, piece)
            if sent:
                os.write(self.near, sent)

    def run(self):
        fresh = True
        while not self.stopping:
            ready = select.select([self.near] + ([self.far] if self.far is not None else []), [], [], 0.05)[0]
            if self.near in ready:
                data = os.read(self.near, 4096)
                self.request = data if fresh else self.request + data
                fresh = False
                if self.far is None:
                    self.answer(b"")
                elif self.hear(data):
                    os.write(self.far, data)
            if self.far in ready:
                data = os.read(self.far, 4096)
                while not self.ends and select.select([self.far], [], [], 0.01)[0]:
                    data += os.read(self.far, 4096)  # the whole of a frame
                self.answer(data)
                fresh = True

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stopping = True
        self.join()
        for end in (self.near, self.slave, self.far):
            if end is not None:
                os.close(end)


class Babbling(Between):
    """An encoder that sends without end once it has answered `answers` times."""

    def __init__(self, path, answers: int, noise: bytes, ends: bytes):
        super().__init__(path, self.count_answer, ends)
        self.left, self.noise = answers, noise
        self.speaker = threading.Thread(target=self.babble, daemon=True)
        os.set_blocking(self.near, False)

    def count_answer(self, _, answer: bytes):
        self.left -= 1
        if self.left == -1:
            self.speaker.start()
        return answer if self.left >= 0 else None

    def babble(self):
        while not self.stopping:
            if select.select([], [self.near], [], 0.05)[1]:
                with contextlib.suppress(BlockingIOError):
                    os.write(self.near, self.noise)

    def __exit__(self, *_):
        self.stopping = True
        if self.speaker.is_alive():
            self.speaker.join()
        super().__exit__()


class Killer:
    """Kill a command at request number `at` of those that `counts` counts, before or after the encoder gets it: what a
    Between asks whether it passes a request on."""

    def __init__(self, at: int, before: bool, counts):
        self.left, self.before, self.counts = at, before, counts
        self.process, self.done = None, False

    def hear(self, request: bytes) -> bool:
        if self.done:
            return False
        self.left -= self.counts(request)
        if self.left > 0:
            return True
        self.process.kill()
        self.done = True
        return not self.before
