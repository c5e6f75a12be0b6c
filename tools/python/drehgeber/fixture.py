# SPDX-License-Identifier: MIT
"""pytest: fixtures, known by themselves where drehgeber is installed."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

import pytest

from . import Clock, rig
from .running import RunningRig


@pytest.fixture
def drehgeber_rig() -> Iterator[Callable[[str], RunningRig]]:
    """Starts rigs from the text of rig files; all end with the test.

    def test_it(drehgeber_rig):
        encoder = drehgeber_rig("[encoder a]\\nmodel = f3668\\nwire = slcan\\n").encoders["a"]
    """
    with contextlib.ExitStack() as stack:
        yield lambda text: stack.enter_context(rig(text))


@pytest.fixture
def drehgeber_clock() -> Clock:
    """Virtual time for encoders of this process.

    def test_it(drehgeber_clock):
        encoder = drehgeber.Encoder("f3668", clock=drehgeber_clock)
        drehgeber_clock.advance(1.5)
    """
    return Clock()
