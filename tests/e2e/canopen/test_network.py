# SPDX-License-Identifier: MIT
"""NMT, error control, emergencies."""
import pytest
from canopen.sdo.exceptions import SdoCommunicationError

STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x04, 0x05, 0x7F


def test_states(rig):
    assert rig.guard() & 0x7F == PRE_OPERATIONAL
    for command, state in [(0x01, OPERATIONAL), (0x80, PRE_OPERATIONAL), (0x02, STOPPED),
                           (0x01, OPERATIONAL), (0x02, STOPPED), (0x80, PRE_OPERATIONAL)]:
        rig.nmt.send_command(command)
        assert rig.guard() & 0x7F == state


def test_all_nodes(rig):
    rig.network.nmt.send_command(0x01)
    assert rig.guard() & 0x7F == OPERATIONAL


def test_other_nodes(rig):
    rig.send(0x000, bytes([0x01, 64]))
    assert rig.guard() & 0x7F == PRE_OPERATIONAL


@pytest.mark.parametrize("command", [0x81, 0x82])
def test_resets(rig, command):
    for before in (0x80, 0x01, 0x02):
        rig.nmt.send_command(before)
        rig.reset(command)
        assert rig.guard() == PRE_OPERATIONAL


def test_client_sees_the_boot_up(rig):
    rig.start()
    assert rig.nmt.state == "OPERATIONAL"
    rig.reset()
    assert rig.nmt.state == "PRE-OPERATIONAL"


def test_stopped_has_no_sdo(rig):
    rig.nmt.send_command(0x02)
    rig.sdo.RESPONSE_TIMEOUT = 0.2
    with pytest.raises(SdoCommunicationError):
        rig.sdo.upload(0x1000, 0)
    rig.sdo.RESPONSE_TIMEOUT = 5.0
    rig.nmt.send_command(0x80)
    rig.barrier()


def test_guarding_toggles(rig):
    assert [rig.guard() for _ in range(4)] == [0x7F, 0xFF, 0x7F, 0xFF]
    rig.reset(0x82)
    assert rig.guard() == 0x7F


def test_no_guarding_beside_a_heartbeat(rig):
    rig.write(0x1017, 0, 60000, 2)
    rig.tap.forget()
    rig.request(0x73F)
    rig.barrier()
    assert rig.tap.so_far(0x73F) == []


def test_life_guarding(rig):
    rig.write(0x100C, 0, 50, 2)
    rig.write(0x100D, 0, 2, 1)
    rig.start()
    assert rig.guard() == OPERATIONAL
    assert rig.emergency(0x8130).register == 0x11
    rig.request(0x73F)
    assert rig.tap.data(0x73F)[0] & 0x7F == PRE_OPERATIONAL
    assert rig.emergency(0x0000).register == 0


def test_heartbeat_producer(rig):
    rig.write(0x1017, 0, 50, 2)
    assert rig.nmt.wait_for_heartbeat(5.0) == "PRE-OPERATIONAL"
    rig.tap.forget()
    rig.tap.has_period(0x73F, 0.045, 0.075)
    rig.nmt.send_command(0x01)
    rig.barrier()
    assert rig.nmt.wait_for_heartbeat(5.0) == "OPERATIONAL"
    rig.nmt.send_command(0x02)
    frame = rig.tap.data(0x73F)
    while frame != bytes([STOPPED]):
        frame = rig.tap.data(0x73F)


def test_heartbeat_consumer(rig):
    rig.write(0x1016, 1, 1000 | 7 << 16, 4)  # longer than a busy machine stands still between two of them
    rig.start()
    for _ in range(4):
        rig.send(0x707, b"\x05")
        rig.barrier()
    error = rig.emergency(0x8130)
    assert (error.register, error.data) == (0x11, bytes(5))
    assert rig.guard() & 0x7F == PRE_OPERATIONAL
    assert rig.read(0x1003, 0) == 1
    assert rig.read(0x1003, 1) & 0xFFFF == 0x8130


@pytest.mark.parametrize("reaction, state", [(0, PRE_OPERATIONAL), (1, OPERATIONAL), (2, STOPPED)])
def test_error_behaviour(rig, reaction, state):
    rig.write(0x1029, 1, reaction, 1)
    rig.write(0x1016, 2, 20 | 9 << 16, 4)
    rig.start()
    rig.send(0x709, b"\x05")
    assert rig.emergency(0x8130).register == 0x11
    assert rig.guard() & 0x7F == state


def test_emergency_of_a_sync_with_a_wrong_length(rig):
    rig.send(0x080, b"\x01")
    rig.emergency(0x8240)
    rig.network.sync.transmit()
    rig.emergency(0x0000)
    assert rig.read(0x1001) == 0
    rig.write(0x1003, 0, 0, 1)
    assert rig.read(0x1003, 0) == 0


def test_emergency_inhibit_time(rig):
    rig.write(0x1015, 0, 2000, 2)
    rig.tap.forget()

    def fail_and_mend():
        rig.send(0x080, b"\x01")
        rig.network.sync.transmit()

    rig.tap.has_period(0x0BF, 0.19, 0.4, count=1, cause=fail_and_mend)
