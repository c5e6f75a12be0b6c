# SPDX-License-Identifier: MIT
"""A disk on which every fdatasync takes 0.4 s longer, and fails while it is told to: whoever writes
waits for his own commit, and nobody else does. An end waits for it, too, and a kill leaves what there was."""
import contextlib
import os
import re
import struct
import subprocess
import threading
import time

import pytest
import serial

from hiperface_master import Master
from rig import PATIENCE_S, Client, assert_one_line, start_rig
from storing import KINDS, Gone, Refused, start_one

SLOW_S = 0.4
ANSWER_S = 3.0  # two commits behind each other, and then some
UNCHANGED_S = 0.005
ATTEMPTS = 10  # a machine that stands still for a moment proves nothing
SLOW_SYNC = """
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
int fdatasync(int fd)
{
    const struct timespec slow = {.tv_nsec = 400000000};
    const char *fails = getenv("SYNC_FAILS");
    (void)close(open(getenv("SYNC_BEGUN"), O_CREAT | O_WRONLY, 0600));
    do {
        (void)nanosleep(&slow, NULL);
    } while (access(getenv("SYNC_STICKS"), F_OK) == 0);
    errno = EIO;
    return access(fails, F_OK) == 0 ? -1 : (int)syscall(SYS_fdatasync, fd);
}
"""
RIG = """
[rig]
control = tcp:127.0.0.1:0
control = unix:{folder}/s
[encoder storing]
model = {model}
wire = {wire}
nvm = {folder}/storing.nvm
[encoder line]
model = s3684-rs485
wire = pty:{folder}/line
pace = 0
[encoder node]
model = f3668
wire = slcan:{folder}/node
"""
WIRES = {"Hiperface": "pty:{folder}/storing\npace = 0", "Canopen": "slcan:{folder}/storing", "Biss": "sim",
         "Interbus": "modbus:127.0.0.1:0\ncycle = 1000"}
REFUSALS = {"Hiperface": "05", "Canopen": "06060000", "Biss": "-240", "Interbus": "86000000"}


@pytest.fixture
def disk(tmp_path):
    """The environment of a program on this disk, and the file that makes it fail while it is there."""
    (tmp_path / "slow.c").write_text(SLOW_SYNC)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", tmp_path / "slow.so", tmp_path / "slow.c"], check=True)
    return os.environ | {"LD_PRELOAD": str(tmp_path / "slow.so"), "SYNC_FAILS": str(tmp_path / "fails"),
                         "SYNC_STICKS": str(tmp_path / "sticks"), "SYNC_BEGUN": str(tmp_path / "begun"),
                         "ASAN_OPTIONS": "verify_asan_link_order=0"}, tmp_path / "fails"


def timed(call, *arguments) -> float:
    begin = time.monotonic()
    call(*arguments)
    return time.monotonic() - begin


class Others:
    """The masters of the other wires: the worst round trip of each."""

    def __init__(self, folder):
        self.line = Master(str(folder / "line"), grace_s=PATIENCE_S)
        self.node = serial.Serial(str(folder / "node"), timeout=PATIENCE_S)
        self.node.write(b"C\rS5\rO\r")
        self.control = Client(f"unix:{folder}/s")
        self.sdo()

    def sdo(self):
        self.node.write(b"t63F8" + struct.pack("<BHBI", 0x40, 0x6004, 0, 0).hex().encode() + b"\r")
        while b"t5BF8" not in (answer := self.node.read_until(b"\r")):
            assert answer, "no answer"

    def worst_s(self, goes_on) -> list:
        worst = [0.0, 0.0, 0.0]
        while goes_on():
            now = [timed(self.line.read_position), timed(self.sdo), timed(self.control.ask, "*IDN?")]
            worst = [max(pair) for pair in zip(worst, now)]
        return worst

    def close(self):
        self.line.close()
        self.node.close()
        self.control.close()


class Witness:
    """How much too late the machine wakes somebody who only sleeps, at worst."""

    def __enter__(self):
        self.late_s = 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        return self

    def _run(self):
        while not self._end.is_set():
            self.late_s = max(self.late_s, timed(time.sleep, 0.001) - 0.001)

    def __exit__(self, *exception):
        self._end.set()
        self._thread.join()


def while_it(do, others) -> tuple:
    """What it came to, and meanwhile the worst round trips of the others and what of them was the
    machine's: a round trip is one wake-up behind another of master, rig and master."""
    took = []
    thread = threading.Thread(target=lambda: took.extend(timed(do, i) for i in range(2)))
    with Witness() as witness:
        thread.start()
        worst = others.worst_s(thread.is_alive)
        thread.join()
    return took, worst, 2 * witness.late_s


def compare(session, others, capsys, kind):
    """Until the machine has kept time once. What it does to the others is not the same each time: the
    worst of all quiet times counts, in which a thread and a witness run, too."""
    told, quiet = [], [0.0, 0.0, 0.0]
    for attempt in range(ATTEMPTS):
        _, worst, _ = while_it(lambda _: time.sleep(2 * SLOW_S), others)
        quiet = [max(pair) for pair in zip(quiet, worst)]
        took, busy, machine_s = while_it(lambda i: session.write(10 * attempt + 1 + i), others)
        assert len(took) == 2 and min(took) >= SLOW_S, took
        told.append(", ".join(f"{name} {1000 * before:.1f} -> {1000 * now:.1f} ms" for name, before, now in
                              zip(("42h", "SDO", "SCPI"), quiet, busy)) +
                    f", of that the machine {1000 * machine_s:.1f} ms")
        if all(now <= min(before + UNCHANGED_S + machine_s, SLOW_S / 2) for before, now in zip(quiet, busy)):
            with capsys.disabled():
                print(f"\n{kind.__name__} acknowledges after {1000 * min(took):.0f} ms; worst round trips: {told[-1]}")
            return
    raise AssertionError(told)


@pytest.mark.parametrize("kind", KINDS)
def test_others_do_not_wait(tmp_path, disk, capsys, kind):
    wire = WIRES[kind.__name__].format(folder=tmp_path)
    (tmp_path / "rig.ini").write_text(RIG.format(folder=tmp_path, model=kind.model, wire=wire))
    with contextlib.ExitStack() as stack:
        rig = start_rig(tmp_path / "rig.ini", env=disk[0])
        stack.callback(rig.clean_up)
        rig.path = rig.lines[0].split(" ")[2].split(":", 1)[-1]
        rig.control = rig.controls[0]
        session = kind(rig, answer_s=ANSWER_S)
        stack.callback(session.close)
        others = Others(tmp_path)
        stack.callback(others.close)
        compare(session, others, capsys, kind)
        waits = re.search(r"\bnvm_waits=(\d+)", others.control.ask("INST:SEL storing;:STAT?"))
        assert int(waits[1]) >= 2
        assert "nvm_waits" not in others.control.ask("INST:SEL line;:STAT?")
        assert rig.end() == 0
        assert rig.errors.so_far() == []


def write_until_taken(session, value):
    """Refused until all that failed is on the disk."""
    deadline = time.monotonic() + PATIENCE_S
    while True:
        try:
            return session.write(value)
        except Refused:
            assert time.monotonic() < deadline
            time.sleep(0.05)


@pytest.mark.parametrize("kind", KINDS)
def test_a_write_that_fails_too_late_is_not_acknowledged(start, nvm, tmp_path, disk, kind):
    environment, fails = disk
    encoder = start_one(start, kind, tmp_path, nvm, 0, env=environment)
    session = kind(encoder, answer_s=ANSWER_S)
    session.write(1)
    fails.touch()
    with pytest.raises(Gone):
        session.write(2)
    assert_one_line(encoder, str(nvm), "Input/output error", "until it works again")
    took = []
    for value in (3, 4):
        begin = time.monotonic()
        with pytest.raises(Refused, match=REFUSALS[kind.__name__]):
            session.write(value)
        took.append(time.monotonic() - begin)
    assert min(took) < SLOW_S  # it is not tried again first
    fails.unlink()
    write_until_taken(session, 5)
    assert_one_line(encoder, str(nvm), "works again")
    assert session.read() == 5
    session.write(6)
    assert encoder.end(9) == -9
    session.close()
    session = kind(start_one(start, kind, tmp_path, nvm, 1))
    assert session.read() == 6
    session.close()


def try_to_write(session, value):
    with contextlib.suppress(Gone):
        session.write(value)


def begin_to_write(session, value, folder) -> threading.Thread:
    """Until the disk works for it. All that was acknowledged before is on the disk: it works for nothing else."""
    (folder / "begun").unlink()
    writer = threading.Thread(target=try_to_write, args=(session, value))
    writer.start()
    deadline = time.monotonic() + PATIENCE_S
    while not (folder / "begun").exists():
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return writer


@pytest.mark.parametrize("kind", KINDS)
def test_an_orderly_end_waits_for_the_disk(start, nvm, tmp_path, disk, kind):
    encoder = start_one(start, kind, tmp_path, nvm, 0, env=disk[0])
    session = kind(encoder, answer_s=ANSWER_S)
    session.write(1)
    writer = begin_to_write(session, 2, tmp_path)
    assert encoder.end() == 0
    writer.join(PATIENCE_S)
    session.close()
    session = kind(start_one(start, kind, tmp_path, nvm, 1))
    assert session.read() == 2
    session.close()


def test_an_end_that_waits_for_a_stuck_disk_says_so(start, nvm, tmp_path, disk):
    kind = KINDS[0]
    encoder = start_one(start, kind, tmp_path, nvm, 0, env=disk[0])
    session = kind(encoder, answer_s=ANSWER_S)
    session.write(1)
    (tmp_path / "sticks").touch()
    writer = begin_to_write(session, 2, tmp_path)
    encoder.process.terminate()
    assert_one_line(encoder, str(nvm), "the disk is slow; waiting until")
    assert encoder.process.poll() is None
    (tmp_path / "sticks").unlink()
    assert encoder.process.wait(PATIENCE_S) == 0
    writer.join(PATIENCE_S)
    session.close()
    session = kind(start_one(start, kind, tmp_path, nvm, 1))
    assert session.read() == 2
    session.close()


def erased_until_killed(start, nvm, tmp_path, disk, after_s) -> tuple:
    """What is in the EEPROM afterwards, and what the next start says."""
    kind = next(kind for kind in KINDS if kind.__name__ == "Biss")
    nvm = nvm.with_name(f"{after_s:.1f}.nvm")
    encoder = start_one(start, kind, tmp_path, nvm, 0)
    session = kind(encoder)
    session.write(0x5A)
    session.close()
    assert encoder.end() == 0
    encoder = start_one(start, kind, tmp_path, nvm, 1, env=disk[0])
    client = Client(int(encoder.control.rpartition(":")[2]))
    client.do("POW OFF")
    client.send("NVM:ERAS")
    time.sleep(after_s)
    assert encoder.end(9) == -9
    client.close()
    encoder = start_one(start, kind, tmp_path, nvm, 2)
    session = kind(encoder)
    found = session.read()
    session.close()
    said = encoder.errors.so_far()
    assert encoder.end() == 0
    return found, said


def test_a_kill_during_nvm_erase_leaves_the_old_or_the_delivered(start, nvm, tmp_path, disk):
    """Its five syncs take two seconds. A user bank is FFh as delivered."""
    ended = 0
    for tenths in range(1, 24, 2):
        found, said = erased_until_killed(start, nvm, tmp_path, disk, tenths / 10)
        assert found in (0x5A, 0xFF)
        assert said == [] or found == 0xFF and len(said) == 1 and "NVM:ERASe was interrupted" in said[0], said
        ended += len(said)
    assert ended > 0
