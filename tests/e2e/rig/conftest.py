# SPDX-License-Identifier: MIT
"""Fixtures of the tests of whole rigs."""
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from bench import PROGRAM, Bench, on_slcan  # noqa: E402


def pytest_sessionstart():
    if not os.access(PROGRAM, os.X_OK):
        pytest.exit(f"no program at {PROGRAM}: build it, or name it in DREHGEBER", returncode=1)


def pytest_collection_modifyitems(items):
    """What is about an encoder on another wire is no test of a CAN interface of the kernel."""
    items[:] = [item for item in items if on_slcan() or encoder_of(item) == "c"]


def encoder_of(item) -> str:
    """Its name in the rig, where a test is about one of them."""
    values = item.callspec.params if hasattr(item, "callspec") else {}
    return values.get("target", values.get("encoder", "c"))


class Benches:
    """Starts rigs and ends them."""

    def __init__(self):
        self.running = []

    def start(self, folder, text, *arguments, **options) -> Bench:
        self.running.append(Bench(folder, text, *arguments, **options))
        return self.running[-1]

    def end(self) -> list:
        return [line for bench in self.running for line in bench.clean_up()]


@pytest.fixture
def start(tmp_path):
    """Start rigs: start("[encoder a]\\n..."). Each is ended; nothing unasked was said."""
    benches = Benches()

    def begin(text, *arguments, **options) -> Bench:
        folder = tmp_path / f"bench{len(benches.running)}"
        folder.mkdir()
        return benches.start(folder, text, *arguments, **options)

    yield begin
    assert benches.end() == []


@pytest.fixture(scope="module")
def start_once(tmp_path_factory):
    """The same for all tests of a module."""
    benches = Benches()

    def begin(text, *arguments, **options) -> Bench:
        return benches.start(tmp_path_factory.mktemp("bench"), text, *arguments, **options)

    yield begin
    assert benches.end() == []
