# SPDX-License-Identifier: MIT
"""A rig of one bus in the place of `drehgeber run --quiet FILE`. $FORGED says what it does with the right answers to a
SYNC; the frames that it has sent are appended to $FORGED_LOG: moment, identifier, data.

usage: forged_rig.py run --quiet FILE
"""
import os
import re
import struct
import sys
from pathlib import Path

E2E = Path(__file__).resolve().parents[1]
sys.path += [str(E2E), str(E2E / "silkit")]

from simulation import PACK_FRAME, PACK_HEAD, PATIENCE_S, Participant, pack, unpack  # noqa: E402

FRAMES, SHAFT = "application/vnd.drehgeber.can.v1", "application/vnd.drehgeber.shaft.v1"
SYNC, TPDO2, REMOTE = 0x080, 0x280, 0x8000


def remote(at, frames):
    """The first one without its data."""
    return PACK_HEAD.pack(at, len(frames), 0) + PACK_FRAME.pack(0, frames[0][0] | REMOTE, 4, 0) + pack(
        at, *frames[1:])[PACK_HEAD.size:]


# how: messages of the frames that are due, all of them of the moment `at`
FORGERIES = {
    "right": lambda at, frames: [pack(at, *frames)],
    "reversed": lambda at, frames: [pack(at, *reversed(frames))],
    "halves": lambda at, frames: [pack(at, *frames[:2]), pack(at, *frames[2:])],
    "beside": lambda at, frames: [pack(at, frames[0], (0x701, b"\5"), *frames[1:])],
    "twice": lambda at, frames: [pack(at, *frames, frames[0])],
    "again": lambda at, frames: 2 * [pack(at, *frames)],
    "late": lambda at, frames: [pack(at + 1000, *frames)],
    "damaged": lambda at, frames: [pack(at, frames[0], (TPDO2 + 2, bytes([frames[1][1][0] ^ 1, *frames[1][1][1:]])), frames[2])],
    "longer": lambda at, frames: [pack(at, (TPDO2 + 1, frames[0][1] + b"\0"), *frames[1:])],
    "remote": lambda at, frames: [remote(at, frames)],
    "other": lambda at, frames: [pack(at, *frames[:2], (TPDO2 + 4, frames[2][1]))],
    "cut": lambda at, frames: [pack(at, *frames)[:-1]],
    "fewer": lambda at, frames: [PACK_HEAD.pack(at, len(frames) + 1, 0) + pack(at, *frames)[PACK_HEAD.size:]],
    "padded": lambda at, frames: [pack(at, *frames) + b"\0"],
    "headless": lambda at, frames: [bytes(PACK_HEAD.size - 1)],
    "silent": lambda at, frames: [],
}


def main():
    text = Path(sys.argv[3]).read_text(encoding="ascii")
    name = re.search(r"^name = (.*)$", text, re.M)[1]
    uri, network = re.search(r"^address = (.*),(.*)$", text, re.M).groups()
    nodes = int(re.search(r"^node = 1\.\.(\d+)$", text, re.M)[1])
    asked, turn, told = f"{network}/frames/to", f"{name}/shaft/s0/turn", f"{network}/frames"
    how = os.environ["FORGED"]

    def answer(rig, at, angle):
        position = ((angle >> 16) % 2**28).to_bytes(4, "little")
        for message in FORGERIES[how](at, [(TPDO2 + node, position) for node in range(1, nodes + 1)]):
            rig.publish(told, FRAMES, message)
            if how in ("right", "halves"):
                with Path(os.environ["FORGED_LOG"]).open("ab") as log:
                    log.writelines(struct.pack("<QH", moment, identifier) + data for moment, identifier, data in unpack(message))

    def step(rig, now):
        """The master turns the shaft when it says SYNC: what it tells about it is where it was then."""
        due, rig.data = [one for one in rig.data if one[0] < now], [one for one in rig.data if one[0] >= now]
        angles = {at: struct.unpack("<qq", content)[0] for at, topic, content in due if topic == turn}
        for at, topic, message in due:
            if topic == asked and any(identifier == SYNC for _, identifier, _ in unpack(message)):
                answer(rig, at, angles[at])

    rig = Participant(uri, name, step)
    rig.subscribe(asked, FRAMES)
    rig.subscribe(turn, SHAFT)
    rig.publish(told, FRAMES)
    rig.start()
    print("ready rig", flush=True)
    rig.wait(4 * PATIENCE_S)
    rig.close()


main()
