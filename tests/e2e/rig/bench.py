# SPDX-License-Identifier: MIT
"""A rig as a process, and what a master and an operator hold in their hands: SCPI sessions as raw
as a socket is, and small masters for each wire. Every wait in here has an end."""
import contextlib
import csv
import functools
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import can
from pymodbus.client import ModbusTcpClient

E2E = Path(__file__).resolve().parents[1]
sys.path += [str(E2E), str(E2E / "canopen")]
from can_rig import WIRE, Tap, on_slcan, open_bus  # noqa: E402
from hiperface_master import Master  # noqa: E402
from rig import (HELD_UP, PATIENCE_S, PROGRAM, Lines, assert_silent, assert_takes, free_port,  # noqa: E402
                 run, tell_stalls)

__all__ = ["Bench", "BissMaster", "CanMaster", "Coupler", "ERROR", "Master", "NO_ERROR",
           "PATIENCE_S", "PROGRAM", "Session", "assert_silent", "assert_takes", "can_wire", "connect", "eventually",
           "fields", "free_port", "run"]

NO_ERROR = 0
ERROR = re.compile(r'([+-]?\d+),"(.*)"')


def fields(answer: str) -> list:
    """The parts of an answer; strings without their quotes. No names are one empty string."""
    return next(csv.reader([answer])) if answer not in ("", '""') else []


def eventually(condition, timeout_s: float = PATIENCE_S):
    """The first true value of `condition()`."""
    deadline = time.monotonic() + timeout_s
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < deadline, f"not within {timeout_s} s; at last {value!r}"
        time.sleep(0.005)


def connect(address: str) -> socket.socket:
    kind, _, where = address.partition(":")
    if kind == "unix":
        line = socket.socket(socket.AF_UNIX)
        line.settimeout(PATIENCE_S)
        line.connect(where)
        return line
    assert kind == "tcp", address
    host, _, port = where.rpartition(":")
    line = socket.create_connection((host, int(port)), PATIENCE_S)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # many short lines in a row
    return line


class Session:
    """A client of the control plane."""

    def __init__(self, address: str):
        self.socket = connect(address)
        self.rest = b""

    def close(self):
        self.socket.close()

    def send(self, text):
        """A line; bytes go as they are."""
        self.socket.sendall(text if isinstance(text, bytes) else f"{text}\n".encode())

    def line(self, timeout_s: float = PATIENCE_S) -> str:
        """The next line that comes back."""
        deadline = time.monotonic() + timeout_s
        while b"\n" not in self.rest:
            left = deadline - time.monotonic()
            assert left > 0 and select.select([self.socket], [], [], left)[0], \
                f"no answer in {timeout_s} s, only {self.rest!r}"
            data = self.socket.recv(65536)
            assert data, f"closed, behind {self.rest!r}"
            self.rest += data
        line, _, self.rest = self.rest.partition(b"\n")
        return line.decode("ascii")

    def silent(self, for_s: float = 0.1) -> bool:
        """Nothing comes for a while."""
        return not self.rest and not select.select([self.socket], [], [], for_s)[0]

    def ask(self, text: str) -> str:
        """A line with a query in it; its answer."""
        self.send(text)
        return self.line()

    def parts(self, text: str) -> list:
        return fields(self.ask(text))

    def name(self, text: str) -> str:
        """A line with a query for one name."""
        (name,) = self.parts(text)
        return name

    def error(self) -> int:
        """The oldest error of the queue."""
        told = ERROR.fullmatch(self.ask("SYST:ERR?"))
        assert told
        return int(told[1])

    def errors(self) -> list:
        """All of the queue, which is empty then."""
        found = []
        while (code := self.error()) != NO_ERROR:
            found.append(code)
        return found

    def codes(self, text) -> list:
        """The errors of a line; it must not be answered."""
        self.send(text)
        return self.errors()

    def do(self, text: str):
        """A line without an answer, which succeeds."""
        assert self.codes(text) == [], text

    def select(self, name: str) -> "Session":
        self.do(f"INST:SEL {name}")
        return self

    def state(self) -> dict:
        return dict(part.split("=", 1) for part in self.parts("STAT?"))


class Bench:
    """`drehgeber run` with a rig file."""

    def __init__(self, folder: Path, text: str, *arguments, **options):
        self.folder = folder
        file = folder / "bench.ini"
        file.write_text(text)
        self.process = subprocess.Popen(
            [PROGRAM, "run", str(file), "--files", tempfile.gettempdir(), *map(str, arguments)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder, **options)
        self.out = Lines(self.process.stdout)
        self.said = Lines(self.process.stderr, HELD_UP)
        self.wires = {}
        self.controls = []
        self.closing = contextlib.ExitStack()
        try:
            self._become_ready()
        except AssertionError:
            self.process.kill()
            self.process.wait(PATIENCE_S)
            raise AssertionError(f"not ready: {self.said.so_far()}") from None

    def _become_ready(self):
        while (line := self.out.wait()) != "ready rig":
            words = line.split(" ")
            if words[0] == "control":
                self.controls.append(words[1])
            else:
                self.wires[words[3]] = words[2].partition(":")[2]

    def session(self, encoder: str = None, address: str = None) -> Session:
        session = self.closing.enter_context(
            contextlib.closing(Session(address or self.controls[0])))
        return session.select(encoder) if encoder else session

    def address(self, kind: str) -> str:
        """Its control address of this kind."""
        return next(address for address in self.controls if address.startswith(f"{kind}:"))

    def alive(self) -> bool:
        return self.process.poll() is None

    def end(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE_S)

    def clean_up(self) -> list:
        """What it said on stderr, and how it ended when that was not well."""
        self.closing.close()
        if self.alive():
            tell_stalls(self.controls)
        status = self.end() if self.alive() else 0
        said = self.said.so_far()
        said += [f"ended with {status}"] if status else []
        self.process.stdout.close()
        self.process.stderr.close()
        return said


def can_wire(folder: Path) -> str:
    """The rig file's words for the wire of the CAN master."""
    return f"slcan:{folder}/can" if on_slcan() else f"can:{WIRE}"


class CanMaster:
    """Raw frames and expedited SDO with one node."""

    def __init__(self, address: str, bit_rate: int = 250_000):
        wire, _, node_id = address.rpartition("/")
        self.node_id = int(node_id)
        self.bus = open_bus(wire, bit_rate)
        self.tap = Tap()
        self.notifier = can.Notifier(self.bus, [self.tap], timeout=0.05)

    def close(self):
        self.notifier.stop()
        self.bus.shutdown()

    def send(self, can_id: int, data: bytes = b""):
        self.bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))

    def nmt(self, command: int):
        self.send(0x000, bytes([command, self.node_id]))

    def transact(self, request: bytes, timeout_s: float = PATIENCE_S) -> bytes:
        """An SDO request; its answer, which names the same object. One that names another comes late: answers() has
        not waited for it."""
        self.tap.forget()
        self.send(0x600 + self.node_id, request)
        deadline = time.monotonic() + timeout_s
        while True:
            answer = self.tap.data(0x580 + self.node_id, max(0.0, deadline - time.monotonic()))
            if answer[1:4] == request[1:4]:
                return answer

    def read(self, index: int, sub: int = 0) -> int:
        answer = self.transact(struct.pack("<BHB4x", 0x40, index, sub))
        assert answer[0] & 0xE0 == 0x40, f"abort {answer[:3:-1].hex()}"
        return int.from_bytes(answer[4:8 - (answer[0] >> 2 & 3)], "little")

    def write(self, index: int, sub: int, value: int, size: int) -> int:
        """0 or the abort code."""
        request = struct.pack("<BHBI", 0x23 | 4 - size << 2, index, sub, value)
        answer = self.transact(request)
        return 0 if answer[0] == 0x60 else int.from_bytes(answer[4:], "little")

    def answers(self) -> bool:
        """Whether the node answers an SDO request in good time."""
        try:
            self.transact(struct.pack("<BHB4x", 0x40, 0x1000, 0), 0.3)
        except AssertionError:
            return False
        return True

    def emergency(self, code: int) -> bytes:
        """The next EMCY with this code; all frames before it are forgotten."""
        while (data := self.tap.data(0x80 + self.node_id))[:2] != code.to_bytes(2, "little"):
            pass
        return data

    def booted(self):
        """The next boot-up."""
        while self.tap.data(0x700 + self.node_id) != b"\0":
            pass


class BissMaster:
    """What the control plane clocks over a simulated wire."""

    def __init__(self, session: Session):
        self.session = session

    def frame(self) -> list:
        """Position, nERR, nWARN, life counter, CRC right."""
        return [int(part) for part in self.session.parts("BISS:FRAM?")]

    def lost(self) -> bool:
        """Clock a frame; whether nobody answers."""
        self.session.send("BISS:FRAM?")
        self.session.send("SYST:ERR?")
        lost = self.session.line().startswith("-240")
        return lost or not self.session.line().startswith("0,")

    def read(self, address: int, count: int = 1) -> list:
        return [int(part, 0) for part in self.session.parts(f"BISS:REG? {address},{count}")]

    def write(self, address: int, *values: int):
        self.session.do(f"BISS:REG {address}," + ",".join(map(str, values)))

    def status(self) -> int:
        return self.read(0x60)[0]

    def errors(self) -> int:
        return self.read(0x69)[0]

    def ready(self) -> bool:
        """The initialisation is over."""
        return self.status() & 0x10 != 0


class Coupler:
    """A Modbus client of the ring's coupler; `at` is the place of an encoder's words."""

    RUN, BUS_ERROR, MODULE_ERROR = 1, 2, 4
    OUTPUT, STATUS, SLAVES = 0x0800, 0x100C, 0x2000
    LED_RD = 8

    def __init__(self, address: str):
        host, _, port = address.split("/")[0].rpartition(":")
        self.client = ModbusTcpClient(host, port=int(port), timeout=PATIENCE_S)
        assert self.client.connect()

    def close(self):
        self.client.close()

    def read(self, address: int, count: int = 1) -> list:
        answer = self.client.read_input_registers(address, count=count)
        assert not answer.isError(), answer
        return answer.registers

    def words(self, at: int, count: int = 2) -> int:
        """IN as one number."""
        return functools.reduce(lambda value, word: value << 16 | word, self.read(at, count))

    def out(self, word: int, at: int):
        answer = self.client.write_registers(self.OUTPUT + at, [word >> 16, word & 0xFFFF])
        assert not answer.isError(), answer

    def status(self) -> int:
        return self.read(self.STATUS)[0]

    def slave(self, number: int) -> list:
        """What the coupler knows of an encoder."""
        return self.read(self.SLAVES + 16 * number, 16)

    def crc_errors(self, number: int) -> int:
        high, low = self.slave(number)[4:6]
        return high << 16 | low

    def id_word(self, number: int) -> int:
        return self.slave(number)[0]

    def leds(self, number: int) -> int:
        return self.slave(number)[6]
