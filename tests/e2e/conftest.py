# SPDX-License-Identifier: MIT
"""Fixtures of the end-to-end tests: the program named by DREHGEBER, on a pty."""
import itertools
import os

import pytest

from rig import MULTITURN, PROGRAM, Encoder


def pytest_sessionstart():
    if not os.access(PROGRAM, os.X_OK):
        pytest.exit(f"no program at {PROGRAM}: build it, or name it in DREHGEBER", returncode=1)


@pytest.fixture
def start(tmp_path):
    """Start encoders: start("--nvm", path, model=...). Each is ended; nothing unasked was said."""
    running = []
    numbers = itertools.count()

    def begin(*arguments, model=MULTITURN, wire=None, **options) -> Encoder:
        wire = [f"--pty={tmp_path}/tty{next(numbers)}"] if wire is None else wire
        running.append(Encoder([model, *wire, *arguments], **options))
        return running[-1]

    yield begin
    unasked = [line for encoder in running for line in encoder.clean_up()]
    assert unasked == []


@pytest.fixture
def nvm(tmp_path):
    """Path of a memory image that does not exist yet."""
    return tmp_path / "encoder.nvm"
