# SPDX-License-Identifier: MIT
"""A small master for HIPERFACE-compatible encoders (RS485 parameter channel).

    with Master("/dev/ttyUSB0") as encoder:
        print(encoder.type_label())
        print(encoder.read_position())

A request is   address | command | data ... | XOR of all bytes before.
A reply is     address | command | data ... | XOR, or after an error  address | 50h | code | XOR.
Bit 7 of a reply's command byte is the warning bit: read_status() tells why.
Chapters in the comments are those of the Sendix S36 manual R67057.0002.
"""
import errno
import struct
import termios
import time
from dataclasses import dataclass
from functools import reduce
from operator import xor
from typing import NamedTuple, Optional

import serial

DEFAULT_ADDRESS = 0x40
BROADCAST = 0xFF
DEFAULT_CODE = 0x55
EXTENDED_LABEL = 0xFF  # virtual data field (5.1.1.2.2)
CHARACTER_BITS = 11

READ_STATUS = 0x50
WARNING_BIT = 0x80


class Command(NamedTuple):
    name: str
    reply_bytes: int  # data bytes of the reply; 4Ah adds those that were asked for
    reaction_ms: int  # longest time from the request to the reply (5.1.2)


COMMANDS = {
    0x42: Command("read position", 4, 10),
    0x43: Command("set position", 0, 40),
    0x44: Command("read analog value", 3, 5),
    0x46: Command("read counter", 3, 5),
    0x47: Command("increment counter", 0, 30),
    0x49: Command("erase counter", 0, 30),
    0x4A: Command("read data", 3, 30),
    0x4B: Command("save data", 3, 250),
    0x4C: Command("data field status", 2, 5),
    0x4D: Command("create data field", 2, 70),
    0x4E: Command("available memory", 2, 5),
    0x4F: Command("modify access key", 1, 40),
    0x50: Command("read encoder status", 1, 5),
    0x52: Command("read type label", 4, 5),
    0x53: Command("encoder reset", 0, 0),
    0x55: Command("assign address", 0, 40),
    0x56: Command("read serial number", 37, 5),
    0x57: Command("configure serial interface", 1, 40),
    0x6A: Command("set position synchronised", 4, 40),
}

STATUS = {  # 5.1.3; 1Dh and above from the command tables in 5.1.2
    0x00: "no error",
    0x01: "faulty compensation data",
    0x02: "faulty internal angular offset",
    0x03: "data field partitioning table destroyed",
    0x05: "internal I2C bus not operational",
    0x06: "internal check sum error",
    0x08: "counter overflow",
    0x0A: "check sum error",
    0x0B: "unknown command code",
    0x0C: "wrong command length",
    0x0D: "wrong command argument",
    0x0E: "data field may not be written",
    0x0F: "wrong access code",
    0x10: "insufficient memory or fixed size",
    0x11: "address outside of the data field",
    0x12: "wrong data field number",
    0x1D: "LED current high",
    0x1E: "temperature outside its limits",
    0x1F: "speed high",
    0x20: "singleturn fault",
    0x21: "multiturn amplitude fault",
    0x22: "multiturn sync fault",
    0x23: "multiturn vector length fault",
}


class HiperfaceError(Exception):
    """Anything that kept a command from succeeding."""


class NoReply(HiperfaceError):
    """The encoder said nothing in time."""


class BadReply(HiperfaceError):
    """Bytes came, but not the frame that was expected."""


class EncoderError(HiperfaceError):
    """The encoder answered with an error response."""

    def __init__(self, command: int, code: int):
        self.command = command
        self.code = code
        self.name = STATUS.get(code, "unknown status code")
        what = COMMANDS[command].name if command in COMMANDS else "unknown command"
        super().__init__(f"{command:02X}h {what}: {code:02X}h {self.name}")


class UartSetting(NamedTuple):
    """The byte of 52h and 57h (5.1.1.2.4), decoded."""

    baudrate: int
    parity: str  # N, E or O
    timeout_bits: int  # end of frame, in bit times after the last character
    bus: bool

    BAUDRATES = (600, 1200, 2400, 4800, 9600, 19200, 38400)

    @classmethod
    def decode(cls, setting: int) -> "UartSetting":
        parity = {0: "N", 2: "E", 3: "O"}[setting >> 4 & 3]
        return cls(cls.BAUDRATES[setting & 7], parity, 44 if setting & 0x40 else 11,
                   not setting & 0x80)

    def encode(self) -> int:
        parity = {"N": 0, "E": 2, "O": 3}[self.parity]
        return ((0 if self.bus else 0x80) | (0x40 if self.timeout_bits == 44 else 0)
                | parity << 4 | self.BAUDRATES.index(self.baudrate))


class TypeLabel(NamedTuple):
    """Reply to 52h (5.1.2.14)."""

    uart: int  # the stored setting; UartSetting.decode() explains it
    type_code: int
    memory_bytes: int
    option_code: int


class Identity(NamedTuple):
    """Reply to 56h (5.1.2.17)."""

    serial_number: str
    version: str
    date: str


class FieldStatus(NamedTuple):
    """Status byte of a data field (4Ch, 4Dh; 5.1.1.2.3)."""

    size: int  # 16 .. 128 bytes in steps of 16
    code_enabled: bool = True
    code_number: int = 0
    writable: bool = True
    exists: bool = True

    @classmethod
    def decode(cls, status: int) -> "FieldStatus":
        return cls(((status & 7) + 1) * 16, bool(status & 0x08), status >> 4 & 3,
                   bool(status & 0x40), bool(status & 0x80))

    def encode(self) -> int:
        return (self.size // 16 - 1 | self.code_enabled << 3 | self.code_number << 4
                | self.writable << 6 | self.exists << 7)


@dataclass(frozen=True)
class ExtendedLabel:
    """Extended type label (5.1.1.2.2). A value is None when its selector bit is not set."""

    checksum_ok: bool
    linear: bool
    bipolar: bool
    periods: int  # per turn (linear: period length in nm)
    turns: int  # coded turns (linear: number of periods)
    designation: str
    selector: int
    temperature_channel: Optional[int]  # for read_analog()
    temperature_min_degc: Optional[int]
    temperature_max_degc: Optional[int]
    led_channel: Optional[int]
    led_min_ma: Optional[int]
    led_max_ma: Optional[int]
    vector_channel: Optional[int]
    vector_min: Optional[int]
    vector_max: Optional[int]
    speed_max_rpm: Optional[int]
    acceleration_max_krad_s2: Optional[int]

    @classmethod
    def decode(cls, label: bytes) -> "ExtendedLabel":
        """From the first 64 bytes; the check sum covers exactly the bytes handed over."""
        kind, periods, turns, name, selector = struct.unpack_from(">BII18sH", label, 1)
        values = struct.unpack_from(">HhhHHHHHHHH", label, 0x1E)
        told = [value if selector >> bit & 1 else None for bit, value in enumerate(values)]
        return cls(checksum(label) == 0, bool(kind & 1), bool(kind & 2), periods, turns,
                   name.rstrip(b"\0").decode("ascii"), selector, *told)


def checksum(data: bytes) -> int:
    """XOR of all bytes."""
    return reduce(xor, data, 0)


def frame(address: int, command: int, data: bytes = b"") -> bytes:
    """A complete request."""
    body = bytes([address, command]) + data
    return body + bytes([checksum(body)])


def open_port(path: str, baudrate: int = 9600, parity: str = "E") -> serial.Serial:
    """The serial port; read() returns after 10 ms with what there is."""
    try:
        return serial.Serial(path, baudrate, parity=parity, timeout=0.01, write_timeout=2)
    except (termios.error, serial.SerialException) as error:
        # A pseudo terminal has no parity bit. Linux refuses a request for one when nothing
        # else would change, which is so from the second opening on.
        if parity == "N" or errno.EINVAL not in error.args:
            raise
        return serial.Serial(path, baudrate, parity="N", timeout=0.01, write_timeout=2)


class Master:
    """Talks to the encoders on one port, by default to the one at address 40h."""

    def __init__(self, path: str, address: int = DEFAULT_ADDRESS, baudrate: int = 9600,
                 parity: str = "E", grace_s: float = 0.5):
        self.address = address
        self.code0 = DEFAULT_CODE
        self.warning = False  # warning bit of the latest reply
        self.reply_address = None  # who sent it; interesting after a broadcast
        self.grace_s = grace_s  # allowed on top of what the manual allows
        self.pause_bits = 44  # end of frame (5.1.1.1)
        self.port = open_port(path, baudrate, parity)
        self._line_free_at = 0.0

    def __enter__(self) -> "Master":
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.port.close()

    # -- frames -----------------------------------------------------------------------------

    def bits_s(self, bits: int) -> float:
        return bits / self.port.baudrate

    def wait_for_line(self):
        """Until the encoder can listen: after a frame's pause, or a reset's initialisation."""
        time.sleep(max(0.0, self._line_free_at - time.monotonic()))

    def send(self, request: bytes):
        """Send bytes as they are, after the pause that ends whatever was before."""
        self.wait_for_line()
        self.port.reset_input_buffer()
        self.port.write(request)
        self._line_free_at = (time.monotonic()
                              + self.bits_s(len(request) * CHARACTER_BITS + self.pause_bits))

    def receive(self, n: int, timeout_s: float) -> bytes:
        """Up to n bytes; fewer when the time is over."""
        deadline = time.monotonic() + timeout_s
        got = b""
        while len(got) < n and time.monotonic() < deadline:
            got += self.port.read(n - len(got))
        if got:
            self._line_free_at = time.monotonic() + self.bits_s(self.pause_bits)
        return got

    def drain(self) -> None:
        """Read until the line is silent."""
        while self.receive(4096, 0.1):
            pass

    def transact(self, request: bytes, reply_bytes: int, reaction_ms: int = 250) -> bytes:
        """Send a request as it is; return the data bytes of its reply, checked."""
        address, command = request[0], request[1]
        self.send(request)
        wait_s = (self.bits_s((len(request) + reply_bytes + 3) * CHARACTER_BITS + self.pause_bits)
                  + reaction_ms / 1000 + self.grace_s)
        reply = self.receive(2, wait_s)
        if not reply:
            raise NoReply(f"no reply to {request.hex(' ')}")
        failed = len(reply) == 2 and reply[1] & 0x7F == READ_STATUS and command != READ_STATUS
        missing = (1 if failed else reply_bytes) + 3 - len(reply)
        reply += self.receive(missing, wait_s)
        if len(reply) < 4 and failed or len(reply) < 3 or checksum(reply) != 0:
            raise BadReply(f"damaged reply {reply.hex(' ')} to {request.hex(' ')}")
        self.reply_address = reply[0]
        self.warning = bool(reply[1] & WARNING_BIT)
        if address not in (BROADCAST, reply[0]) and command != 0x55:
            raise BadReply(f"{reply[0]:02X}h answers for {address:02X}h")
        if failed:
            raise EncoderError(command, reply[2])
        if reply[1] & 0x7F != command or len(reply) != reply_bytes + 3:
            raise BadReply(f"unexpected reply {reply.hex(' ')} to {request.hex(' ')}")
        return reply[2:-1]

    def command(self, code: int, data: bytes = b"", more: int = 0) -> bytes:
        """Send a command; return the data bytes of its reply, `more` than the table says."""
        row = COMMANDS[code]
        return self.transact(frame(self.address, code, data), row.reply_bytes + more,
                             row.reaction_ms)

    # -- the commands (5.1.2) -----------------------------------------------------------------

    def read_position(self) -> int:
        """42h: counts, latched when the reply starts."""
        return int.from_bytes(self.command(0x42), "big")

    def set_position(self, position: int):
        """43h: from now on this position is here."""
        self.command(0x43, struct.pack(">IB", position, self.code0))

    def read_analog(self, channel: int) -> int:
        """44h: a sensor value as a signed 16-bit number."""
        told, value = struct.unpack(">Bh", self.command(0x44, bytes([channel])))
        if told != channel:
            raise BadReply(f"channel {told:02X}h answers for {channel:02X}h")
        return value

    def read_counter(self) -> int:
        """46h: the non-volatile 24-bit counter."""
        return int.from_bytes(self.command(0x46), "big")

    def increment_counter(self):
        """47h"""
        self.command(0x47)

    def erase_counter(self):
        """49h"""
        self.command(0x49, bytes([self.code0]))

    def read_data(self, field: int, offset: int, count: int, code: int = DEFAULT_CODE) -> bytes:
        """4Ah: bytes of a data field."""
        where = bytes([field, offset, count])
        reply = self.command(0x4A, where + bytes([code]), more=count)
        if reply[:3] != where:
            raise BadReply(f"data of {reply[:3].hex(' ')} instead of {where.hex(' ')}")
        return reply[3:]

    def save_data(self, field: int, offset: int, data: bytes, code: int = DEFAULT_CODE):
        """4Bh: 1 to 128 bytes into a data field."""
        where = bytes([field, offset, len(data)])
        if self.command(0x4B, where + bytes([code]) + data) != where:
            raise BadReply("the encoder saved something else")

    def field_status(self, field: int) -> FieldStatus:
        """4Ch"""
        return FieldStatus.decode(self.command(0x4C, bytes([field]))[1])

    def create_field(self, field: int, status: FieldStatus, code: int = DEFAULT_CODE):
        """4Dh: create or modify a data field; erase it when status.exists is False."""
        wanted = bytes([field, status.encode()])
        if self.command(0x4D, wanted + bytes([code])) != wanted:
            raise BadReply("the encoder created something else")

    def available_memory(self) -> tuple[int, int]:
        """4Eh: (free bytes, number of data fields)."""
        blocks, fields = self.command(0x4E)
        return blocks * 16, fields

    def modify_access_code(self, number: int, old: int, new: int):
        """4Fh: change Code0 .. Code3. Code0 also guards the commands that this master sends."""
        self.command(0x4F, bytes([number, old, new]))
        if number == 0:
            self.code0 = new

    def read_status(self) -> int:
        """50h: the oldest stored warning or error, 0 when there is none. STATUS has the names."""
        return self.command(0x50)[0]

    def type_label(self) -> TypeLabel:
        """52h"""
        uart, type_code, blocks, option = self.command(0x52)
        return TypeLabel(uart, type_code, blocks * 16, option)

    def reset(self):
        """53h: no reply; the encoder is deaf for 100 ms after the request's timeout."""
        self.send(frame(self.address, 0x53))
        self._line_free_at += 0.11

    def assign_address(self, new: int):
        """55h: the reply already comes from the new address."""
        self.command(0x55, bytes([new, self.code0]))
        if self.reply_address != new:
            raise BadReply(f"{self.reply_address:02X}h answers instead of {new:02X}h")
        self.address = new

    def identity(self) -> Identity:
        """56h"""
        reply = self.command(0x56)
        serial_number, version, date = (part.rstrip(b"\0").decode("ascii")
                                        for part in (reply[:9], reply[9:29], reply[29:]))
        return Identity(serial_number, version, date)

    def configure_uart(self, setting: int):
        """57h: in force after reset() or the next power-on; then call use_uart()."""
        if self.command(0x57, bytes([setting, self.code0])) != bytes([setting]):
            raise BadReply("the encoder stored another setting")

    def set_position_synchronised(self, position: int) -> int:
        """6Ah: as 43h, in phase with the sine period; returns the position really used."""
        return int.from_bytes(self.command(0x6A, struct.pack(">IB", position, self.code0)), "big")

    # -- conveniences ---------------------------------------------------------------------------

    def extended_label(self) -> ExtendedLabel:
        """The extended type label: data field FFh."""
        return ExtendedLabel.decode(self.read_data(EXTENDED_LABEL, 0, 64))

    def read_all_status(self) -> dict[int, str]:
        """Empty the encoder's error stack: {code: name}, oldest first."""
        found = {}
        while True:
            code = self.read_status()
            if code == 0 or code in found:
                return found
            found[code] = STATUS.get(code, "unknown status code")

    def use_uart(self, setting: int):
        """Follow the encoder to another UART setting."""
        self.wait_for_line()
        uart = UartSetting.decode(setting)
        path = self.port.port
        self.port.close()
        self.port = open_port(path, uart.baudrate, uart.parity)
        self.pause_bits = uart.timeout_bits
