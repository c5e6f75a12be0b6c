# SPDX-License-Identifier: MIT
"""For pytest: pytest_plugins = ["drehgeber.fixture"]"""

import contextlib

import pytest

from . import rig


@pytest.fixture
def drehgeber_rig():
    """Starts rigs from the text of rig files; all end with the test.

    def test_it(drehgeber_rig):
        encoder = drehgeber_rig("[encoder a]\\nmodel = f3668\\nwire = slcan\\n").encoders["a"]
    """
    with contextlib.ExitStack() as stack:
        yield lambda text: stack.enter_context(rig(text))
