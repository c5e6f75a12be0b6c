# SPDX-License-Identifier: MIT
"""A registry, rigs and participants; each is taken down again."""
import pytest

from simulation import LIBRARY, Participant, Registry, Rig


def pytest_sessionstart():
    if not LIBRARY.exists():
        pytest.exit(f"no {LIBRARY}: tools/check fetches it, or name its folder in DREHGEBER_SILKIT", returncode=1)


@pytest.fixture
def registry():
    one = Registry()
    yield one
    one.end()


@pytest.fixture
def rig():
    """rig(ARGUMENTS...): drehgeber run with them."""
    running = []

    def begin(*arguments, **environment):
        running.append(Rig(*arguments, **environment))
        return running[-1]

    yield begin
    for one in running:
        one.close()


@pytest.fixture
def join(registry):
    """join(NAME, ...): a participant."""
    there = []

    def begin(name, *arguments, **options):
        there.append(Participant(registry.uri, name, *arguments, **options))
        return there[-1]

    yield begin
    for one in there:
        one.close()
