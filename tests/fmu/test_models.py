# SPDX-License-Identifier: MIT
"""FMUs of encoders that are texts or EDS files, in an importer that is not ours (fmpy)."""

import math
import os
import pathlib
import struct
import subprocess
import zipfile
from collections.abc import Callable
from typing import Any

import pytest
from conftest import DREHGEBER, Fmu, Slave, Slave2
from fmpy.validation import validate_fmu  # type: ignore[import-untyped]
from test_fmu import frame, frames

Make = Callable[..., Fmu]
QUARTER = math.pi / 2
TEXTS = """[model la26]
base = s3674-biss
st = 26
lc = 0
title = linear, 26 bit
[model slow]
base = la26
inherit = registers
busy_us = 20.5
[model word40]
base = ssi-25
mt = 16
st = 20
code = binary
error_bit = high
parity = even
frame = 0 P E Y 1
"""
ACME = """[DeviceInfo]
ProductName=Acme 3600
[DeviceComissioning]
NodeID=0x21
[1000]
DataType=7
DefaultValue=0x00020196
[2003]
DataType=5
AccessType=rw
DefaultValue=0xA5
[6004]
DataType=7
[6501]
DataType=7
DefaultValue=3600
[6502]
DataType=6
DefaultValue=100
"""
RIG = """[shaft s]
[bus can]
wire = slcan
address = cell
[encoder first]
model = acme.eds
bus = can
node = 5
[encoder second]
model = acme.eds
bus = can
node = 6
[model la28]
base = s3674-biss
st = 28
[encoder third]
model = la28
wire = sim
"""


def crc(value: int, bits: int) -> int:
    """x^6 + x + 1, inverted, as BiSS has it."""
    value <<= 6
    for bit in range(bits + 5, 5, -1):
        value ^= 0x43 << bit - 6 if value >> bit & 1 else 0
    return ~value & 0x3F


LA26 = (1 << 24) << 2 | 3
# How many bits a frame has, these, and their position.
FRAMES = {"la26": (34, LA26 << 6 | crc(LA26, 28), 1 << 24), "slow": (34, LA26 << 6 | crc(LA26, 28), 1 << 24),
          "word40": (40, (1 << 18) << 3 | 0b011, 1 << 18)}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("models")
    (folder / "texts.ini").write_text(TEXTS)
    (folder / "acme.eds").write_text(ACME)
    (folder / "rig.ini").write_text(RIG)
    return folder


@pytest.mark.parametrize("version", ["3", "2"])
@pytest.mark.parametrize("model", [*FRAMES])
def test_a_text_sends_its_own_frames(make: Make, files: pathlib.Path, model: str, version: str) -> None:
    fmu = make(model, "--model", str(files / "texts.ini"), "--fmi", version)
    assert validate_fmu(fmu.path) == []
    slave: Any = Slave2(fmu) if version == "2" else Slave(fmu)
    kind = ("Real",) if version == "2" else ()
    slave.set(*kind, "shaft.angle", QUARTER)
    slave.step(0.5)
    if version == "3":
        slave.tick("MA")
    slave.step(0.1)
    assert slave.get(*kind, "frame.bits") == FRAMES[model][0]
    assert version == "2" or slave.get("frame") == FRAMES[model][1]
    assert slave.get(*kind, "frame.position") == FRAMES[model][2]
    slave.close()


def test_settings_begin_with_the_figures_of_the_text(make: Make, files: pathlib.Path) -> None:
    of = {name: {v.name: v for v in make(name, "--model", str(files / "texts.ini")).description.modelVariables}
          for name in ("la26", "slow")}
    assert float(of["slow"]["busy_us"].start) == 20.5 and float(of["la26"]["busy_us"].start) != 20.5


def test_a_text_needs_no_files(make: Make, files: pathlib.Path) -> None:
    fmu = make("slow", "--model", str(files / "texts.ini"))
    with zipfile.ZipFile(fmu.path) as archive:
        assert not [name for name in archive.namelist() if name.startswith("resources")]
    assert "slow:s3674-biss;-eds;st=26;" in fmu.description.guid and "-registers" not in fmu.description.guid
    assert "la26:s3674-biss;-registers;-eds;st=26" in make("la26", "--model", str(files / "texts.ini")).description.guid


def ask(slave: Slave, node: int, request: str) -> str:
    data = slave.send("CanChannel", frame(0x600 + node, bytes.fromhex(request)))
    slave.step(1e-3)
    answers = [body for number, body in frames(data + slave.fetch("CanChannel")) if number == 0x580 + node]
    return answers[0].hex()


def test_an_eds_file_answers(make: Make, files: pathlib.Path) -> None:
    fmu = make(str(files / "acme.eds"))
    assert validate_fmu(fmu.path) == []
    slave = Slave(fmu)
    slave.set("shaft.angle", QUARTER)
    slave.step(2.0)
    assert (0x721, b"\0") in frames(slave.fetch("CanChannel"))
    assert slave.get("position") == 900
    assert ask(slave, 0x21, "4001650000000000") == "43016500100e0000"
    assert ask(slave, 0x21, "4003200000000000") == "4f032000a5000000"
    assert ask(slave, 0x21, "2f0320005a000000") == "6003200000000000"
    state, at = slave.save(), slave.time
    assert ask(slave, 0x21, "2f03200011000000") == "6003200000000000"
    slave.restore(state, at)
    assert ask(slave, 0x21, "4003200000000000") == "4f0320005a000000"
    assert ask(slave, 0x21, "4005210000000000") == "8005210000000206"
    slave.close()


def test_an_eds_file_of_fmi_2(make: Make, files: pathlib.Path) -> None:
    fmu = make(str(files / "acme.eds"), "--fmi", "2")
    assert validate_fmu(fmu.path) == []
    slave = Slave2(fmu)
    slave.set("Real", "shaft.angle", QUARTER)
    slave.step(2.0)
    assert slave.get("Real", "position") == 900
    slave.slave.reset()
    slave.slave.setupExperiment()
    slave.slave.enterInitializationMode()
    slave.slave.exitInitializationMode()
    assert slave.get("Real", "position") == 0
    slave.close()


def test_a_rig_of_files(make: Make, files: pathlib.Path) -> None:
    """One EDS file that two encoders have is there once."""
    fmu = make(str(files / "rig.ini"))
    assert validate_fmu(fmu.path) == []
    with zipfile.ZipFile(fmu.path) as archive:
        assert len([name for name in archive.namelist() if name.startswith("resources/")]) == 1
    slave = Slave(fmu)
    slave.set("first.shaft.angle", QUARTER)
    slave.step(2.0)
    assert [slave.get(f"{name}.position") for name in ("first", "second", "third")] == [900, 900, 1 << 26]
    slave.close()


def test_the_archive_says_the_same_of_every_file(make: Make, files: pathlib.Path) -> None:
    """Neither the clock nor the user shows in it: two of one model are the same bytes."""
    path = pathlib.Path(make(str(files / "rig.ini")).path)
    with zipfile.ZipFile(path) as archive:
        said = {(file.flag_bits, file.compress_type, file.date_time, file.create_system, file.external_attr >> 16,
                 file.extract_version, file.extra, file.comment) for file in archive.infolist()}
        content = path.read_bytes()
        for file in archive.infolist():
            ahead = content[file.header_offset:file.header_offset + 30]
            size, name = file.file_size, file.filename.encode()
            assert ahead == struct.pack("<IHHHHHIIIHH", 0x04034B50, 10, 0, 0, 0, 0x21, file.CRC, size, size, len(name), 0)
    assert said == {(0, zipfile.ZIP_STORED, (1980, 1, 1, 0, 0, 0), 3, 0o100644, 10, b"", b"")}


def test_another_file_is_refused(make: Make, files: pathlib.Path) -> None:
    """Its name is a check sum: a state or a token is of one text only."""
    fmu = make(str(files / "acme.eds"))
    folder = pathlib.Path(fmu.folder) / "resources"
    (file,) = folder.iterdir()
    text = file.read_bytes()
    for wrong in (text.replace(b"3600", b"3601"), b"", None):
        if wrong is None:
            os.remove(file)
        else:
            file.write_bytes(wrong)
        with pytest.raises(Exception):
            Slave(fmu)
    file.write_bytes(text)
    Slave(fmu).close()


def test_what_is_wrong_in_a_file_is_told(files: pathlib.Path, tmp_path: pathlib.Path) -> None:
    (tmp_path / "bad.eds").write_text("[1000\n")
    (tmp_path / "bad.ini").write_text(TEXTS.replace("st = 26", "st = 99"))
    for name, what in (("bad.eds", "bad.eds: no object"), ("bad.ini", "bad.ini:3: st 99: expected a number in 8..32")):
        said = subprocess.run([DREHGEBER, "fmu", tmp_path / name, "--output", tmp_path / "a.fmu"], capture_output=True, text=True)
        assert said.returncode == 2 and what in said.stderr and said.stderr.count("\n") == 1
        assert not (tmp_path / "a.fmu").exists()
