# SPDX-License-Identifier: MIT
"""Masters that store: one for each kind of encoder, with the same face. write() ends when the encoder
has acknowledged; Refused is its own code for a memory that does not take it."""
import socket
import struct
import termios
import time

import serial

from hiperface_master import EncoderError, FieldStatus, HiperfaceError, Master
from rig import MULTITURN, PATIENCE_S, Client, free_port

SAVE = 0x65766173  # "save", least significant byte first


class Refused(Exception):
    """The encoder's own code, in hexadecimal digits."""


class Gone(Exception):
    """There is no acknowledgement."""


class Hiperface:
    """4Bh: the same number twice in a data field, written and read as one."""

    model, wire, options = MULTITURN, ["--pty={folder}/tty{nth}"], ["--set", "pace=0"]
    modulus = 1 << 64

    def __init__(self, encoder, answer_s=0.05):
        self.answer_s = answer_s  # a dead one is not waited for
        self.master = Master(encoder.path, grace_s=PATIENCE_S)
        if self.master.available_memory()[1] == 0:
            self.master.create_field(0, FieldStatus(16))
            self.write(0)
        self.master.grace_s = self.answer_s

    def write(self, value: int):
        try:
            self.master.save_data(0, 0, struct.pack("<QQ", value, value))
        except EncoderError as error:
            raise Refused(f"{error.code:02X}") from error
        except (HiperfaceError, OSError, termios.error) as error:
            raise Gone from error

    def read(self) -> int:
        self.master.grace_s = PATIENCE_S
        first, second = struct.unpack("<QQ", self.master.read_data(0, 0, 16))
        self.master.grace_s = self.answer_s
        assert first == second, f"mixed: {first} and {second}"
        return first

    def close(self):
        self.master.close()


class Canopen:
    """1010h: a number in two objects, saved together."""

    model, wire, options = "f3668", ["--slcan={folder}/can{nth}"], []
    modulus = 1 << 16
    objects = ((0x100C, 2), (0x1006, 4))  # guard time, cycle period

    def __init__(self, encoder, answer_s=0.3):
        self.answer_s = answer_s
        self.port = serial.Serial(encoder.path.rpartition("/")[0], timeout=0.01)
        self.rest = b""
        self.port.write(b"C\rS5\rO\r")

    def sdo(self, request: bytes, timeout_s: float) -> bytes:
        self.port.write(b"t63F8" + request.hex().upper().encode() + b"\r")
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            *lines, self.rest = (self.rest + self.port.read(max(1, self.port.in_waiting))).split(b"\r")
            for line in lines:
                if b"t5BF8" in line:
                    return bytes.fromhex(line.partition(b"t5BF8")[2][:16].decode())
        raise Gone

    def download(self, index: int, sub: int, value: int, n: int):
        command = 0x23 | (4 - n) << 2
        answer = self.sdo(struct.pack("<BHBI", command, index, sub, value), self.answer_s)
        if answer[0] == 0x80:
            raise Refused(answer[7:3:-1].hex())
        assert answer[0] == 0x60, answer.hex()

    def write(self, value: int):
        try:
            for index, n in self.objects:
                self.download(index, 0, value, n)
            self.download(0x1010, 1, SAVE, 4)
        except OSError as error:
            raise Gone from error

    def read(self) -> int:
        values = []
        for index, _ in self.objects:
            answer = self.sdo(struct.pack("<BHBI", 0x40, index, 0, 0), PATIENCE_S)
            assert answer[0] & 0xE2 == 0x42, answer.hex()
            values.append(int.from_bytes(answer[4:], "little"))
        assert values[0] == values[1], f"mixed: {values}"
        return values[0]

    def close(self):
        self.port.close()


class Biss:
    """A register of a user bank, over the master of the simulated wire."""

    model, wire, options = "s3684-biss", ["--sim", "--control=tcp:127.0.0.1:{port}"], []
    modulus = 1 << 8

    def __init__(self, encoder, answer_s=None):
        self.client = Client(int(encoder.control.rpartition(":")[2]))
        while self.client.error("BISS:REG 64,7") != 0:  # the encoder starts for 100 ms
            time.sleep(0.01)

    def write(self, value: int):
        try:
            self.client.send(f"BISS:REG 3,{value}")
            said = self.client.ask("SYST:ERR?")
        except OSError as error:
            raise Gone from error
        if not said or said.startswith("-250,"):
            raise Gone
        if said.startswith("-240,"):
            raise Refused(said)
        assert said.startswith("0,"), said

    def read(self) -> int:
        return int(self.client.ask("BISS:REG? 3"))

    def close(self):
        self.client.close()


class Interbus:
    """08xxxxxxh: the preset, over Modbus; read out as item 4."""

    model, wire, options = "ocd-ib-k3", ["--modbus=127.0.0.1:{port}"], ["--set", "cycle=1000"]
    modulus = 1 << 20
    at_input, at_output, at_status = 0x0000, 0x0800, 0x100C

    def __init__(self, encoder, answer_s=PATIENCE_S):
        self.answer_s = answer_s
        self.line = socket.create_connection(("127.0.0.1", int(encoder.path.split(":")[1].split("/")[0])), PATIENCE_S)
        while self.ask(struct.pack(">BHH", 4, self.at_status, 1))[2] & 1 == 0:  # the ring does not run yet
            time.sleep(0.01)
        self.until(lambda word: word != 0xA0000000, PATIENCE_S)  # the self-test
        self.put(0)

    def ask(self, pdu: bytes) -> bytes:
        self.line.sendall(struct.pack(">HHHB", 1, 0, len(pdu) + 1, 1) + pdu)
        answer = b""
        while len(answer) < 6 or len(answer) < 6 + answer[5]:
            more = self.line.recv(300)
            if not more:
                raise Gone
            answer += more
        assert answer[7] == pdu[0], answer.hex()
        return answer[8:]

    def put(self, word: int):
        self.ask(struct.pack(">BHHBI", 16, self.at_output, 2, 4, word))

    def until(self, wanted, timeout_s: float) -> int:
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            word = int.from_bytes(self.ask(struct.pack(">BHH", 4, self.at_input, 2))[1:], "big")
            if wanted(word):
                return word
            time.sleep(0.001)  # others want to run, too
        raise Gone

    def write(self, value: int):
        try:
            self.put(0x08000000 | value)
            word = self.until(lambda word: word in (0xC8000000 | value, 0x86000000), self.answer_s)
            if word == 0x86000000:
                self.put(0x80000000)  # the error stays until the release
                self.until(lambda word: word != 0x86000000, PATIENCE_S)
                self.put(0)
        except OSError as error:
            raise Gone from error
        if word == 0x86000000:
            raise Refused(f"{word:08X}")

    def read(self) -> int:
        self.put(0x20210004)
        value = self.until(lambda word: word >> 29 == 5, PATIENCE_S) & 0x1FFFFFFF
        self.put(0)
        return value

    def close(self):
        self.line.close()


KINDS = [Hiperface, Canopen, Biss, Interbus]


def start_one(start, kind, folder, nvm, nth, **options):
    """An encoder of that kind; the nth one in this folder."""
    names = {"folder": folder, "nth": nth, "port": free_port()}
    wire = [part.format(**names) for part in kind.wire]
    encoder = start(*kind.options, "--nvm", nvm, model=kind.model, wire=wire, **options)
    encoder.control = wire[-1]
    return encoder
