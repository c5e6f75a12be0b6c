# SPDX-License-Identifier: MIT
"""What a user writes: strictly typed, and it runs. test_package.py and bootstrap try both."""
import can
import drehgeber
from drehgeber import Clock, Encoder, Shaft

clock = Clock()
shaft = Shaft(clock, "60RPM")
motor: Encoder = Encoder("s3684-rs485", shaft=shaft)
blade = Encoder("f3668", shaft=Shaft(driver=shaft, ratio=(1, 10)), node=5)
clock.advance(1.5)
reply: bytes = motor.request(b"\x40\x42\x02")
assert reply[:2] == b"\x40\x42" and len(reply) == 7
blade.can.send(0x605, bytes.fromhex("40 04 60 00 00 00 00 00"))
frame = blade.can.recv()
assert frame is not None
position: int = int.from_bytes(frame.data[4:], "little")
assert position == blade.position
blade.world.temperature = 85.0
warm: float = blade.world.temperature
lit: bool = blade.world.singleturn_ok
assert warm == 85 and lit
sampled: int = len(blade.positions(0.0, 0.00025, 4000))

with can.Bus(interface="drehgeber", channel="f3668?node=7&shaft=90DEG") as bus:
    bus.send(can.Message(arbitration_id=0x607, data=bytes.fromhex("4004600000000000"), is_extended_id=False))
    answer = bus.recv(0)
    assert answer is not None and int.from_bytes(answer.data[4:], "little") == 16384


def steer() -> tuple[int, dict[str, str]]:
    """With the command on PATH."""
    with drehgeber.run("s3684-rs485", "--shaft", "60RPM") as rig:
        rig.encoders["s3684-rs485"].shaft.move(90)
        encoder = rig.encoders["s3684-rs485"]
        position: int = encoder.state()["position"]
        return position, encoder.state(raw=True)
