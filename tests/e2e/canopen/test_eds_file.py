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


def add_node(network, number: int, path) -> canopen.RemoteNode:
    """With more patience than canopen's 0.3 s: a busy machine is late, and a disk takes its time to save."""
    node = network.add_node(number, str(path))
    node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
    return node


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
            yield add_node(network, 5, path)
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


LONG = ("[2101]\nParameterName=Parameters\nObjectType=7\nDataType=0xF\nAccessType=rw\n"
        "[2102]\nParameterName=Place\nObjectType=7\nDataType=9\nAccessType=rw\nDefaultValue=hall\n"
        "[2103]\nParameterName=Steps\nObjectType=7\nDataType=0x1B\nAccessType=rw\nDefaultValue=0x123456789A\n"
        "[2104]\nParameterName=Low\nObjectType=7\nDataType=0x15\nAccessType=rw\nDefaultValue=-5\n")


@pytest.mark.parametrize("size", [1, 4, 5, 7, 889, 1024])
def test_a_domain_goes_up_and_down_by_segments_and_blocks(tmp_path, vendor, size):
    data = bytes(i * 7 % 251 for i in range(size))
    vendor.write_text(vendor.read_text() + LONG)
    with encoder(tmp_path, vendor) as node:
        for blocks in (False, True):
            with node.sdo[0x2101].open("wb", buffering=4096, size=size, block_transfer=blocks) as to:
                to.write(data[::-1] if blocks else data)
            for reads_blocks in (False, True):
                with node.sdo[0x2101].open("rb", block_transfer=reads_blocks) as source:
                    assert source.read() == (data[::-1] if blocks else data)


def test_texts_and_wide_numbers(tmp_path, vendor):
    vendor.write_text(vendor.read_text() + LONG)
    with encoder(tmp_path, vendor) as node:
        assert [node.sdo[index].raw for index in (0x2102, 0x2103, 0x2104)] == ["hall", 0x123456789A, -5]
        node.sdo[0x2102].raw = "in the tower, third floor, behind the door"
        node.sdo[0x2103].raw = (1 << 64) - 1
        node.sdo[0x2104].raw = -1 << 63
        assert node.sdo[0x2102].raw == "in the tower, third floor, behind the door"
        assert [node.sdo[index].raw for index in (0x2103, 0x2104)] == [(1 << 64) - 1, -1 << 63]
        with pytest.raises(canopen.SdoAbortedError) as refused:
            node.sdo.download(0x2101, 0, bytes(1025))
        assert refused.value.code == 0x06070012


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
                one = add_node(network, node, vendor)
                assert (one.sdo[0x6501].raw, one.sdo[0x6004].raw) == (steps, 250)
        finally:
            network.disconnect()


@pytest.mark.parametrize("model, said", [
    ("missing.eds", "bench.ini:2: model: missing.eds: No such file or directory"),
    ("/etc/vendor.eds", "bench.ini:2: model: /etc/vendor.eds is not allowed; expected a file in the folder of this one, or below it"),
    ("../vendor.eds", "bench.ini:2: model: ../vendor.eds is not allowed; expected a file in the folder of this one, or below it"),
    ("link.eds", "bench.ini:2: model: link.eds: not in the folder for files; expected a name below it"),
    ("own.eds", "bench.ini:2: model: own.eds:{line}: [6501] DefaultValue: not the figures of the encoder with this identity; "
                "expected 65536 steps, and 4096 turns or one"),
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


def test_an_image_of_another_file(tmp_path, vendor):
    """Refused with the objects; what fits goes on in a new file."""
    old, new = tmp_path / "old.nvm", tmp_path / "new.nvm"
    live = ("--slcan", "--time", "virtual:1MS")
    with encoder(tmp_path, vendor, "--nvm", old) as node:
        node.sdo[0x2000].raw = 9
        node.sdo[0x1017].raw = 300
        node.sdo[0x1010][1].raw = int.from_bytes(b"save", "little")
    image = old.read_bytes()
    vendor.write_text(vendor.read_text() + "[2001]\nParameterName=More\nDataType=5\nAccessType=rw\nDefaultValue=6\n")
    said = run("run", vendor, *live, "--nvm", old)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr == (f"drehgeber: {old}: of another EDS file: 2001h is not in the image; "
                           "--nvm-convert NEW makes one of what fits\n")
    with encoder(tmp_path, vendor, "--nvm", old, "--nvm-convert", new) as node:
        assert [node.sdo[index].raw for index in (0x2000, 0x1017, 0x2001)] == [9, 300, 6]
    assert run("run", vendor, *live, "--nvm", new, "--quiet").returncode == 0
    assert old.read_bytes() == image
    again = run("run", vendor, *live, "--nvm", old, "--nvm-convert", new)
    assert (again.returncode, again.stderr.splitlines()[-1]) == (
        2, f"drehgeber: {new}: File exists; expected the name of a new file")
    (tmp_path / "bench.ini").write_text("[encoder a]\nmodel = vendor.eds\nwire = slcan\nnvm = old.nvm\n")
    assert "2001h is not in the image" in run("run", tmp_path / "bench.ini", "--time", "virtual:1MS").stderr


@pytest.mark.parametrize("words, said", [
    (("--nvm-convert", "NEW"), "--nvm-convert NEW: expected 'run FILE --nvm OLD --nvm-convert NEW'"),
    (("--nvm", "none.nvm", "--nvm-convert", "NEW"), "none.nvm: there is no image"),
    (("--nvm", "vendor.eds", "--nvm-convert", "NEW"),
     "vendor.eds: nothing that could be converted; expected an image in which the encoder of an EDS file has saved"),
])
def test_what_cannot_be_converted(tmp_path, vendor, words, said):
    told = run("run", "vendor.eds", "--slcan", *words, cwd=tmp_path)
    assert (told.returncode, told.stdout, told.stderr) == (2, "", f"drehgeber: {said}\n")
    assert not (tmp_path / "NEW").exists()


def test_check_says_what_is_in_a_file(tmp_path, vendor):
    said = run("check", vendor)
    assert (said.returncode, said.stderr) == (0, "")
    assert re.fullmatch(r"\S+/vendor.eds: acme-3600, 3600 steps, 37 turns: 11 objects, "
                        r"9 sub-indices behave, 3 are values, 0 notes\n", said.stdout)
    vendor.write_text(vendor.read_text() + "[2001]\nDataType=0x20\n[2002]\nDataType=5\nDefaultValue=No\nAccessType=rw\n")
    notes = run("check", vendor).stdout.splitlines()
    assert [re.sub(r"^\S+?eds:\d+: ", "", line) for line in notes[:2]] == [
        "[2001] DataType is left out: it has no such type; expected a data type of CiA 301, 0x1 to 0x1B",
        "[2002] DefaultValue is no number of its type, and left out; expected a number, as 7, 0x0007 or $NODEID+0x180"]


def test_check_counts_as_one_speaks(tmp_path):
    (tmp_path / "one.eds").write_text("[1000]\nDataType=7\nDefaultValue=0x30191\nAccessType=ro\n[2000]\nDataType=5\nAccessType=rw\n")
    assert run("check", tmp_path / "one.eds").stdout.endswith("2 objects, 1 sub-index behaves, 1 is a value, 1 note\n")


LACKING = ("[1400]\nParameterName=RPDO\nObjectType=9\n[1400sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x200\n"
           "[2040]\nParameterName=Odd\nDataType=0x20\nAccessType=rw\n")


def test_what_each_object_does(tmp_path, vendor):
    vendor.write_text(vendor.read_text().replace("[6004]", "[2001]\nParameterName=\x1b[2J\nDataType=5\nAccessType=rw\n[6004]") + LACKING)
    said = run("eds", vendor, "--explain")
    assert (said.returncode, said.stderr) == (0, "")
    assert said.stdout.splitlines() == [
        "1000h     constant   Object 1000",
        "1010h     constant   Highest",
        "1010h:1   simulated  All",
        "1017h     simulated  Object 1017",
        "1400h:1   stores     a PDO that this node does not have: values only",
        "2000h     stores     Object 2000",
        "2001h     stores     ?[2J",
        "2040h     refused    Odd; is left out: it has no such type",
        "6000h     simulated  Object 6000",
        "6001h     simulated  Object 6001",
        "6002h     simulated  Object 6002",
        "6003h     simulated  Object 6003",
        "6004h     simulated  Object 6004",
        "6501h     constant   Object 6501",
        "6502h     constant   Object 6502",
    ]
    for words in (("eds", vendor), ("eds", "f3668", "--explain"), ("eds", tmp_path / "missing.eds", "--explain")):
        refused = run(*words)
        assert refused.returncode != 0 and refused.stdout == "" and refused.stderr.count("\n") == 1


def test_what_it_does_not_do_is_said_at_the_start(tmp_path, vendor):
    many = "".join(f"[{index:04X}]\nDataType=5\nAccessType=rw\n" for index in range(0x3000, 0x3020))
    odd = "".join(f"[{index:04X}]\nDataType=0x20\nAccessType=rw\n" for index in range(0x4000, 0x4005))
    live = ("--slcan", "--time", "virtual:1MS")
    assert run("run", vendor, *live).stderr == f"drehgeber: {vendor}: values only: 2000h\n"
    vendor.write_text(vendor.read_text() + many + odd)
    told = run("run", vendor, *live).stderr.replace(str(vendor), "x.eds").splitlines()
    assert told[0] == ("drehgeber: x.eds: values only: 2000h 3000h 3001h 3002h 3003h 3004h 3005h 3006h and 25 more; "
                       "'drehgeber eds x.eds --explain' lists them")
    assert [re.sub(r":\d+:", ":", line) for line in told[1:4]] == [
        f"drehgeber: x.eds: [{index}] DataType is left out: it has no such type; expected a data type of CiA 301, 0x1 to 0x1B"
        for index in (4000, 4001, 4002)]
    assert told[4:] == ["drehgeber: x.eds: 2 more that its encoder does not do; 'drehgeber check x.eds' lists them"]
    assert run("run", vendor, *live, "--quiet").stderr == ""
    (tmp_path / "bench.ini").write_text("[bus b]\nwire = slcan\n[encoder a]\nmodel = vendor.eds\nbus = b\nnode = 1..3\n")
    told = run("run", tmp_path / "bench.ini", "--time", "virtual:1MS").stderr
    assert told.replace(f"{tmp_path}/", "") == ("drehgeber: vendor.eds: 5 things that its encoders do not do; "
                                                "'drehgeber check vendor.eds' lists them\n")


def test_a_file_comes_by_stdin(tmp_path):
    """eds f3668 | run -: the encoder that it was, in the same words."""
    link = tmp_path / "can"
    eds = run("eds", "f3668").stdout
    (tmp_path / "f3668.eds").write_text(eds)
    with subprocess.Popen([PROGRAM, "run", "-", f"--slcan={link}", "--shaft", "90DEG"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        network = canopen.Network()
        try:
            process.stdin.write(eds)
            process.stdin.close()
            assert process.stdout.readline().startswith("ready f3668 slcan:")
            network.connect(interface="slcan", channel=str(link), bitrate=250000)
            node = add_node(network, 63, tmp_path / "f3668.eds")
            assert (node.sdo[0x6004].raw, node.sdo[0x6501].raw) == (16384, 65536)
        finally:
            network.disconnect()
            process.terminate()
            assert process.wait(PATIENCE_S) == 0
            assert process.stderr.read() == ""
    nothing = run("run", "-", "--slcan")
    assert (nothing.returncode, nothing.stderr) == (
        2, "drehgeber: stdin: no object; expected an EDS or DCF file, with sections as [1000]\n")


def test_commands_that_take_a_model(tmp_path, vendor):
    """Help, what can happen to it, an FMU."""
    missing = tmp_path / "missing.eds"
    for words in (("run", missing, "--help"), ("faults", missing), ("fmu", missing, "--output", "x.fmu")):
        said = run(*words)
        assert (said.returncode, said.stdout) == (2, "")
        assert said.stderr == f"drehgeber: {missing}: cannot open: No such file or directory\n"
    assert "acme-3600" in run("run", vendor, "--help").stdout
    assert "acme-3600" in run("faults", vendor).stdout
    own = tmp_path / "own.eds"
    own.write_text(run("eds", "f3668").stdout)
    for path in (vendor, own):
        said = run("fmu", path, "--output", tmp_path / "x.fmu")
        assert (said.returncode, said.stderr) == (0, "")
    # Also where the kernel has CAN, and `run` wants to know the interface.
    assert "wire" not in run("fmu", "f3668", "--output", tmp_path / "x.fmu").stderr


@pytest.mark.parametrize("text, what", [
    ("", "no object"),
    ("[1000]\nDataType=0x20\n", "no object that can be read"),
])
def test_what_is_no_eds_file_is_refused(tmp_path, text, what):
    path = tmp_path / "bad.eds"
    path.write_text(text)
    said = run("run", path, "--slcan")
    assert (said.returncode, said.stdout) == (2, "")
    assert what in said.stderr and str(path) in said.stderr
