#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Asks an encoder that runs as Arm code in QEMU for its position, with pyserial.

usage: qemu.py IMAGE
"""

import re
import socket
import subprocess
import sys
import time

import serial

REQUEST = bytes([0x40, 0x42, 0x02])
REPLY = bytes([0x40, 0x42, 0x00, 0x00, 0x40, 0x00, 0x42])  # a quarter of 65536 steps
# All that comes back: replies, and errors (50h) to requests in pieces, as a machine that stands still takes them apart.
RIGHT = re.compile(rb"(?:" + re.escape(REPLY) + rb"|\x40\x50..)*", re.S)
WANTED = 10
ASKED_MOST = 40
PATIENCE = 30


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def connect(port, until):
    while True:
        try:
            return serial.serial_for_url(f"socket://127.0.0.1:{port}", timeout=1)
        except serial.SerialException:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    port = free_port()
    # It waits for us before it starts. An instruction takes 1 ns: while this machine is busy, its time stands still.
    machine = subprocess.Popen(["qemu-system-arm", "-M", "mps2-an385", "-icount", "shift=0", "-kernel", sys.argv[1],
                                "-display", "none", "-monitor", "none",
                                "-serial", f"tcp:127.0.0.1:{port},server=on,wait=on"])
    try:
        with connect(port, time.monotonic() + PATIENCE) as line:
            came, asked = b"", 0
            while came.count(REPLY) < WANTED and asked < ASKED_MOST:
                line.write(REQUEST)
                asked += 1
                came += line.read(len(REPLY))
    finally:
        machine.kill()
        machine.wait()
    good = came.count(REPLY)
    right = RIGHT.fullmatch(came) is not None
    print(f"{good} replies to {asked} requests, {'nothing' if right else 'something'} wrong among them: {came.hex(' ')}")
    sys.exit(0 if good == WANTED and right else 1)


main()
