# SPDX-License-Identifier: MIT
"""Several encoders on one shaft agree: all four kinds on real wires, at rest after moves to any
angle. (Latched at one moment while it turns: tests/unit/test_agree.c.)"""
import contextlib
import random
from decimal import Decimal, getcontext

import pytest

from bench import BissMaster, CanMaster, Coupler, Master, can_wire, eventually, free_port

TURNS = 4096
TURN = 1 << 32  # the unit of angles
RIG = """
[rig]
control = tcp:127.0.0.1:0
[shaft motor]
[shaft load]
driver = motor
ratio = -3:10
[bus ring]
wire = modbus
address = 127.0.0.1:{port}
[encoder h]
model = s3684-rs485
shaft = {shaft}
wire = pty
[encoder b]
model = s3684-biss
shaft = {shaft}
wire = sim
[encoder c]
model = f3668
shaft = {shaft}
wire = {can}
[encoder k1]
model = ocd-ib-k1
shaft = {shaft}
bus = ring
[encoder k2]
model = ocd-ib-k2
shaft = {shaft}
bus = ring
[encoder k3]
model = ocd-ib-k3
shaft = {shaft}
bus = ring
[encoder drive]
model = s3684-biss
shaft = motor
wire = sim
"""
getcontext().prec = 60


class Eyes:
    """A master for each of the four."""

    def __init__(self, bench, stack):
        self.hiperface = Master(bench.wires["h"])
        self.can = CanMaster(bench.wires["c"])
        self.ring = Coupler(bench.wires["k1"])
        for master in (self.hiperface, self.can, self.ring):
            stack.callback(master.close)
        self.biss = BissMaster(bench.session("b"))
        eventually(self.biss.ready, 5)
        eventually(self.can.answers, 5)
        eventually(lambda: self.ring.status() == Coupler.RUN
                   and self.ring.words(3) != 0xA0000000, 5)

    def agree_on(self, angle: int):
        """All tell `angle` (in 2^-32 turn), each in its own steps."""
        assert self.hiperface.read_position() == counts(angle, 65536)
        assert self.biss.frame()[0] == counts(angle, 1 << 21)
        assert self.can.read(0x6004) == counts(angle, 65536)
        eventually(lambda: self.ring.words(3) == counts(angle, 4096))
        assert self.ring.words(1) == counts(angle, 4096)
        assert self.ring.words(0, 1) == counts(angle, 4096) % 4096


def counts(angle: int, steps: int) -> int:
    """Whole steps, modulo 4096 turns."""
    return (angle * steps // TURN) % (TURNS * steps)


def degrees(angle: int) -> str:
    """Exactly."""
    return format(Decimal(angle) * 360 / TURN, "f")


@pytest.fixture
def begin(start, tmp_path):
    """Start the rig with all on one of its shafts."""
    with contextlib.ExitStack() as stack:
        def up(shaft: str):
            text = RIG.format(port=free_port(), can=can_wire(tmp_path), shaft=shaft)
            bench = start(text, "--quiet")
            return bench.session("drive"), Eyes(bench, stack)
        yield up


def test_all_agree_at_rest(begin):
    session, eyes = begin("motor")
    chance = random.Random(406)
    edges = [0, 1, -1, TURN - 1, TURN, -TURN, TURNS * TURN - 1, TURNS * TURN, TURNS * TURN + 1,
             -TURNS * TURN - 1, TURN >> 12, (TURN >> 12) - 1, TURN >> 16, (TURN >> 16) - 1]
    anywhere = [chance.randrange(-10_000 * TURN, 10_000 * TURN) for _ in range(15)]
    for angle in edges + anywhere:
        session.do(f"SHAF:POS {degrees(angle)}")
        eyes.agree_on(angle)


def test_all_agree_after_moves(begin):
    session, eyes = begin("motor")
    chance = random.Random(4711)
    for turns in (1, 10, 100, 5000, 9000):
        for acceleration in (0, 10_000_000):
            angle = chance.randrange(-turns * TURN, turns * TURN)
            session.do(f"SHAF:ACC {acceleration}")
            session.send(f"SHAF:MOVE {degrees(angle)},1000000;*OPC?")
            assert session.line() == "1"
            eyes.agree_on(angle)


def test_all_agree_behind_a_gear(begin):
    session, eyes = begin("load")
    chance = random.Random(42)
    for _ in range(10):
        angle = chance.randrange(-20_000 * TURN, 20_000 * TURN)
        session.do(f"SHAF:POS {degrees(angle)}")
        eyes.agree_on(angle * -3 // 10)
