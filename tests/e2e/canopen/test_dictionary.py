# SPDX-License-Identifier: MIT
"""Every object of the EDS file is there, and can be read and written as the file says."""
import logging

import canopen
import pytest
from canopen.objectdictionary import ODVariable
from canopen.sdo.exceptions import SdoAbortedError

WRITE_ONLY = 0x06010001
READ_ONLY = 0x06010002
STATE = 0x08000022
NO_DATA = 0x08000024
STORE = 0x08000020

# The password opens the serial number for one write; anything else is refused.
PASSWORD = 0x300A
PROTECTED = 0x300B
# A read value written back is no signature.
SIGNED = {0x1010, 0x1011, 0x2105}
MAPPINGS = range(0x1A00, 0x1A04)
CLOCK = 0x1013


def variables(eds, node_id=63):
    """All (index, sub, variable) of the EDS file."""
    dictionary = canopen.import_od(str(eds), node_id)
    for index in dictionary:
        entry = dictionary[index]
        members = [entry] if isinstance(entry, ODVariable) else entry.subindices.values()
        for variable in members:
            yield index, variable.subindex, variable


def abort_code(call, *arguments) -> int:
    with pytest.raises(SdoAbortedError) as caught:
        call(*arguments)
    return caught.value.code


def invalidate_pdos(rig):
    for number in range(4):
        rig.write(0x1800 + number, 1, rig.read(0x1800 + number, 1) | 1 << 31, 4)
        rig.write(0x1A00 + number, 0, 0, 1)


def test_import_without_warning(eds, caplog):
    with caplog.at_level(logging.WARNING):
        dictionary = canopen.import_od(str(eds), 63)
    assert caplog.records == []
    assert dictionary.device_information.vendor_number == 0x13
    assert dictionary.device_information.product_number == 0x56682001
    assert dictionary.device_information.revision_number == 108
    assert dictionary.device_information.LSS_supported
    assert dictionary.device_information.nr_of_TXPDO == 4
    assert dictionary.device_information.nr_of_RXPDO == 0


def test_lists_every_object_of_the_manual(eds):
    dictionary = canopen.import_od(str(eds), 63)
    wanted = [0x1000, 0x1001, 0x1002, 0x1003, 0x1004, 0x1005, 0x1006, 0x1007, 0x1008, 0x1009,
              0x100A, 0x100B, 0x100C, 0x100D, 0x1010, 0x1011, 0x1012, 0x1013, 0x1014, 0x1015,
              0x1016, 0x1017, 0x1018, 0x1029, 0x1800, 0x1801, 0x1802, 0x1803, 0x1A00,
              0x1A01, 0x1A02, 0x1A03, 0x2100, 0x2101, 0x2102, 0x2103, 0x2105, 0x2160, 0x2161,
              0x2162, 0x2110, 0x2120, 0x2125, 0x2140, 0x300A, 0x300B, 0x6000, 0x6001, 0x6002, 0x6003,
              0x6004, 0x6030, 0x6031, 0x6040, 0x6200, 0x6400, 0x6401, 0x6402, 0x6500, 0x6501, 0x6502,
              0x6503, 0x6504, 0x6505, 0x6506, 0x6507, 0x6508, 0x6509, 0x650A, 0x650B, 0x650D, 0x650E]
    assert [index for index in wanted if index not in dictionary] == []


def test_read_every_object(rig, eds):
    read = 0
    for index, sub, variable in variables(eds):
        if index == 0x1003 and sub > 0:
            assert abort_code(rig.sdo.upload, index, sub) == NO_DATA
            continue
        if index == PASSWORD:
            assert not variable.readable
            assert abort_code(rig.sdo.upload, index, sub) == WRITE_ONLY
            continue
        assert variable.readable, variable
        data = rig.sdo.upload(index, sub)
        if variable.default is not None:
            assert variable.decode_raw(data) == variable.default, variable
        if len(variable) and isinstance(variable.default, int):
            assert len(data) * 8 == len(variable), variable
        read += 1
    assert read > 100


def test_write_every_object_that_may_be_written(rig, eds):
    invalidate_pdos(rig)
    written = 0
    for index, sub, variable in variables(eds):
        if not variable.writable or (index in MAPPINGS and sub == 0):
            continue
        if index == PASSWORD:
            assert abort_code(rig.sdo.download, index, sub, bytes(4)) == STORE
            continue
        data = rig.sdo.upload(index, sub)
        if index == PROTECTED:
            assert abort_code(rig.sdo.download, index, sub, data) == STATE
        elif index in SIGNED:
            assert abort_code(rig.sdo.download, index, sub, data) == STORE
        else:
            rig.sdo.download(index, sub, data)
            assert index == CLOCK or rig.sdo.upload(index, sub) == data, variable
        written += 1
    assert written > 50


def test_write_every_object_that_may_not_be_written(rig, eds):
    refused = 0
    for index, sub, variable in variables(eds):
        if variable.writable:
            continue
        size = max(1, len(variable) // 8)
        assert abort_code(rig.sdo.download, index, sub, bytes(size)) == READ_ONLY, variable
        refused += 1
    assert refused > 20


def test_what_the_eds_does_not_list_does_not_exist(rig, eds):
    listed = {index for index, _, _ in variables(eds)}
    for index in [*range(0x1000, 0x1020), *range(0x2100, 0x2106), 0x1400, 0x1200, 0x6005, 0xA000]:
        if index not in listed:
            assert abort_code(rig.sdo.upload, index, 0) == 0x06020000
    for index, sub in [(0x1000, 1), (0x1018, 5), (0x1800, 4), (0x1800, 6), (0x1A00, 9)]:
        assert abort_code(rig.sdo.upload, index, sub) == 0x06090011


def test_identity(start):
    rig = start("--serial", "1234567890")
    assert [rig.read(0x1018, sub) for sub in range(5)] == [4, 0x13, 0x56682001, 108, 1234567890]
    assert rig.read(0x1000) == 0x00020196


def test_node_id_of_the_command_line(start):
    rig = start("--node", "17", node_id=17)
    assert rig.said_node_id in (None, 17)
    assert rig.read(0x100B) == 17
    assert rig.read(0x1800, 1) == 0x180 + 17
    rig.reset()
