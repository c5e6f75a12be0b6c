# SPDX-License-Identifier: MIT
"""The wire in time: replies, transactions, pauses. Alone on the machine, as it is about milliseconds."""
import time

import pytest

from hiperface_master import CHARACTER_BITS, FieldStatus, Master, UartSetting, frame
from rig import Client, assert_takes

READ_POSITION = frame(0x40, 0x42)
READ_IDENTITY = frame(0x40, 0x56)
IDENTITY_CHARACTERS = 40
IDENTITY_S = IDENTITY_CHARACTERS * CHARACTER_BITS / 9600
REACTION_S = 0.001
MARGIN_S = 0.010 - REACTION_S  # 10 ms are the manual's maximum behind 42h; here for what a busy machine takes, too


def test_requests_in_pieces(start):
    master = start().master()
    replies = []
    while (good := bytes.fromhex("40 42 00 00 00 00 02")) not in replies:
        assert len(replies) < 10, replies  # a machine that stands still makes a pause that ends a frame
        master.drain()
        for byte in READ_POSITION:
            master.port.write(bytes([byte]))
            time.sleep(0.001)  # at most one character time, below that pause
        replies.append(master.receive(7, 2))


@pytest.fixture
def timed(start, tmp_path):
    """Start an encoder; its master, and what its rig counts of missed deadlines."""
    clients = []

    def begin(*arguments):
        address = f"unix:{tmp_path}/control.sock"
        encoder = start("--control", address, *arguments)
        assert encoder.out.wait().startswith("control ")
        clients.append(Client(address))
        return encoder.master(), clients[-1].late

    yield begin
    for client in clients:
        client.close()


def reply_times(master: Master) -> tuple[float, float]:
    """Seconds from the request to the end of a 40 character reply, and from its first read on."""
    master.wait_for_line()
    sent = time.monotonic()
    master.send(READ_IDENTITY)
    first = master.receive(1, 2)
    began = time.monotonic()
    assert len(first + master.receive(IDENTITY_CHARACTERS - 1, 2)) == IDENTITY_CHARACTERS
    ended = time.monotonic()
    return ended - sent, ended - began


def test_reply_takes_its_time(timed):
    """It comes character by character, not as a whole at its end."""
    master, late = timed()
    spread = []

    def total():
        times = reply_times(master)
        spread.append(times[1])
        return times[0]

    assert_takes(transaction_s(3, IDENTITY_CHARACTERS), MARGIN_S, total, late, 20)
    assert sorted(spread)[len(spread) // 2] >= IDENTITY_S - MARGIN_S


def test_reply_without_pace(start):
    master = start("--set", "pace=0").master()
    assert min(reply_times(master)[0] for _ in range(10)) < IDENTITY_S


def transaction_s(request: int, reply: int, character_bits: int = CHARACTER_BITS) -> float:
    """Characters of both, the silence of 44 bits that ends a request (5.1.1.1), and 1 ms to react."""
    return ((request + reply) * character_bits + 44) / 9600 + REACTION_S


def round_trip(master: Master, request: bytes, reply_bytes: int) -> float:
    """Seconds from writing a request to the end of its reply."""
    master.wait_for_line()
    begun = time.monotonic()
    master.send(request)
    assert len(master.receive(reply_bytes, 2)) == reply_bytes
    return time.monotonic() - begun


def test_a_transaction_takes_its_time(timed):
    """17.0 ms; 26.0 is what the manual allows."""
    master, late = timed()
    assert_takes(transaction_s(3, 7), MARGIN_S, lambda: round_trip(master, READ_POSITION, 7), late)


def test_a_long_request_takes_its_time(timed):
    """167.1 ms, of which a character is 1.1: each is waited for. Ten times only, so that one moment in which the
    machine stands still is a good part of them: 30 ms for that."""
    master, late = timed()
    master.create_field(0, FieldStatus(128, code_enabled=False))
    request = frame(0x40, 0x4B, bytes([0, 0, 128, 0x55]) + bytes(128))
    assert_takes(transaction_s(135, 6), 0.03, lambda: round_trip(master, request, 6), late, 10)


def test_a_transaction_without_parity_is_shorter(timed):
    """10 bits a character; the timeout is what it is. 1 ms is little for a busy machine: the shortest one."""
    master, _ = timed()
    setting = UartSetting(9600, "N", 44, False).encode()
    master.configure_uart(setting)
    master.reset()
    shortest = min(round_trip(master, READ_POSITION, 7) for _ in range(100))
    assert transaction_s(3, 7, 10) <= shortest < transaction_s(3, 7)


def test_a_transaction_at_once(timed):
    """The silence and the time to react are left."""
    master, late = timed("--set", "pace=0")
    assert_takes(transaction_s(0, 0), MARGIN_S, lambda: round_trip(master, READ_POSITION, 7), late)


def test_deaf_after_reset(start):
    master = start().master()
    for _ in range(5):
        master.send(frame(0x40, 0x53))
        sent = time.monotonic()
        heard = master.receive(1, 0.04)
        master.port.write(READ_POSITION)
        in_time = time.monotonic() - sent < 0.09
        heard += master.receive(1, 0.2)
        if in_time:
            assert heard == b""
            break
    else:
        raise AssertionError("the machine is too busy to be in time")
    assert master.read_position() == 0


def test_idle_costs_nothing(start):
    never_opened, left_open, closed_again = (start() for _ in range(3))
    left_open.master().read_position()
    with Master(closed_again.path) as master:
        master.read_position()
    encoders = [never_opened, left_open, closed_again]
    time.sleep(0.3)  # start-up windows end
    before = [encoder.cpu_ticks() for encoder in encoders]
    time.sleep(2)
    assert all(encoder.cpu_ticks() - ticks < 2 for encoder, ticks in zip(encoders, before))
