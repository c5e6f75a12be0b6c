# SPDX-License-Identifier: MIT
"""RS485 on a TCP port, raw and by RFC 2217: pyserial as it is, socat and ser2net in between, plain sockets."""
import contextlib
import os
import re
import socket
import struct
import subprocess
import time

import pytest
import serial

from hiperface_master import UartSetting, frame
from rig import MULTITURN, PATIENCE_S, SINGLETURN, Client, assert_one_line, free_port, run_refused, start_rig

RAW, TELNET = "tcp:127.0.0.1:0", "rfc2217:127.0.0.1:0"
KINDS = [RAW, TELNET]
PLACES = 32
SILENCE_S = 0.3
GAP_S = 0.05  # between a reply and the next request
START_UP_S = 1.5  # in which an encoder listens at 9600 Bd
POSITION = bytes.fromhex("404202")
IAC, SE, SB, WILL, WONT, DO, DONT = 255, 240, 250, 251, 252, 253, 254
COM_PORT = 44


def option(code: int, value: bytes = b"") -> bytes:
    return bytes([IAC, SB, COM_PORT, code]) + value.replace(b"\xff", b"\xff\xff") + bytes([IAC, SE])


@pytest.fixture
def listen(start):
    """An encoder on a TCP port; .url is what pyserial opens, .port the number."""
    def begin(kind, *arguments, **options):
        encoder = start(*arguments, wire=[f"--rs485={kind}"], **options)
        ready = re.fullmatch(r"ready \S+ rs485:(tcp|rfc2217):127\.0\.0\.1:([1-9]\d*)", encoder.ready_line)
        assert ready, encoder.ready_line
        encoder.port = int(ready[2])
        encoder.url = f"{'socket' if ready[1] == 'tcp' else 'rfc2217'}://127.0.0.1:{encoder.port}"
        return encoder

    return begin


@contextlib.contextmanager
def opened(url: str, **setting):
    """With the setting of the delivery state, where one can be told."""
    told = {"baudrate": 9600, "parity": "E", **setting} if url.startswith("rfc2217") else {}
    with serial.serial_for_url(url, timeout=PATIENCE_S, **told) as port:
        yield port


def ask(port, request: bytes, length: int) -> bytes:
    port.write(request)
    return port.read(length)


def assert_position(port):
    reply = ask(port, POSITION, 7)
    assert reply == frame(0x40, 0x42, reply[2:6])


def assert_silence(port):
    port.timeout = SILENCE_S
    assert ask(port, POSITION, 7) == b""
    port.timeout = PATIENCE_S


def connect(encoder) -> socket.socket:
    line = socket.create_connection(("127.0.0.1", encoder.port), PATIENCE_S)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return line


def read(line: socket.socket, length: int) -> bytes:
    got = b""
    while len(got) < length:
        more = line.recv(length - len(got))
        assert more, got
        got += more
    return got


@pytest.mark.parametrize("kind", KINDS)
def test_position(listen, kind):
    encoder = listen(kind, "--shaft", "90DEG")
    with opened(encoder.url) as port:
        for _ in range(5):
            assert ask(port, POSITION, 7) == frame(0x40, 0x42, struct.pack(">I", 0x4000))


@pytest.mark.parametrize("setting, said", [({"parity": "N"}, "9600 Bd 8N1"), ({"parity": "O"}, "9600 Bd 8O1"),
                                           ({"parity": "M"}, "9600 Bd 8M1"), ({"baudrate": 19200}, "19200 Bd 8E1"),
                                           ({"bytesize": 7}, "without 8 data bits")])
def test_wrong_setting_gets_silence(listen, setting, said):
    encoder = listen(TELNET)
    with opened(encoder.url, **setting) as port:
        assert_silence(port)
        assert_one_line(encoder, said, "the encoder expects 9600 Bd 8E1")
        port.apply_settings({"baudrate": 9600, "parity": "E", "bytesize": 8})
        assert_position(port)


def test_second_stop_bit_harms_nobody(listen):
    with opened(listen(TELNET).url, stopbits=2) as port:
        assert_position(port)


def test_any_line_takes_any_setting(listen):
    with opened(listen(TELNET, "--set", "line=any").url, parity="N", baudrate=115200) as port:
        assert_position(port)


def test_rate_change_is_followed(listen):
    encoder = listen(TELNET)
    setting = UartSetting(19200, "E", 44, False).encode()
    with opened(encoder.url) as port:
        assert ask(port, frame(0x40, 0x57, bytes([setting, 0x55])), 4) == frame(0x40, 0x57, bytes([setting]))
        assert_position(port)  # not in force yet
        port.write(frame(0x40, 0x53))
        time.sleep(START_UP_S)
        assert_silence(port)
        assert_one_line(encoder, "9600 Bd", "the encoder expects 19200 Bd 8E1")
        port.baudrate = 19200
        assert_position(port)


def test_one_encoder_with_the_masters_setting_is_enough(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text(f"[bus line]\nwire = rs485\naddress = {TELNET}\n[encoder a]\nmodel = {MULTITURN}\nbus = line\n"
                    f"[encoder b]\nmodel = {MULTITURN}\nbus = line\naddress = 0x41\n")
    rig = start_rig(file)
    setting = UartSetting(19200, "E", 44, False).encode()
    try:
        with opened(f"rfc2217://127.0.0.1:{re.search(r':([0-9]+) a$', rig.lines[0])[1]}") as port:
            assert ask(port, frame(0x41, 0x57, bytes([setting, 0x55])), 4) == frame(0x41, 0x57, bytes([setting]))
            time.sleep(GAP_S)
            port.write(frame(0x41, 0x53))
            time.sleep(START_UP_S)
            assert_position(port)
        assert rig.errors.so_far() == []
    finally:
        rig.clean_up()


def test_characters_are_paced(listen):
    """A reply of 7 characters takes 7 x 11 bits, as the request does 3 x 11."""
    with opened(listen(RAW).url) as port:
        began = time.monotonic()
        for _ in range(10):
            assert_position(port)
        assert time.monotonic() - began > 10 * 10 * 11 / 9600


def test_lines_of_a_modem(listen):
    with opened(listen(TELNET).url) as port:
        assert (port.cts, port.dsr, port.cd, port.ri) == (True, True, True, False)
        port.rts, port.dtr = False, False
        port.reset_input_buffer()
        port.reset_output_buffer()
        port.send_break(0.01)
        time.sleep(SILENCE_S)  # what the break was part of is over
        assert_position(port)
        port.rtscts = True
        assert_position(port)


def test_option_by_hand(listen):
    with connect(listen(TELNET)) as line:
        for request, reply in (
                (bytes([IAC, WILL, COM_PORT]), bytes([IAC, DO, COM_PORT]) + option(107, b"\xb0")),
                (bytes([IAC, DO, COM_PORT]), bytes([IAC, WILL, COM_PORT])),
                (bytes([IAC, WILL, COM_PORT, IAC, DO, 0]), bytes([IAC, WILL, 0])),
                (bytes([IAC, DONT, 0]), bytes([IAC, WONT, 0])),
                (bytes([IAC, WILL, 1, IAC, WONT, 1]), bytes([IAC, DONT, 1])),
                (option(0), option(100, b"drehgeber")),
                (option(1, struct.pack(">I", 0)), option(101, struct.pack(">I", 9600))),
                (option(1, struct.pack(">I", 255)), option(101, struct.pack(">I", 255))),
                (option(1, struct.pack(">I", 0xFFFFFFFF)), option(101, struct.pack(">I", 255))),
                (option(2, b"\0"), option(102, b"\x08")),
                (option(3, b"\0"), option(103, b"\x03")),
                (option(3, b"\x09"), option(103, b"\x03")),
                (option(4, b"\0"), option(104, b"\x01")),
                (option(5, b"\0"), option(105, b"\x01")),
                (option(5, b"\x0b") + option(5, b"\x0a"), 2 * option(105, b"\x0b")),
                (option(6), option(106, b"\x60")),
                (option(7), option(107, b"\xb0")),
                (option(10, b"\xff"), option(110, b"\xff")),
                (option(12, b"\x03"), option(112, b"\x03")),
                (option(1, b"\x01") + option(3) + option(99, b"x") + option(12, b"\x01"), option(112, b"\x01"))):
            line.sendall(request)
            assert read(line, len(reply)) == reply, request


@pytest.mark.parametrize("kind", KINDS)
def test_each_hears_the_others(listen, kind):
    encoder = listen(kind)
    with opened(encoder.url) as first, opened(encoder.url) as second:
        assert_position(second)
        assert first.read(10)[:3] == POSITION
        first.write(POSITION)
        assert second.read(3) == POSITION
        assert first.read(7) == second.read(7)


def test_who_listens_at_another_setting_hears_damage(listen):
    encoder = listen(TELNET)
    with opened(encoder.url) as right, opened(encoder.url, baudrate=19200) as fast, opened(encoder.url, parity="O") as odd:
        assert_position(right)
        assert fast.read(10) == bytes(10)
        assert odd.read(10)[:3] == POSITION
    with connect(encoder) as line:
        line.sendall(option(1, struct.pack(">I", 19200)) + option(10, b"\x0c"))
        read(line, len(option(101, bytes(4)) + option(110, b"\x0c")))
        with opened(encoder.url) as right:
            assert_position(right)
        assert read(line, 8) == option(106, b"\x08") + b"\0"


@pytest.mark.parametrize("kind", KINDS)
def test_ff_is_a_character(listen, kind):
    """The broadcast address."""
    with opened(listen(kind).url) as port:
        assert ask(port, frame(0xFF, 0x42), 7)[:2] == b"\x40\x42"
        ask(port, frame(0x40, 0x43, bytes.fromhex("00FFFF00") + b"\x55"), 3)
        assert ask(port, POSITION, 7) == frame(0x40, 0x42, bytes.fromhex("00FFFF00"))


@pytest.mark.parametrize("kind", KINDS)
def test_silent_clients_give_up_their_places(listen, kind):
    encoder = listen(kind)
    lines = [connect(encoder) for _ in range(2 * PLACES)]
    with opened(encoder.url) as port:
        assert_position(port)
        assert lines[0].recv(1) == b""
        assert_position(port)
    for line in lines:
        line.close()


@pytest.mark.parametrize("kind", KINDS)
def test_garbage_ends(listen, kind):
    encoder = listen(kind, "--quiet")
    for _ in range(5):
        with connect(encoder) as line:
            line.sendall(os.urandom(2000).replace(b"\x16", b"\0"))
    with opened(encoder.url) as port:
        port.timeout = SILENCE_S
        deadline = time.monotonic() + PATIENCE_S
        while not ask(port, POSITION, 7):
            assert time.monotonic() < deadline


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("begins", [b"GET /", b"PUT /x", b"\x16\x03\x01"])
def test_browsers_are_sent_away(listen, kind, begins):
    encoder = listen(kind)
    with connect(encoder) as line:
        line.sendall(begins)
        assert line.recv(1) == b""
    with opened(encoder.url) as port:
        assert_position(port)


@pytest.mark.parametrize("kind", KINDS)
def test_half_closed_still_hears(listen, kind):
    with connect(listen(kind)) as line:
        line.sendall(POSITION)
        line.shutdown(socket.SHUT_WR)
        assert read(line, 7)[:2] == b"\x40\x42"
        assert line.recv(1) == b""


@pytest.mark.parametrize("kind", KINDS)
def test_slow_reader_holds_up_nobody(listen, kind):
    encoder = listen(kind, "--set", "pace=0", "--control", "tcp:127.0.0.1:0")
    control = Client(encoder.out.wait().partition(" ")[2])
    with contextlib.closing(control), connect(encoder) as slow, opened(encoder.url) as port:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deadline = time.monotonic() + 3 * PATIENCE_S
        while "wire_lost=0," in control.ask("STAT?"):
            assert time.monotonic() < deadline
            port.write(bytes(4000))
        time.sleep(SILENCE_S)
        port.timeout = SILENCE_S
        while not ask(port, POSITION, 7):
            assert time.monotonic() < deadline
        assert slow.recv(100) == bytes(100)


@contextlib.contextmanager
def between(*command):
    """A program that listens at a port, sooner or later."""
    program = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
        assert program.poll() is None
    finally:
        program.kill()
        program.wait(PATIENCE_S)


@contextlib.contextmanager
def opened_soon(url: str, **setting):
    """It may still listen, or talk to its last client."""
    deadline = time.monotonic() + 3 * PATIENCE_S
    while True:
        try:
            port = serial.serial_for_url(url, timeout=PATIENCE_S, **setting)
            break
        except serial.SerialException:
            assert time.monotonic() < deadline
            time.sleep(0.1)
    with port:
        time.sleep(SILENCE_S)  # it does not wait for the far side
        yield port


def test_socat_in_between(listen):
    encoder, port = listen(RAW), free_port()
    with between("socat", f"TCP-LISTEN:{port},bind=127.0.0.1,fork,reuseaddr", f"TCP:127.0.0.1:{encoder.port}"), \
            opened_soon(f"socket://127.0.0.1:{port}") as line:
        assert_position(line)


def test_ser2net_in_between(listen, tmp_path):
    """It takes the setting of its own clients to the wire."""
    encoder, port = listen(TELNET), free_port()
    file = tmp_path / "ser2net.yaml"
    file.write_text(f"connection: &encoder\n  accepter: telnet(rfc2217),tcp,127.0.0.1,{port}\n"
                    f"  connector: telnet(rfc2217),tcp,127.0.0.1,{encoder.port}\n")
    url = f"rfc2217://127.0.0.1:{port}"
    with between("/usr/sbin/ser2net", "-n", "-d", "-c", str(file)):
        with opened_soon(url, baudrate=9600, parity="E") as line:
            assert_position(line)
        with opened_soon(url, baudrate=9600, parity="O") as line:
            assert_silence(line)
        assert_one_line(encoder, "9600 Bd 8O1")


def test_rig_file(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text("[bus line]\nwire = rs485\naddress = rfc2217:127.0.0.1:0\ntrace = line.vcd\n"
                    f"[encoder a]\nmodel = {MULTITURN}\nbus = line\n"
                    f"[encoder b]\nmodel = {SINGLETURN}\nbus = line\naddress = 0x41\n"
                    f"[encoder c]\nmodel = {MULTITURN}\nwire = rs485:tcp:127.0.0.1:0\n")
    rig = start_rig(file, "--control", "tcp:127.0.0.1:0")
    try:
        ports = [re.fullmatch(rf"ready \S+ rs485:\w+:127\.0\.0\.1:(\d+) {name}", line)[1]
                 for name, line in zip("abc", rig.lines)]
        assert ports[0] == ports[1]
        with opened(f"rfc2217://127.0.0.1:{ports[0]}") as line, opened(f"socket://127.0.0.1:{ports[2]}") as other:
            assert_position(line)
            time.sleep(GAP_S)
            assert ask(line, frame(0x41, 0x42), 7)[:2] == b"\x41\x42"
            assert_position(other)
        with contextlib.closing(Client(rig.controls[0])) as control:
            assert "wire_up=1," in control.ask("STAT?") and "wire_baud=9600" in control.ask("STAT?")
        assert rig.end() == 0
        assert "$enddefinitions" in (tmp_path / "line.vcd").read_text()
    finally:
        assert rig.clean_up() == []


@pytest.mark.parametrize("kind", KINDS)
def test_open_is_said_once(start, kind):
    encoder = start(wire=[f"--rs485={kind.replace('127.0.0.1', '0.0.0.0')},open"])
    assert_one_line(encoder, "beyond loopback; every machine that reaches it is on this wire")


@pytest.mark.parametrize("where, right", [
    ("127.0.0.1:0", "expected rfc2217:HOST:PORT or tcp:HOST:PORT, with or without ,open"),
    ("tcp:127.0.0.1:0,x", "expected rfc2217:HOST:PORT or tcp:HOST:PORT, with or without ,open"),
    ("tcp:127.0.0.1", "expected rfc2217:HOST:PORT or tcp:HOST:PORT, with or without ,open"),
    ("rfc2217:0.0.0.0:0", "use 0.0.0.0:0,open if you want that"),
])
def test_refusals_say_what_is_right(where, right):
    status = 1 if ",open if" in right else 2
    line = run_refused(status, "run", MULTITURN, f"--rs485={where}")
    assert f"--rs485 {where}: " in line and line.endswith(right), line
