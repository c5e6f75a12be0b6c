# SPDX-License-Identifier: MIT
"""python-can and canopen, as a user has them, with the SLCAN of an emulated board behind a TCP port."""
import os
import subprocess
from pathlib import Path

import can
import canopen
import pytest

IMAGE = "drehgeber-f3668-slcan"
NODE, PATIENCE_S = 63, 30


@pytest.fixture
def bus():
    bridge = subprocess.Popen([os.environ.get("NODE", "node"), Path(__file__).with_name("bridge.mjs"), IMAGE],
                              stdout=subprocess.PIPE, text=True)
    try:
        port = int(bridge.stdout.readline())
        with can.Bus(f"socket://127.0.0.1:{port}", interface="slcan", bitrate=250000, sleep_after_open=0) as one:
            yield one
    finally:
        bridge.kill()
        bridge.wait()


def test_a_position(bus):
    network = canopen.Network(bus)
    network.notifier = can.Notifier(bus, network.listeners, 0.05)
    try:
        node = network.add_node(NODE)
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        assert node.sdo.upload(0x1000, 0) == bytes.fromhex("96010200")
        assert node.sdo.upload(0x1008, 0).startswith(b"F36")  # segmented
        node.nmt.state = "OPERATIONAL"
        positions = []
        network.subscribe(0x280 + NODE, lambda _id, data, _at: positions.append(bytes(data)))
        network.sync.transmit()
        node.sdo.upload(0x6004, 0)  # behind the SYNC
        assert positions == [bytes(4)]
    finally:
        network.notifier.stop()
