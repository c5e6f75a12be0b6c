# SPDX-License-Identifier: MIT
"""SDO: expedited, segmented, block, and what is refused."""
import pytest
from canopen.sdo.exceptions import SdoAbortedError

NAME = b"F36x8 CANopen encoder"


def refused(call, *arguments, **options) -> int:
    with pytest.raises(SdoAbortedError) as caught:
        call(*arguments, **options)
    return caught.value.code


def test_expedited(rig):
    rig.sdo[0x1017].raw = 0
    rig.sdo[0x1006].raw = 10000
    rig.sdo[0x1029][1].raw = 2
    assert (rig.sdo[0x1017].raw, rig.sdo[0x1006].raw, rig.sdo[0x1029][1].raw) == (0, 10000, 2)


def test_segmented_upload(rig):
    assert rig.sdo.upload(0x1008, 0) == NAME
    assert rig.sdo[0x1008].raw == NAME.decode()


def test_segmented_download(rig):
    with rig.sdo.open(0x1006, mode="wb", size=4, force_segment=True) as stream:
        stream.write((123456).to_bytes(4, "little"))
    assert rig.read(0x1006) == 123456


# Uploads with the CRC only: this client takes a server that can do CRC for one that has agreed to
# it, and then refuses the 0 that CiA 301 wants in its place. The conformance rows have the other.
def test_block_upload(rig):
    with rig.sdo.open(0x1008, block_transfer=True) as stream:
        assert stream.read() == NAME
    with rig.sdo.open(0x1000, block_transfer=True) as stream:
        assert stream.read() == bytes.fromhex("96010200")


@pytest.mark.parametrize("crc", [True, False])
def test_block_download(rig, crc):
    with rig.sdo.open(0x1006, mode="wb", size=4, block_transfer=True,
                      request_crc_support=crc) as stream:
        stream.write((123456).to_bytes(4, "little"))
    assert rig.read(0x1006) == 123456


def test_refusals(rig):
    assert refused(rig.sdo.upload, 0x1999, 0) == 0x06020000
    assert refused(rig.sdo.upload, 0x1018, 9) == 0x06090011
    assert refused(rig.sdo.download, 0x1000, 0, bytes(4)) == 0x06010002
    assert refused(rig.sdo.download, 0x1017, 0, bytes(4)) == 0x06070012
    assert refused(rig.sdo.download, 0x1017, 0, bytes(1)) == 0x06070013
    assert refused(rig.sdo.download, 0x1029, 1, b"\x03") == 0x06090030
    assert refused(rig.sdo.download, 0x1003, 0, b"\x01") == 0x06090030
    assert refused(rig.sdo.open, 0x1999, block_transfer=True) == 0x06020000
    assert refused(rig.sdo.open, 0x1000, mode="wb", size=4, block_transfer=True) == 0x06010002


def test_wrong_toggle(rig):
    rig.tap.forget()
    rig.send(0x63F, bytes.fromhex("4008100000000000"))
    assert rig.tap.data(0x5BF) == bytes.fromhex("4108100015000000")
    rig.send(0x63F, bytes.fromhex("7000000000000000"))
    assert rig.tap.data(0x5BF) == bytes.fromhex("8008100000000305")


def test_timeout(rig):
    rig.tap.forget()
    rig.send(0x63F, bytes.fromhex("4008100000000000"))
    begun = rig.tap.wait(0x5BF)
    ended = rig.tap.wait(0x5BF)
    assert bytes(ended.data) == bytes.fromhex("8008100000000405")
    assert 0.9 < ended.timestamp - begun.timestamp < 2.0


def test_a_new_request_ends_the_old_one(rig):
    rig.tap.forget()
    rig.send(0x63F, bytes.fromhex("4008100000000000"))
    rig.send(0x63F, bytes.fromhex("4000100000000000"))
    assert rig.tap.data(0x5BF)[0] == 0x41
    assert rig.tap.data(0x5BF) == bytes.fromhex("4300100096010200")


def test_many_requests(rig):
    for number in range(300):
        rig.write(0x2140, 1, number, 4)
        assert rig.read(0x2140, 1) == number
