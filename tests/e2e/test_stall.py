# SPDX-License-Identifier: MIT
"""A process that is held up knows it, and an idle one is not woken for that."""
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from rig import Client, assert_one_line, free_port

LONG_S = 0.5
SLOW_ACCEPT = """
#define _GNU_SOURCE
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
int accept4(int fd, struct sockaddr *restrict address, socklen_t *restrict length, int flags)
{
    const struct timespec slow = {.tv_nsec = 400000000};
    (void)nanosleep(&slow, NULL);
    return (int)syscall(SYS_accept4, fd, address, length, flags);
}
"""
KINDS = {"rs485": ("s3684-rs485", "--pty"), "can": ("f3668", "--slcan"),
         "ring": ("ocd-ib-k3", "--modbus=127.0.0.1:{port}")}


@pytest.fixture(autouse=True)
def all_is_heard(monkeypatch):
    monkeypatch.setattr("rig.HELD_UP", None)


@pytest.fixture
def served(start):
    """Start an encoder with a client of its control plane."""
    clients = []

    def begin(*arguments, **options):
        port = free_port()
        encoder = start("--control", f"tcp:127.0.0.1:{port}", *arguments, **options)
        assert encoder.out.wait().startswith("control ")
        clients.append(Client(port))
        return encoder, clients[-1]

    yield begin
    for client in clients:
        client.close()


def stop(encoder, seconds):
    time.sleep(0.1)  # it waits again
    os.kill(encoder.pid, signal.SIGSTOP)
    time.sleep(seconds)
    os.kill(encoder.pid, signal.SIGCONT)


def wakeups(encoder) -> int:
    status = Path(f"/proc/{encoder.pid}/status").read_text()
    return sum(int(line.split()[1]) for line in status.splitlines() if "ctxt_switches" in line)


@pytest.mark.parametrize("kind", KINDS)
def test_a_stop_is_counted_and_told(served, kind):
    model, wire = KINDS[kind]
    encoder, client = served(model=model, wire=[wire.format(port=free_port())])
    before = client.late()
    stop(encoder, LONG_S)
    assert client.late() >= before + 1
    line = assert_one_line(encoder)  # stopped while it waited, or while its LEDs blinked
    assert re.search("stopped and continued|held up for [4-9][0-9][0-9] ms", line), line


def test_stops_one_behind_the_other_are_one_line(served):
    encoder, client = served()
    before = client.late()
    for _ in range(5):
        stop(encoder, 0.1)
        time.sleep(0.1)
    assert client.late() >= before + 5
    assert_one_line(encoder, "stopped and continued")
    time.sleep(1.2)
    stop(encoder, 0.1)
    assert client.late() >= before + 6
    assert_one_line(encoder, "stopped and continued")


def test_a_request_that_waits_for_a_call_is_counted_and_told(served, tmp_path):
    (tmp_path / "slow.c").write_text(SLOW_ACCEPT)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", tmp_path / "slow.so", tmp_path / "slow.c"], check=True)
    environment = os.environ | {"LD_PRELOAD": str(tmp_path / "slow.so"), "ASAN_OPTIONS": "verify_asan_link_order=0"}
    encoder, client = served(env=environment)
    master = encoder.master(grace_s=5.0)
    before = client.late()
    with Client(client.line.getpeername()[1]):
        time.sleep(0.1)  # it is being let in
        assert master.read_position() == 0
        assert client.late() >= before + 1
    line = assert_one_line(encoder, "held up for")
    assert 200 <= int(line.split("held up for ")[1].split()[0]) < 5000


def sleeper(served, kind):
    """Started, and dealt with: nothing is left to do."""
    model, wire = KINDS[kind]
    encoder, client = served(model=model, wire=[wire.format(port=free_port())])
    time.sleep(0.5)
    return encoder, client


@pytest.mark.parametrize("kind", KINDS)
def test_an_idle_process_sleeps_and_is_never_late(served, kind):
    seen = []
    while (0, 0, []) not in seen:
        assert len(seen) < 5, seen  # the machine may hold up whoever asks
        encoder, client = sleeper(served, kind)
        first = client.late()
        time.sleep(0.5)  # the connection is dealt with
        before = wakeups(encoder)
        time.sleep(2.0)
        assert wakeups(encoder) == before
        seen.append((first, client.late(), encoder.errors.so_far()))


def test_a_node_that_sleeps_sees_what_happens(served):
    """Its supervision is left out while nothing can have changed."""
    _, client = sleeper(served, "can")
    for command, causes in (("SHAF:VEL 13000 RPM", "00000200"), ("SHAF:VEL 0", "00000000"),
                            ("WORL:TEMP 99", "00000100"), ("WORL:TEMP 37", "00000000")):
        client.do(command)
        time.sleep(0.5)
        assert f"causes={causes}" in client.ask("STAT?"), command


def long_motion(folder, lines) -> Path:
    file = folder / "long.csv"
    file.write_text("".join(f"{n / 1000:.3f},{n % 360}\n" for n in range(lines)))
    return file


def test_a_long_motion_holds_up_nobody(start, tmp_path):
    """Whoever asks while another client's file is read is answered before that is through."""
    port = free_port()
    file = long_motion(tmp_path, 300_000)
    encoder = start("--files", str(tmp_path), "--control", f"tcp:127.0.0.1:{port}")
    assert encoder.out.wait().startswith("control ")
    reader, other = Client(port), Client(port)
    os.kill(encoder.pid, signal.SIGSTOP)  # both are there when it goes on
    reader.send(f"SHAF:PROF '{file}';PROF?")
    other.send("SHAF:PROF?")
    os.kill(encoder.pid, signal.SIGCONT)
    assert other.answers.readline().strip() == '"rest"'  # not the file: it is not through
    assert reader.answers.readline().strip() == f'"{file}"'
    assert other.ask("SHAF:PROF?") == f'"{file}"'
    assert all("stopped and continued" in line for line in encoder.errors.so_far())  # it was


def test_a_long_motion_of_a_client_that_goes(start, tmp_path):
    """It is read and played, as a short one is."""
    port = free_port()
    file = long_motion(tmp_path, 100_000)
    encoder = start("--files", str(tmp_path), "--control", f"tcp:127.0.0.1:{port}")
    assert encoder.out.wait().startswith("control ")
    reader, other = Client(port), Client(port)
    reader.send(f"SHAF:PROF '{file}'")
    reader.close()
    end = time.monotonic() + 30
    while other.ask("SHAF:PROF?") != f'"{file}"':
        assert time.monotonic() < end
        time.sleep(0.05)
