# SPDX-License-Identifier: MIT
"""What a conformance test does with the EDS file: every object is read and compared with its
DefaultValue, everything that may be written is written back, transmission type 0 sends, and what is no
heartbeat does not start the consumer."""
import configparser
import time

import pytest
from can_rig import run
from canopen.sdo.exceptions import SdoAbortedError

TOO_LONG, TOO_SHORT, RANGE = 0x06070012, 0x06070013, 0x06090030
NO_DATA = 0x08000024
NO_DOWNLOAD = 1  # of ObjFlags
CLOCK = 0x1013
SIZES = {2: 1, 3: 2, 4: 4, 5: 1, 6: 2, 7: 4}
SIGNED = {2, 3, 4}
STRING = 9
WHO = [("f3668", 63), ("f3668", 4), ("f3658", 63), ("f3658", 127)]


class Entry:
    """An object that can be read or written: a section of the EDS file."""

    def __init__(self, name: str, section, node_id: int):
        index, _, sub = name.partition("sub")
        self.index, self.sub = int(index, 16), int(sub or "0", 16)
        self.type = int(section["DataType"], 16)
        self.size = SIZES.get(self.type)
        self.access = section["AccessType"]
        self.flags = int(section.get("ObjFlags", "0"), 0)
        self.low, self.high = (section.get(key) for key in ("LowLimit", "HighLimit"))
        self.default = section.get("DefaultValue")
        if self.default is not None and self.type != STRING:
            offset, plus, number = self.default.partition("$NODEID+")
            self.default = node_id + int(number, 0) if plus else int(offset, 0)

    @property
    def writable(self) -> bool:
        return "w" in self.access

    @property
    def is_mapping(self) -> bool:
        return self.index >> 8 == 0x1A

    def decode(self, data: bytes):
        if self.type == STRING:
            return data.decode("ascii")
        assert len(data) == self.size, self
        return int.from_bytes(data, "little", signed=self.type in SIGNED)

    def __repr__(self):
        return f"{self.index:04X}h:{self.sub}"


def entries(model: str, node_id: int) -> list:
    """The file as a plain reader of .ini files sees it."""
    said = run("eds", model)
    assert (said.returncode, said.stderr) == (0, "")
    file = configparser.ConfigParser(interpolation=None)
    file.optionxform = str
    file.read_string(said.stdout)
    return [Entry(name, file[name], node_id) for name in file.sections()
            if "AccessType" in file[name]]


@pytest.fixture(params=WHO, ids=lambda who: f"{who[0]}-{who[1]}")
def device(request, start):
    """An encoder in delivery state, and its entries."""
    model, node_id = request.param
    rig = start("--node", str(node_id), "--shaft", "90DEG", model=model, node_id=node_id)
    return rig, entries(model, node_id)


def abort_code(rig, entry, data: bytes) -> int:
    with pytest.raises(SdoAbortedError) as caught:
        rig.sdo.download(entry.index, entry.sub, data)
    return caught.value.code


def announce(rig, entry, size: int) -> int:
    """Abort code of a download of so many bytes, expedited as long as they fit. One request of the client's: its
    download() sends segments after an abort."""
    command = 0x23 | (4 - size) << 2 if size <= 4 else 0x21
    request = bytes([command]) + entry.index.to_bytes(2, "little") + bytes([entry.sub])
    rig.tap.forget()
    with pytest.raises(SdoAbortedError) as caught:
        rig.sdo.request_response(request + (size if size > 4 else 0).to_bytes(4, "little"))
    answer = rig.tap.data(0x580 + rig.node_id)
    assert answer[1:4] == request[1:], (entry, answer.hex())
    return caught.value.code


def readable(rig, entry) -> bool:
    if "r" not in entry.access and entry.access != "const":
        return False
    if entry.index == 0x1003 and entry.sub > rig.read(0x1003):
        with pytest.raises(SdoAbortedError) as caught:
            rig.sdo.upload(entry.index, entry.sub)
        assert caught.value.code == NO_DATA
        return False
    return True


def write_back(rig, listed: list, reverse: bool = False) -> int:
    """Everything that may be downloaded, with what is read. Mappings in CiA 301's five steps."""
    written = 0
    for entry in reversed(listed) if reverse else listed:
        if entry.writable and not entry.flags & NO_DOWNLOAD and not entry.is_mapping:
            data = rig.sdo.upload(entry.index, entry.sub)
            rig.sdo.download(entry.index, entry.sub, data)
            assert entry.index == CLOCK or rig.sdo.upload(entry.index, entry.sub) == data, entry
            written += 1
    for number in range(4):
        mapping = [entry for entry in listed if entry.index == 0x1A00 + number]
        data = [rig.sdo.upload(entry.index, entry.sub) for entry in mapping]
        cob_id = rig.read(0x1800 + number, 1)
        rig.write(0x1800 + number, 1, cob_id | 1 << 31, 4)
        rig.write(0x1A00 + number, 0, 0, 1)
        for entry, value in reversed(list(zip(mapping, data, strict=True))):  # sub 0 last
            rig.sdo.download(entry.index, entry.sub, value)
            written += 1
        rig.write(0x1800 + number, 1, cob_id, 4)
    return written


def image(rig, listed: list) -> dict:
    """All settings, and the position."""
    return {(entry.index, entry.sub): rig.sdo.upload(entry.index, entry.sub) for entry in listed
            if (entry.writable and entry.access != "wo" and entry.index != CLOCK)
            or entry.index in (0x6004, 0x6509)}


def test_every_default_is_what_is_read(device):
    rig, listed = device
    compared = 0
    for entry in listed:
        if readable(rig, entry):
            value = entry.decode(rig.sdo.upload(entry.index, entry.sub))
            assert entry.default in (None, value), entry
            compared += entry.default is not None
    assert compared > 110


def test_defaults_come_back_after_load(device):
    """The same after everything else has been there."""
    rig, listed = device
    rig.write(0x1017, 0, 500, 2)
    rig.write(0x6031, 2, 10, 2)
    rig.sdo.download(0x1010, 1, b"save")
    rig.sdo.download(0x1011, 1, b"load")
    rig.reset()
    for entry in listed:
        if readable(rig, entry):
            value = entry.decode(rig.sdo.upload(entry.index, entry.sub))
            assert entry.default in (None, value), entry


def test_everything_can_be_written_back(device):
    rig, listed = device
    before = image(rig, listed)
    rig.tap.forget()
    assert write_back(rig, listed) > 80
    assert image(rig, listed) == before
    assert rig.tap.so_far(0x80 + rig.node_id) == []
    assert rig.read(0x1003) == 0


def test_everything_can_be_written_back_when_configured(device):
    rig, listed = device
    node_id = rig.node_id
    for index, sub, value, size in [
            (0x1005, 0, 0x90, 4), (0x1006, 0, 10000, 4), (0x1012, 0, 0x80000100, 4),
            (0x1016, 1, 0x00110064, 4), (0x1016, 2, 0x001203E8, 4), (0x1029, 1, 2, 1),
            (0x1800, 1, 0x80000180 + node_id, 4), (0x1800, 1, 0x40000222, 4), (0x1801, 2, 0, 1),
            (0x1802, 1, 0x80000000, 4), (0x1803, 5, 500, 2), (0x2101, 0, 77, 1), (0x2120, 2, 0x40, 1),
            (0x2120, 3, 0xA0, 1), (0x2140, 3, 0xFFFFFFFF, 4), (0x6002, 0, 7200, 4),
            (0x6001, 0, 3600, 4), (0x6000, 0, 0x200F, 2), (0x6003, 0, 7199, 4), (0x6031, 2, 1, 2),
            (0x6402, 1, 500, 4), (0x6401, 1, 5000, 4)]:
        rig.write(index, sub, value, size)
    before = image(rig, listed)
    for reverse in (False, True):
        write_back(rig, listed, reverse)
        assert image(rig, listed) == before


def test_what_is_not_to_be_downloaded(device):
    """Each of them needs its flag: it is refused, or does something."""
    rig, listed = device
    flagged = {(entry.index, entry.sub) for entry in listed if entry.flags & NO_DOWNLOAD}
    assert flagged == {(0x1003, 0), (0x1010, 1), (0x1011, 1), (0x2105, 0), (0x300A, 0), (0x300B, 0),
                       (0x6003, 0)}
    for entry in listed:
        if (entry.index, entry.sub) in flagged and entry.index in (0x1010, 0x1011, 0x2105, 0x300B):
            assert abort_code(rig, entry, rig.sdo.upload(entry.index, entry.sub)) in (
                0x08000020, 0x08000022)
    before = rig.read(0x6004)
    rig.write(0x6003, 0, rig.read(0x6003), 4)
    assert rig.read(0x6004) != before


def test_wrong_lengths_and_limits_of_everything(device):
    rig, listed = device
    for entry in listed:
        if not entry.writable or entry.access == "wo":
            continue
        data = rig.sdo.upload(entry.index, entry.sub)
        for size in {1, 2, 3, 4, 5, 8, 0x7FFFFFFF} - {entry.size}:
            expected = TOO_SHORT if size < entry.size else TOO_LONG
            assert announce(rig, entry, size) == expected, (entry, size)
        for limit, beyond in [(entry.low, -1), (entry.high, 1)]:
            if limit is not None:
                value = (int(limit, 0) + beyond).to_bytes(entry.size, "little")
                assert abort_code(rig, entry, value) == RANGE, entry
        if entry.index != CLOCK:
            assert rig.sdo.upload(entry.index, entry.sub) == data, entry


@pytest.mark.parametrize("number", range(1, 5))
def test_type_0_sends(start, number):
    rig = start()
    can_id = 0x100 * number + 0x80 + rig.node_id
    rig.write(0x1800 + number - 1, 2, 0, 1)
    rig.start()
    rig.tap.forget()
    rig.network.sync.transmit()
    rig.barrier()
    assert len(rig.tap.so_far(can_id)) == 1
    rig.network.sync.transmit()
    rig.barrier()
    assert rig.tap.so_far(can_id) == []


@pytest.mark.parametrize("data", [b"\x00", b"", b"\x85", b"\xff", b"\x05\x05", bytes(8)],
                         ids=lambda data: data.hex() or "empty")
def test_what_is_no_heartbeat_does_not_start_the_consumer(rig, data):
    rig.write(0x1016, 1, 0x000700C8, 4)
    rig.start()
    rig.tap.forget()
    rig.send(0x707, data)
    time.sleep(0.4)
    assert rig.guard() & 0x7F == 5
    assert rig.read(0x1003) == 0
    rig.send(0x707, b"\x05")
    rig.emergency(0x8130)
    assert rig.guard() & 0x7F == 0x7F
