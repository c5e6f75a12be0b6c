# SPDX-License-Identifier: MIT
"""PDOs of every type, received by a client that read their parameters from the encoder."""
import struct
import time

import pytest
from canopen.sdo.exceptions import SdoAbortedError

POSITION = {"0": 0, "90DEG": 16384, "2.5REV": 163840}


def set_type(rig, number: int, kind: int):
    rig.write(0x1800 + number - 1, 2, kind, 1)


def invalidate(rig, number: int) -> int:
    """Returns the COB-ID for later."""
    cob_id = rig.read(0x1800 + number - 1, 1)
    rig.write(0x1800 + number - 1, 1, cob_id | 1 << 31, 4)
    return cob_id


@pytest.mark.parametrize("shaft", POSITION)
def test_all_four_on_start(start, shaft):
    rig = start("--shaft", shaft)
    rig.tap.forget()
    rig.nmt.send_command(0x01)
    position = struct.pack("<I", POSITION[shaft])
    assert rig.tap.data(0x1BF) == position
    assert rig.tap.data(0x3BF) == bytes(2)
    raw = rig.tap.data(0x4BF)
    assert raw[:4] == position and len(raw) == 6
    rig.network.sync.transmit()
    assert rig.tap.data(0x2BF) == position


def test_client_reads_the_default_mapping(rig):
    rig.node.tpdo.read()
    mapped = [[(entry.index, entry.subindex, entry.length) for entry in rig.node.tpdo[number].map]
              for number in range(1, 5)]
    assert mapped == [[(0x6004, 0, 32)], [(0x6004, 0, 32)], [(0x6030, 1, 16)],
                      [(0x2160, 0, 32), (0x2162, 0, 16)]]
    assert [rig.node.tpdo[number].cob_id for number in range(1, 5)] == [0x1BF, 0x2BF, 0x3BF, 0x4BF]
    assert [rig.node.tpdo[number].trans_type for number in range(1, 5)] == [255, 1, 255, 255]
    assert all(rig.node.tpdo[number].rtr_allowed for number in range(1, 5))


def test_remap_tpdo1(start):
    rig = start("--shaft", "60RPM")
    rig.node.tpdo.read()
    pdo = rig.node.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6030, 1)
    pdo.add_variable(0x6004)
    pdo.trans_type = 1
    pdo.enabled = True
    pdo.save()
    assert rig.read(0x1A00, 0) == 2
    rig.start()
    speed, end = 0, time.monotonic() + 5
    while abs(speed - 60) > 1 and time.monotonic() < end:  # it is the mean over the last 100 ms
        rig.tap.forget()
        rig.network.sync.transmit()
        speed, position = struct.unpack("<hI", rig.tap.data(0x1BF))
    assert abs(speed - 60) <= 1
    assert (pdo[0].raw, pdo[1].raw) == (speed, position)
    rig.network.sync.transmit()
    later = struct.unpack("<hI", rig.tap.data(0x1BF))[1]
    assert later > position


def test_remap_out_of_order_is_refused(rig):
    with pytest.raises(SdoAbortedError) as caught:
        rig.write(0x1A00, 0, 0, 1)
    assert caught.value.code == 0x06010000


def test_rtr(rig):
    rig.start()
    for can_id, length in [(0x1BF, 4), (0x2BF, 4), (0x3BF, 2), (0x4BF, 6)]:
        rig.tap.forget()
        rig.request(can_id)
        assert len(rig.tap.data(can_id)) == length


def test_rtr_not_allowed(rig):
    cob_id = invalidate(rig, 1)
    rig.write(0x1800, 1, cob_id | 1 << 30, 4)
    rig.start()
    rig.tap.forget()
    rig.request(0x1BF)
    rig.barrier()
    assert rig.tap.so_far(0x1BF) == []


@pytest.mark.parametrize("divisor", [1, 2, 4, 240])
def test_sync_divisor(rig, divisor):
    set_type(rig, 2, divisor)
    rig.start()
    fired = []
    for number in range(1, max(12, divisor + 1) + 1):
        rig.tap.forget()
        rig.network.sync.transmit()
        if divisor <= 12 or number % 60 == 0 or number > 238:
            rig.barrier()
            fired += [number] * len(rig.tap.so_far(0x2BF))
    assert fired == list(range(divisor, max(12, divisor + 1) + 1, divisor))


def test_type_253_is_sampled_at_the_request(start):
    rig = start("--shaft", "600RPM")
    set_type(rig, 1, 253)
    rig.start()
    rig.tap.forget()
    rig.network.sync.transmit()
    rig.barrier()
    assert rig.tap.so_far(0x1BF) == []
    rig.request(0x1BF)
    first = rig.tap.data(0x1BF)
    rig.request(0x1BF)
    assert rig.tap.data(0x1BF) != first


def test_type_252_is_sampled_at_the_sync(start):
    rig = start("--shaft", "600RPM")
    set_type(rig, 1, 252)
    set_type(rig, 2, 1)
    rig.start()
    rig.tap.forget()
    rig.network.sync.transmit()
    sampled = rig.tap.data(0x2BF)
    for _ in range(3):
        rig.request(0x1BF)
        assert rig.tap.data(0x1BF) == sampled


def test_one_sync_one_moment(start):
    rig = start("--shaft", "6000RPM")
    set_type(rig, 1, 1)
    rig.start()
    for _ in range(20):
        rig.tap.forget()
        rig.network.sync.transmit()
        assert rig.tap.data(0x1BF) == rig.tap.data(0x2BF)


@pytest.mark.parametrize("kind", [254, 255])
def test_event_timer(rig, kind):
    set_type(rig, 1, kind)
    rig.write(0x1800, 5, 50, 2)
    rig.start()
    rig.tap.wait(0x1BF)
    rig.tap.has_period(0x1BF, 0.045, 0.075)
    rig.write(0x6200, 0, 20, 2)
    assert rig.read(0x1800, 5) == 20
    rig.tap.forget()
    rig.tap.wait(0x1BF)
    rig.tap.has_period(0x1BF, 0.018, 0.035)
    rig.write(0x1800, 5, 0, 2)
    rig.tap.forget()
    rig.barrier()
    assert rig.tap.so_far(0x1BF) == []


def test_inhibit_time(rig):
    cob_id = invalidate(rig, 3)
    rig.write(0x1802, 3, 1000, 2)
    rig.write(0x1802, 1, cob_id, 4)
    rig.write(0x1802, 5, 10, 2)
    rig.start()
    rig.tap.wait(0x3BF)
    rig.tap.has_period(0x3BF, 0.095, 0.15, count=5)


def test_other_can_id(rig):
    invalidate(rig, 1)
    rig.write(0x1800, 1, 0x190, 4)
    rig.tap.forget()
    rig.start()
    assert len(rig.tap.data(0x190)) == 4


def test_no_pdo_outside_operational(rig):
    rig.write(0x1800, 5, 10, 2)
    rig.tap.forget()
    rig.network.sync.transmit()
    rig.request(0x1BF)
    rig.barrier()
    with rig.tap.arrived:
        assert {f.arbitration_id for f in rig.tap.frames if not f.is_remote_frame} <= {
            0x80, 0x63F, 0x5BF}
