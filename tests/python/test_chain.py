# SPDX-License-Identifier: MIT
"""Chains of BiSS encoders in this process; the differential test has their bits."""
import pytest
from drehgeber import Clock, Encoder, EncoderError, RangeError, Shaft
from drehgeber.chain import Chain

SERIAL = 0x44


def chain_of(*models, **settings):
    clock = Clock()
    return Chain([Encoder(model, shaft=Shaft(clock, f"{90 * i}DEG"), serial=i, **settings) for i, model in enumerate(models, 1)])


def said(act, *arguments):
    """What it gives, or the code of its error."""
    try:
        return act(*arguments)
    except EncoderError as error:
        return error.code


def test_a_frame_has_all_of_them():
    chain = chain_of("s3684-biss", "s3674-biss", "s3684-biss")
    frames = chain.frame()
    assert [frame.singleturn for frame in frames] == [1 << 19, 2 << 19, 3 << 19]
    assert all(frame.good and not frame.error for frame in frames) and [frame.width for frame in frames] == [47, 35, 47]
    assert {frame.at for frame in frames} == {1e-6} and chain.clock.now == frames[0].end
    chain.clock.advance(0.001)
    assert [frame.life - before.life for frame, before in zip(chain.frame(), frames)] == [1, 1, 1]


@pytest.mark.parametrize("angle", ["0DEG", "123.456789DEG", "-0.001DEG", "5.2501REV"])
def test_a_chain_of_one_is_read_as_one_alone(angle):
    chain, alone = (Encoder("s3684-biss", shaft=Shaft(Clock(), angle)) for _ in range(2))
    assert Chain([chain]).frame()[0][2:] == alone.biss.frame()[2:]


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


@pytest.mark.parametrize("stop_bit", ["own", "early"])
def test_registers_are_those_of_a_master_for_one_alone(stop_bit):
    """Also where less comes than was asked for; and each takes its time on the line."""
    models, took = ("s3684-biss", "s3674-biss"), {}
    chain, alone = chain_of(*models, stop_bit=stop_bit), chain_of(*models, stop_bit=stop_bit)
    for address, count in (0x40, 8), (SERIAL, 8), (0x48, 8), (0x62, 4), (0x7C, 16), (0x00, 4):
        for place, encoder in enumerate(alone.encoders):
            begin = chain.clock.now
            assert said(chain.register, place, address, count) == said(encoder.biss.register, address, count)
            took[address, place] = round((chain.clock.now - begin) * 1e6)
            alone.clock.advance(1)
    for data in b"\2", b"\2\3":
        assert chain.write_register(0, 0x40, data) == alone.encoders[0].biss.write_register(0x40, data) == 1
        alone.clock.advance(1)
    with pytest.raises(RangeError, match="count 0: expected 1..64"):
        chain.register(0, SERIAL, 0)
    for data in b"", bytes(65):
        with pytest.raises(RangeError, match=f"{len(data)} registers: expected 1..64"):
            chain.write_register(0, 0x40, data)
    last = 0 if stop_bit == "early" else 1443  # us, for the register that is refused
    assert [took[address, 0] for address in (0x40, SERIAL, 0x48, 0x7C)] == [14952, 12586 + last, 3407, 12588 + last]


def test_a_register_that_is_refused_takes_its_time():
    """Of a master for one alone, too: the chain goes on behind it."""
    chain = chain_of("s3684-biss", "s3674-biss")
    assert said(chain.encoders[0].biss.register, 0x48, 8) == -13
    assert chain.clock.now > 0.001
    assert said(chain.register, 0, 0x48, 8) == -13 and chain.register(0, SERIAL, 4) == b"\0\0\0\1"


def test_an_encoder_takes_its_time_for_a_register():
    """The EEPROM is busy with each: the master clocks frames until it is not."""
    chain = chain_of("s3684-biss", "s3674-biss")
    assert chain.write_register(1, 0x40, b"\7") == 1
    begin = chain.clock.now
    assert chain.write_register(1, 0, b"abc") == 3
    assert chain.clock.now - begin > 0.015
    assert chain.register(1, 0, 4) == b"abc\xff"


def test_a_frame_is_that_of_a_master_for_one_alone():
    """Every bit of it, with an error, and a life counter or none."""
    for setting in {}, {"lc": 0}:
        chain, alone = chain_of("s3684-biss", "s3674-biss", **setting), chain_of("s3684-biss", "s3674-biss", **setting)
        for led_current_ua in 12000, 60000:
            for encoder in (*chain.encoders, *alone.encoders):
                encoder.shaft.position = 1000.5
                encoder.world.led_current_ua = led_current_ua
            for clock in chain.clock, alone.clock:
                clock.advance(0.1)
            frames = chain.frame()
            assert [frame[2:] for frame in frames] == [encoder.biss.frame()[2:] for encoder in alone.encoders]
        assert all(frame.error for frame in frames)


def test_a_frame_takes_its_time():
    """A clock of 1 MHz for each bit of both and what goes ahead of them, then the timeout."""
    chain = chain_of("s3684-biss", "s3674-biss")
    chain.frame()
    assert chain.clock.now == pytest.approx(103e-6, abs=1e-12)


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
        if act == chain.frame:  # it gave up
            assert chain.clock.now == pytest.approx(1312e-6, abs=1e-9)
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
