# SPDX-License-Identifier: MIT
"""Rings of several encoders in one process: what happens in one place is felt by all."""

import pytest

from drehgeber import Clock, Encoder, EncoderError, RangeError
from drehgeber.ring import Ring

MODELS = ("ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2")  # words 0, 1-2, 3-4
DEAD_CYCLES = 5


@pytest.fixture
def encoders() -> list[Encoder]:
    clock = Clock()
    return [Encoder(model, clock=clock, shaft=f"{90 * (i + 1)}DEG") for i, model in enumerate(MODELS)]


def run(ring: Ring, encoders: list[Encoder], words: tuple[int, ...] = ()) -> tuple[int, ...]:
    encoders[0].clock.advance(0.001)
    return ring.cycle(words)


def refuses(ring: Ring, why: str) -> None:
    with pytest.raises(EncoderError, match=why) as caught:
        ring.cycle()
    assert caught.value.code == -14


def test_words_stand_in_the_order_of_the_ring(encoders: list[Encoder]) -> None:
    ring = Ring(encoders)
    assert run(ring, encoders) == (1024, 0, 2048, 0, 3072)
    assert ring.identify_all() == (0x0136, 0x0237, 0x0236)
    assert ring.identify() == 0x0136
    for _ in range(4):
        words = run(ring, encoders, (0, 0x0800, 7, 0x0800, 7))  # a K2 does not look
    assert words == (1024, 0xC800, 7, 0, 3072)


def test_an_encoder_without_power_interrupts_the_ring(encoders: list[Encoder]) -> None:
    ring = Ring(encoders)
    run(ring, encoders)
    encoders[1].power(False)
    refuses(ring, "interrupted")
    assert ring.identify_all() == (0x0136,)
    encoders[0].power(False)
    with pytest.raises(EncoderError, match="interrupted"):
        ring.identify()
    for encoder in encoders:
        encoder.power(True)
    encoders[0].clock.advance(1)
    assert run(ring, encoders) == (1024, 0, 2048, 0, 3072)


def test_a_transmission_error_is_told_where_it_was(encoders: list[Encoder]) -> None:
    ring = Ring(encoders)
    run(ring, encoders)
    encoders[2].set_fault("wire_damage")
    refuses(ring, "^a transmission error")
    encoders[2].clear_fault("wire_damage")
    for _ in range(DEAD_CYCLES):
        refuses(ring, "behind a transmission error")
    assert run(ring, encoders) == (1024, 0, 2048, 0, 3072)
    assert ring.identify_all() == (0x0136, 0x0237, 0x4236)


def test_faults_of_one_are_felt_by_all(encoders: list[Encoder]) -> None:
    ring = Ring(encoders)
    run(ring, encoders)
    encoders[1].set_fault("wire_drop")
    refuses(ring, "lost")
    encoders[1].clear_fault("wire_drop")
    encoders[1].set_fault("wire_break")
    refuses(ring, "interrupted")
    assert ring.identify_all() == (0x0136,)
    encoders[1].clear_fault("wire_break")
    assert run(ring, encoders) == (1024, 0, 2048, 0, 3072)


def test_what_is_no_ring(encoders: list[Encoder]) -> None:
    with pytest.raises(RangeError, match="without encoders"):
        Ring([])
    with pytest.raises(EncoderError, match="once"):
        Ring([encoders[0], encoders[0]])
    with pytest.raises(EncoderError, match="same clock"):
        Ring([encoders[0], Encoder("ocd-ib-k1")])
    with pytest.raises(RangeError, match="in a ring"):
        Ring([encoders[0], Encoder("ssi-25", clock=encoders[0].clock)])
    ring = Ring(encoders)
    with pytest.raises(RangeError, match="expected 0 or 5"):
        ring.cycle((1, 2))
    with pytest.raises(RangeError, match="word"):
        ring.cycle((1, 2, 3, 4, 0x10000))
