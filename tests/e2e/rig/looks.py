# SPDX-License-Identifier: MIT
"""What a master sees of a fault. A look is a generator: it prepares, yields; the fault is there, it
looks, yields; the fault is cleared, it looks again."""
import time
from typing import NamedTuple

from bench import Session

HARDWARE_ERROR = -240


class Target(NamedTuple):
    """An encoder between its operator and its master."""

    scpi: Session
    master: object
    place: int = 0  # in the ring
    at: int = 0  # its words there
    words: int = 2


def power_cycle(target: Target):
    target.scpi.do("POW CYCLE")


def inject(target: Target, name: str, look):
    steps = look(target)
    next(steps)
    target.scpi.do(f"FAUL:SET {name}")
    assert [active.lower() for active in target.scpi.parts("FAUL:ACT?")] == [name]
    next(steps)
    target.scpi.do(f"FAUL:CLE {name}")
    assert target.scpi.parts("FAUL:ACT?") == []
    assert next(steps, "gone") == "gone"


def seconds(command) -> float:
    begin = time.monotonic()
    command()
    return time.monotonic() - begin


def flipped(one: bytes, other: bytes) -> int:
    """Bits that differ."""
    assert len(one) == len(other)
    return (int.from_bytes(one, "big") ^ int.from_bytes(other, "big")).bit_count()


def stays(condition, for_s: float = 0.08):
    end = time.monotonic() + for_s
    while time.monotonic() < end:
        assert condition()
