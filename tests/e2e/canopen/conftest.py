# SPDX-License-Identifier: MIT
"""Fixtures of the CANopen end-to-end tests."""
import itertools
import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from can_rig import MODEL, PROGRAM, Rig, on_slcan  # noqa: E402

# What only one of the wires has is no test of the other one.
collect_ignore = ["test_socketcan.py"] if on_slcan() else ["test_slcan.py", "test_net.py", "test_verify_others.py"]


def pytest_sessionstart():
    if not os.access(PROGRAM, os.X_OK):
        pytest.exit(f"no program at {PROGRAM}: build it, or name it in DREHGEBER", returncode=1)


@pytest.fixture(scope="session")
def eds(tmp_path_factory) -> Path:
    """The EDS file, byte for byte."""
    said = subprocess.run([PROGRAM, "eds", MODEL], capture_output=True, timeout=30)
    assert (said.returncode, said.stderr) == (0, b"")
    path = tmp_path_factory.mktemp("eds") / f"{MODEL}.eds"
    path.write_bytes(said.stdout)
    return path


@pytest.fixture
def start(tmp_path, eds):
    """Start encoders: start("--nvm", path). Each is ended; nothing unasked was said."""
    running = []
    numbers = itertools.count()

    def begin(*arguments, **options) -> Rig:
        running.append(Rig(f"{tmp_path}/can{next(numbers)}", eds, *arguments, **options))
        return running[-1]

    yield begin
    unasked = [line for rig in running for line in rig.clean_up()]
    assert unasked == []


@pytest.fixture
def rig(start) -> Rig:
    """An encoder in delivery state."""
    return start()


@pytest.fixture
def nvm(tmp_path) -> Path:
    """Path of a memory image that does not exist yet."""
    return tmp_path / "encoder.nvm"
