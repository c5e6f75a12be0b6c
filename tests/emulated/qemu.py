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
# What came of a request in pieces: an error (50h), or nothing. A machine that stands still takes one apart.
TORN = re.compile(rb"(?:\x40\x50..)*", re.S)
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
    # It waits for us before it starts.
    machine = subprocess.Popen(["qemu-system-arm", "-M", "mps2-an385", "-kernel", sys.argv[1], "-display", "none",
                                "-monitor", "none", "-serial", f"tcp:127.0.0.1:{port},server=on,wait=on"])
    try:
        with connect(port, time.monotonic() + PATIENCE) as line:
            answers = []
            while answers.count(REPLY) < WANTED and len(answers) < ASKED_MOST:
                line.write(REQUEST)
                answers.append(line.read(len(REPLY)))
    finally:
        machine.kill()
        machine.wait()
    good = answers.count(REPLY)
    wrong = [answer.hex(" ") for answer in answers if answer != REPLY and not TORN.fullmatch(answer)]
    print(f"{good} of {len(answers)} answers are right, these are wrong: {wrong}")
    sys.exit(0 if good == WANTED and not wrong else 1)


main()
