# SPDX-License-Identifier: MIT
"""LSS with canopen's master."""
import pytest
from canopen.lss import LssError, LssMaster

IDENTITY = (0x13, 0x56682001, 108, 1234567890)
SERIAL = ("--serial", "1234567890")


@pytest.fixture
def rig(start):
    return start(*SERIAL)


def configuration(rig) -> LssMaster:
    rig.network.lss.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
    return rig.network.lss


def wait(rig):
    rig.network.lss.send_switch_state_global(LssMaster.WAITING_STATE)


def scan(lss):
    """Fastscan. It takes silence for half of the answers, so a machine that stands still misleads it."""
    for lss.RESPONSE_TIMEOUT in (0.1, 0.2, 0.4):
        found = lss.fast_scan()
        if found[0]:
            break
    lss.RESPONSE_TIMEOUT = 2.0
    return found


def test_inquire(rig):
    lss = configuration(rig)
    assert lss.inquire_node_id() == 63
    assert tuple(lss.inquire_lss_address(cs) for cs in range(0x5A, 0x5E)) == IDENTITY


def test_selective(rig):
    lss = rig.network.lss
    assert lss.send_switch_state_selective(*IDENTITY)
    assert lss.inquire_node_id() == 63
    wait(rig)
    lss.RESPONSE_TIMEOUT = 0.2
    with pytest.raises(LssError):
        lss.send_switch_state_selective(*IDENTITY[:3], 1234567891)


def test_identify(rig):
    lss = rig.network.lss
    lss.RESPONSE_TIMEOUT = 0.2
    rig.tap.forget()
    lss.send_identify_remote_slave(*IDENTITY[:2], 0, 200, 0, 0xFFFFFFFF)
    assert rig.tap.data(0x7E4) == bytes.fromhex("4F00000000000000")
    lss.send_identify_remote_slave(*IDENTITY[:2], 0, 107, 0, 0xFFFFFFFF)
    rig.barrier()
    assert rig.tap.so_far(0x7E4) == []


def test_configure_node_id(rig):
    configuration(rig).configure_node_id(5)
    rig.tap.forget()
    wait(rig)
    assert rig.tap.data(0x705) == b"\x00"
    rig.use(5)
    assert rig.read(0x100B) == 5


def test_refused_node_id_and_bit_timing(rig):
    lss = configuration(rig)
    for call, value in [(lss.configure_node_id, 0), (lss.configure_node_id, 128),
                        (lss.configure_bit_timing, 1), (lss.configure_bit_timing, 5)]:
        with pytest.raises(LssError):
            call(value)
    wait(rig)
    rig.barrier()


def test_store_over_kill(start, nvm):
    rig = start("--nvm", nvm)
    lss = configuration(rig)
    lss.configure_node_id(9)
    lss.store_configuration()
    rig.kill()
    rig = start("--nvm", nvm, node_id=9)
    assert rig.said_node_id in (None, 9)
    assert rig.read(0x2101) == 9


def test_without_store_the_node_id_is_lost(start, nvm):
    rig = start("--nvm", nvm)
    configuration(rig).configure_node_id(9)
    rig.tap.forget()
    wait(rig)
    assert rig.tap.data(0x709) == b"\x00"
    rig.kill()
    assert start("--nvm", nvm).read(0x100B) == 63


def test_saved_defaults_follow_fastscan(start, nvm):
    """The usual order at commissioning: save, take the node-ID away, find it, give it another."""
    rig = start("--nvm", nvm, *SERIAL)
    rig.write(0x1801, 1, 0x800002BF, 4)
    rig.write(0x1801, 1, 0x222, 4)
    rig.sdo.download(0x1010, 1, b"save")
    lss = configuration(rig)
    lss.configure_node_id(0xFF)
    lss.store_configuration()
    wait(rig)
    assert scan(lss) == (True, list(IDENTITY))
    lss.configure_node_id(12)
    lss.store_configuration()
    rig.kill()
    rig = start("--nvm", nvm, *SERIAL, node_id=12)
    assert [rig.read(index, 1) for index in range(0x1800, 0x1804)] == [0x18C, 0x222, 0x38C, 0x48C]
    assert rig.read(0x1014) == 0x8C


def test_not_in_operational(rig):
    rig.start()
    lss = configuration(rig)
    lss.RESPONSE_TIMEOUT = 0.2
    with pytest.raises(LssError):
        lss.inquire_node_id()


def test_fastscan(rig):
    lss = configuration(rig)
    lss.configure_node_id(0xFF)
    wait(rig)
    assert scan(lss) == (True, list(IDENTITY))
    assert lss.inquire_node_id() == 0xFF
    lss.configure_node_id(21)
    rig.tap.forget()
    wait(rig)
    assert rig.tap.data(0x715) == b"\x00"
    rig.use(21)
    assert rig.read(0x1018, 4) == IDENTITY[3]


def test_no_fastscan_with_a_node_id(rig):
    rig.network.lss.RESPONSE_TIMEOUT = 0.2
    assert rig.network.lss.fast_scan() == (False, None)
