# SPDX-License-Identifier: MIT
"""What the Python package's encoders answer: those of the playground, on a shaft with 60 rpm, 1.25 s after it began.

usage: handle.py MODEL; prints a line of hexadecimal digits"""

import sys

import drehgeber

MOMENT = 1.25


def rs485(encoder: drehgeber.Encoder) -> bytes:
    return encoder.request(bytes.fromhex("404202"))


def canopen(encoder: drehgeber.Encoder) -> bytes:
    port = encoder.can
    port.send(0x600 + int(encoder.get("node")), bytes.fromhex("4004600000000000"))
    frame = port.recv()
    assert frame is not None
    return frame.data


def biss(encoder: drehgeber.Encoder) -> bytes:
    frame = encoder.biss.frame()
    return frame.bits.to_bytes((frame.width + 7) // 8, "big")


def interbus(encoder: drehgeber.Encoder) -> bytes:
    return b"".join(word.to_bytes(2, "big") for word in encoder.ring.cycle())


ASK = {"s3684-rs485": rs485, "f3668": canopen, "s3684-biss": biss, "ocd-ib-k3": interbus}


def main() -> None:
    model = sys.argv[1]
    encoder = drehgeber.Encoder(model)
    encoder.shaft.velocity = 60
    encoder.clock.advance(MOMENT)
    print(ASK[model](encoder).hex())


main()
