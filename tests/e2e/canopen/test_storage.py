# SPDX-License-Identifier: MIT
"""1010h, 1011h and 2105h over `kill -9`, resets and restarts."""
import can
import pytest
from can_rig import LOAD, SAVE
from canopen.sdo.exceptions import SdoAbortedError


def test_saved_over_kill(start, nvm):
    rig = start("--nvm", nvm)
    rig.node.tpdo.read()
    pdo = rig.node.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6030, 1)
    pdo.add_variable(0x6004)
    pdo.trans_type = 4
    pdo.save()
    rig.write(0x1800, 5, 33, 2)
    rig.write(0x1029, 1, 2, 1)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.write(0x1006, 0, 10000, 4)
    rig.kill()
    rig = start("--nvm", nvm)
    rig.node.tpdo.read()
    assert [entry.index for entry in rig.node.tpdo[1].map] == [0x6030, 0x6004]
    assert rig.node.tpdo[1].trans_type == 4
    assert rig.read(0x6200) == 33
    assert rig.read(0x1029, 1) == 2
    assert rig.read(0x1006) == 0


def test_not_saved_is_lost(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x1006, 0, 10000, 4)
    rig.reset()
    assert rig.read(0x1006) == 0


def test_without_memory_state_is_lost(start):
    rig = start()
    rig.write(0x1006, 0, 10000, 4)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.reset()
    assert rig.read(0x1006) == 10000
    rig.kill()
    assert start().read(0x1006) == 0


def test_restore(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x1006, 0, 10000, 4)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.reset()
    assert rig.read(0x1006) == 10000
    rig.sdo.download(0x1011, 1, LOAD)
    assert rig.read(0x1006) == 10000
    rig.reset()
    assert rig.read(0x1006) == 0
    rig.kill()
    assert start("--nvm", nvm).read(0x1006) == 0


def test_restore_over_kill(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x1006, 0, 10000, 4)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.sdo.download(0x1011, 1, LOAD)
    rig.kill()
    assert start("--nvm", nvm).read(0x1006) == 0


def test_bus_parameters_over_kill(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x2101, 0, 34, 1)
    rig.write(0x2102, 0, 0, 1)
    rig.write(0x1006, 0, 10000, 4)
    rig.sdo.download(0x2105, 0, SAVE)
    rig.kill()
    rig = start("--nvm", nvm, node_id=34)
    assert rig.said_node_id in (None, 34)
    assert (rig.read(0x2101), rig.read(0x2102), rig.read(0x1006)) == (34, 0, 0)


def test_bus_parameters_at_reset_node(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x2101, 0, 34, 1)
    rig.sdo.download(0x2105, 0, SAVE)
    rig.reset(0x82)
    rig.reset(0x81, node_id=34)
    rig.use(34)
    assert rig.read(0x100B) == 34


def test_parameters_are_not_bus_parameters(start, nvm):
    rig = start("--nvm", nvm)
    rig.write(0x2101, 0, 34, 1)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.kill()
    assert start("--nvm", nvm).read(0x2101) == 63


@pytest.mark.parametrize("index, sub", [(0x1010, 1), (0x1011, 1), (0x2105, 0)])
def test_other_signatures(rig, index, sub):
    with pytest.raises(SdoAbortedError) as caught:
        rig.sdo.download(index, sub, b"evas")
    assert caught.value.code == 0x08000020
    assert rig.read(index, sub) == 1


def test_a_save_cut_by_kill_is_old_or_new(start, nvm):
    """Whatever the encoder was at when it was killed, its memory holds one of the two values."""
    save = can.Message(arbitration_id=0x63F, data=bytes.fromhex("2310100173617665"),
                       is_extended_id=False)
    possible = {0}
    for value in range(1, 7):
        rig = start("--nvm", nvm)
        before = rig.read(0x1006)
        assert before in possible
        rig.write(0x1006, 0, value, 4)
        rig.kill(save, after_s=0.004 * value)
        possible = {before, value}
    assert start("--nvm", nvm).read(0x1006) in possible
