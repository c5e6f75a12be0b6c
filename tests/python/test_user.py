# SPDX-License-Identifier: MIT
"""A user's tests: the fixtures are there by themselves."""
import drehgeber


def test_half_a_second(drehgeber_clock):
    encoder = drehgeber.Encoder("f3668", clock=drehgeber_clock, shaft="60RPM")
    drehgeber_clock.advance(0.5)
    assert encoder.shaft.position == 180


def test_a_rig(drehgeber_rig):
    encoder = drehgeber_rig("[encoder axis]\nmodel = s3684-biss\nwire = sim\n").encoders["axis"]
    encoder.shaft.position = 90
    assert encoder.shaft.position == 90
