# SPDX-License-Identifier: MIT
"""Fixtures of the examples: one reader at a time on a machine, whose ports and wires pages name."""
import fcntl
import os
import sys
import tempfile
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import rig  # noqa: E402
from examples import Reader  # noqa: E402

PROGRAM = Path(rig.PROGRAM).absolute()
WHERE = os.environ.get("DREHGEBER_DOCS", "here")
GPIO_SIM = Path("/sys/kernel/config/gpio-sim/drehgeber-docs")
LINES = 8


@pytest.fixture(scope="session", autouse=True)
def alone():
    path = Path(tempfile.gettempdir()) / f"drehgeber-docs-{os.getuid()}.lock"
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture
def read():
    """read(blocks, tree): as examples.Reader.read."""

    def begin(blocks: list, tree: Path, program: Path = PROGRAM, replaced=None, **options):
        with Reader(tree, program, **options) as reader:
            reader.replaced.update(replaced or {})
            reader.read(blocks)

    return begin


@pytest.fixture(scope="session")
def chips():
    """The chip that pages call gpiochip0: a simulated one, where the kernel has that."""
    if WHERE != "guest":
        yield {}
        return
    (GPIO_SIM / "bank").mkdir(parents=True)
    (GPIO_SIM / "bank/num_lines").write_text(str(LINES))
    (GPIO_SIM / "live").write_text("1")
    yield {"gpiochip0": (GPIO_SIM / "bank/chip_name").read_text().strip()}
    (GPIO_SIM / "live").write_text("0")
    (GPIO_SIM / "bank").rmdir()
    GPIO_SIM.rmdir()
