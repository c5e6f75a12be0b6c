# SPDX-License-Identifier: MIT
"""Two INTERBUS encoders in a ring behind a Modbus/TCP coupler, read with pymodbus."""
import time

import pytest
from pymodbus.client import ModbusTcpClient

RIG = """
[bus ring]
wire = modbus
address = 127.0.0.1:0
[encoder lift]
model = ocd-ib-k2
bus = ring
[encoder slide]
model = ocd-ib-k3
bus = ring
"""
STEPS_PER_TURN = 4096
LIFT, SLIDE = 0, 2  # first input registers: each has two
NO_POSITION = 1 << 31
COUPLER_STATUS = 0x100C
SLIDE_OUT = 0x0800 + SLIDE
RELEASE, ILLEGAL = 0x80000000, 0x82000000
RUN, BUS_ERROR = 1, 2


@pytest.fixture
def rig(drehgeber_rig):
    return drehgeber_rig(RIG)


@pytest.fixture
def coupler(rig):
    host, _, port = rig.encoders["lift"].address.rpartition(":")
    client = ModbusTcpClient(host, port=int(port))
    assert client.connect()
    yield client
    client.close()


def word(coupler, register: int) -> int:
    """IN of an encoder, high word first."""
    high, low = coupler.read_input_registers(register, count=2).registers
    return high << 16 | low


def status(coupler) -> int:
    return coupler.read_input_registers(COUPLER_STATUS, count=1).registers[0]


def wait_for(condition):
    """The ring has its own cycle: what is done shows in one of the next."""
    end = time.monotonic() + 5
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_both_follow_their_shaft(rig, coupler):
    rig.encoders["lift"].shaft.position = 540
    wait_for(lambda: word(coupler, LIFT) == 1.5 * STEPS_PER_TURN)
    wait_for(lambda: word(coupler, SLIDE) == 1.5 * STEPS_PER_TURN)


def test_a_lost_track_has_no_position(rig, coupler):
    wait_for(lambda: word(coupler, SLIDE) == 0)
    with rig.encoders["slide"].fault("singleturn_lost"):
        wait_for(lambda: word(coupler, SLIDE) & NO_POSITION)
    wait_for(lambda: word(coupler, SLIDE) == 0)


def send(coupler, out: int, answer: int):
    """OUT of the slide until IN is the answer."""
    coupler.write_registers(SLIDE_OUT, [out >> 16, out & 0xFFFF])
    wait_for(lambda: word(coupler, SLIDE) == answer)


def test_10000_steps_over_3_turns(rig, coupler):
    rig.encoders["slide"].shaft.position = 3 * 360
    wait_for(lambda: word(coupler, SLIDE) == 3 * STEPS_PER_TURN)
    send(coupler, 0x02000000 | 10000, 0xC2000000 | 10000)
    send(coupler, 0x04000000 | 3, 0xC4000000 | 3)  # an echo: the release judges both
    send(coupler, RELEASE, 10000)


def test_more_steps_than_the_discs_have(rig, coupler):
    send(coupler, 0x02000000 | 5000, 0xC2000000 | 5000)
    send(coupler, RELEASE, ILLEGAL)
    send(coupler, 0, ILLEGAL)
    time.sleep(0.01)  # a release is an edge: the ring has to see bit 31 clear
    send(coupler, RELEASE, 0)


def test_a_cut_cable_stops_the_ring(rig, coupler):
    wait_for(lambda: status(coupler) == RUN)
    with rig.encoders["slide"].fault("wire_break"):
        wait_for(lambda: status(coupler) & BUS_ERROR)
    wait_for(lambda: status(coupler) == RUN)
