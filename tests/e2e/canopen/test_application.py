# SPDX-License-Identifier: MIT
"""The application example of the manual's chapters 11 and 12, and that it survives a power cut."""
import struct

from can_rig import SAVE

MUR = 3600
TMR = 36000
LOW, HIGH = 1000, 35000


def configure(rig):
    rig.write(0x6002, 0, TMR, 4)
    rig.write(0x6001, 0, MUR, 4)
    rig.write(0x6000, 0, 0x0004, 2)  # scaling
    rig.write(0x6003, 0, 0, 4)
    rig.write(0x1800, 5, 10, 2)
    rig.node.tpdo.read()
    speed = rig.node.tpdo[2]
    speed.clear()
    speed.add_variable(0x6030, 1)
    speed.trans_type = 255
    speed.event_timer = 20
    speed.save()
    rig.write(0x1017, 0, 500, 2)
    rig.write(0x6401, 1, LOW, 4)
    rig.write(0x6402, 1, HIGH, 4)
    rig.sdo.download(0x1010, 1, SAVE)


def works(rig):
    assert (rig.read(0x6001), rig.read(0x6002), rig.read(0x6000)) == (MUR, TMR, 4)
    assert (rig.read(0x6401, 1), rig.read(0x6402, 1)) == (LOW, HIGH)
    rig.start()
    rig.tap.forget()
    positions = [struct.unpack("<I", rig.tap.data(0x1BF))[0] for _ in range(20)]
    assert all(position < TMR for position in positions)
    # 600 rpm are 36 steps a millisecond: 360 from one TPDO to the next, however late each arrives.
    steps = [(b - a) % TMR for a, b in zip(positions, positions[1:])]
    assert all(0 < step < TMR // 4 for step in steps)
    assert 0.5 * 360 < sum(steps) / len(steps) < 4 * 360
    rig.tap.has_period(0x2BF, 0.010, 0.030)
    assert struct.unpack("<h", rig.tap.data(0x2BF))[0] in (599, 600)
    assert rig.tap.data(0x73F) == b"\x05"
    position, state = rig.read(0x6004), rig.read(0x6400, 1)
    assert position < TMR and state & 0x38 == 0
    assert state & 7 in (0, 3, 5)


def test_application_example(start, nvm):
    rig = start("--nvm", nvm, "--shaft", "600RPM")
    configure(rig)
    works(rig)
    rig.kill()
    works(start("--nvm", nvm, "--shaft", "600RPM"))
