# SPDX-License-Identifier: MIT
"""Every example of every page runs, and prints what the page says."""
import re
import sys
from pathlib import Path

import pytest

from conftest import PROGRAM, WHERE
from pages import PageError, check, parse

TREE = Path(__file__).resolve().parents[3]
sys.path.append(str(TREE / "tests/gates"))
from sources import files  # noqa: E402

HISTORY = "CHANGELOG.md"
PAGES = [page for page in files(str(TREE), suffixes=(".md",)) if page != HISTORY]


def blocks_of(page: str) -> list:
    return parse(page, (TREE / page).read_text(encoding="utf-8"))


def has_work(page: str) -> bool:
    """A page that is wrong has, too: the test says what is wrong."""
    try:
        return any(block.where == WHERE for block in blocks_of(page))
    except PageError:
        return True


@pytest.fixture(scope="session")
def tests() -> list:
    """Names of the tests of the tree that the program was built in. Asking ctest itself would cut
    short the log of the one that runs this."""
    generated = sorted((PROGRAM.parent / "tests").rglob("CTestTestfile.cmake"))
    return [name for file in generated
            for name in re.findall(r"^add_test\((?:\[=*\[)?([\w.+-]+)", file.read_text(encoding="utf-8"), re.M)]


def assert_right(act):
    """A page's error is the whole report."""
    wrong = ""
    try:
        act()
    except PageError as error:
        wrong = str(error)
    if wrong:
        pytest.fail(wrong, pytrace=False)


@pytest.mark.parametrize("page", PAGES)
def test_marks(page, tests):
    assert_right(lambda: check(blocks_of(page), TREE, tests))


@pytest.mark.parametrize("page", [page for page in PAGES if has_work(page)])
def test_examples(page, read, chips):
    assert_right(lambda: read(blocks_of(page), TREE, where=WHERE, replaced=chips))
