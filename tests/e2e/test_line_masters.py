# SPDX-License-Identifier: MIT
"""The wire: settings, masters that misbehave, terminals that vanish."""
import contextlib
import os
import random
import select
import termios
import time

import pytest
import serial

from hiperface_master import CHARACTER_BITS, Master, NoReply, UartSetting, frame
from rig import MULTITURN, PATIENCE_S, assert_one_line, assert_silent, run_refused

READ_POSITION = frame(0x40, 0x42)
READ_IDENTITY = frame(0x40, 0x56)
IDENTITY_CHARACTERS = 40
SETTING_19200 = UartSetting(19200, "E", 44, False).encode()
SETTING_38400_SHORT = UartSetting(38400, "E", 11, False).encode()


def test_master_comes_and_goes(start):
    encoder = start()
    for _ in range(3):
        master = Master(encoder.path)
        assert master.read_position() == 0
        master.close()


def read_and_wait(port: serial.Serial):
    """Read the position, and wait until the encoder has taken CLOCAL from its pty: only then can a client ask for parity
    again (platform/linux/wire/pty.c). A busy machine takes longer for that than the pause behind a reply."""
    port.write(READ_POSITION)
    assert port.read(7).hex() == "40420000000002"
    deadline = time.monotonic() + PATIENCE_S
    while termios.tcgetattr(port.fd)[2] & termios.CLOCAL:
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_every_opening_can_ask_for_8e1(start):
    encoder = start()
    for _ in range(3):
        with serial.Serial(encoder.path, 9600, parity=serial.PARITY_EVEN, timeout=2) as port:
            for timeout_s in (3, 2):
                read_and_wait(port)
                port.timeout = timeout_s  # sets the line again, with nothing new but the parity
            read_and_wait(port)


def test_master_leaves_in_the_middle_of_a_request(start):
    encoder = start()
    master = Master(encoder.path)
    master.port.write(READ_POSITION[:2])
    master.close()
    master = encoder.master()
    time.sleep(0.1)  # the pause that ends a frame
    assert master.read_position() == 0


def test_two_side_by_side(start):
    masters = [start("--shaft", f"{turns}REV").master() for turns in (1, 2)]
    for _ in range(5):
        for turns, master in enumerate(masters, 1):
            assert master.read_position() == turns * 65536
    masters[0].set_position(5)
    assert [master.read_position() for master in masters] == [5, 2 * 65536]


def test_garbage(start):
    encoder = start()
    master = encoder.master()
    noise = random.Random(5)
    end = time.monotonic() + 3
    while time.monotonic() < end:
        count = noise.randrange(1, 64)
        master.port.write(noise.randbytes(count))
        time.sleep(master.bits_s(count * CHARACTER_BITS) + noise.choice([0, 0.002, 0.02]))
    # The noise may have carried a valid command: only the reply counts, not its data. A busy machine
    # may still be hearing the noise.
    for _ in range(5):
        master.drain()
        with contextlib.suppress(NoReply):
            master.read_status()
            break
    else:
        raise AssertionError("no reply behind the noise")
    assert encoder.alive()


@pytest.mark.parametrize("pace, asked, reply_bytes, interval_s", [
    ([], READ_POSITION, 7, 0.005),
    (["--set", "pace=0"], READ_IDENTITY, IDENTITY_CHARACTERS, 0.003),
], ids=["paced", "at once"])
def test_master_never_reads(start, pace, asked, reply_bytes, interval_s):
    encoder = start(*pace)
    master = encoder.master()
    master.configure_uart(SETTING_38400_SHORT)
    master.reset()
    master.use_uart(SETTING_38400_SHORT)
    assert len(master.identity().serial_number) == 9
    due = time.monotonic()
    for _ in range(2000):
        time.sleep(max(0.0, due - time.monotonic()))
        master.port.write(asked)
        due += interval_s
    assert encoder.alive()
    master.drain()
    for _ in range(3):
        assert master.type_label().uart == SETTING_38400_SHORT
        master.send(asked)
        assert len(master.receive(reply_bytes, 2)) == reply_bytes
        assert master.receive(1, 0.1) == b""


def test_wrong_baud_rate(start):
    encoder = start()
    master = encoder.master(baudrate=19200)
    assert_silent(master)
    assert_one_line(encoder, "9600", "8E1")
    for _ in range(3):
        assert_silent(master)
    assert encoder.errors.so_far() == []
    master.use_uart(0xE4)
    assert master.read_position() == 0


def test_any_line_setting(start):
    encoder = start("--set", "line=any")
    for baudrate in (19200, 600, 115200, 9600):
        with Master(encoder.path, baudrate=baudrate) as master:
            assert master.read_position() == 0


def test_more_than_the_line_can_carry(start):
    """What comes in faster than 9600 Bd is lost, and over soon."""
    encoder = start()
    master = encoder.master()
    for _ in range(20):
        master.port.write(bytes(4000))
    time.sleep(0.6)
    master.drain()
    assert master.read_position() == 0


def test_baud_rate_changes_after_reset(start):
    encoder = start()
    master = encoder.master()
    master.configure_uart(SETTING_19200)
    assert master.type_label().uart == SETTING_19200  # stored, not in force
    master.reset()
    assert_silent(master)
    assert_one_line(encoder, "19200", "8E1")
    master.use_uart(SETTING_19200)
    assert master.read_position() == 0
    master.configure_uart(0xE4)
    master.reset()
    master.use_uart(0xE4)
    assert master.type_label().uart == 0xE4


def store_19200(start, nvm):
    encoder = start("--nvm", nvm)
    encoder.master().configure_uart(SETTING_19200)
    assert encoder.end() == 0


def test_frame_in_the_window_keeps_the_factory_setting(start, nvm):
    store_19200(start, nvm)
    encoder = start("--nvm", nvm, "--set", "init_ms=2000")
    master = encoder.master()
    assert master.read_position() == 0
    time.sleep(max(0.0, encoder.ready + 2.2 - time.monotonic()))
    assert master.type_label().uart == SETTING_19200
    assert master.read_position() == 0


def test_silence_in_the_window_switches(start, nvm):
    store_19200(start, nvm)
    encoder = start("--nvm", nvm, "--set", "init_ms=2000")
    time.sleep(max(0.0, encoder.ready + 2.2 - time.monotonic()))
    master = encoder.master()
    assert_silent(master)
    assert_one_line(encoder, "19200", "8E1")
    master.use_uart(SETTING_19200)
    assert master.read_position() == 0


class Tty:
    """A terminal for --tty; the test is at its other end."""

    def __init__(self, path):
        self.path = str(path)  # a link, as udev makes them: it goes when the terminal goes
        self.far = self.near = None
        self.appear()

    def appear(self):
        self.far, self.near = os.openpty()
        os.symlink(os.ttyname(self.near), self.path)

    def vanish(self):
        if self.far is not None:
            os.unlink(self.path)
            os.close(self.near)
            os.close(self.far)
            self.far = self.near = None

    def ask(self, request: bytes, length: int, timeout_s: float = 2) -> bytes:
        time.sleep(0.05)  # a reply's time on the line and the pause behind it
        while select.select([self.far], [], [], 0)[0]:
            os.read(self.far, 4096)
        os.write(self.far, request)
        reply, deadline = b"", time.monotonic() + timeout_s
        while len(reply) < length and time.monotonic() < deadline:
            if select.select([self.far], [], [], 0.05)[0]:
                reply += os.read(self.far, 4096)
        return reply

    def baudrate(self) -> int:
        return termios.tcgetattr(self.far)[5]


@pytest.fixture
def tty(tmp_path):
    terminal = Tty(tmp_path / "ttyUSB0")
    yield terminal
    terminal.vanish()


def test_tty(tty, start):
    encoder = start(wire=["--tty", tty.path])
    assert encoder.ready_line == f"ready {MULTITURN} tty:{tty.path}"
    attributes = termios.tcgetattr(tty.far)
    assert not attributes[3] & (termios.ICANON | termios.ECHO | termios.ISIG)
    assert not attributes[1] & termios.OPOST
    assert tty.baudrate() == termios.B9600
    # 0Ah, 0Dh, 11h, 13h: bytes that a terminal in another mode would change or swallow.
    position = bytes.fromhex("0A 0D 11 13")
    assert tty.ask(frame(0x40, 0x43, position + b"\x55"), 3).hex() == "404303"
    assert tty.ask(frame(0x40, 0x42), 7) == frame(0x40, 0x42, position)


def test_tty_follows_the_baud_rate(tty, start):
    start(wire=["--tty", tty.path])
    assert tty.ask(frame(0x40, 0x57, bytes([SETTING_19200, 0x55])), 4) == \
        frame(0x40, 0x57, bytes([SETTING_19200]))
    assert tty.baudrate() == termios.B9600
    assert tty.ask(frame(0x40, 0x53), 1, 0.05) == b""
    deadline = time.monotonic() + PATIENCE_S
    while tty.baudrate() != termios.B19200 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert tty.baudrate() == termios.B19200


def test_tty_vanishes(tty, start):
    encoder = start(wire=["--tty", tty.path], start_new_session=True)
    assert len(tty.ask(READ_POSITION, 7)) == 7
    tty.vanish()
    assert_one_line(encoder, tty.path)
    before = encoder.cpu_ticks()
    time.sleep(1.5)
    assert encoder.alive()
    assert encoder.cpu_ticks() - before < 3
    assert encoder.errors.so_far() == []

    tty.appear()
    deadline = time.monotonic() + PATIENCE_S
    while tty.ask(READ_POSITION, 7, 0.5) != frame(0x40, 0x42, bytes(4)):
        assert time.monotonic() < deadline
    encoder.errors.so_far()  # it may say that the terminal is back
    assert encoder.end() == 0


def test_tty_must_be_a_terminal(tmp_path):
    ordinary = tmp_path / "file"
    ordinary.write_text("")
    assert str(ordinary) in run_refused(1, "run", MULTITURN, "--tty", ordinary)
