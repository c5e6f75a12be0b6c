#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Asks an encoder that runs as Arm code in QEMU for its position, with pyserial.

usage: qemu.py IMAGE
"""

import socket
import subprocess
import sys
import time

import serial

REQUEST = bytes([0x40, 0x42, 0x02])
REPLY = bytes([0x40, 0x42, 0x00, 0x00, 0x40, 0x00, 0x42])  # a quarter of 65536 steps
PATIENCE = 30


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def connect(port, until):
    while True:
        try:
            return serial.serial_for_url(f"socket://127.0.0.1:{port}", timeout=5)
        except serial.SerialException:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    port = free_port()
    # It waits for us before it starts.
    machine = subprocess.Popen(["qemu-system-arm", "-M", "mps2-an385", "-kernel", sys.argv[1], "-display", "none",
                                "-monitor", "none", "-serial", f"tcp:127.0.0.1:{port},server=on,wait=on"])
    try:
        with connect(port, time.monotonic() + PATIENCE) as line:
            answers = []
            for _ in range(10):
                line.write(REQUEST)
                answers.append(line.read(len(REPLY)))
    finally:
        machine.kill()
        machine.wait()
    good = answers.count(REPLY)
    print(f"{good} of {len(answers)} answers are right, the last one is {answers[-1].hex(' ')}")
    # A machine that stands still lets a request fall apart, which is answered with an error.
    sys.exit(0 if good >= 8 else 1)


main()
