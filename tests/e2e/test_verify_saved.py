# SPDX-License-Identifier: MIT
"""`drehgeber verify --write --power COMMAND`: an encoder is asked to bring back what was delivered (1011h), and to save (1010h);
what its owner had saved, and what was only in force, is there again afterwards, also when the command was killed."""
import os
import re
import select
import subprocess
import tty

import pytest

from rig import run
from verified import LIMIT_S, Between, Crowd, Killer, command, results, state, strange_lines, those, verify

MODEL = "f3668"
SAVE, LOAD = b"73617665", b"6C6F6164"
DELIVERED = {"M10-1", "M10-7", "M10-21"}
# Beginnings of clauses that rows prove which save, bring back or preset; each list is asked of an encoder of its own. None is
# about times: many encoders run at once.
STORING = [["M10"], ["M12", "M26-3"], ["C7", "M26-42", "M26-10"], ["CIA-7-3", "CIA-7-4", "CIA-1-7", "M26-9", "M26-11"]]
# Written in this order, and saved: object, bytes, value. TPDO 1 has another identifier and mapping, TPDO 3 is off and has an
# entry behind its last one, the scaling has the figures of USF.
OWN = [
    (0x1005, 0, 4, 0x90), (0x1006, 0, 4, 10000), (0x1007, 0, 4, 1000), (0x100C, 0, 2, 100), (0x100D, 0, 1, 3),
    (0x1012, 0, 4, 0x80000100), (0x1015, 0, 2, 10), (0x1016, 1, 4, 0x000501F4), (0x1016, 2, 4, 0x000703E8),
    (0x1017, 0, 2, 300), (0x1029, 1, 1, 1), (0x1029, 2, 1, 2), (0x1029, 3, 1, 0),
    (0x1800, 1, 4, 0x800001BF), (0x1A00, 0, 1, 0), (0x1A00, 1, 4, 0x60040020), (0x1A00, 2, 4, 0x60300110), (0x1A00, 0, 1, 2),
    (0x1800, 2, 1, 254), (0x1800, 3, 2, 20), (0x1800, 5, 2, 50), (0x1800, 1, 4, 0x800001A5), (0x1800, 1, 4, 0x1A5),
    (0x1802, 1, 4, 0x800003BF), (0x1A02, 0, 1, 0), (0x1A02, 1, 4, 0x65030010), (0x1A02, 2, 4, 0x65050010), (0x1A02, 0, 1, 1),
    (0x2120, 2, 1, 0x30), (0x2120, 3, 1, 0x90), (0x2140, 1, 4, 0x12345678), (0x2140, 4, 4, 0x9ABCDEF0),
    (0x6001, 0, 4, 3600), (0x6002, 0, 4, 36000), (0x6000, 0, 2, 0x2005),
    (0x6031, 1, 2, 1), (0x6031, 2, 2, 200), (0x6031, 3, 2, 2), (0x6031, 4, 2, 3),
    (0x6401, 1, 4, 1000), (0x6401, 2, 4, 2000), (0x6402, 1, 4, 35000), (0x6402, 2, 4, 34000),
]


@pytest.fixture(scope="module")
def crowd():
    crowd = Crowd()
    yield crowd
    assert strange_lines(crowd.end()) == []


JOBS = {}  # what the tests do: most of it is waiting, so all of them begin at once


def job(*rows):
    """Each is called with one of the rows."""
    def add(do):
        for number, row in enumerate(rows or [()]):
            JOBS[do.__name__ + (f"-{number}" if rows else "")] = (do, row)
        return do
    return add


@pytest.fixture(scope="module", autouse=True)
def running(crowd):
    return {name: crowd.pool.submit(do, crowd, name, *row) for name, (do, row) in JOBS.items()}


def sdo(link, *requests: bytes) -> list:
    """Answers of the encoder, by an adapter of our own."""
    near = os.open(link, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(near)
    os.write(near, b"C\rS5\rO\r")
    answers = []
    for request in requests:
        os.write(near, b"t63F8" + request + b"\r")
        answer = b""
        while not (answer.startswith(b"t5BF8") and answer[-1:] == b"\r"):
            assert select.select([near], [], [], 5.0)[0], request
            byte = os.read(near, 1)
            answer = byte if answer[-1:] in (b"\r", b"\a") else answer + byte
        answers.append(answer[5:21])
    os.write(near, b"C\r")
    os.close(near)
    return answers


def download(index: int, sub: int, n: int, value: int) -> bytes:
    return b"%02X%02X%02X%02X" % (0x23 | (4 - n) << 2, index & 0xFF, index >> 8, sub) + value.to_bytes(4, "little").hex().upper().encode()


SAVING = b"23101001" + SAVE


def switch(folder):
    for to in ("off", "on"):
        subprocess.run([folder / "relay", to], check=True, timeout=LIMIT_S)


def own(crowd, name: str, objects=tuple(OWN), saved: bool = True):
    """An encoder whose owner has written these objects."""
    folder = crowd.begin(name, MODEL)
    for at, answer in enumerate(sdo(folder / "link", *(download(*one) for one in objects), *[SAVING] * saved)):
        assert answer.startswith(b"60"), (at, answer)
    if saved:
        switch(folder)
    return folder


def everything(folder) -> tuple:
    """What is in force, then what is saved."""
    before = state(MODEL, folder)
    switch(folder)
    return before, state(MODEL, folder)


def storing(folder, *words, **options) -> subprocess.CompletedProcess:
    return verify(MODEL, folder / "link", "--write", "--power", folder / "relay", "--journal", folder / "journal", *words, **options)


# --- what was saved -------------------------------------------------------------------------------

@job(*zip(STORING))
def what_its_owner_has_saved_is_saved_again(crowd, name, words):
    folder = own(crowd, name)
    before = state(MODEL, folder)
    found = results(storing(folder, "--json", *words))
    assert those(found, "differs") == set() and len(those(found, "agrees")) > 1
    if words == ["M10"]:
        assert DELIVERED <= {clause for _, clause in those(found, "agrees")}
    assert (folder / "journal").read_bytes() == b""
    assert everything(folder) == (before, before)


@job(*zip(STORING))
def what_a_new_encoder_has_is_the_same(crowd, name, words):
    folder = crowd.begin(name, MODEL)
    before = state(MODEL, folder)
    found = results(storing(folder, "--json", "--alone", *words))
    assert those(found, "differs") == set() and len(those(found, "agrees")) > 3
    assert everything(folder) == (before, before)


@job()
def what_was_in_force_and_not_saved_is_so_again(crowd, name):
    folder = own(crowd, name, [(0x1006, 0, 4, 20000), (0x6031, 2, 2, 200)])
    for answer in sdo(folder / "link", download(0x1006, 0, 4, 30000), download(0x2140, 2, 4, 5), download(0x1029, 1, 1, 2)):
        assert answer.startswith(b"60")
    before = state(MODEL, folder)
    storing(folder, "M10")
    now, saved = everything(folder)
    assert now == before and saved != before
    uploads = [b"40061000" + b"0" * 8, b"40402102" + b"0" * 8, b"40291001" + b"0" * 8]
    assert [answer[8:] for answer in sdo(folder / "link", *uploads)] == [b"204E0000", b"00000000", b"00000000"]


@job()
def every_object_that_can_be_written_is_noted(crowd, name):
    """By the encoder's own EDS file; but for what counts, what deletes, and what is a command."""
    sections = re.findall(r"\[(\w{4})(?:sub(\w))?\]\s(.*?)(?=\n\[|\Z)", run("eds", MODEL).stdout, re.S)
    wanted = {(int(index, 16), int(sub or "0", 16)) for index, sub, text in sections
              if re.search(r"^AccessType=rww?r?\s*$", text, re.M) and "ObjFlags=0x1" not in text} - {(0x1003, 0), (0x1013, 0)}
    assert len(wanted) > 80
    heard, folder = [], crowd.begin(name, MODEL)
    with Between(folder / "link", ends=b"\r\a", hear=lambda request: heard.append(request) or True) as wire:
        verify(MODEL, wire.path, "M10-1", "--write", "--power", folder / "relay", "--journal", folder / "journal")
    before = b"".join(heard).partition(b"t63F823111001" + LOAD)[0]
    asked = [(int(at[2:4] + at[:2], 16), int(at[4:6], 16)) for at in re.findall(rb"t63F840(\w{6})", before)]
    assert {at for at in wanted if asked.count(at) < 2} == set()  # in force, and saved


# --- what cannot be saved again -------------------------------------------------------------------

USF = [(0x6002, 0, 4, 36000), (0x6001, 0, 4, 3600), (0x6000, 0, 2, 0x1004)]
PRESET, ZERO, BUS = [(0x6003, 0, 4, 1000)], [(0x6003, 0, 4, 0)], [(0x2102, 0, 1, 0)]
REASONS = [
    (PRESET, True, "the encoder has a preset, and 1011h would lose it (6003h)"),
    (PRESET, False, "the encoder has a preset, and 1011h would lose it (6003h)"),
    (ZERO, True, "the encoder has a preset, and 1011h would lose it (6509h)"),
    (USF, True, "the encoder has USF on, and 1011h would lose its zero (6000h)"),
    (USF, False, "the encoder has USF on, and 1011h would lose its zero (6000h)"),
    (BUS, False, "the encoder has its own bus parameters, and 1011h could lose them (2102h)"),
]


@job(*REASONS)
def what_could_not_be_put_back_is_not_tried(crowd, name, objects, saved, reason):
    folder = own(crowd, name, objects, saved)
    before, heard = state(MODEL, folder), []
    with Between(folder / "link", ends=b"\r\a", hear=lambda request: heard.append(request) or True) as wire:
        ended = verify(MODEL, wire.path, "--write", "--power", folder / "relay", "--journal", folder / "journal", "M10-14", "M10-27",
                       "--alone", "--json")
    found = {clause: row for (_, clause), row in results(ended).items() if clause in ("M10-14", "M10-27")}
    assert len(found) == 2 and all(result == "not seen" and why.endswith(reason) for result, why in found.values()), found
    assert not re.search(rb"t63F82.1[01]1001", b"".join(heard))
    assert state(MODEL, folder) == before and (folder / "journal").read_bytes() == b""


@job()
def a_supply_that_nobody_cuts_is_needed(crowd, name):
    folder = crowd.begin(name, MODEL)
    ended = verify(MODEL, folder / "link", "--write", "--journal", folder / "journal", "--json", "CIA-7-4", "--alone")
    assert ("not seen", "needs a supply that can be cut (--power)") in results(ended).values()


# --- killed ---------------------------------------------------------------------------------------

def downloads(pattern: bytes):
    """Counts the downloads that this is in."""
    return lambda request: sum(line.startswith(b"t63F82") and pattern in line for line in request.split(b"\r"))


def restore(folder):
    refused = storing(folder, "M10-1", status=1)
    assert refused.stdout == "" and "expected --restore" in refused.stderr
    restored = verify(MODEL, folder / "link", "--restore", "--power", folder / "relay", "--journal", folder / "journal")
    assert restored.stdout == "the encoder is as it was\n" and (folder / "journal").read_bytes() == b""


# Which download: the first 1011h makes the encoder one as delivered, the second is the row's, the third is that of putting back;
# then every object follows, and 1010h.
@job((1, True, b""), (1, False, b""), (2, True, b""), (2, False, b""), (3, True, b""), (3, False, b""), (10, False, b""),
     (25, True, b""), (60, False, b""), (90, True, b""), (1, True, SAVE), (1, False, SAVE))
def a_killed_run_is_restored(crowd, name, at, before, pattern):
    folder = own(crowd, name)
    was, killer = state(MODEL, folder), Killer(at, before, downloads(pattern))
    with Between(folder / "link", ends=b"\r\a", hear=killer.hear) as wire:
        killer.process = subprocess.Popen(
            command(MODEL, wire.path, "--write", "--power", folder / "relay", "--journal", folder / "journal", "M10-1"),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        killer.process.communicate(timeout=LIMIT_S)
    assert killer.done and killer.process.returncode == -9
    restore(folder)
    assert everything(folder) == (was, was)


@job((1,), (2,), (3,), (4,))
def one_that_is_left_without_supply_is_restored(crowd, name, at):
    """It is killed while the supply is off: before the row, in it, behind it."""
    folder = own(crowd, name)
    was = state(MODEL, folder)
    relay = folder / "killing"
    relay.write_text(f"#!/bin/sh\n{folder}/relay $1\n[ $1 = off ] && echo >>{folder}/cuts && "
                     f"[ $(wc -l <{folder}/cuts) = {at} ] && kill -9 $(cat {folder}/pid)\nexit 0\n")
    relay.chmod(0o755)
    words = command(MODEL, folder / "link", "--write", "--power", relay, "--journal", folder / "journal", "M10-1")
    process = subprocess.Popen(["sh", "-c", f"echo $$ >{folder}/pid; exec \"$@\"", "sh", *words],
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.communicate(timeout=LIMIT_S)
    assert process.returncode == -9
    restore(folder)
    assert everything(folder) == (was, was)


@job()
def an_object_that_is_refused_is_named_and_restored_later(crowd, name):
    folder = own(crowd, name)
    was = state(MODEL, folder)
    with Between(folder / "link", ends=b"\r\a", hear=lambda request: b"t63F82B316002C800" not in request) as wire:
        ended = verify(MODEL, wire.path, "M10-7", "--write", "--power", folder / "relay", "--journal", folder / "journal", status=1)
    assert "the encoder does not have its old values (6031h:2, saved); --restore puts them back from " in ended.stdout
    assert state(MODEL, folder) != was
    short = verify(MODEL, folder / "link", "--restore", "--journal", folder / "journal", status=1)
    assert short.stdout == "" and short.stderr.count("\n") == 1 and "saved parameters need --power COMMAND" in short.stderr
    restore(folder)
    assert everything(folder) == (was, was)


@pytest.mark.parametrize("name", JOBS)
def test_saved(running, name):
    running[name].result()
