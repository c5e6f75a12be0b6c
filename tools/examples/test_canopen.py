# SPDX-License-Identifier: MIT
"""Two CANopen encoders on one bus, read with python-can and canopen over a serial CAN adapter (SLCAN);
`wire = can` and `address = vcan0` would put them on SocketCAN."""
import subprocess
import time

import canopen
import drehgeber
import pytest

RIG = """
[shaft motor]
[shaft blade]
driver = motor
ratio = 1:10
[bus can]
wire = slcan
[encoder motor]
model = f3668
shaft = motor
bus = can
node = 1
[encoder blade]
model = f3668
shaft = blade
bus = can
node = 2
"""
STEPS_PER_TURN = 65536
EMCY_OPTICS = 0x5200
PATIENCE_S = 10  # a busy computer may need more than canopen's 0.3


@pytest.fixture
def rig(drehgeber_rig):
    return drehgeber_rig(RIG)


@pytest.fixture
def nodes(rig, tmp_path):
    """A node of canopen for each encoder, by name; the EDS file comes from drehgeber itself."""
    eds = tmp_path / "f3668.eds"
    said = subprocess.run([drehgeber.program(), "eds", "f3668"], capture_output=True, check=True)
    eds.write_bytes(said.stdout)
    network = canopen.Network()
    network.connect(interface="slcan", channel=rig.encoders["motor"].address, bitrate=250000)
    found = {name: network.add_node(encoder.place, str(eds)) for name, encoder in rig.encoders.items()}
    for node in found.values():
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
    yield found
    network.disconnect()


def hears(node, code) -> bool:
    """Whether this emergency has come, or comes soon; wait() of canopen's misses what has come before it."""
    end = time.monotonic() + PATIENCE_S
    while code not in [error.code for error in node.emcy.log] and time.monotonic() < end:
        time.sleep(0.01)
    return code in [error.code for error in node.emcy.log]


def test_a_geared_shaft_follows(rig, nodes):
    rig.encoders["motor"].shaft.move(5 * 360, rpm=600)
    assert nodes["motor"].sdo["Position value"].raw == 5 * STEPS_PER_TURN
    assert nodes["blade"].sdo["Position value"].raw == STEPS_PER_TURN / 2


def test_a_worn_led_is_an_emergency(rig, nodes):
    with rig.encoders["blade"].fault("led_current_high"):
        assert hears(nodes["blade"], EMCY_OPTICS)
        assert nodes["blade"].sdo["Error register"].raw & 1
    assert nodes["motor"].emcy.log == []
