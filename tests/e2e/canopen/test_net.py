# SPDX-License-Identifier: MIT
"""CAN on a TCP port: SLCAN adapters and a socketcand, with python-can, canopen and plain sockets."""
import contextlib
import os
import re
import socket
import struct
import subprocess
import threading
import time

import can
import canopen
import pytest
from can_rig import MODEL, PATIENCE_S, Client, Encoder, assert_one_line, run, state_of

SLCAN, SOCKETCAND = "slcan=tcp:127.0.0.1:0", "socketcand=127.0.0.1:0"
KINDS = [SLCAN, SOCKETCAND]
PLACES = 32
SETTLED_S = 0.3
REQUEST = can.Message(arbitration_id=0x63F, data=bytes.fromhex("4000100000000000"), is_extended_id=False)


class Wire:
    """One `drehgeber run` with the bus on a TCP port."""

    def __init__(self, wire: str, *arguments):
        self.kind = wire.partition("=")[0]
        self.encoder = Encoder([MODEL, f"--{wire}", "--control", "tcp:127.0.0.1:0", *arguments])
        ready = re.fullmatch(rf"ready {MODEL} {self.kind}:(?:tcp:)?(\S+):(\d+)(?:,(\w+))?/63", self.encoder.ready_line)
        assert ready, self.encoder.ready_line
        self.host, self.port, self.name = ready[1], int(ready[2]), ready[3] or "can0"
        assert self.port != 0
        self.control = Client(self.encoder.out.wait().partition(" ")[2])
        self.opened = contextlib.ExitStack()

    def bus(self, bit_rate: int = 250_000) -> can.BusABC:
        if self.kind == "slcan":
            bus = can.Bus(interface="slcan", channel=f"socket://{self.host}:{self.port}", bitrate=bit_rate,
                          sleep_after_open=0)
        else:
            bus = can.Bus(interface="socketcand", host=self.host, port=self.port, channel=self.name)
        self.opened.callback(bus.shutdown)
        return bus

    def line(self) -> socket.socket:
        line = self.opened.enter_context(socket.create_connection((self.host, self.port), PATIENCE_S))
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return line

    def answered(self, bus: can.BusABC) -> can.Message:
        """What an encoder says to a client."""
        bus.send(REQUEST)
        return the_next(bus, 0x5BF)

    def clean_up(self) -> list:
        self.opened.close()
        self.control.close()
        return self.encoder.clean_up()


def the_next(bus: can.BusABC, can_id: int) -> can.Message:
    """The next frame with this identifier; what came before is forgotten."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        frame = bus.recv(PATIENCE_S)
        if frame is not None and frame.arbitration_id == can_id:
            return frame
    raise AssertionError(f"no frame {can_id:X}")


def is_closed(line: socket.socket) -> bool:
    line.settimeout(PATIENCE_S)
    with contextlib.suppress(ConnectionResetError):
        while line.recv(4096):
            pass
    return True


def said(line: socket.socket, end: bytes, so_far: bytes = b"") -> bytes:
    """Up to these bytes."""
    line.settimeout(PATIENCE_S)
    while not so_far.endswith(end):
        byte = line.recv(1)
        assert byte, so_far
        so_far += byte
    return so_far


@pytest.fixture
def start():
    running = []

    def begin(*arguments) -> Wire:
        running.append(Wire(*arguments))
        return running[-1]

    yield begin
    assert [line for wire in running for line in wire.clean_up()] == []


@pytest.fixture(params=KINDS)
def wire(request, start) -> Wire:
    return start(request.param)


def test_canopen(wire, eds):
    network = canopen.Network(wire.bus())
    network.NOTIFIER_CYCLE = 0.05
    network.connect()
    node = network.add_node(63, str(eds))
    node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
    booted = threading.Event()
    network.subscribe(0x73F, lambda *_: booted.set())
    node.nmt.send_command(0x81)
    assert booted.wait(PATIENCE_S)
    assert node.sdo[0x1000].raw == 0x00020196
    node.sdo[0x1017].raw = 50
    assert node.sdo[0x1017].raw == 50
    assert node.nmt.wait_for_heartbeat(PATIENCE_S) == "PRE-OPERATIONAL"
    node.tpdo.read()
    node.nmt.state = "OPERATIONAL"
    wire.control.do("SHAF:POS 90DEG")
    while int.from_bytes(node.sdo.upload(0x6004, 0), "little") != 0x4000:
        pass
    node.tpdo[2].add_callback(lambda pdo: seen.append(pdo[0].raw))
    seen = []
    deadline = time.monotonic() + PATIENCE_S
    while not seen:
        network.sync.transmit()
        time.sleep(0.01)
        assert time.monotonic() < deadline
    assert seen[0] == 0x4000
    network.notifier.stop()


def test_each_hears_the_others_and_the_encoder(wire):
    first, second, third = wire.bus(), wire.bus(), wire.bus()
    wire.answered(third)  # all of them have their channel open
    for frame in (can.Message(arbitration_id=0x123, data=b"\xDE\xAD", is_extended_id=False),
                  can.Message(arbitration_id=0x321, data=b"", is_extended_id=False),
                  can.Message(arbitration_id=0x1ABCDE01, data=bytes(range(8)), is_extended_id=True)):
        first.send(frame)
        for other in (second, third):
            got = the_next(other, frame.arbitration_id)
            assert (got.data, got.is_extended_id) == (frame.data, frame.is_extended_id)
    second.send(REQUEST)
    for bus in (first, second, third):
        assert the_next(bus, 0x5BF).data[:4] == bytes.fromhex("43001000")
    seen = []
    while frame := first.recv(SETTLED_S):
        seen.append(frame.arbitration_id)
    assert set(seen).isdisjoint({0x123, 0x321, 0x1ABCDE01})  # not its own


def test_silent_clients_give_up_their_places(wire):
    lines = [wire.line() for _ in range(2 * PLACES)]
    assert wire.answered(wire.bus()).data[0] == 0x43
    assert is_closed(lines[0])
    wire.answered(wire.bus())


def test_garbage_is_nobodys_frame(wire):
    bus = wire.bus()
    wire.answered(bus)
    for _ in range(20):
        line = wire.line()
        line.sendall(os.urandom(3000).replace(b"\r", b"\n").replace(b">", b")"))
        line.sendall(b"\r< send 123 9 > < " + b"x" * 5000 + b" >\r")
        line.close()
    assert wire.answered(bus).data[0] == 0x43


@pytest.mark.parametrize("begins", [b"POST / HTTP/1.1\r\nHost: x\r\n\r\n", b"get /\r", b"\x16\x03\x01\x02\x00\x01"])
def test_browsers_are_sent_away(wire, begins):
    listener = wire.bus()
    wire.answered(listener)
    line = wire.line()
    with contextlib.suppress(OSError):
        line.sendall(begins + b"S5\rO\rt1230\r" + b"< open can0 >< send 123 0 >")
    assert is_closed(line)
    wire.answered(listener)
    while frame := listener.recv(SETTLED_S):
        assert frame.arbitration_id != 0x123


def test_connection_that_breaks_in_the_middle(wire):
    line = wire.line()
    line.sendall(b"S5\rO\rt12" if wire.kind == "slcan" else b"< open can0 >< rawmode >< send 12")
    line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    line.close()  # resets it
    assert wire.answered(wire.bus()).data[0] == 0x43


@pytest.mark.parametrize("kind", KINDS)
def test_slow_reader_holds_up_nobody(start, kind):
    wire = start(kind, "--quiet")  # it says that no real bus carries this
    slow = wire.line()
    slow.sendall(b"S5\rO\r" if wire.kind == "slcan" else b"< open can0 >< rawmode >")
    fast = wire.bus()
    deadline = time.monotonic() + 6 * PATIENCE_S
    while int(state_of(wire.control)["wire_lost"]) == 0:
        assert time.monotonic() < deadline
        for _ in range(500):
            fast.send(can.Message(arbitration_id=0x234, data=bytes(8), is_extended_id=False))
    assert wire.answered(fast).data[0] == 0x43
    heard = slow.recv(1 << 20)
    frame = rb"t2348(00){8}\r" if wire.kind == "slcan" else rb"< frame 234 \d+\.\d{6} (00){8} >"
    assert re.search(frame, heard)


def test_lost_without_a_client(wire):
    wire.control.do("POW OFF")
    wire.control.do("POW ON")
    assert state_of(wire.control)["wire_up"] == "1"
    wire.answered(wire.bus())


def test_bit_rates_have_to_agree(start):
    wire = start(SLCAN)
    wrong, right, other = wire.bus(500_000), wire.bus(), wire.bus()
    assert wire.answered(right).data[0] == 0x43
    assert_one_line(wire.encoder, "500 kBd", "250 kBd")
    wrong.send(can.Message(arbitration_id=0x123, data=b"", is_extended_id=False))
    wrong.send(REQUEST)
    assert wrong.recv(SETTLED_S) is None
    assert wire.answered(other).data[0] == 0x43
    while frame := other.recv(SETTLED_S):
        assert frame.arbitration_id != 0x123


def test_socketcand_as_it_is_written(start):
    wire = start(SOCKETCAND + ",can7")
    assert wire.name == "can7"
    other = wire.bus()
    line = wire.line()
    assert said(line, b">") == b"< hi >"
    for request, reply in ((b"< echo >", b"< echo >"),
                           (b"< send 123 0 >", b"< error unknown command >"),
                           (b"< open can0 >", b"< error could not open bus >"),
                           (b"< open can7 >", b"< ok >"),
                           (b"< send 123 1 >", b"< error syntax error in send command >"),
                           (b"< send 800 0 >", b"< error syntax error in send command >"),
                           (b"<echo>", b"< echo >"),
                           (b"< open can7 >", b"< error unknown command >")):
        line.sendall(request)
        assert said(line, b">") == reply, request
    line.sendall(b"< subscribe 0 0 5BF >\n< send 63F 8 40 0 10 0 0 0 0 0 >")
    assert re.fullmatch(rb"< frame 5BF \d+\.\d{6} 4300100096010200 >", said(line, b">"))
    line.sendall(b"< unsubscribe 5BF >< send 63F 8 40 0 10 0 0 0 0 0 >< rawmode >")
    assert said(line, b">") == b"< ok >"
    the_next(other, 0x5BF)
    other.send(can.Message(arbitration_id=0x77, data=b"", is_extended_id=False))
    told = b""
    while b" 077 " not in b" " + told.replace(b"frame", b""):
        told = said(line, b">")
    assert re.fullmatch(rb"< frame 077 \d+\.\d{6}  >", told)
    line.sendall(b"< bcmmode >")
    assert said(line, b"< ok >")


def test_frames_take_their_time_with_pace(start):
    wire = start(SLCAN, "--set", "pace=1")
    bus = wire.bus()
    assert wire.answered(bus).data[0] == 0x43
    for _ in range(200):
        bus.send(REQUEST)
    for _ in range(200):
        the_next(bus, 0x5BF)


def test_socat_makes_a_pty_of_it(start, tmp_path):
    wire = start(SLCAN)
    link = tmp_path / "port"
    between = subprocess.Popen(["socat", f"PTY,link={link},rawer", f"TCP:127.0.0.1:{wire.port},nodelay"])
    try:
        deadline = time.monotonic() + PATIENCE_S
        while not link.exists():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        with can.Bus(interface="slcan", channel=str(link), bitrate=250_000, sleep_after_open=0) as bus:
            assert wire.answered(bus).data[0] == 0x43
    finally:
        between.kill()
        between.wait(PATIENCE_S)


def test_rig_file(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text("[bus hub]\nwire = slcan\naddress = tcp:127.0.0.1:0\ntrace = hub.log\n"
                    f"[encoder a]\nmodel = {MODEL}\nbus = hub\nnode = 5\n"
                    f"[encoder b]\nmodel = {MODEL}\nwire = socketcand:127.0.0.1:0,can1\nnode = 6\n"
                    f"[encoder c]\nmodel = {MODEL}\nwire = slcan:tcp:[::1]:0\nnode = 7\n")
    rig = Encoder([file, "--control", "tcp:127.0.0.1:0"])
    try:
        ready = [rig.ready_line, *(rig.out.wait() for _ in range(4))]
        port = re.fullmatch(rf"ready {MODEL} slcan:tcp:127\.0\.0\.1:(\d+)/5 a", ready[0])[1]
        assert re.fullmatch(rf"ready {MODEL} socketcand:127\.0\.0\.1:[1-9]\d+,can1/6 b", ready[1])
        assert re.fullmatch(rf"ready {MODEL} slcan:tcp:\[::1\]:[1-9]\d+/7 c", ready[2])
        with can.Bus(interface="slcan", channel=f"socket://127.0.0.1:{port}", bitrate=250_000,
                     sleep_after_open=0) as bus:
            bus.send(can.Message(arbitration_id=0x605, data=REQUEST.data, is_extended_id=False))
            the_next(bus, 0x585)
        assert rig.end() == 0
        log = (tmp_path / "hub.log").read_text()
        assert "605#4000100000000000" in log and "585#4300100096010200" in log
    finally:
        assert rig.clean_up() == []


def refused(*arguments) -> str:
    ended = run("run", MODEL, *arguments)
    assert ended.returncode != 0 and ended.stdout == ""
    assert ended.stderr.count("\n") == 1
    return ended.stderr


@pytest.mark.parametrize("wire, right", [
    ("--slcan=tcp:5000", "expected LINK, tcp:HOST:PORT or tcp:HOST:PORT,open"),
    ("--slcan=tcp:localhost:0,can0", "expected LINK, tcp:HOST:PORT or tcp:HOST:PORT,open"),
    ("--socketcand=5000", "expected HOST:PORT or HOST:PORT,BUS, with or without ,open"),
    ("--socketcand=localhost:0,a b", "expected HOST:PORT or HOST:PORT,BUS, with or without ,open"),
    ("--slcan=tcp:0.0.0.0:0", "use 0.0.0.0:0,open if you want that"),
    ("--socketcand=0.0.0.0:0,can3", "use 0.0.0.0:0,can3,open if you want that"),
    ("--socketcand=300.0.0.1:0", "cannot listen there"),
])
def test_refusals_say_what_is_right(wire, right):
    line = refused(wire)
    assert right in line and wire.replace("=", " ", wire.startswith("--socketcand")) in line, line


@pytest.mark.parametrize("wire", ["slcan=tcp:0.0.0.0:0,open", "socketcand=0.0.0.0:0,open"])
def test_open_is_said_once(start, wire):
    one = start(wire)
    assert_one_line(one.encoder, "beyond loopback; every machine that reaches it is on this wire")
    assert one.answered(one.bus()).data[0] == 0x43


def test_port_that_is_taken(start):
    wire = start(SOCKETCAND)
    assert "Address already in use" in refused(f"--socketcand=127.0.0.1:{wire.port}")
