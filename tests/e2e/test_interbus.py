# SPDX-License-Identifier: MIT
"""The INTERBUS encoder behind its Modbus/TCP coupler; pymodbus and mbpoll are the clients."""
import contextlib
import inspect
import pathlib
import random
import re
import signal
import socket
import subprocess
import threading
import time

import pytest
from pymodbus.client import ModbusTcpClient

from rig import PATIENCE_S, Client, free_port, run, run_refused

K3 = "ocd-ib-k3"
INPUT, OUTPUT, STATUS, LENGTHS, SLAVES = 0x0000, 0x0800, 0x100C, 0x1010, 0x2000
WATCHDOG_MS, WATCHDOG_RESET, FALLBACK = 0x1120, 0x1121, 0x1123
ZERO, FREEZE, STOP = 0, 1, 2
RUN, BUS_ERROR, MODULE_ERROR = 0x0001, 0x0002, 0x0004
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
STEPS_PER_TURN = 4096
POSITION = "position"
STORED = slice(0x2AA, 0x4F8)  # of a K3's image: all regions but the time, and no journal of the store

# Chapter 5.3, all rows: OUT of the master, IN of the encoder.
EXAMPLE = [
    (0x00000000, POSITION),
    (0x020000FF, POSITION), (0x020000FF, POSITION), (0x020000FF, POSITION), (0x020000FF, POSITION),
    (0x020000FF, 0xC20000FF),
    (0x04000001, 0xC20000FF), (0x04000001, 0xC20000FF), (0x04000001, 0xC4000001),
    (0x06000003, 0xC4000001), (0x06000003, 0xC4000001), (0x06000003, 0xC6000003),
    (0x08000000, 0xC6000003), (0x08000000, 0xC6000003), (0x08000000, 0xC8000000),
    (0x80000000, 0xC8000000), (0x80000000, POSITION),
    (0x00000000, POSITION),
]


def split(word: int) -> list:
    return [word >> 16, word & 0xFFFF]


def join(registers: list) -> int:
    return registers[0] << 16 | registers[1]


class Plc:
    """A Modbus client that speaks 32-bit process data."""

    def __init__(self, port: int):
        self.client = ModbusTcpClient("127.0.0.1", port=port, timeout=PATIENCE_S)
        assert self.client.connect()
        names = inspect.signature(self.client.readwrite_registers).parameters
        self.values = "values" if "values" in names else "write_registers"

    def read(self, address: int, count: int = 1) -> list:
        """FC 4."""
        answer = self.client.read_input_registers(address, count=count)
        assert not answer.isError(), answer
        return answer.registers

    def write(self, address: int, words: list):
        """FC 16."""
        answer = self.client.write_registers(address, words)
        assert not answer.isError(), answer

    def position(self, at: int = 0) -> int:
        """IN of the slave whose words begin at `at`."""
        return join(self.read(INPUT + at, 2))

    def exchange(self, out: int) -> int:
        """FC 23: OUT goes, IN comes back as it was at that moment."""
        answer = self.client.readwrite_registers(
            read_address=INPUT, read_count=2, write_address=OUTPUT, **{self.values: split(out)})
        assert not answer.isError(), answer
        return join(answer.registers)

    def becomes(self, word: int, at: int = 0, first: int | None = None):
        """IN goes straight from `first`, or from what it is, to `word`."""
        deadline = time.monotonic() + PATIENCE_S
        got = self.position(at)
        first = got if first is None else first
        while got != word:
            assert got == first, f"{got:08X} between {first:08X} and {word:08X}"
            assert time.monotonic() < deadline, f"{got:08X} instead of {word:08X}"
            got = self.position(at)

    def command(self, out: int, answer: int, at: int = 0):
        self.write(OUTPUT + at, split(out))
        self.becomes(answer, at)

    def parameter(self, out: int, at: int = 0):
        """An accepted command is answered with bits 31 and 30 set."""
        self.command(out, out | 0xC0000000, at)

    def release(self, at: int = 0) -> int:
        """Back to operation; what IN is then."""
        self.write(OUTPUT + at, split(0x80000000))
        deadline = time.monotonic() + PATIENCE_S
        while self.position(at) >> 31:
            assert time.monotonic() < deadline, f"{self.position(at):08X} is not released"
        self.write(OUTPUT + at, [0, 0])
        return self.position(at)

    def read_out(self, item: int, value: int, at: int = 0):
        before = self.position(at)
        self.command(0x20210000 | item, 0xA0000000 | value, at)
        self.command(0, before, at)


def port_of(encoder) -> int:
    return int(encoder.path.rpartition(":")[2])


@pytest.fixture
def coupler(start):
    """Start couplers: coupler("--shaft", "60RPM", model=...)."""
    def begin(*arguments, model=K3):
        return start(*arguments, model=model, wire=["--modbus", f"127.0.0.1:{free_port()}"])
    return begin


@pytest.fixture
def plc():
    """Connect clients: plc(encoder)."""
    with contextlib.ExitStack() as open_clients:
        def begin(encoder) -> Plc:
            client = Plc(port_of(encoder))
            open_clients.callback(client.client.close)
            return client
        yield begin


def in_operation(client: Plc, at: int = 0):
    """The ring runs, and the encoder's self-test is over."""
    deadline = time.monotonic() + PATIENCE_S
    while client.read(STATUS)[0] & RUN == 0 or client.position(at) == 0xA0000000:
        assert time.monotonic() < deadline


def mbpoll(encoder, *arguments) -> str:
    """A call of mbpoll; what it printed."""
    call = ["mbpoll", "-m", "tcp", "-p", str(port_of(encoder)), "-0", "-1", "-q",
            arguments[0], *map(str, arguments[1:-1]), "127.0.0.1", *arguments[-1]]
    ended = subprocess.run(call, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                           timeout=PATIENCE_S)
    assert ended.returncode == 0, (call, ended.stdout, ended.stderr)
    return ended.stdout


def mbpoll_words(encoder, address: int, count: int) -> list:
    printed = mbpoll(encoder, "-t", "3:hex", "-r", address, "-c", count, [])
    return [int(word, 16) for word in re.findall(r"^\[\d+\]:\s+0x([0-9A-F]{4})", printed, re.M)]


def mbpoll_write(encoder, word: int):
    mbpoll(encoder, "-t", "4:hex", "-r", OUTPUT, [f"0x{part:04X}" for part in split(word)])


def ask_raw(port: int, pdu: bytes) -> bytes:
    """One request on a connection of its own; the answer's PDU."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as line:
        line.sendall(bytes([0, 1, 0, 0, 0, len(pdu) + 1, 1]) + pdu)
        answer = line.recv(300)
    assert answer[:4] == bytes([0, 1, 0, 0]) and len(answer) == 6 + answer[5]
    return answer[7:]


# --- the examples of the manual -----------------------------------------------------------------

def test_example_of_5_3(coupler, plc):
    # A cycle long enough to see what is before an answer, and a shaft that stands at 30.5 turns. Rows of one OUT that
    # repeat each other are one: on a busy machine the answer may be there before the second of them is looked for.
    client = plc(coupler("--set", "cycle=20000", "--shaft", "10980DEG"))
    in_operation(client)
    unscaled, scaled = 30 * STEPS_PER_TURN + STEPS_PER_TURN // 2, 30 * 255 + 127
    position = unscaled
    last = before = None
    for out, expected in EXAMPLE:
        position = scaled if out == 0x80000000 else position
        word = position if expected == POSITION else expected
        if out != last:
            got = client.exchange(out)  # no reaction yet
            assert got == word, f"{out:08X}: {got:08X}"
        elif word != before:
            client.becomes(word, first=before)
        last, before = out, word

    # The preset is called up.
    assert client.exchange(0x00000000) == scaled
    assert client.exchange(0x40000000) == scaled
    client.becomes(0x00000000)
    client.write(OUTPUT, [0, 0])
    assert client.position() == 0x00000000


def test_example_of_5_4_4(coupler, plc):
    client = plc(coupler("--shaft", "sine:90DEG,2S"))
    in_operation(client)
    for out in [0x20800001, 0x46000015, 0x66000213, 0x20400008]:
        client.write(OUTPUT, split(out))
        deadline = time.monotonic() + PATIENCE_S
        while client.position() != out | 0xC0000000:
            assert time.monotonic() < deadline
    client.release()
    seen = set()
    end = time.monotonic() + 2.2
    while time.monotonic() < end:
        word = client.position()
        position = word >> 8 & 0x1FFFF  # shift_iw 0; +-1024 around 0
        assert word & 0xFE0000FF in (0, 8), f"{word:08X}"
        assert (word & 8 != 0) == (0x15 <= position < 0x213), f"{word:08X}"
        seen.add("below" if position >= 0x10000 else "on" if word & 8 else "off")
    assert seen == {"below", "on", "off"}


# --- mbpoll -------------------------------------------------------------------------------------

def test_mbpoll(coupler):
    encoder = coupler("--shaft", "10980DEG")
    deadline = time.monotonic() + PATIENCE_S
    while (mbpoll_words(encoder, STATUS, 1) != [RUN]
           or mbpoll_words(encoder, INPUT, 2) == [0xA000, 0x0000]):
        assert time.monotonic() < deadline
    assert mbpoll_words(encoder, INPUT, 2) == [0x0001, 0xE800]
    printed = mbpoll(encoder, "-t", "3:int", "-B", "-r", INPUT, "-c", 1, [])
    assert re.search(rf"^\[0\]:\s+{0x1E800}$", printed, re.M), printed
    for out in [0x020000FF, 0x04000001, 0x06000003, 0x08000000]:
        mbpoll_write(encoder, out)
        assert mbpoll_words(encoder, OUTPUT, 2) == split(out)
        time.sleep(0.05)  # many cycles
        assert mbpoll_words(encoder, INPUT, 2) == split(out | 0xC0000000)
    mbpoll_write(encoder, 0x80000000)
    mbpoll_write(encoder, 0x00000000)
    assert mbpoll_words(encoder, INPUT, 2) == split(30 * 255 + 127)
    assert mbpoll_words(encoder, SLAVES, 1) == [0x0237]


# --- functions ----------------------------------------------------------------------------------

def test_ready_line(coupler):
    encoder = coupler()
    assert re.fullmatch(rf"ready {K3} modbus:127\.0\.0\.1:\d+", encoder.ready_line)
    assert encoder.out.so_far() == []


def test_parametrise_and_read_out(coupler, plc):
    client = plc(coupler("--serial", "4711", "--shaft", "90DEG"))
    in_operation(client)
    assert client.position() == 0x400
    for out in [0x02000064, 0x0400000A, 0x06000004, 0x08000123, 0x0A000045]:
        client.parameter(out)
    client.command(0x02000000, 0x82000000)
    client.command(0x1E000000, 0x84000000)
    client.release()
    for item, value in [(0, 4711), (1, 0x64), (2, 0x0A), (3, 4), (4, 0x123), (5, 0x45), (6, 1),
                        (9, 1), (0xA, 2), (0xCD, 0x37)]:
        client.read_out(item, value)
    client.command(0x2021000B, 0xA4000000 | 0x0021000B)


def test_gear_factor_in_the_order_of_the_manual(coupler, plc, nvm):
    """Both words are echoed, the release judges them; what it has not taken is not in the memory."""
    encoder = coupler("--nvm", nvm, "--shaft", "1080DEG")
    client = plc(encoder)
    in_operation(client)
    client.parameter(0x02002710)
    client.parameter(0x04000003)
    assert client.release() == 10000
    client.parameter(0x02003001)
    client.command(0x80000000, 0x82000000)
    client.command(0x00000000, 0x82000000)
    time.sleep(0.02)  # bit 31 has to be seen clear
    assert client.release() == 10000
    client.parameter(0x02000100)
    encoder.end(signal.SIGKILL)
    client = plc(coupler("--nvm", nvm, "--shaft", "1080DEG"))
    in_operation(client)
    assert client.position() == 10000
    client.read_out(1, 10000)
    client.read_out(2, 3)


def test_preset(coupler, plc):
    client = plc(coupler("--shaft", "90DEG"))
    in_operation(client)
    client.parameter(0x08012345)
    assert client.release() == 0x400
    client.command(0x40000000, 0x12345)
    client.command(0x00000000, 0x12345)
    client.parameter(0x08000777)
    client.release()
    client.command(0x60000000, 0x777)
    client.command(0x80000000, 0x777)


@pytest.mark.parametrize("shaft, word", [("60RPM", 60), ("-1500RPM", 0x2000000 - 1500)])
def test_speed(coupler, plc, shaft, word):
    client = plc(coupler("--shaft", shaft))
    in_operation(client)
    client.write(OUTPUT, split(0x20400001))
    deadline = time.monotonic() + PATIENCE_S
    while client.position() != 0xE0400001:
        assert time.monotonic() < deadline
    assert client.release() == word
    assert {client.position() for _ in range(100)} == {word}


def test_position_follows_the_shaft(coupler, plc):
    client = plc(coupler("--shaft", "60RPM"))
    in_operation(client)
    begin, first = time.monotonic(), client.position()
    time.sleep(1)
    last, end = client.position(), time.monotonic()
    assert 0.97 * STEPS_PER_TURN <= last - first <= 1.01 * STEPS_PER_TURN * (end - begin) + 8


def set_everything(client):
    for out in [0x02000064, 0x0400000A, 0x06000004, 0x0A000045, 0x08000123]:
        client.parameter(out)
    client.release()
    client.command(0x40000000, 0x123)
    client.command(0x00000000, 0x123)
    for out in [0x08000321, 0x20800005, 0x46000015, 0x66000213, 0x20400008, 0x20100003]:
        client.parameter(out)


def check_everything(client):
    in_operation(client)
    assert client.position() == (0x123 >> 3) << 8 | 8  # cam mode, without a release
    for item, value in [(1, 0x64), (2, 0x0A), (3, 4), (4, 0x321), (5, 0x45), (6, 1), (9, 7)]:
        client.read_out(item, value)
    for out, answer in [(0x20200000, 8), (0x20200013, 0x15), (0x20200023, 0x213), (0x20200040, 3)]:
        client.command(out, 0xA0000000 | answer)


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGKILL])
def test_restart_keeps_all(coupler, plc, nvm, signal_number):
    encoder = coupler("--nvm", nvm, "--shaft", "90DEG")
    client = plc(encoder)
    in_operation(client)
    set_everything(client)
    assert encoder.end(signal_number) == (0 if signal_number == signal.SIGTERM else -signal_number)
    check_everything(plc(coupler("--nvm", nvm, "--shaft", "90DEG")))


def test_without_memory_state_is_lost(coupler, plc):
    encoder = coupler()
    client = plc(encoder)
    in_operation(client)
    client.parameter(0x02000064)
    client.release()
    client.read_out(1, 0x64)
    encoder.end()
    client = plc(coupler())
    in_operation(client)
    client.read_out(1, STEPS_PER_TURN)


# --- the ring -----------------------------------------------------------------------------------

def test_ring_of_three(coupler, plc):
    client = plc(coupler("--ring", "ocd-ib-k1,ocd-ib-k3,ocd-ib-k3", "--shaft", "450DEG"))
    in_operation(client, 1)
    in_operation(client, 3)
    assert client.read(INPUT, 5) == [0x0400, 0x0000, 0x1400, 0x0000, 0x1400]
    client.parameter(0x02000064, 3)
    client.parameter(0x08000123, 1)
    assert client.position(3) == 0xC2000064
    assert client.release(3) == 125
    assert client.position(1) == 0xC8000123
    assert client.release(1) == 0x1400
    assert client.read(INPUT) == [0x0400]


def test_restart_of_a_ring_keeps_each_slave(coupler, plc, nvm):
    ring = ["--ring", "ocd-ib-k1,ocd-ib-k3,ocd-ib-k3", "--nvm", nvm]
    encoder = coupler(*ring)
    client = plc(encoder)
    for at, steps in [(1, 100), (3, 200)]:
        in_operation(client, at)
        client.parameter(0x02000000 | steps, at)
        client.release(at)
    encoder.end(signal.SIGKILL)
    client = plc(coupler(*ring))
    for at, steps in [(1, 100), (3, 200)]:
        in_operation(client, at)
        client.read_out(1, steps, at)


def test_id_words(coupler, plc):
    client = plc(coupler("--ring", "ocd-ib-k1,ocd-ib-k2,ocd-ib-k3"))
    in_operation(client, 3)
    assert [client.read(SLAVES + 16 * n)[0] for n in range(3)] == [0x0136, 0x0236, 0x0237]


def test_both_slaves_in_one_request(coupler, plc):
    client = plc(coupler("--ring", "ocd-ib-k3,ocd-ib-k3"))
    in_operation(client)
    in_operation(client, 2)
    client.write(OUTPUT, split(0x08000011) + split(0x0A000022))
    client.becomes(0xC8000011, 0)
    client.becomes(0xCA000022, 2)


@pytest.mark.parametrize("ring", ["ocd-ib-k3,ocd-ib-k9", "ocd-ib-k3,s3684-rs485", ""])
def test_ring_of_unknown_models(ring):
    run_refused(2, "run", K3, "--modbus", f"127.0.0.1:{free_port()}", "--ring", ring)


# --- the coupler --------------------------------------------------------------------------------

def test_images_by_both_reading_functions(coupler, plc):
    client = plc(coupler("--shaft", "90DEG"))
    in_operation(client)
    client.write(OUTPUT, [0x0055, 0xAA55])
    for read in [client.client.read_input_registers, client.client.read_holding_registers]:
        assert read(INPUT, count=2).registers == [0x0000, 0x0400]
        assert read(OUTPUT, count=2).registers == [0x0055, 0xAA55]
        assert sorted(read(LENGTHS, count=4).registers) == [0, 0, 32, 32]
        assert len(read(0x1000, count=10).registers) == 10
        assert read(STATUS, count=1).registers == [RUN]


def test_a_word_is_only_taken_whole(coupler, plc):
    client = plc(coupler())
    in_operation(client)
    client.client.write_register(OUTPUT, 0x0800)
    client.client.write_register(OUTPUT + 1, 0x0123)
    time.sleep(0.05)
    assert client.position() == 0
    assert client.read(OUTPUT, 2) == [0, 0]
    client.parameter(0x08000123)


def test_a_torn_word_is_a_fault_that_can_be_had(coupler, plc):
    client = plc(coupler("--set", "tear=1"))
    in_operation(client)
    client.client.write_register(OUTPUT, 0x0800)
    client.becomes(0xC8000000)
    client.client.write_register(OUTPUT + 1, 0x0123)
    client.becomes(0xC8000123)


def test_a_lost_sensor(coupler, plc):
    encoder = coupler("--ring", "ocd-ib-k1,ocd-ib-k3", "--set", "singleturn_ok=0")
    client = plc(encoder)
    in_operation(client, 1)
    assert client.position(1) >> 28 == 8  # a K3 has a bit for it
    assert client.read(STATUS) == [RUN | MODULE_ERROR]  # a K1 has not


def test_an_interrupted_ring(coupler, plc):
    client = plc(coupler("--ring", "ocd-ib-k3,ocd-ib-k3", "--set", "break_at=1"))
    time.sleep(0.3)
    assert client.read(STATUS)[0] & (RUN | BUS_ERROR) == BUS_ERROR
    client.write(OUTPUT, split(0x08000123) + split(0x08000123))
    time.sleep(0.05)
    assert client.read(INPUT, 4) == [0, 0, 0, 0]


def test_two_clients(coupler, plc):
    encoder = coupler("--shaft", "90DEG")
    one, two = plc(encoder), plc(encoder)
    in_operation(one)
    one.parameter(0x08000123)
    assert two.position() == 0xC8000123 and two.read(OUTPUT, 2) == split(0x08000123)
    two.parameter(0x0A000001)
    assert one.position() == 0xCA000001
    assert two.release() == 0x401
    assert one.position() == 0x401


def test_two_clients_at_once(coupler, plc):
    encoder = coupler("--shaft", "90DEG", "--ring", "ocd-ib-k3,ocd-ib-k3")
    clients = [plc(encoder), plc(encoder)]
    failures = []

    def work(client, at):
        try:
            in_operation(client, at)
            for value in range(1, 21):
                client.parameter(0x0A000000 | value << 4 | at, at)
            client.release(at)
            assert client.position(at) == 0x400 + (20 << 4 | at)
        except AssertionError as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(client, 2 * n))
               for n, client in enumerate(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE_S)
    assert failures == [] and not any(thread.is_alive() for thread in threads)


@pytest.mark.parametrize("pdu, code", [
    ("04 0000 0003", ILLEGAL_ADDRESS),  # one more than the image
    ("04 0002 0001", ILLEGAL_ADDRESS),
    ("03 0700 0001", ILLEGAL_ADDRESS),
    ("03 0801 0002", ILLEGAL_ADDRESS),
    ("04 FFFF 0001", ILLEGAL_ADDRESS),
    ("04 FFFF 0002", ILLEGAL_ADDRESS),
    ("06 0000 0001", ILLEGAL_ADDRESS),  # the input image is read-only
    ("06 100C 0001", ILLEGAL_ADDRESS),
    ("06 2000 0001", ILLEGAL_ADDRESS),
    ("10 0000 0002 04 0000 0000", ILLEGAL_ADDRESS),
    ("10 0800 0003 06 0000 0000 0000", ILLEGAL_ADDRESS),
    ("17 0000 0002 0900 0002 04 0000 0000", ILLEGAL_ADDRESS),
    ("17 0900 0002 0800 0002 04 0801 2345", ILLEGAL_ADDRESS),
    ("04 0000 0000", ILLEGAL_VALUE),
    ("04 0000 007E", ILLEGAL_VALUE),
    ("01 0000 0001", ILLEGAL_FUNCTION),
    ("0F 0000 0001 01 00", ILLEGAL_FUNCTION),
    ("63", ILLEGAL_FUNCTION),
])
def test_exceptions(coupler, plc, pdu, code):
    encoder = coupler()
    request = bytes.fromhex(pdu)
    allowed = {code, ILLEGAL_ADDRESS} if code == ILLEGAL_FUNCTION and request[0] != 0x63 else {code}
    answer = ask_raw(port_of(encoder), request)
    assert answer[0] == request[0] | 0x80 and answer[1] in allowed, answer.hex(" ")
    client = plc(encoder)
    assert client.read(OUTPUT, 2) == [0, 0]


@pytest.mark.parametrize("fallback, image", [(ZERO, 0), (FREEZE, 0x0A000123)])
def test_watchdog_and_fallback(coupler, plc, fallback, image):
    client = plc(coupler("--shaft", "90DEG"))
    in_operation(client)
    client.write(FALLBACK, [fallback])
    client.write(WATCHDOG_MS, [1000])  # longer than a busy machine keeps this process waiting
    end = time.monotonic() + 1.5
    while time.monotonic() < end:  # written often enough
        client.write(OUTPUT, split(0x0A000123))
        time.sleep(0.05)
    assert join(client.read(OUTPUT, 2)) == 0x0A000123
    assert client.position() == 0xCA000123
    time.sleep(1.3)  # each request feeds it: nothing is asked
    assert join(client.read(OUTPUT, 2)) == image
    assert client.position() == 0xCA000123  # the encoder keeps its state


def test_fallback_stops_the_ring_until_the_reset(coupler, plc):
    client = plc(coupler("--shaft", "60RPM"))
    in_operation(client)
    client.write(FALLBACK, [STOP])
    client.write(WATCHDOG_MS, [200])
    client.write(OUTPUT, [0, 0])
    time.sleep(0.6)
    assert client.read(STATUS)[0] & RUN == 0
    held = client.position()
    time.sleep(0.1)
    assert client.position() == held
    assert client.read(WATCHDOG_RESET) == [1]
    client.write(WATCHDOG_MS, [0])
    client.write(WATCHDOG_RESET, [0xBECF])
    client.write(WATCHDOG_RESET, [0xAFFE])
    deadline = time.monotonic() + PATIENCE_S
    while client.position() == held:
        assert time.monotonic() < deadline
    assert client.read(STATUS) == [RUN] and client.read(WATCHDOG_RESET) == [0]


def test_watchdog_zero_ends_the_fraba_preset(coupler, plc):
    client = plc(coupler("--shaft", "60RPM"))
    in_operation(client)
    client.write(FALLBACK, [ZERO])
    client.write(WATCHDOG_MS, [1000])  # longer than a busy machine keeps this process waiting
    client.write(OUTPUT, split(0x60000000))
    time.sleep(0.1)
    assert {client.position() for _ in range(20)} == {0}
    time.sleep(1.3)
    assert client.position() > 0  # OUT is 0 again, the position moves on


def test_garbage_is_survived(coupler, plc):
    encoder = coupler("--shaft", "90DEG")
    client = plc(encoder)
    in_operation(client)
    chance = random.Random(4711)
    request = bytes.fromhex("0001 0000 0006 01 04 0000 0002")
    pieces = [chance.randbytes(chance.randrange(1, 400)) for _ in range(40)]
    pieces += [request[:n] for n in range(1, len(request))]
    pieces += [request[:4] + length.to_bytes(2, "big") + request[6:]
               for length in (0, 1, 5, 255, 65535)]
    pieces += [b"GET / HTTP/1.0\r\n\r\n", bytes(3000), b"\xff" * 3000, request * 50]
    for piece in pieces:
        with socket.create_connection(("127.0.0.1", port_of(encoder)), PATIENCE_S) as line:
            with contextlib.suppress(OSError):
                line.sendall(piece)
    assert encoder.alive()
    assert client.position() == 0x400
    assert plc(encoder).position() == 0x400
    assert plc(encoder).read(OUTPUT, 2) == [0, 0]


def read_to_end(line: socket.socket) -> bytes:
    """Whatever comes until the other side has no more to say; a reset is an error."""
    got = b""
    while piece := line.recv(4096):
        got += piece
    return got


def test_garbage_behind_requests_costs_no_answer(coupler, plc):
    encoder = coupler("--shaft", "90DEG")
    in_operation(plc(encoder))
    numbers = range(44)
    requests = b"".join(number.to_bytes(2, "big") + bytes.fromhex("0000 0006 01 04 0000 0002")
                        for number in numbers)
    answers = b"".join(number.to_bytes(2, "big") + bytes.fromhex("0000 0007 01 04 04 0000 0400")
                       for number in numbers)
    for _ in range(20):
        with socket.create_connection(("127.0.0.1", port_of(encoder)), PATIENCE_S) as line:
            line.sendall(requests + b"\xff" * 3000)
            assert read_to_end(line) == answers
            line.sendall(requests)  # nobody listens any more
            assert line.recv(300) == b""


def is_closed(line: socket.socket) -> bool:
    """Whether the other side does not take any more either."""
    with contextlib.suppress(ConnectionError):
        for _ in range(3):
            line.sendall(b"\xff")
            time.sleep(0.05)
        return False
    return True


@pytest.mark.parametrize("more, soon", [(0, False), (1 << 20, True)])
def test_who_sends_garbage_has_a_while_to_leave(coupler, more, soon):
    encoder = coupler()
    with socket.create_connection(("127.0.0.1", port_of(encoder)), PATIENCE_S) as line:
        line.sendall(b"\xff" * 7)
        assert read_to_end(line) == b""
        with contextlib.suppress(ConnectionError):
            line.sendall(bytes(more))
        assert is_closed(line) == soon
        time.sleep(2)
        assert is_closed(line)


def test_a_silent_client_stops_nobody(coupler, plc):
    encoder = coupler("--shaft", "90DEG")
    with socket.create_connection(("127.0.0.1", port_of(encoder)), PATIENCE_S) as line:
        line.sendall(bytes.fromhex("0001 0000 0006 01"))
        client = plc(encoder)
        in_operation(client)
        assert client.position() == 0x400
        line.sendall(bytes.fromhex("04 0000 0002"))
        assert line.recv(300) == bytes.fromhex("0001 0000 0007 01 04 04 0000 0400")


def test_cycles_go_on(coupler, plc):
    client = plc(coupler("--set", "cycle=5000"))
    begin = time.monotonic()
    first = client.read(SLAVES, 16)
    time.sleep(1)
    last, seconds = client.read(SLAVES, 16), time.monotonic() - begin
    moved = [after - before for before, after in zip(first, last) if before != after]
    assert any(0.8 * 200 <= difference <= 1.05 * 200 * seconds + 1 for difference in moved), moved


def wakes(encoder) -> int:
    status = pathlib.Path(f"/proc/{encoder.pid}/status").read_text()
    return int(re.search(r"^voluntary_ctxt_switches:\s+(\d+)", status, re.M)[1])


def test_a_ring_that_nobody_needs_sleeps(coupler, plc):
    encoder = coupler("--shaft", "60RPM")
    client = plc(encoder)
    in_operation(client)
    begin = time.monotonic()
    cycles, before = client.read(SLAVES + 2, 2), wakes(encoder)
    time.sleep(2)
    assert wakes(encoder) - before < 20
    counted = join(client.read(SLAVES + 2, 2)) - join(cycles)
    assert 2000 - 100 <= counted <= 1000 * (time.monotonic() - begin) + 100


def test_it_sleeps_again_when_a_fault_has_happened_often_enough(coupler, plc):
    encoder = coupler("--shaft", "90DEG", "--control", "tcp:127.0.0.1:0")
    client = plc(encoder)
    in_operation(client)
    with Client(int(encoder.out.wait().rsplit(":", 1)[1])) as control:
        for fault, crc_errors in (("wire_damage", 3), ("wire_drop", 0), ("wire_tear", 0)):
            first = join(client.read(SLAVES + 4, 2))
            control.do(f"FAUL:SET {fault},COUN 3")
            time.sleep(0.3)
            assert control.ask(f"FAUL:ACT?;:FAUL:HAPP? {fault}") == '"";3'
            assert join(client.read(SLAVES + 4, 2)) - first == crc_errors
            before = wakes(encoder)
            time.sleep(1)
            assert wakes(encoder) - before < 20, fault
    assert client.position() == 0x400


def test_what_a_client_leaves_behind_is_done(coupler, plc, nvm):
    """Nobody is connected when the answer is due, and it is stored all the same."""
    encoder = coupler("--nvm", nvm)
    client = plc(encoder)
    in_operation(client)
    before = nvm.read_bytes()[STORED]
    client.write(OUTPUT, split(0x0A000321))
    client.client.close()
    deadline = time.monotonic() + PATIENCE_S
    while nvm.read_bytes()[STORED] == before:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    encoder.end(signal.SIGKILL)
    client = plc(coupler("--nvm", nvm))
    in_operation(client)
    assert client.position() == 0x321


# --- the command line ---------------------------------------------------------------------------

def test_list():
    lines = run("list").stdout.splitlines()
    for model in ["ocd-ib-k1", "ocd-ib-k2", K3]:
        assert any(line.split()[0] == model and "INTERBUS" in line for line in lines)


def test_map():
    ended = run("map", K3)
    assert (ended.returncode, ended.stderr) == (0, "")
    for address in ["0000", "0800", "1000", "100C", "1010", "1020", "1120", "1121", "1122", "1123",
                    "2000"]:
        assert re.search(rf"\b(0x)?{address}h?\b", ended.stdout, re.I), (address, ended.stdout)


def test_map_of_another_wire():
    run_refused(2, "map", "s3684-rs485")
    run_refused(2, "map")


@pytest.mark.parametrize("address", ["127.0.0.1", "127.0.0.1:port", "127.0.0.1:70000", ":", ""])
def test_bad_addresses(address):
    line = run_refused(2, "run", K3, "--modbus", address)
    assert "--modbus" in line or "HOST:PORT" in line


def test_port_in_use(coupler):
    port = port_of(coupler())
    line = run_refused(1, "run", K3, "--modbus", f"127.0.0.1:{port}")
    assert str(port) in line


def test_other_wires_are_refused():
    for arguments in [["run", K3, "--pty"], ["run", "s3684-rs485", "--modbus", "127.0.0.1:5020"]]:
        run_refused(2, *arguments)


@pytest.mark.parametrize("signal_number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_it(coupler, plc, signal_number):
    encoder = coupler()
    in_operation(plc(encoder))
    assert encoder.end(signal_number) == 0
    assert encoder.out.so_far() == []
