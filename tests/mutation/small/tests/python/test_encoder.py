# SPDX-License-Identifier: MIT
from drehgeber import z


def test_seen():
    assert z.seen() == 5
