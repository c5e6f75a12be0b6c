# SPDX-License-Identifier: MIT
"""Runs the real program as a separate process. Every wait in here has an end."""
import contextlib
import os
import re
import resource
import select
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest

from hiperface_master import Master, NoReply

REPOSITORY = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("DREHGEBER", str(REPOSITORY / "build/release/drehgeber"))
MULTITURN = "s3684-rs485"
SINGLETURN = "s3674-rs485"
STEPS_PER_TURN = 2048 * 32
PATIENCE_S = 10.0  # for what should happen at once on a busy machine
# A line that a busy machine makes a program say now and then; what test_stall.py is about.
HELD_UP = r"drehgeber: held up for [1-4]\d\d ms: "


def run(*arguments, **options) -> subprocess.CompletedProcess:
    """A call that ends by itself."""
    return subprocess.run([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=PATIENCE_S, **options)


def run_refused(status: int, *arguments, **options) -> str:
    """A call that has to fail with this exit status; its one line on stderr."""
    ended = run(*arguments, **options)
    assert ended.returncode == status, (ended.stdout, ended.stderr)
    assert ended.stdout == ""
    lines = ended.stderr.splitlines()
    assert len(lines) == 1 and ended.stderr.endswith("\n"), lines
    return lines[0]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def end_process(process: subprocess.Popen):
    """As a user ends a program: one that does not end has failed."""
    if process.poll() is None:
        process.terminate()
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait(PATIENCE_S)
        raise AssertionError("SIGTERM does not end it") from None


class Lines:
    """Lines out of a pipe but for those that begin as `unheard` says, with bounded waits."""

    def __init__(self, stream, unheard=None):
        self.stream = stream
        self.unheard = unheard
        self.rest = b""
        self.lines = []

    def _pump(self, timeout_s: float) -> bool:
        if not select.select([self.stream], [], [], max(0.0, timeout_s))[0]:
            return False
        data = os.read(self.stream.fileno(), 65536)
        *whole, self.rest = (self.rest + data).split(b"\n")
        for line in (line.decode() for line in whole):
            if self.unheard and re.match(self.unheard, line):
                print(f"stall: {line}")  # if the test fails, tests/gates/tally.py wants to know
            else:
                self.lines.append(line)
        return bool(data)

    def wait(self, timeout_s: float = PATIENCE_S) -> str:
        """The next line."""
        deadline = time.monotonic() + timeout_s
        while not self.lines:
            left = deadline - time.monotonic()
            if left <= 0 or not self._pump(left):
                raise AssertionError(f"no line in {timeout_s} s, only {self.rest!r}")
        return self.lines.pop(0)

    def so_far(self) -> list:
        """What else has been said until now."""
        while self._pump(0):
            pass
        said, self.lines = self.lines, []
        return said


def tell_stalls(controls: list):
    """Print what the wires of a running rig were late; if the test fails, tests/gates/tally.py wants to know."""
    with contextlib.suppress(OSError, ValueError, StopIteration):
        with Client(next(one for one in controls if one.startswith(("tcp:", "unix:")))) as client:
            client.line.settimeout(1.0)
            for name in re.findall(r"[\w.-]+", client.ask("INST:CAT?")):
                late = re.search(r"\bwire_late=([1-9]\d*)", client.ask(f"INST:SEL {name};:STAT?"))
                if late:
                    print(f"stall: {name} {late[0]}")


class Encoder:
    """A running `drehgeber run`."""

    def __init__(self, arguments, **options):
        self.started = time.monotonic()
        self.process = subprocess.Popen(
            [PROGRAM, "run", *map(str, arguments)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
        self.pid = self.process.pid
        self.out = Lines(self.process.stdout)
        self.errors = Lines(self.process.stderr, HELD_UP)
        self.masters = []
        self.controls = []
        try:
            self.ready_line = self.out.wait()
        except AssertionError:
            self.process.kill()
            self.process.wait(PATIENCE_S)
            raise AssertionError(f"not ready: {self.errors.so_far()}") from None
        self.ready = time.monotonic()
        self.path = self.ready_line.split(":", 1)[-1]

    def master(self, **options) -> Master:
        self.masters.append(Master(self.path, **options))
        return self.masters[-1]

    def alive(self) -> bool:
        return self.process.poll() is None

    def cpu_ticks(self) -> int:
        """User and system time so far, in clock ticks of 10 ms."""
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return int(fields[11]) + int(fields[12])

    def limit_file_size(self, size: int):
        """Every write beyond this size fails from now on, as on a full disk."""
        hard = resource.prlimit(self.pid, resource.RLIMIT_FSIZE)[1]
        resource.prlimit(self.pid, resource.RLIMIT_FSIZE, (size, hard))

    def end(self, signal_number: int = signal.SIGTERM) -> int:
        """End this process and no other; its exit status."""
        self.process.send_signal(signal_number)
        return self.process.wait(PATIENCE_S)

    def clean_up(self) -> list:
        """What it said on stderr that no test asked for."""
        for master in self.masters:
            master.close()
        if self.alive():
            tell_stalls(self.controls)
        end_process(self.process)
        unasked = self.errors.so_far()
        self.process.stdout.close()
        self.process.stderr.close()
        return unasked


def start_rig(file, *arguments, **options) -> Encoder:
    """A rig file until it is ready; .controls are its control addresses."""
    rig = Encoder([file, *arguments], **options)
    rig.lines = [rig.ready_line]
    while rig.lines[-1] != "ready rig":
        try:
            rig.lines.append(rig.out.wait())
        except AssertionError:
            rig.clean_up()
            raise
    rig.controls = [line.split(" ", 1)[1] for line in rig.lines if line.startswith("control ")]
    return rig


class Client:
    """A client of the control plane; every wait has an end."""

    def __init__(self, address):
        """At a TCP port of this machine, or at unix:PATH or tcp:HOST:PORT."""
        kind, _, where = str(address).partition(":")
        if kind == "unix":
            self.line = socket.socket(socket.AF_UNIX)
            self.line.connect(where)  # with a timeout it would not wait for its turn
            self.line.settimeout(PATIENCE_S)
        else:
            host, _, port = where.rpartition(":") if where else ("127.0.0.1", "", kind)
            self.line = socket.create_connection((host.strip("[]"), int(port)), PATIENCE_S)
            self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.answers = self.line.makefile("r")

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def close(self):
        self.answers.close()
        self.line.close()

    def send(self, text: str):
        self.line.sendall(text.encode() + b"\n")

    def ask(self, text: str) -> str:
        self.send(text)
        return self.answers.readline().strip()

    def error(self, text: str) -> int:
        """The oldest error behind a line without an answer."""
        self.send(text)
        return int(self.ask("SYST:ERR?").split(",")[0])

    def do(self, text: str):
        """A line that has to be taken; the question is a line of its own, as a failure ends a line."""
        self.send(text)
        told = self.ask("SYST:ERR?")
        assert told.startswith("0,"), (text, told)

    def late(self) -> int:
        """Deadlines that the selected encoder's wire has missed, by the rig's own count."""
        return int(re.search(r"\bwire_late=(\d+)", self.ask("STAT?"))[1])

    def refused(self, text: str, code: int):
        assert self.error(text) == code, text


class Rigs:
    """Rigs that a test starts, and their clients, which go before them."""

    def __init__(self, folder: Path, client=Client):
        self.folder, self.client = folder, client
        self.running, self.clients = [], []

    def begin(self, text: str, *arguments, **options) -> Encoder:
        """Its files are in the folder; .client(N) connects to its control address N."""
        file = self.folder / "rig.ini"
        file.write_text(text)
        one = start_rig(file, "--files", self.folder, *arguments, **options)
        self.running.append(one)
        one.client = lambda number=0: self._connect(one.controls[number])
        return one

    def _connect(self, address: str):
        self.clients.append(self.client(address))
        return self.clients[-1]

    def end(self) -> list:
        """What they said on stderr that no test asked for."""
        for one in self.clients:
            one.close()
        return [line for one in self.running for line in one.clean_up()]


def assert_takes(nominal_s: float, margin_s: float, measure, late, count: int = 100):
    """Of `count` times that measure() finds none is below nominal_s, and three of four are at most margin_s
    above it: what comes late every other time may not hide behind the rest. late() is the rig's own count of
    deadlines that it has missed; if it rose meanwhile, tests/gates/tally.py wants to know."""
    before = late()
    took = sorted(measure() for _ in range(count))
    missed = late() - before
    told = (f"{count} times {1000 * nominal_s:.1f} ms: {1000 * took[0]:.2f} at least, three of four within "
            f"{1000 * took[3 * count // 4]:.2f}, {1000 * took[-1]:.2f} at most; the rig missed {missed} deadlines")
    print(f"stall: {told}" if missed else told)
    assert took[0] >= nominal_s and took[3 * count // 4] <= nominal_s + margin_s, told


def assert_silent(master: Master, command=Master.read_position):
    """Nothing answers this master."""
    grace_s, master.grace_s = master.grace_s, 0.1
    with pytest.raises(NoReply):
        command(master)
    master.grace_s = grace_s


def assert_one_line(encoder: Encoder, *parts: str) -> str:
    """Exactly one line came on stderr, and it names all this."""
    line = encoder.errors.wait()
    for part in parts:
        assert part in line, line
    assert encoder.errors.so_far() == []
    return line
