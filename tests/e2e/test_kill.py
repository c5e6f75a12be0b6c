# SPDX-License-Identifier: MIT
"""kill -9 at any moment while a master writes: what was acknowledged is there after the restart, what
was not is old or new as a whole. DREHGEBER_KILLS: how often, for each kind of encoder."""
import os
import random
import threading

import pytest

from rig import PATIENCE_S
from storing import KINDS, Gone, start_one

KILLS = int(os.environ.get("DREHGEBER_KILLS", "25"))
LONGEST_S = 0.15  # until the kill; a write takes between half a millisecond and a tenth of a second


def write_until_killed(encoder, session, value, moment_s) -> tuple:
    """What was acknowledged last, what was under way, how many were acknowledged."""
    acknowledged, count = value, 0
    timer = threading.Timer(moment_s, encoder.process.kill)
    timer.start()
    try:
        while True:
            value = (value + 1) % session.modulus
            session.write(value)
            acknowledged, count = value, count + 1
    except Gone:
        pass
    timer.join()
    assert encoder.process.wait(PATIENCE_S) == -9
    return acknowledged, value, count


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_acknowledged_survives_kill(start, nvm, tmp_path, capsys, kind):
    moments = random.Random(kind.__name__)
    possible, writes, kept = None, 0, 0
    for nth in range(KILLS + 1):
        encoder = start_one(start, kind, tmp_path, nvm, nth)
        session = kind(encoder)
        shown = session.read()
        assert possible is None or shown in possible, f"kill {nth}: {shown}, not {possible}"
        kept += possible is not None and shown != possible[0]
        if nth < KILLS:
            *possible, count = write_until_killed(encoder, session, shown, moments.uniform(0, LONGEST_S))
            writes += count
        session.close()
    with capsys.disabled():
        print(f"\n{kind.__name__}: {KILLS} kills, {writes} writes acknowledged, 0 lost, 0 mixed; {kept} under way and kept")
    assert writes >= KILLS
