# SPDX-License-Identifier: MIT
"""The encoder as a process on a CAN bus, and a client that knows nothing but its EDS file.

RIG_CAN says which wire: `slcan` (default; a pty, python-can's slcan interface) or the name of a
SocketCAN interface such as `vcan0`. Every wait in here has an end.
"""
import contextlib
import os
import re
import signal
import socket
import sys
import threading
import time
from collections import deque
from pathlib import Path

import can
import canopen
import canopen.emcy

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from rig import (PATIENCE_S, PROGRAM, Client, Encoder, Lines, assert_one_line,  # noqa: E402
                 assert_takes, free_port, run)

__all__ = ["PATIENCE_S", "PROGRAM", "WIRE", "Client", "Encoder", "Lines", "LOAD", "MODEL", "Rig",
           "SAVE", "assert_one_line", "assert_takes", "free_port", "on_slcan", "run", "state_of", "wait_for_leds"]

WIRE = os.environ.get("RIG_CAN", "slcan")
MODEL = "f3668"
NODE_ID = 63
BIT_RATE = 250_000
SAVE, LOAD = b"save", b"load"
ATTEMPTS = 5  # to measure a time, on a machine that may stand still for a moment


def on_slcan() -> bool:
    return WIRE == "slcan"


class Tap(can.Listener):
    """Every frame on the bus, in order. Where others of the same notifier get it later, wait() gives a frame that
    they have, too."""

    def __init__(self):
        self.frames = deque()
        self.under_way = None  # the frame that others do not have yet
        self.others = False
        self.passed = deque(maxlen=12)  # the last ones that nobody waited for
        self.arrived = threading.Condition()

    def on_message_received(self, msg):
        with self.arrived:
            self.frames.append(msg)
            self.under_way = msg if self.others else None
            self.arrived.notify_all()

    def behind_others(self, _):
        """A listener for the end of the notifier's list."""
        with self.arrived:
            self.under_way = None
            self.arrived.notify_all()

    def forget(self):
        with self.arrived:
            self.frames.clear()

    def _take(self, can_id):
        while self.frames and self.frames[0] is not self.under_way:
            frame = self.frames.popleft()
            if frame.arbitration_id == can_id and not frame.is_remote_frame:
                return frame
            self.passed.append(f"{frame.arbitration_id:03X}#{frame.data.hex()}")
        return None

    def wait(self, can_id: int, timeout_s: float = PATIENCE_S) -> can.Message:
        """The next data frame with this CAN-ID; what came before it is forgotten."""
        deadline = time.monotonic() + timeout_s
        with self.arrived:
            while True:
                frame = self._take(can_id)
                if frame is not None:
                    return frame
                left = deadline - time.monotonic()
                if left <= 0 or not self.arrived.wait(left):
                    raise AssertionError(f"no frame {can_id:03X} within {timeout_s} s, the last "
                                         f"others were {', '.join(self.passed) or 'none'}")

    def data(self, can_id: int, timeout_s: float = PATIENCE_S) -> bytes:
        return bytes(self.wait(can_id, timeout_s).data)

    def so_far(self, can_id: int) -> list:
        """Data of the frames with this CAN-ID that have come; all others are forgotten."""
        with self.arrived:
            found = [bytes(frame.data) for frame in self.frames
                     if frame.arbitration_id == can_id and not frame.is_remote_frame]
            self.frames.clear()
        return found

    def has_period(self, can_id: int, low_s: float, high_s: float, count: int = 10,
                   cause=lambda: None):
        """The mean time between this many frames, each time behind their cause. A machine that stands
        still makes it a wrong one at times, not again and again."""
        found = []
        for _ in range(ATTEMPTS):
            cause()
            stamps = [self.wait(can_id).timestamp for _ in range(count + 1)]
            found.append((stamps[-1] - stamps[0]) / count)
            if low_s < found[-1] < high_s:
                return
        raise AssertionError(f"{can_id:03X} comes every {found} s, not {low_s} to {high_s}")


def state_of(control: Client) -> dict:
    """What STATe? says, by key."""
    return dict(part.split("=", 1) for part in control.ask("STAT?").split(","))


def wait_for_leds(control: Client, leds: str):
    """Until STATe? says these patterns, e.g. "bus:off/err:blink"."""
    deadline = time.monotonic() + PATIENCE_S
    while (seen := state_of(control)["leds"]) != leds:
        assert time.monotonic() < deadline, (seen, leds)
        time.sleep(0.01)


def open_bus(channel: str, bit_rate: int) -> can.BusABC:
    if on_slcan():
        return can.Bus(interface="slcan", channel=channel, bitrate=bit_rate, sleep_after_open=0)
    bus = can.Bus(interface="socketcan", channel=WIRE)
    bus.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    return bus


class Rig:
    """One `drehgeber run`, and a client on its bus."""

    def __init__(self, link: str, eds: Path, *arguments, bit_rate=BIT_RATE, node_id=NODE_ID,
                 quiet=True, client=True, model=MODEL):
        self.eds = eds
        self.link = link
        self.network = None
        self.tap = Tap()
        if client and not on_slcan():
            self.connect(bit_rate)
        wire = [f"--slcan={link}"] if on_slcan() else ["--can", WIRE]
        self.encoder = Encoder([model, *wire, *(["--quiet"] if quiet else []), *arguments])
        ready = re.fullmatch(rf"ready {model} (slcan|can):(\S+?)(?:/(\d+))?", self.encoder.ready_line)
        assert ready, self.encoder.ready_line
        assert ready[2].startswith("/dev/pts/" if on_slcan() else WIRE)
        self.said_node_id = int(ready[3]) if ready[3] else None
        if client and on_slcan():
            self.connect(bit_rate)
        if client:
            self.use(node_id)

    def connect(self, bit_rate: int = BIT_RATE):
        """Open the bus, again if it is open: a new client."""
        self.disconnect()
        self.network = canopen.Network(open_bus(self.link, bit_rate))
        self.network.NOTIFIER_CYCLE = 0.05  # disconnecting waits for it
        # Before canopen's own: what that has, the tap has already, and can forget. And behind it: what was waited for
        # at the tap, canopen knows.
        self.tap.others, self.tap.under_way = True, None
        self.network.listeners = [self.tap, *self.network.listeners, self.tap.behind_others]
        self.network.connect()
        self.network.lss.RESPONSE_TIMEOUT = 2.0

    def use(self, node_id: int):
        """Talk to this node-ID."""
        self.node_id = node_id
        self.node = self.network.add_node(node_id, str(self.eds))
        self.sdo = self.node.sdo
        self.sdo.RESPONSE_TIMEOUT = 5.0
        self.sdo.MAX_RETRIES = 1  # it means attempts
        self.nmt = self.node.nmt

    def disconnect(self):
        if self.network is not None:
            self.network.disconnect()
            self.network = None

    def kill(self, last_frame: can.Message = None, after_s: float = 0.0):
        """As a power cut, so long after a last frame. A reader would stumble over the lost pty."""
        self.network.notifier.stop()
        if last_frame is not None:
            self.network.bus.send(last_frame)
        time.sleep(after_s)
        self.encoder.end(signal.SIGKILL)
        with contextlib.suppress(can.CanError):
            self.network.bus.shutdown()
        self.network = None

    def send(self, can_id: int, data: bytes = b""):
        self.network.send_message(can_id, data)

    def request(self, can_id: int):
        """A remote frame."""
        self.network.send_message(can_id, b"", remote=True)

    def barrier(self):
        """Everything the encoder sent before this has arrived."""
        self.sdo.upload(0x1000, 0)

    def read(self, index: int, sub: int = 0) -> int:
        return int.from_bytes(self.sdo.upload(index, sub), "little")

    def write(self, index: int, sub: int, value: int, size: int):
        self.sdo.download(index, sub, value.to_bytes(size, "little"))

    def start(self):
        """Operational; what is sent on entering it is not forgotten."""
        self.nmt.send_command(0x01)
        self.barrier()

    def reset(self, command: int = 0x81, node_id: int = None):
        """Reset the node, by default reset node, and wait for its boot-up."""
        self.tap.forget()
        self.nmt.send_command(command)
        assert self.tap.data(0x700 + (node_id or self.node_id)) == b"\x00"

    def emergency(self, code: int) -> canopen.emcy.EmcyError:
        """The next EMCY with this code, as canopen understood it."""
        while int.from_bytes(self.tap.data(0x80 + self.node_id)[:2], "little") != code:
            pass
        return [error for error in self.node.emcy.log if error.code == code][-1]

    def guard(self) -> int:
        self.tap.forget()
        self.request(0x700 + self.node_id)
        return self.tap.data(0x700 + self.node_id)[0]

    def clean_up(self) -> list:
        """What it said on stderr that no test asked for."""
        self.disconnect()
        return self.encoder.clean_up()
