# SPDX-License-Identifier: MIT
"""Files that earlier releases have written are taken by the program of today."""
import signal
import time

import pytest

from hiperface_master import Master
from rig import REPOSITORY, run

GOLDEN = REPOSITORY / "tests/golden"
# Encoders whose models are files: la26.ini and so on.
MODELS = {path.stem: path for path in (GOLDEN / "models").iterdir()}
IMAGES = {
    "s3674-rs485": ["--pty"],
    "s3684-rs485": ["--pty"],
    "s3674-biss": ["--sim"],
    "s3684-biss": ["--sim"],
    "f3658": ["--slcan"],
    "f3668": ["--slcan"],
    "f3668-16": ["--slcan", "--set", "mt_bits=16"],
    "ocd-ib-k3": ["--modbus", "127.0.0.1:0"],
    "la26": ["--sim"],
    "drive": ["--pty"],
    "k3": ["--modbus", "127.0.0.1:0"],
    "acme": ["--slcan", "--node", "5"],
}


def file_of(image, nvm):
    nvm.write_bytes(bytes.fromhex(image.read_text()))
    return nvm


@pytest.mark.parametrize("image", sorted(GOLDEN.glob("*/*.hex")), ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_image_is_taken(start, nvm, image):
    kind = image.stem.removesuffix("-crossed")
    wire = IMAGES[kind]
    model = MODELS.get(kind, kind.removesuffix("-16"))
    encoder = start("--nvm", file_of(image, nvm), "--quiet", model=model, wire=wire)
    assert encoder.end(signal.SIGTERM) == 0
    start("--nvm", nvm, "--quiet", model=model, wire=wire)


def test_what_is_in_two_of_them(start, nvm):
    encoder = start("--nvm", file_of(GOLDEN / "0.1.0/s3684-rs485.hex", nvm), "--quiet")
    time.sleep(0.2)  # the start-up window is at 9600 Bd
    with Master(encoder.path, address=0x52, baudrate=19200) as master:
        assert master.read_position() == 0x0ABCDEF0
    file_of(GOLDEN / "0.1.0/s3684-biss.hex", nvm.parent / "biss.nvm")
    said = run("biss", "s3684-biss", "registers", "7:0", "4", "--nvm", nvm.parent / "biss.nvm")
    assert (said.returncode, said.stdout) == (0, "01 04 07 0A\n")


def test_what_is_in_those_of_files(start, nvm):
    encoder = start("--nvm", file_of(GOLDEN / "1.0.0/drive.hex", nvm), "--quiet", model=MODELS["drive"])
    with Master(encoder.path) as master:
        assert master.read_position() == 0xDEF0
    scale = file_of(GOLDEN / "1.0.0/la26.hex", nvm.parent / "scale.nvm")
    said = run("biss", MODELS["la26"], "registers", "7:0", "4", "--nvm", scale)
    assert (said.returncode, said.stdout) == (0, "01 04 07 0A\n")
