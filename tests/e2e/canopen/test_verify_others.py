# SPDX-License-Identifier: MIT
"""`drehgeber verify` against CANopen nodes that others have written, with our dictionary: LocalNode of canopen, and durand.
Every difference that it prints was judged by hand; it stands in docs/verify.md with its reason."""
import contextlib
import json
import re
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import canopen
import durand
import pytest
from can_rig import PROGRAM
from canopen.objectdictionary import NUMBER_TYPES, ODVariable
from durand.network import NetworkABC
from durand.node import NodeCapabilities
from durand.scheduler import VirtualScheduler

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from verified import Server  # noqa: E402

NODE = 63
LIMIT_S = 120.0


def variables(eds):
    """(index, sub-index, variable, what it is as delivered) of the file."""
    for one in canopen.import_od(str(eds), NODE).values():
        for variable in [one] if isinstance(one, ODVariable) else one.values():
            value = variable.default
            if value is None:
                value = 0 if variable.data_type in NUMBER_TYPES else ""
            yield variable.index, variable.subindex, variable, value


class Slave(Server):
    """A node behind an SLCAN adapter, for one master. take_frame() is its receiver."""

    def __init__(self):
        super().__init__()
        self.option = f"--slcan=tcp:{self.where}"

    def send_frame(self, can_id: int, data: bytes):
        self.wire.sendall(b"t%03X%d%s\r" % (can_id, len(data), bytes(data).hex().upper().encode()))

    def run(self):
        rest = b""
        with contextlib.suppress(OSError), self.listener.accept()[0] as self.wire:
            self.wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            while data := self.wire.recv(4096):
                *lines, rest = (rest + data).split(b"\r")
                for line in lines:
                    self.wire.sendall(b"\r")
                    frame = re.fullmatch(rb"t(...).(.*)", line)
                    if frame:  # none of them answers remote frames
                        self.take_frame(int(frame[1], 16), bytearray.fromhex(frame[2].decode()))


class OfCanopen(Slave):
    """https://github.com/canopen-python/canopen, MIT"""

    def __init__(self, eds):
        super().__init__()
        self.network = canopen.Network(self)
        node = canopen.LocalNode(NODE, str(eds))
        self.network[NODE] = node
        for index, sub, variable, value in variables(eds):
            if index != 0x1003:  # no error has happened
                node.set_data(index, sub, variable.encode_raw(value))

    def send(self, message):
        self.send_frame(message.arbitration_id, message.data)

    def take_frame(self, can_id: int, data: bytearray):
        self.network.notify(can_id, data, 0.0)


class OfDurand(Slave, NetworkABC):
    """https://github.com/semiversus/python-durand, MIT; what it has of CiA 301 is its own, the rest is ours."""

    def __init__(self, eds):
        Slave.__init__(self)
        self.receivers, self.wire = {}, None
        durand.set_scheduler(VirtualScheduler())  # nothing is due by itself
        node = durand.Node(self, NODE, capabilities=NodeCapabilities(sdo_servers=1, rpdos=0, tpdos=4))
        own = set(index for index, _ in node.object_dictionary)
        for index, sub, variable, value in variables(eds):
            if index not in own:
                self.add_object(node.object_dictionary, index, sub, variable)
            with contextlib.suppress(KeyError):  # a sub-index that its own object does not have
                node.object_dictionary.write(index, sub, value.encode() if isinstance(value, str) else value)

    @staticmethod
    def add_object(dictionary, index: int, sub: int, variable):
        access = variable.access_type[:2] if variable.access_type != "const" else "const"
        made = durand.Variable(durand.DatatypeEnum(variable.data_type), access)
        if isinstance(variable.parent, canopen.ObjectDictionary):
            dictionary[index] = made
            return
        if index not in dictionary:
            dictionary[index] = durand.Record()
        if sub > 0:
            dictionary[index][sub] = made

    def add_subscription(self, cob_id, callback):
        self.receivers[cob_id] = callback

    def remove_subscription(self, cob_id):
        self.receivers.pop(cob_id)

    def send(self, cob_id, msg):
        if self.wire is not None:  # nobody is there yet when it boots
            self.send_frame(cob_id, msg)

    def take_frame(self, can_id, data):
        with contextlib.suppress(Exception):  # its listener logs them
            self.receivers.get(can_id, lambda *_: None)(can_id, bytes(data))


def verify(slave: Slave, *arguments) -> list:
    """Of each clause of each list: what became of it, and why."""
    with slave:
        ended = subprocess.run([PROGRAM, "verify", *map(str, arguments), slave.option, "--json"], stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, timeout=LIMIT_S)
    assert ended.stderr == "", ended.stderr
    return json.loads(ended.stdout)


def those(found: list, result: str) -> dict:
    return {row["clause"]: row["why"] for row in found if row["result"] == result}


SUB_INDICES = "its arrays have each sub-index, 1 to 254"
NO_GUARDING = "it answers no remote frame"
NO_BLOCKS = "it answers as if the client had asked for segments, which it may do only when the client allows it"
STAYS = "a transfer goes on when it was aborted, or when another one has begun"
NO_EVENT_TIMER = "its TPDOs have no event timer"
LAST_SEGMENT = "it says that 7 bytes of a full segment are unused"

# node: what is different, and why that is right; by our dictionary, and by its EDS file
DIFFERS = {
    OfCanopen: {
        "M10-24": SUB_INDICES, "M10-25": SUB_INDICES, "CIA-9-5": SUB_INDICES,
        "C13-1": NO_GUARDING, "CIA-5-1": NO_GUARDING,
        "C11-4": "1003h without errors: 060A0023h", "CIA-6-4": "the same",
        "C27-1": "an upload that is not continued stays", "C27-2": STAYS, "CIA-2-23": STAYS, "CIA-2-29": STAYS,
        **dict.fromkeys(("CIA-2-30", "CIA-2-31", "CIA-2-32", "CIA-2-33", "CIA-2-34", "CIA-2-35", "CIA-2-36", "CIA-2-46",
                         "CIA-2-48", "CIA-2-50"), NO_BLOCKS),
    },
    OfDurand: {
        **dict.fromkeys(("M10-9", "M10-10", "M10-11", "M10-12", "M11-6", "C2-1", "C3-1"), NO_EVENT_TIMER),
        "C27-1": "an upload that is not continued stays",
        **dict.fromkeys(("CIA-2-32", "CIA-2-33", "CIA-2-34", "CIA-2-35"), LAST_SEGMENT),
        "CIA-2-36": "it takes a block size of 128 in an acknowledgement",
    },
}
DIFFERS_FROM_FILE = {
    OfCanopen: {f"1003:{sub}{aspect}" for sub in range(1, 9) for aspect in ("", "-type")},
    OfDurand: {f"180{pdo}:5{aspect}" for pdo in range(4) for aspect in ("", "-type", "-value")},
}
AGREE, AGREE_WITH_FILE = 40, 440  # at least


@pytest.fixture(scope="module", autouse=True)
def asked(eds):
    """(node, by what): what became of each clause; most of the time is waiting for what must not come."""
    with ThreadPoolExecutor(4) as pool:
        yield {(node, words): pool.submit(verify, node(eds), words) for node in DIFFERS for words in ("f3668", eds)}


@pytest.mark.parametrize("node", DIFFERS)
def test_differences_are_those_of_the_node(asked, node):
    found = asked[node, "f3668"].result()
    assert those(found, "differs").keys() == DIFFERS[node].keys(), those(found, "differs")
    assert len(those(found, "agrees")) >= AGREE


@pytest.mark.parametrize("node", DIFFERS_FROM_FILE)
def test_differences_from_the_file_are_those_of_the_node(asked, eds, node):
    found = asked[node, eds].result()
    assert those(found, "differs").keys() == DIFFERS_FROM_FILE[node], those(found, "differs")
    assert len(those(found, "agrees")) >= AGREE_WITH_FILE
