# SPDX-License-Identifier: MIT
"""`drehgeber verify FILE.eds`: a device does what its file says, nothing is written to it, and devices that do otherwise are
found and named by the object. The devices are a few lines of Python behind an SLCAN adapter, and our own."""
import contextlib
import re
import socket
import subprocess

import pytest

from rig import PROGRAM, REPOSITORY, Encoder, run_refused
from verified import Server

LIMIT_S = 60.0
NODE = 63
OBJECT = "[{0}]\nParameterName={1}\nObjectType=0x7\nDataType={2}\nAccessType={3}\n{4}\n"
FILE = """[FileInfo]
FileName=vendor.eds

[DeviceInfo]
VendorName=Vendor
ProductName=Meter

[MandatoryObjects]
SupportedObjects=3
1=0x1000
2=0x1001
3=0x1018

[1018]
ParameterName=Identity object
ObjectType=0x9
SubNumber=2
""" + "".join(OBJECT.format(*row) for row in [
    ("1000", "Device type", "0x0007", "ro", "DefaultValue=0x00010196\nPDOMapping=0"),
    ("1001", "Error register", "0x0005", "ro", "PDOMapping=0"),
    ("1018sub0", "Highest sub-index", "0x0005", "const", "DefaultValue=1\nPDOMapping=0"),
    ("1018sub1", "Vendor | ID]", "0x0007", "ro", "DefaultValue=0x0000ABCD\nPDOMapping=0"),
    ("1800sub1", "COB-ID", "0x0007", "rw", "DefaultValue=$NODEID+0x180\nPDOMapping=0"),
    ("2000", "Command", "0x0006", "wo", "PDOMapping=0"),
    ("2001", "Offset", "0x0003", "rw", "DefaultValue=-5\nLowLimit=-10\nHighLimit=10\nPDOMapping=0"),
    ("2002", "Name", "0x0009", "const", "DefaultValue=Meter\nPDOMapping=0"),
    ("2003", "Filter", "0x0005", "rw", "DefaultValue=7\nLowLimit=1\nHighLimit=9\nPDOMapping=0"),
    ("2004", "Counter", "0x001B", "ro", "PDOMapping=0"),
    ("2005", "Type", "0x0016", "ro", "PDOMapping=0")])
# object: bytes, or the code of an abort
DEVICE = {(0x1000, 0): b"\x96\x01\x01\0", (0x1001, 0): b"\0", (0x1018, 0): b"\1", (0x1018, 1): b"\xcd\xab\0\0",
          (0x1800, 1): b"\xbf\1\0\0", (0x2000, 0): 0x06010001, (0x2001, 0): b"\xfb\xff", (0x2002, 0): b"Meter",
          (0x2003, 0): b"\7", (0x2004, 0): bytes(8), (0x2005, 0): b"\1\2\3"}


class Device(Server):
    """A node with an SDO server for uploads, behind an adapter, for one master."""

    def __init__(self, **changes):
        super().__init__()
        self.objects = DEVICE | changes.get("objects", {})
        self.option = f"--slcan=tcp:{self.where}"
        self.lines = []

    def answer(self, line: bytes) -> bytes:
        self.lines.append(line)
        found = re.fullmatch(rb"t63F840(..)(..)(..)0{8}", line)
        if not found:
            return b"\r"
        value = self.objects.get((int(found[2] + found[1], 16), int(found[3], 16)), 0x06020000)
        if value is None:
            return b"\r"
        if isinstance(value, int):
            head, data = 0x80, value.to_bytes(4, "little")
        elif len(value) > 4:
            head, data = 0x41, len(value).to_bytes(4, "little")
        else:
            head, data = 0x43 | (4 - len(value)) << 2, value.ljust(4, b"\0")
        return b"\rt5BF8%02X%s%s\r" % (head, b"".join(found.groups()), data.hex().upper().encode())

    def run(self):
        rest = b""
        with contextlib.suppress(OSError), self.listener.accept()[0] as wire:
            while data := wire.recv(4096):
                *lines, rest = (rest + data).split(b"\r")
                for line in lines:
                    wire.sendall(self.answer(line))


def verify(file, where: str, *arguments, status: int = 0) -> subprocess.CompletedProcess:
    ended = subprocess.run([PROGRAM, "verify", str(file), where, *map(str, arguments)], stdin=subprocess.DEVNULL,
                           capture_output=True, text=True, timeout=LIMIT_S)
    assert ended.returncode == status, (ended.stdout[-2000:], ended.stderr)
    return ended


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "vendor.eds"
    path.write_text(FILE)
    return path


AGREES = """1000:0 1000:0-type 1000:0-value 1001:0 1001:0-type 1018:0 1018:0-type 1018:0-value 1018:1 1018:1-type 1018:1-value
1800:1 1800:1-type 1800:1-value 2000:0 2001:0 2001:0-type 2001:0-limits 2001:0-value 2002:0 2003:0 2003:0-type 2003:0-limits
2003:0-value 2004:0 2004:0-type 2005:0 2005:0-type""".split()


def test_a_device_that_does_what_its_file_says(file):
    with Device() as device:
        ended = verify(file, device.option)
    lines = ended.stdout.splitlines()
    assert sorted(lines[1:-1]) == sorted(f"agrees   {clause}" for clause in AGREES)
    assert lines[-1] == f"{len(AGREES)} clauses agree, 0 differ, 0 were not seen"
    # uploads, and the abort that begins each row
    assert {line[:7] for line in device.lines if line[:1] == b"t"} == {b"t63F840", b"t63F880"}


def test_a_device_that_does_not_say_how_long_values_are(file):
    """CiA 301 lets an expedited answer leave its size open."""
    class Unsized(Device):
        def answer(self, line: bytes) -> bytes:
            return re.sub(rb"t5BF84[37BF]", b"t5BF842", super().answer(line))

    with Unsized() as device:
        ended = verify(file, device.option, "1000", "2001")
    lines = ended.stdout.splitlines()
    assert {line for line in lines if line.startswith("agrees")} == {f"agrees   {clause}" for clause in (
        "1000:0", "1000:0-value", "2001:0", "2001:0-limits", "2001:0-value")}, ended.stdout
    assert {line.split(":")[1] for line in lines if line.startswith("not seen")} == {"0-type"} and " 0 differ, " in lines[-1]


# clause: what its device has in place of what the file says
BROKEN = {
    "1001:0": {(0x1001, 0): 0x06020000},
    "2000:0": {(0x2000, 0): b"\0\0"},
    "2001:0-type": {(0x2001, 0): b"\xfb\xff\xff\xff"},
    "2001:0-limits": {(0x2001, 0): b"\xf5\xff"},
    "2003:0-limits": {(0x2003, 0): b"\n"},
    "1018:0-value": {(0x1018, 0): b"\2"},
    "1018:1-value": {(0x1018, 1): b"\xce\xab\0\0"},
    "2004:0-type": {(0x2004, 0): bytes(7)},
    "1001:0-type": {(0x1001, 0): None},
}


@pytest.mark.parametrize("clause", BROKEN)
def test_each_broken_device_is_found_and_named(file, clause):
    with Device(objects=BROKEN[clause]) as device:
        ended = verify(file, device.option, clause, status=1)
    why = next(line for line in ended.stdout.splitlines() if line.startswith(f"differs  {clause}: "))
    index, sub = (int(part, 16) for part in clause.partition("-")[0].split(":"))
    assert f"sent 63F 40 {index & 255:02X} {index >> 8:02X} {sub:02X}" in why and "expected an object that is" in why
    assert "came" in why


def test_what_somebody_may_have_written_is_no_difference(file):
    with Device(objects={(0x2003, 0): b"\3", (0x1001, 0): 0x08000024}) as device:
        ended = verify(file, device.option, "2003", "1001")
    assert "not seen 2003:0-value: eds:" in ended.stdout and "not seen 1001:0-type: eds:" in ended.stdout
    assert "agrees   2003:0-limits" in ended.stdout and "agrees   1001:0\n" in ended.stdout


def test_our_own_does_what_its_file_says(tmp_path):
    encoder = Encoder(["f3668", f"--slcan={tmp_path}/link", "--nvm", tmp_path / "image"])
    before = (tmp_path / "image").read_bytes()
    ended = verify(REPOSITORY / "tools/eds/f3668.eds", f"--slcan={tmp_path}/link", "--junit", tmp_path / "junit.xml")
    assert encoder.clean_up() == []
    assert " 0 differ, " in ended.stdout.splitlines()[-1]
    assert len(re.findall("^agrees ", ended.stdout, re.M)) >= 300
    after = (tmp_path / "image").read_bytes()
    assert after[:0x27C] + after[0x292:] == before[:0x27C] + before[0x292:]  # all but the operating time


def test_a_row_about_another_model_is_no_difference(tmp_path):
    encoder = Encoder(["f3658", f"--slcan={tmp_path}/link"])
    ended = verify("f3658", f"--slcan={tmp_path}/link", "C1-", "M12-9", "M19-1")
    assert encoder.clean_up() == []
    assert "not seen C1-1: is about an encoder with other figures" in ended.stdout and " 0 differ, " in ended.stdout


def test_what_is_refused(file, tmp_path):
    assert "--write" in run_refused(2, "verify", file, "--slcan=/dev/null", "--write")
    assert "no such clause" in run_refused(1, "verify", file, "--slcan=/dev/null", "9")
    assert "--node 200" in run_refused(1, "verify", file, "--slcan=/dev/null", "--node", "200")
    large = tmp_path / "large.eds"
    large.write_text(FILE + "".join(OBJECT.format(f"{0x2100 + i:04X}", "One", "0x0005", "ro", "PDOMapping=0")
                                    for i in range(2500)))
    assert "clauses are too many" in run_refused(1, "verify", large, "--slcan=/dev/null")
