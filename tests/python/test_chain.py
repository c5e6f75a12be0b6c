# SPDX-License-Identifier: MIT
"""Chains of BiSS encoders in this process; the differential test has their bits."""
import pytest
from drehgeber import Clock, Encoder, EncoderError, RangeError, Shaft
from drehgeber.chain import Chain

SERIAL = 0x44


def chain_of(*models, **settings):
    clock = Clock()
    return Chain([Encoder(model, shaft=Shaft(clock, f"{90 * i}DEG"), serial=i, **settings) for i, model in enumerate(models, 1)])


def test_a_frame_has_all_of_them():
    chain = chain_of("s3684-biss", "s3674-biss", "s3684-biss")
    frames = chain.frame()
    assert [frame.singleturn for frame in frames] == [1 << 19, 2 << 19, 3 << 19]
    assert all(frame.good and not frame.error for frame in frames) and [frame.width for frame in frames] == [47, 35, 47]
    assert {frame.at for frame in frames} == {1e-6} and chain.clock.now == frames[0].end
    chain.clock.advance(0.001)
    assert [frame.life - before.life for frame, before in zip(chain.frame(), frames)] == [1, 1, 1]


def test_each_has_its_registers():
    chain = chain_of("s3684-biss", "s3674-biss")
    for place, encoder in enumerate(chain.encoders):
        assert chain.register(place, SERIAL, 4) == (place + 1).to_bytes(4, "big")
        assert chain.register(place, 0x78, 4) == encoder.biss.register(0x78, 4)
    assert chain.write_register(1, 0x40, b"\7") == 1
    assert [chain.register(place, 0x40) for place in (0, 1)] == [b"\0", b"\7"]
    with pytest.raises(EncoderError, match="refuses") as caught:
        chain.write_register(0, SERIAL, b"\1")
    assert caught.value.code == -13
    for arguments, text in ((2, SERIAL), "place 2: expected 0..1"), ((0, 128), "address 128"), ((0, 0, 65), "count 65"):
        with pytest.raises(RangeError, match=text):
            chain.register(*arguments)


def test_a_fault_is_of_the_line_behind_its_driver():
    """The cut line of the second one is a second frame that is wrong."""
    chain = chain_of("s3684-biss", "s3684-biss")
    with chain.encoders[1].fault("wire_break"):
        assert [frame.good for frame in chain.frame()] == [True, False]
    chain.clock.advance(0.001)
    assert [frame.good for frame in chain.frame()] == [True, True]


def test_nobody_answers_without_power():
    chain = chain_of("s3684-biss", "s3684-biss", power=False)
    for act in (chain.frame, lambda: chain.register(0, SERIAL)):
        with pytest.raises(EncoderError) as caught:
            act()
        assert caught.value.code == -14
    for encoder in chain.encoders:
        encoder.power(True)
    chain.clock.advance(1)
    assert all(frame.good for frame in chain.frame())


def test_chains_that_are_none():
    one = Encoder("s3684-biss")
    for encoders, text in (
        ([], "one at least"), ([one, one], "once"), ([one, Encoder("s3684-biss")], "same clock"), ([Encoder("ssi-25")], "speaks ssi"),
        ([Encoder("s3684-biss", clock=one.clock) for _ in range(9)], "9 encoders"),
    ):  # fmt: skip
        with pytest.raises(EncoderError, match=text):
            Chain(encoders)
