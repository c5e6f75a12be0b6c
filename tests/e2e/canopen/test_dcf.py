# SPDX-License-Identifier: MIT
"""A master that configures the encoder at boot-up: the concise DCF that `dcfgen` (lely-core's, PyPI dcf-tools)
makes from the encoder's own EDS file, written in its order over whatever the encoder has saved, and the
encoder started then, as CiA 302-2 has it."""
import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from can_rig import SAVE
from canopen.sdo.exceptions import SdoAbortedError

DCFGEN = Path(sys.executable).parent / "dcfgen"
NODE_ID = 4
TPDO1, TPDO2 = 0x180 + NODE_ID, 0x280 + NODE_ID
COB_ID_REFUSED = 0x06090030
# Chapter 12 (738-760), in the order of indices. The manual has 6002h before 6001h.
EXAMPLE = """
  heartbeat_producer: 500
  tpdo:
    1: {transmission: 0xFF, event_timer: 10}
    2: {transmission: 0xFF, event_timer: 20, mapping: [{index: 0x6030, sub_index: 1}]}
  sdo:
    - {index: 0x6000, value: 4}
    - {index: 0x6001, value: 3600}
    - {index: 0x6002, value: 36000}
    - {index: 0x6003, value: 0}
    - {index: 0x6401, sub_index: 1, value: 1000}
    - {index: 0x6402, sub_index: 1, value: 35000}
"""
SWAP = """
  tpdo:
    1: {cob_id: 0x284}
    2: {cob_id: 0x184, mapping: [{index: 0x6030, sub_index: 1}]}
"""
LIMITS = """
  sdo:
    - {index: 0x2120, sub_index: 2, value: 0x40}
    - {index: 0x2120, sub_index: 3, value: 0x60}
    - {index: 0x6401, sub_index: 1, value: 1000}
    - {index: 0x6401, sub_index: 2, value: 1000}
    - {index: 0x6402, sub_index: 1, value: 35000}
    - {index: 0x6402, sub_index: 2, value: 35000}
"""


@pytest.fixture
def generate(tmp_path, eds):
    """generate(yaml): what dcfgen makes of it, a list of (index, sub, data). A warning, of the EDS file for
    one, is an error."""
    def make(wanted: str) -> list:
        (tmp_path / "master.yml").write_text(f"""
master:
  node_id: 1
encoder:
  dcf: {eds}
  node_id: {NODE_ID}
  revision_number: 0x6C
{wanted}""")
        subprocess.run([DCFGEN, "-r", "-d", tmp_path, tmp_path / "master.yml"], check=True, cwd=tmp_path,
                       env={**os.environ, "PYTHONWARNINGS": "error"})
        return read_concise((tmp_path / "encoder.bin").read_bytes())

    return make


def read_concise(data: bytes) -> list:
    """CiA 302-3: how many, then index, sub-index, size and data of each."""
    count, at, entries = int.from_bytes(data[:4], "little"), 4, []
    for _ in range(count):
        index, sub, size = struct.unpack_from("<HBI", data, at)
        at += 7
        entries.append((index, sub, data[at:at + size]))
        at += size
    assert at == len(data)
    return entries


def boot(rig, entries: list):
    """Write them in their order, and start the node. What is refused ends it."""
    for index, sub, data in entries:
        rig.sdo.download(index, sub, data)
    rig.start()


def pdos(rig) -> dict:
    """How long the PDOs are that come on entering Operational and at a SYNC, by CAN-ID."""
    rig.nmt.send_command(0x80)
    rig.barrier()
    rig.tap.forget()
    rig.start()
    rig.network.sync.transmit()
    rig.barrier()
    with rig.tap.arrived:
        return {frame.arbitration_id: frame.dlc for frame in rig.tap.frames
                if frame.arbitration_id in (TPDO1, TPDO2)}


def saved(start, nvm, *writes):
    """An encoder that has saved these, after a power cut."""
    rig = start("--node", str(NODE_ID), "--nvm", nvm, node_id=NODE_ID)
    for write in writes:
        rig.write(*write)
    rig.sdo.download(0x1010, 1, SAVE)
    rig.kill()
    return start("--nvm", nvm, "--shaft", "36DEG", node_id=NODE_ID)


def test_the_manuals_example_over_saved_limits(start, nvm, generate):
    """Its low limit comes first, and is above the saved high one."""
    entries = generate(EXAMPLE)
    rig = saved(start, nvm, (0x6402, 1, 500, 4))
    boot(rig, entries)
    assert (rig.read(0x6401, 1), rig.read(0x6402, 1)) == (1000, 35000)
    assert rig.tap.data(TPDO1) == bytes(4) and rig.tap.data(TPDO2) == bytes(2)  # 6003h = 0: here is 0
    rig.tap.has_period(TPDO1, 0.009, 0.011, count=50)


@pytest.mark.parametrize("low, high", [(0x20, 0x30), (0x80, 0x90)], ids=["from-below", "from-above"])
def test_limits_move_both_ways(start, nvm, generate, low, high):
    entries = generate(LIMITS)
    far = 500 if low < 0x40 else 1 << 27
    rig = saved(start, nvm, (0x2120, 2, low, 1), (0x2120, 3, high, 1), (0x6402, 1, far + 100, 4),
                (0x6401, 1, far, 4), (0x6402, 2, far + 100, 4), (0x6401, 2, far, 4))
    boot(rig, entries)
    assert [rig.read(0x2120, sub) for sub in (2, 3)] == [0x40, 0x60]
    assert [rig.read(index, sub) for index in (0x6401, 0x6402) for sub in (1, 2)] == [1000, 1000, 35000, 35000]


def test_two_tpdos_swap_their_cob_ids(start, nvm, generate):
    """Also over the swapped ones that it has saved, and with the node-ID of another."""
    entries = generate(SWAP)
    rig = saved(start, nvm)
    assert pdos(rig) == {TPDO1: 4, TPDO2: 4}
    boot(rig, entries)
    assert (rig.read(0x1800, 1), rig.read(0x1801, 1)) == (TPDO2, TPDO1)
    assert pdos(rig) == {TPDO2: 4, TPDO1: 2}
    rig.sdo.download(0x1010, 1, SAVE)
    rig.write(0x2101, 0, 5, 1)
    rig.sdo.download(0x2105, 0, SAVE)
    rig.kill()
    rig = start("--nvm", nvm, node_id=5)
    assert (rig.read(0x1800, 1), rig.read(0x1801, 1)) == (TPDO2, TPDO1)
    boot(rig, entries)
    assert pdos(rig) == {TPDO2: 4, TPDO1: 2}


def test_a_cob_id_is_not_swapped_while_it_is_valid(start, nvm, generate):
    """The same without the steps that set bit 31."""
    rig = saved(start, nvm)
    entries = [entry for entry in generate(SWAP) if entry[1] != 1 or entry[2][3:] != b"\x80"]
    with pytest.raises(SdoAbortedError) as caught:
        boot(rig, entries)
    assert caught.value.code == COB_ID_REFUSED
    assert (rig.read(0x1800, 1), rig.read(0x1801, 1)) == (TPDO1, TPDO2)
