# SPDX-License-Identifier: MIT
"""An encoder of another maker, run from its EDS file, and a client that knows nothing but that file."""
import re
import subprocess
from contextlib import contextmanager

import canopen
import pytest

from can_rig import PATIENCE_S, PROGRAM, WIRE, on_slcan, run

OBJECTS = [  # index, type, access, default, mappable
    ("1000", 7, "ro", "0x00020196", 0),
    ("1017", 6, "rw", "0", 0),
    ("2000", 5, "rw", "3", 0),
    ("6000", 6, "rw", "4", 0),
    ("6001", 7, "rw", "1000", 0),
    ("6002", 7, "rw", "37000", 0),
    ("6003", 7, "rw", "0", 0),
    ("6004", 7, "ro", "", 1),
    ("6501", 7, "ro", "3600", 0),
    ("6502", 6, "ro", "37", 0),
]
STORE = ("[1010]\nParameterName=Store\nObjectType=8\nSubNumber=2\n"
         "[1010sub0]\nParameterName=Highest\nObjectType=7\nDataType=5\nAccessType=ro\nDefaultValue=1\n"
         "[1010sub1]\nParameterName=All\nObjectType=7\nDataType=7\nAccessType=rw\nDefaultValue=1\n")


@pytest.fixture
def vendor(tmp_path):
    text = "[DeviceInfo]\nProductName=Acme 3600\nBaudRate_250=1\n[OptionalObjects]\nSupportedObjects=0\n"
    for index, kind, access, default, mappable in OBJECTS:
        text += (f"[{index}]\nParameterName=Object {index}\nObjectType=7\nDataType={kind}\nAccessType={access}\n"
                 f"DefaultValue={default}\nPDOMapping={mappable}\n")
    path = tmp_path / "vendor.eds"
    path.write_text(text + STORE)
    return path


@contextmanager
def encoder(folder, path, *options):
    """Node 5 of the file, as python-canopen sees it."""
    link = folder / "can" if on_slcan() else WIRE
    wire = f"--slcan={link}" if on_slcan() else f"--can={link}"
    with subprocess.Popen([PROGRAM, "run", path, wire, "--node", "5", *options],
                          stdout=subprocess.PIPE, text=True) as process:
        network = canopen.Network()
        try:
            assert process.stdout.readline().startswith("ready acme-3600")
            network.connect(interface="slcan" if on_slcan() else "socketcan", channel=str(link), bitrate=250000)
            yield network.add_node(5, str(path))
        finally:
            network.disconnect()
            process.terminate()
            assert process.wait(PATIENCE_S) == 0


def test_a_client_finds_the_objects_of_the_file(tmp_path, vendor):
    with encoder(tmp_path, vendor, "--shaft", "90DEG") as node:
        assert node.sdo[0x6501].raw == 3600
        assert node.sdo[0x6004].raw == 250
        node.sdo[0x6003].raw = 7
        assert node.sdo[0x6004].raw == 7
        with pytest.raises(canopen.SdoAbortedError) as refused:
            node.sdo.upload(0x2100, 0)
        assert refused.value.code == 0x06020000


@contextmanager
def rig(folder, text):
    """A rig file that is at work, as its ready lines say."""
    (folder / "bench.ini").write_text(text)
    with subprocess.Popen([PROGRAM, "run", folder / "bench.ini"], stdout=subprocess.PIPE, text=True) as process:
        try:
            yield [process.stdout.readline() for _ in range(text.count("model =") + 1)]
        finally:
            process.terminate()
            assert process.wait(PATIENCE_S) == 0


def test_encoders_of_a_rig_file_have_the_objects_of_theirs(tmp_path, vendor):
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "other.dcf").write_text(
        vendor.read_text().replace("3600", "1000") + "[DeviceComissioning]\nNodeID=9\n")
    text = (f"[shaft s]\nmotion = 90DEG\n[bus b]\nwire = slcan\naddress = {tmp_path}/can\n"
            "[encoder a]\nmodel = vendor.eds\nbus = b\nnode = 5\n"
            "[encoder z]\nmodel = models/other.dcf\nbus = b\n")
    network = canopen.Network()
    with rig(tmp_path, text) as lines:
        assert [line.split()[1] for line in lines[:2]] == ["acme-3600", "acme-1000"]
        try:
            network.connect(interface="slcan", channel=f"{tmp_path}/can", bitrate=250000)
            for node, steps in ((5, 3600), (9, 1000)):
                one = network.add_node(node, str(vendor))
                assert (one.sdo[0x6501].raw, one.sdo[0x6004].raw) == (steps, 250)
        finally:
            network.disconnect()


@pytest.mark.parametrize("model, said", [
    ("missing.eds", "bench.ini:2: model: missing.eds: No such file or directory"),
    ("/etc/vendor.eds", "bench.ini:2: model: /etc/vendor.eds is none; a file in the folder of this one, or below it, is right"),
    ("../vendor.eds", "bench.ini:2: model: ../vendor.eds is none; a file in the folder of this one, or below it, is right"),
    ("link.eds", "bench.ini:2: model: link.eds: not in the folder for files; a name below it is right"),
    ("own.eds", "bench.ini:2: model: own.eds:{line}: [6501] DefaultValue: not the figures of the encoder with this identity; "
                "right is 65536 steps, and 4096 turns or one"),
])
def test_what_is_wrong_with_the_model_of_a_rig_file(tmp_path, model, said):
    (tmp_path / "link.eds").symlink_to("/etc/passwd")
    own = run("eds", "f3668").stdout.replace("\r", "")
    at = own.index("DefaultValue", own.index("[6501]"))
    own = own[:at] + "DefaultValue=1000\n" + own[own.index("\n", at) + 1:]
    (tmp_path / "own.eds").write_text(own)
    (tmp_path / "bench.ini").write_text(f"[encoder a]\nmodel = {model}\nwire = slcan\n")
    told = run("run", tmp_path / "bench.ini")
    assert (told.returncode, told.stdout) == (2, "")
    line = 1 + own[:own.index("[6501]")].count("\n")
    assert told.stderr.replace(f"{tmp_path}/", "") == f"drehgeber: {said.format(line=line)}\n"


def test_what_was_saved_is_there_again(tmp_path, vendor):
    with encoder(tmp_path, vendor, "--nvm", tmp_path / "e.nvm") as node:
        node.sdo[0x2000].raw = 9
        node.sdo[0x1010][1].raw = int.from_bytes(b"save", "little")
    with encoder(tmp_path, vendor, "--nvm", tmp_path / "e.nvm") as node:
        assert node.sdo[0x2000].raw == 9


def test_check_says_what_is_in_a_file(tmp_path, vendor):
    said = run("check", vendor)
    assert (said.returncode, said.stderr) == (0, "")
    assert re.fullmatch(r"\S+/vendor.eds: acme-3600, 3600 steps, 37 turns: 11 objects, "
                        r"9 sub-indices behave, 3 are values, 0 notes\n", said.stdout)
    vendor.write_text(vendor.read_text() + "[2001]\nDataType=0x1B\n[2002]\nDataType=5\nDefaultValue=No\nAccessType=rw\n")
    notes = run("check", vendor).stdout.splitlines()
    assert [re.sub(r"^\S+?eds:\d+: ", "", line) for line in notes[:2]] == [
        "[2001] DataType is left out: it has no such type; right is 0x1 to 0xB, or 0xF",
        "[2002] DefaultValue is no number of its type, and left out; right is a number, as 7, 0x0007 or $NODEID+0x180"]


@pytest.mark.parametrize("text, what", [
    ("", "no object"),
    ("[1000]\nDataType=0x1B\n", "no object that can be read"),
])
def test_what_is_no_eds_file_is_refused(tmp_path, text, what):
    path = tmp_path / "bad.eds"
    path.write_text(text)
    said = run("run", path, "--slcan")
    assert (said.returncode, said.stdout) == (2, "")
    assert what in said.stderr and str(path) in said.stderr
