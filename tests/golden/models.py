# SPDX-License-Identifier: MIT
"""Writes a memory image of each encoder in models/, whose models are files, as this build stores it: over the encoder's
wire, in virtual time, with values that are not the delivered ones. Once for each release, see README.md.

usage: models.py FOLDER    with the Python package of this build
"""

import sys
from functools import reduce
from operator import xor
from pathlib import Path

from drehgeber import Encoder

MODELS = Path(__file__).resolve().parent / "models"
BYTES_A_LINE = 30
# Commands without address and sum: access codes, a data field with a text in it, address 52h, and the position.
DRIVE = ("4F 01 55 21", "4F 02 55 32", "4D 00 D9 21", "4B 00 05 05 21 68 65 6C 6C 6F", "43 00 00 DE F0 55")
# Steps, revolutions, their release, direction, a preset and its release.
K3 = (0x02000E10, 0x04000002, 0x80000000, 0x06000004, 0x080003E8, 0x80000000)
K3_CYCLES = 5
# Index, size and value.
ACME = ((0x2000, 1, 42), (0x6000, 2, 4), (0x6001, 4, 360), (0x6003, 4, 99), (0x1017, 2, 500))
SAVE = 0x65766173
NODE = 5


def write_la26(encoder: Encoder) -> None:
    """User bank 7."""
    bank = bytes((3 * i + 1) % 256 for i in range(64))
    assert encoder.biss.write_register(0x40, b"\x07") == 1
    assert encoder.biss.write_register(0x00, bank) == len(bank)


def write_drive(encoder: Encoder) -> None:
    for command in DRIVE:
        frame = b"\x40" + bytes.fromhex(command)
        answer = encoder.request(frame + bytes([reduce(xor, frame)]))
        assert answer[1] != 0x50, f"{command}: {answer.hex(' ')}"


def write_k3(encoder: Encoder) -> None:
    for word in K3:
        for _ in range(K3_CYCLES):
            answer = encoder.ring.cycle((word >> 16, word & 0xFFFF))
            encoder.clock.advance(0.001)
        assert answer[0] >> 8 not in (0x82, 0x84, 0x86), f"{word:08X}: {answer[0]:04X}{answer[1]:04X}"
        encoder.ring.cycle((0, 0))


def download(encoder: Encoder, index: int, sub: int, size: int, value: int) -> None:
    """An SDO."""
    data = bytes([0x23 | 4 - size << 2, index & 0xFF, index >> 8, sub]) + value.to_bytes(4, "little")
    encoder.can.send(0x600 + NODE, data)
    frames = iter(lambda: encoder.can.wait(0.5), None)
    answer = next(frame.data for frame in frames if frame.id == 0x580 + NODE)
    assert answer[0] == 0x60, f"{index:04X}h: {answer.hex(' ')}"


def write_acme(encoder: Encoder) -> None:
    encoder.clock.advance(1)
    for index, size, value in ACME:
        download(encoder, index, 0, size, value)
    download(encoder, 0x1010, 1, 4, SAVE)
    encoder.clock.advance(1)


WRITERS = {"la26.ini": write_la26, "drive.ini": write_drive, "k3.ini": write_k3, "acme.eds": write_acme}


def main() -> None:
    """An image each, as `xxd -p` writes it."""
    folder = Path(sys.argv[1])
    for name, write in WRITERS.items():
        settings = {"node": NODE} if name.endswith(".eds") else {}
        encoder = Encoder(MODELS / name, **settings)
        encoder.clock.advance(1)
        write(encoder)
        encoder.clock.advance(1)
        encoder.power(False)
        image = encoder.memory
        lines = [image[i:i + BYTES_A_LINE].hex() + "\n" for i in range(0, len(image), BYTES_A_LINE)]
        (folder / f"{Path(name).stem}.hex").write_text("".join(lines), encoding="ascii")
        print(f"{name}: {len(image)} bytes")


main()
