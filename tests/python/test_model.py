# SPDX-License-Identifier: MIT
"""Encoders whose models are files: EDS and DCF files, and files with [model NAME]."""
import time
from pathlib import Path

import canopen
import drehgeber
import pytest
from drehgeber import CanBus, Clock, Encoder, EncoderError, Rig

PATIENCE_S = 20  # for a thread of python-can on a busy machine
OBJECTS = [  # index, type, access, default, mappable
    ("1000", 7, "ro", "0x00020196", 0),
    ("1017", 6, "rw", "0", 0),
    ("1800sub1", 7, "rw", "$NODEID+0x180", 0),
    ("1800sub2", 5, "rw", "1", 0),
    ("1A00sub0", 5, "rw", "1", 0),
    ("1A00sub1", 7, "rw", "0x60040020", 0),
    ("2000", 5, "rw", "3", 0),
    ("6003", 7, "rw", "0", 0),
    ("6004", 7, "ro", "", 1),
    ("6501", 7, "ro", "3600", 0),
    ("6502", 6, "ro", "37", 0),
]
HALF = "[model half]\nbase = s3674-biss\nst = 20\nlc = 0\n"
LINEAR = "[model la26]\nbase = s3674-biss\nst = 26\nlc = 0\ntitle = linear, 26 bit\n"


def eds(figures=OBJECTS, head="[DeviceInfo]\nProductName=Acme 3600\n"):
    records = sorted({index[:4] for index, *_ in figures if "sub" in index})
    head += "".join(f"[{index}]\nParameterName=Record {index}\nObjectType=9\nSubNumber=3\n" for index in records)
    return head + "".join(
        f"[{index}]\nParameterName=Object {index}\nObjectType=7\nDataType={kind}\nAccessType={access}\n"
        f"DefaultValue={default}\nPDOMapping={mappable}\n"
        for index, kind, access, default, mappable in figures
    )


@pytest.fixture
def vendor(tmp_path, monkeypatch):
    (tmp_path / "vendor.eds").write_text(eds())
    monkeypatch.chdir(tmp_path)
    return tmp_path / "vendor.eds"


def test_one_line(vendor):
    encoder = Encoder("vendor.eds", shaft="90DEG")
    assert (encoder.model, encoder.medium.name, encoder.position) == ("acme-3600", "FRAMES", 900)


@pytest.mark.parametrize("name", [str, Path, lambda path: path.name, lambda path: f"../{path.parent.name}/{path.name}"])
def test_where_the_file_is_is_the_callers_business(vendor, name):
    assert Encoder(name(vendor)).model == "acme-3600"


def test_a_client_that_knows_nothing_but_the_file(vendor):
    """python-canopen over python-can: SDO, preset, a TPDO behind SYNC."""
    network = canopen.Network()
    network.connect(interface="drehgeber", channel="vendor.eds?node=5&shaft=90DEG")
    node = network.add_node(5, str(vendor))
    node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
    try:
        assert (node.sdo[0x6501].raw, node.sdo[0x6004].raw, node.sdo[0x2000].raw) == (3600, 900, 3)
        node.sdo[0x2000].raw = 9
        node.sdo[0x6003].raw = 7
        assert (node.sdo[0x2000].raw, node.sdo[0x6004].raw) == (9, 7)
        with pytest.raises(canopen.SdoAbortedError) as refused:
            node.sdo.upload(0x2100, 0)
        assert refused.value.code == 0x06020000
        node.tpdo.read()
        node.nmt.state = "OPERATIONAL"
        network.sync.transmit()
        end = time.monotonic() + PATIENCE_S
        while node.tpdo[1].timestamp is None:  # wait_for_reception() misses one that has come before it
            assert time.monotonic() < end
            time.sleep(0.01)
        assert node.tpdo[1][0].raw == 7
    finally:
        network.disconnect()


def test_its_memory_outlives_the_power(vendor):
    vendor.write_text(eds([*OBJECTS, ("1010sub1", 7, "rw", "1", 0)]))
    encoder = Encoder(vendor)
    encoder.can.send(0x63F, bytes.fromhex("2f 00 20 00 05 00 00 00"))
    encoder.can.send(0x63F, bytes.fromhex("23 10 10 01") + b"save")
    assert encoder.can.wait(1) is not None
    encoder.clock.advance(0.1)
    again = Encoder(vendor, memory=encoder.memory)
    again.can.send(0x63F, bytes.fromhex("40 00 20 00 00 00 00 00"))
    assert again.can.recv().data[4] == 5


def test_several_on_one_bus(vendor, tmp_path):
    (tmp_path / "other.dcf").write_text(eds(head="[DeviceComissioning]\nNodeID=9\n").replace("3600", "1000"))
    bus = CanBus(clock=Clock())
    nodes = [Encoder("vendor.eds", bus=bus, node=1, shaft="90DEG"), Encoder("other.dcf", bus=bus, shaft="90DEG"),
             Encoder("f3668", bus=bus, node=3, shaft="90DEG")]
    assert [node.position for node in nodes] == [900, 250, 16384]
    port = bus.port()
    for node, steps in ((1, 3600), (9, 1000), (3, 65536)):
        port.send(0x600 + node, bytes.fromhex("40 01 65 00 00 00 00 00"))
        assert int.from_bytes(port.recv().data[4:], "little") == steps


@pytest.mark.parametrize("name, said", [
    ("missing.eds", "missing.eds: No such file or directory"),
    ("folder.eds", "folder.eds: Is a directory"),
    ("empty.eds", "empty.eds: no object; expected an EDS or DCF file, with sections as [1000]"),
    ("long.eds", "long.eds: too long; expected at most 1 MB"),
    ("many.eds", "many.eds:4001: too many objects; expected at most 4000 objects, 16384 sub-indices"),
    ("own.eds", "own.eds:{own}: [6501] DefaultValue: not the figures of the encoder with this identity; "
                "expected 65536 steps, and 4096 turns or one"),
    ("missing.ini", "missing.ini: No such file or directory"),
    ("bench.ini", "bench.ini: a rig file is no model; expected Rig('bench.ini')"),
    ("bad.ini", "bad.ini:3: st 99: expected a number in 8..32"),
])
def test_what_is_no_model(vendor, tmp_path, name, said):
    """One exception with file, line, key, what is wrong and what is right."""
    own = drehgeber.eds("f3668").replace("\r", "")
    at = own.index("DefaultValue", own.index("[6501]"))
    own = own[:at] + "DefaultValue=1000\n" + own[own.index("\n", at) + 1:]
    (tmp_path / "own.eds").write_text(own)
    (tmp_path / "folder.eds").mkdir()
    (tmp_path / "empty.eds").write_text("")
    (tmp_path / "long.eds").write_text(eds() + "\n" * 1_048_576)
    (tmp_path / "many.eds").write_text("".join(f"[{index:04X}]\n" for index in range(0x2000, 0x4000)))
    (tmp_path / "bench.ini").write_text("[encoder a]\nmodel = f3668\nwire = slcan\n")
    (tmp_path / "bad.ini").write_text("[model x]\nbase = s3674-biss\nst = 99\n")
    with pytest.raises(EncoderError) as refused:
        Encoder(name)
    assert str(refused.value) == said.format(own=1 + own[:own.index("[6501]")].count("\n"))


def test_what_is_no_word(vendor):
    with pytest.raises(EncoderError, match="^no model 'vendor'; there are s3674-rs485, .*, or FILE.eds, FILE.dcf, MODELS.ini$"):
        Encoder("vendor")
    with pytest.raises(TypeError, match="expected a text, or the path of a file"):
        Encoder(b"vendor.eds")


def test_a_model_file(tmp_path):
    (tmp_path / "la26.ini").write_text(HALF + LINEAR)
    encoder = Encoder(tmp_path / "la26.ini", shaft="180DEG")
    assert (encoder.model, encoder.get("st"), encoder.position) == ("la26", "26", 1 << 25)
    assert encoder.biss.frame().position == 1 << 25


def test_models_of_a_rig(vendor, tmp_path):
    text = ("[shaft s]\nmotion = 90DEG\n" + HALF + "[encoder half]\nmodel = half\nwire = sim\n"
            "[bus b]\nwire = slcan\n[encoder n]\nmodel = vendor.eds\nbus = b\nnode = 1..3\n")
    with Rig.of_text(text, tmp_path) as rig:
        assert (rig.encoders["half"].model, rig.encoders["half"].position) == ("half", 1 << 18)
        assert [rig.encoders[f"n-{i}"].position for i in (1, 2, 3)] == [900] * 3
        assert len(rig.buses["b"].nodes) == 3


@pytest.mark.parametrize("model, said", [
    ("missing.eds", "text:2: model: missing.eds: No such file or directory"),
    ("/etc/x.eds", "text:2: model: /etc/x.eds is not allowed; expected a file in the folder of this one, or below it"),
    ("../vendor.eds", "text:2: model: ../vendor.eds is not allowed; expected a file in the folder of this one, or below it"),
    ("link.eds", "text:2: model: link.eds: not in the folder for files; expected a name below it"),
    ("empty.eds", "text:2: model: empty.eds: no object; expected an EDS or DCF file, with sections as [1000]"),
])
def test_what_a_rig_refuses(vendor, tmp_path, model, said):
    (tmp_path / "link.eds").symlink_to(vendor)
    (tmp_path / "empty.eds").write_text("")
    with pytest.raises(EncoderError) as refused:
        Rig.of_text(f"[encoder a]\nmodel = {model}\nwire = slcan\n", tmp_path)
    assert str(refused.value) == said


def test_encoders_keep_what_their_model_lies_in(vendor):
    """Long after the file is gone, and others have come."""
    encoders = [Encoder("vendor.eds", shaft="90DEG") for _ in range(20)]
    vendor.unlink()
    with Rig.of_text(LINEAR + "[encoder a]\nmodel = la26\nwire = sim\n") as rig:
        kept = rig.encoders["a"]
    del rig
    bytearray(1 << 22)
    for encoder in encoders:
        encoder.power("CYCLE")
        assert encoder.position == 900
    assert kept.model == "la26"
