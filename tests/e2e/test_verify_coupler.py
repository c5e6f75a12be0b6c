# SPDX-License-Identifier: MIT
"""`drehgeber verify` behind a Modbus/TCP coupler: our own encoders agree and are left as they were, with --write, too; encoders
that are broken on purpose, each in one word, are found and named by their clause; couplers that misbehave are left in time."""
import contextlib
import json
import os
import re
import socket
import struct
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rig import PROGRAM, Client, Encoder, run_refused
from verified import Server

K3 = "ocd-ib-k3"
LIMIT_S = 120.0
PARTS = 12  # into which the clauses are cut for --write
AGREE, AGREE_WRITTEN = 35, 60  # at least
STORED = slice(0x2AA, 0x4F8)  # of the image: all regions but the time, and no journal of the store
INPUT, OUTPUT, ID_WORD = 0x0000, 0x0800, 0x2000
READ, WRITE = 3, 16


@pytest.fixture(scope="module")
def folders():
    """begin(name, model): an encoder with its coupler; .port, .folder. An encoder acknowledges a write when it is on the disk,
    for which a busy disk takes seconds: here there is none."""
    place = tempfile.TemporaryDirectory(prefix="drehgeber-verify-", dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None)
    running, root = [], Path(place.name)

    def begin(name: str, model: str = K3, *arguments, shaft: str = "2000.3DEG"):
        folder = root / name
        folder.mkdir()
        control = f"unix:{folder}/ctl"
        relay = folder / "relay"
        relay.write_text(f"#!/bin/sh\necho $1 >>{folder}/switched\n"
                         f"exec {PROGRAM} ctl --control {control} \"POWer $1\" >/dev/null\n")
        relay.chmod(0o755)
        memory = ["--nvm", folder / "image"] if model == K3 else []
        one = Encoder([model, "--modbus=127.0.0.1:0", *memory, "--shaft", shaft, "--control", control, *arguments])
        one.folder, one.port = folder, int(one.ready_line.rpartition(":")[2])
        one.where = f"127.0.0.1:{one.port}"
        running.append(one)
        time.sleep(0.3)  # its self-test, in which IN looks like a read-out
        return one

    yield begin
    said = [line for one in running for line in one.clean_up()]
    place.cleanup()
    assert said == []


def verify(where, *arguments, model: str = K3, status: int = 0) -> subprocess.CompletedProcess:
    ended = subprocess.run([PROGRAM, "verify", model, f"--modbus={where}", *map(str, arguments)], stdin=subprocess.DEVNULL,
                           capture_output=True, text=True, timeout=LIMIT_S)
    assert ended.returncode == status, (ended.stdout[-2000:], ended.stderr)
    return ended


def results(ended) -> dict:
    return {row["clause"]: (row["result"], row["why"]) for row in json.loads(ended.stdout)}


def those(found: dict, result: str) -> set:
    return {clause for clause, (became, _) in found.items() if became == result}


class Between(Server):
    """A coupler between the command and ours, for one client. alter(command, word) makes of IN what is sent in its place,
    where `command` is the last OUT with a command; hear(OUT) is told of each OUT. answer(reply) makes of a whole reply what
    is sent; None: the connection ends."""

    def __init__(self, port, alter=lambda _, word: word, hear=lambda _: None, answer=lambda reply: reply):
        super().__init__()
        self.port, self.alter, self.hear, self.answer = port, alter, hear, answer
        self.command, self.stopping = 0, False

    @staticmethod
    def message(wire) -> bytes:
        head = wire.recv(6, socket.MSG_WAITALL)
        return head + wire.recv(struct.unpack(">H", head[4:])[0], socket.MSG_WAITALL) if len(head) == 6 else b""

    def changed(self, request: bytes, reply: bytes) -> bytes:
        function, first = struct.unpack(">BH", request[7:10])
        if function == WRITE and first == OUTPUT:
            out = struct.unpack(">I", request[13:17])[0]
            self.command = out if out >> 25 else self.command
            self.hear(out)
        if function == READ and first == INPUT and len(reply) == 13:
            reply = reply[:9] + struct.pack(">I", self.alter(self.command, struct.unpack(">I", reply[9:])[0]))
        return reply

    def run(self):
        with contextlib.suppress(OSError), self.listener.accept()[0] as near:
            with socket.create_connection(("127.0.0.1", self.port)) as far:
                while request := self.message(near):
                    far.sendall(request)
                    reply = self.answer(self.changed(request, self.message(far)))
                    if reply is None:
                        return
                    near.sendall(reply)


# --- our own

def test_our_own_agrees_and_stays_as_it_was(folders):
    one, sent = folders("asked"), []
    before = (one.folder / "image").read_bytes()
    with Between(one.port, hear=sent.append) as wire:
        found = results(verify(wire.where, "--json", "--report", one.folder / "report"))
    assert {clause: found[clause] for clause in those(found, "differs")} == {}
    assert len(those(found, "agrees")) >= AGREE
    assert all(why for result, why in found.values() if result == "not seen")
    assert (one.folder / "image").read_bytes()[STORED] == before[STORED]
    report = (one.folder / "report").read_text("utf-8")
    assert "0 differ" in report and "ID word 0237h" in report and "1234567" not in report
    assert "- none" not in report.partition("Choices that this encoder settles")[2]
    # operation, release, read-outs, and what is no command of the manual
    harmless = {0x00, 0x80, 0xA2, 0x20, *(code for code in range(0x0C, 0x20) if code not in (0x0E, 0x0F))}
    assert {word >> 24 for word in sent} - harmless == {0x01} and sent[-1] == 0
    assert all(word >> 16 in (0x2020, 0x2021) for word in sent if word >> 24 == 0x20)


@pytest.mark.parametrize("model, clause", [("ocd-ib-k1", "2.1.1-2"), ("ocd-ib-k2", "2.2-2")])
def test_those_without_out(folders, model, clause):
    one = folders(model, model)
    found = results(verify(one.where, "--json", model=model))
    assert those(found, "differs") == set() and found["2.2-1" if model.endswith("1") else clause][0] == "agrees"


@pytest.fixture(scope="module")
def written(folders):
    every = re.findall(r'"clause": "([^"]+)"', verify(folders("list").where, "--json", "5", "9", "I", "2", "D").stdout)
    pool = ThreadPoolExecutor(PARTS)

    def ask(part):
        one = folders(f"write{part}")
        before = (one.folder / "image").read_bytes()[STORED]
        ended = verify(one.where, "--json", "--write", "--power", one.folder / "relay", "--journal", one.folder / "journal",
                       *every[part::PARTS])
        assert (one.folder / "journal").read_bytes() == b""
        with Client(f"unix:{one.folder}/ctl") as client:
            assert client.ask("*IDN?")
        return results(ended), before == (one.folder / "image").read_bytes()[STORED], one.folder

    yield [pool.submit(ask, part) for part in range(PARTS)]
    pool.shutdown()


def test_everything_that_is_written_is_put_back(written):
    agrees, switched = set(), []
    for found, same, folder in (one.result() for one in written):
        assert {clause: found[clause] for clause in those(found, "differs")} == {}
        assert same, folder
        agrees |= those(found, "agrees")
        switched += (folder / "switched").read_text().split() if (folder / "switched").exists() else []
    assert len(agrees) >= AGREE_WRITTEN
    assert switched and switched == ["off", "on"] * (len(switched) // 2)


def await_change(image, before: bytes):
    """Until the encoder has stored something; the command waits meanwhile."""
    deadline = time.monotonic() + LIMIT_S
    while image.read_bytes()[STORED] == before and time.monotonic() < deadline:
        time.sleep(0.005)


def test_a_run_that_was_killed_is_restored(folders):
    one = folders("killed")
    before, journal = (one.folder / "image").read_bytes()[STORED], one.folder / "journal"
    arguments = ["2.1-3", "--write", "--journal", journal]
    changed, killed = threading.Event(), threading.Event()

    def hear(out):
        if out == 0x06000004:
            await_change(one.folder / "image", before)
            changed.set()
            killed.wait(LIMIT_S)

    with Between(one.port, hear=hear) as wire:
        process = subprocess.Popen([PROGRAM, "verify", K3, f"--modbus={wire.where}", *map(str, arguments)],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert changed.wait(LIMIT_S)
        process.kill()
        process.communicate(timeout=LIMIT_S)
        killed.set()
    assert (one.folder / "image").read_bytes()[STORED] != before
    assert "expected --restore" in verify(one.where, *arguments, status=1).stderr
    assert verify(one.where, "--restore", "--journal", journal).stdout == "the encoder is as it was\n"
    assert (one.folder / "image").read_bytes()[STORED] == before


def test_one_that_dies_changed_is_restored_later(folders):
    one, dead = folders("dies_changed"), []
    before, journal = (one.folder / "image").read_bytes()[STORED], one.folder / "journal"
    arguments = ["2.1-3", "--write", "--journal", journal]

    def hear(out):
        if out == 0x06000004:
            await_change(one.folder / "image", before)
            dead.append(out)

    with Between(one.port, hear=hear, answer=lambda reply: None if dead else reply) as wire:
        ended = verify(wire.where, *arguments, status=1)
    assert "does not have its old values" in ended.stdout and "--restore" in ended.stdout
    assert dead and (one.folder / "image").read_bytes()[STORED] != before
    assert "expected --restore" in verify(one.where, *arguments, status=1).stderr
    assert verify(one.where, "--restore", "--journal", journal).stdout == "the encoder is as it was\n"
    assert (one.folder / "image").read_bytes()[STORED] == before


# --- broken on purpose

BROKEN = {  # clause: what its encoder makes of IN
    "9.3-3": lambda _, word: 0x82000000 if word == 0x84000000 else word,
    "9.3-5": lambda command, word: word ^ 1 if word >> 25 == 0xA4 >> 1 else word,
    "9.2-24": lambda command, word: word & ~2 if command == 0x2021000A and word >> 25 == 0xA0 >> 1 else word,
}


@pytest.mark.parametrize("clause", BROKEN)
def test_each_broken_encoder_is_found_and_named(folders, clause):
    with Between(folders(f"broken{clause}").port, BROKEN[clause]) as wire:
        ended = verify(wire.where, clause, status=1)
    (why,) = re.findall(rf"^differs  {re.escape(clause)}: (.*)$", ended.stdout, re.M)
    assert re.search(r":\d+: sent [0-9A-F]{8}; expected [0-9A-F]{8}; came [0-9A-F]{8}$", why), why


def test_what_flickers_on_its_way_is_a_difference(folders):
    """IN is something else for one look before each answer."""
    last = []

    def flicker(_, word):
        fresh = word >> 25 == 0xA4 >> 1 and (not last or last[-1] >> 25 == 0)
        last.append(word)
        return 0xE0000000 if fresh else word

    with Between(folders("flickers").port, flicker) as wire:
        ended = verify(wire.where, "9.3-5", status=1)
    assert "expected A421000B; came E0000000" in ended.stdout


class Late(Between):
    """The encoder gets one word of OUT only when it has stood for longer than a second."""
    WORD = 0x2021000E

    def run(self):
        held = None  # the request, and when it is due
        with contextlib.suppress(OSError), self.listener.accept()[0] as near:
            with socket.create_connection(("127.0.0.1", self.port)) as far:
                while request := self.message(near):
                    if held and time.monotonic() > held[1]:
                        far.sendall(held[0])
                        self.message(far)
                        held = None
                    if struct.unpack(">BH", request[7:10]) == (WRITE, OUTPUT):
                        late = struct.unpack(">I", request[13:17])[0] == self.WORD
                        held = (request, time.monotonic() + 1.5) if late else None
                    if held and held[0] == request:
                        near.sendall(request[:4] + b"\0\6" + request[6:12])
                        continue
                    far.sendall(request)
                    near.sendall(self.message(far))


def test_what_comes_late_is_a_difference(folders):
    with Late(folders("late").port) as wire:
        ended = verify(wire.where, "9.3-5", "9.3-3", status=1)
    (why,) = re.findall("^differs  (.*)$", ended.stdout, re.M)
    assert re.fullmatch(r"9\.3-5: interbus:\d+: sent 2021000E; expected A421000E; came 0[0-9A-F]{7}", why), why
    assert "\nagrees   9.3-3\n" in ended.stdout and "ended early" not in ended.stdout


def test_one_that_does_not_leave_an_error_is_lost(folders):
    stuck = []

    def hold(_, word):
        stuck.extend([word] if word == 0x84000000 else [])
        return stuck[0] if stuck else word

    with Between(folders("holds").port, hold) as wire:
        ended = verify(wire.where, "9.3-3", status=1)
    assert "differs  9.3-3" in ended.stdout
    assert "it ended early: the encoder stopped answering in the row" in ended.stdout


# --- couplers

def test_one_that_dies_is_told_and_ends_it(folders):
    count = []

    def die(reply):
        count.append(reply)
        return reply if len(count) < 300 else None

    with Between(folders("dies").port, answer=die) as wire:
        ended = verify(wire.where, status=1)
    assert "it ended early: the encoder stopped answering in the row" in ended.stdout


class Endless(Between):
    """It sends without end once it has answered `answers` times."""

    def __init__(self, port, answers: int):
        super().__init__(port)
        self.answers = answers

    def run(self):
        with contextlib.suppress(OSError), self.listener.accept()[0] as near:
            with socket.create_connection(("127.0.0.1", self.port)) as far:
                for _ in range(self.answers):
                    far.sendall(self.message(near))
                    near.sendall(self.message(far))
                while True:
                    near.sendall(bytes(range(256)))


@pytest.mark.parametrize("answers", [0, 300])
def test_one_that_never_stops_is_told_and_ends_it(folders, answers):
    with Endless(folders(f"endless{answers}").port, answers) as wire:
        ended = verify(wire.where, status=1)
    if answers == 0:
        assert ended.stdout == "" and ended.stderr.startswith(f"drehgeber: {wire.where}: ") and ended.stderr.count("\n") == 1
    else:
        assert "it ended early: the encoder stopped answering in the row" in ended.stdout


GARBAGE = {
    "silent": b"",
    "noise": bytes(range(256)) * 8,
    "another transaction": b"\xff\xff\0\0\0\x05\xff\3\2\0\0",
    "an endless answer": b"\0\1\0\0\xff\xff\xff\3\xff" + bytes(65536),
}


@pytest.mark.parametrize("noise", GARBAGE.values(), ids=GARBAGE)
def test_garbage_is_no_coupler(noise):
    def talk():
        with contextlib.suppress(OSError), listener.accept()[0] as wire:
            while wire.recv(4096):
                wire.sendall(noise)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=talk, daemon=True)
        thread.start()
        where = "127.0.0.1:%d" % listener.getsockname()[1]
        ended = verify(where, status=1)
        assert ended.stdout == "" and ended.stderr.startswith(f"drehgeber: {where}: ") and ended.stderr.count("\n") == 1
        thread.join(LIMIT_S)


def test_what_is_refused(folders):
    """A whole line each, with what is expected."""
    other, turning = folders("other", "ocd-ib-k2"), folders("turning", shaft="100RPM")
    ring = folders("ring", K3, "--ring", f"{K3},ocd-ib-k1")
    for where, options, line in (
            (other.where, [], f"{other.where}: its ID word is 0236, not 0237; expected an encoder in operation, first in the "
                              "ring of a coupler with the registers of 'drehgeber map'"),
            (turning.where, [], f"{turning.where}: the shaft turns; expected a shaft at rest"),
            ("here", [], "here is no address of a coupler; expected HOST:PORT"),
            (ring.where, ["--alone"], "another device is in the ring: it has 3 words; without --alone, verify disturbs no other device")):
        assert run_refused(1, "verify", K3, f"--modbus={where}", *options) == f"drehgeber: {line}"
