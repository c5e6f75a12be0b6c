# SPDX-License-Identifier: MIT
"""A page that is wrong is refused, with its line; a page that is right is not."""
from pathlib import Path

import pytest

from pages import PageError, check, matches, parse

ENCODER = "build/quickstart/drehgeber run s3684-rs485 --pty=/tmp/enc --shaft 90DEG"
# In place of the program: a rig that takes a while, and says that it has ended.
RIG = """#!/bin/bash
trap 'touch ended; exit 0' TERM
grep -qx '\\[encoder a\\]' "$2" || {
    echo "$2:$(grep -n . "$2" | cut -d: -f1): no encoder" >&2
    exit 1
}
echo "ready s3684-rs485 pty:/dev/pts/9 a"
sleep 0.3
echo "ready rig"
while :; do sleep 0.05; done
"""


def fence(language: str, text: str) -> str:
    return f"```{language}\n{text}\n```\n\n"


def page(*parts: str) -> list:
    return parse("page.md", "# Page\n\n" + "".join(parts))


@pytest.fixture
def tree(tmp_path) -> Path:
    (tmp_path / "tree").mkdir()
    (tmp_path / "tree/job").write_text("tools/all --really\n")
    (tmp_path / "tree/README.md").write_text("# Page\n")
    return tmp_path / "tree"


@pytest.fixture
def rig(tmp_path) -> Path:
    path = tmp_path / "drehgeber"
    path.write_text(RIG)
    path.chmod(0o755)
    return path


def error_of(act, *arguments, **options) -> str:
    with pytest.raises(PageError) as caught:
        act(*arguments, **options)
    return str(caught.value)


PROGRAM_C = """#include <stdio.h>
#include "drehgeber/drehgeber.h"
int main(void)
{
    puts(dg_version() ? "linked" : "");
    return RETURNED;
}"""

RIGHT = {
    "output": [fence("sh", "echo one; echo two >&2\necho three"), fence("text", "one\n...\nthree")],
    "bare output": [fence("sh", "echo one"), fence("", "o...")],
    "drawing": [fence("", "( o )"), fence("sh", "true")],
    "encoder": [fence("sh", ENCODER), fence("text", "ready s3684-rs485 pty:/dev/pts/..."),
                fence("sh", "test -e /tmp/enc")],
    "ended with its section": ["## One\n\n", fence("sh", ENCODER), "### Below\n\n",
                               fence("sh", "test -e /tmp/enc"), "## Two\n\n",
                               fence("sh", "test ! -e /tmp/enc")],
    "long line": [fence("sh", ENCODER.replace(" --", " \\\n  --") + "\ntest -e /tmp/enc")],
    "asked to the background": [fence("sh", f"{ENCODER} &\nkill -0 $!\n"
                                      "until test -e /tmp/enc; do sleep 0.01; done\n"
                                      "kill $!\nwait $!")],
    "refused, as it says": [fence("sh", "drehgeber run nonsense || echo refused"),
                            fence("text", "...unknown model nonsense...\nrefused")],
    "python": [fence("python", "print(2 + 2)"), fence("text", "4")],
    "folder of its own": [fence("sh", "cat README.md\necho 1 > made"), fence("text", "# Page"),
                          fence("python", "print(open('made').read())"), fence("text", "1")],
    "saved": ["<!-- file: seen.py -->\n", fence("python", "SEEN = 5"),
              fence("python", "import seen\nprint(seen.SEEN)"), fence("text", "5")],
    "for the guest": ["<!-- run: guest -->\n", fence("sh", "false"), fence("text", "never")],
    "elsewhere": ["<!-- run: elsewhere, other.test -->\n", fence("sh", "false"),
                  "<!-- run: elsewhere, job -->\n", fence("sh", "tools/all"),
                  "<!-- run: elsewhere, other.test -->\n", fence("yaml", "script: tools/all")],
    "heading in a block": [fence("sh", "# One\n" + ENCODER), fence("sh", "test -e /tmp/enc")],
}

# What is wrong: the page, and what the error has to say.
WRONG = {
    "status": ([fence("sh", "true\nsh -c 'echo no; exit 7'\ntrue")],
               ["page.md:5: exit status 7: sh -c 'echo no; exit 7'\nno"]),
    "unset": ([fence("sh", 'echo "$NOTHING"')], ["page.md:4: exit status 1", "NOTHING: unbound"]),
    "syntax": ([fence("sh", "true\nif")], ["page.md", "line 6: syntax error"]),
    "output": ([fence("sh", "echo one\necho two"), fence("text", "two\none")],
               ["page.md:9: the block in line 4 does not print this", "one\ntwo"]),
    "part of a line": ([fence("sh", "echo 1 turns"), fence("text", "turns")], ["page.md:8: "]),
    "python": ([fence("python", "a = 1\na.b")],
               ["page.md:4: exit status 1", "line 5", "no attribute 'b'"]),
    "background": ([fence("sh", "true\n" + ENCODER.replace("90DEG", "90FOO"))],
                   ["page.md:5: exit status 2: build/quickstart/drehgeber", "90FOO"]),
    "encoder dies": ([fence("sh", ENCODER + "\necho $! >pid"),
                      fence("sh", 'kill -KILL "$(cat pid)"')],
                     ["page.md:4: exit status -9: build/quickstart/drehgeber run"]),
    "encoder speaks": ([fence("sh", ENCODER), fence("sh", "false")],
                       ["page.md:8: exit status 1: false",
                        "meanwhile build/quickstart/drehgeber run", "ready s3684-rs485 pty:"]),
}

# What is wrong before anything is run.
MARKED = {
    "no such test": (["<!-- run: elsewhere, other.tset -->\n", fence("sh", "tools/all")],
                     "page.md:5: 'other.tset' is no test of ctest"),
    "not called there": (["<!-- run: elsewhere, job -->\n", fence("sh", "tools/other")],
                         "page.md:5: 'job' is no test of ctest, and no file of the tree with"),
    "nobody": (["<!-- run: elsewhere -->\n", fence("sh", "tools/all")],
               "page.md:5: 'run: elsewhere' is neither"),
    "never": (["<!-- run: never -->\n", fence("sh", "tools/all")],
              "page.md:5: 'run: never' is neither"),
    "guest without its test": (["<!-- run: guest -->\n", fence("sh", "true")],
                               "page.md:5: 'rig.docs' is no test"),
    "mark without a block": (["<!-- run: guest -->\nText.\n\n", fence("sh", "true")],
                             "page.md:4: a mark belongs right above a block"),
    "mark at the end": ([fence("sh", "true"), "<!-- run: guest -->\n"],
                        "page.md: a mark belongs right above a block"),
    "mark on output": ([fence("sh", "true"), "<!-- run: guest -->\n", fence("text", "one")],
                       "page.md:9: only what can be run"),
    "output of nothing": ([fence("sh", "echo one"), "## Two\n\n", fence("text", "one")],
                          "page.md:10: 'text' cannot be run, and no block before it"),
    "unknown language": ([fence("shell", "true")], "page.md:4: 'shell' cannot be run"),
    "saved for nobody": (["<!-- file: rig.ini -->\n", fence("ini", "[rig]"), fence("sh", "true")],
                         "page.md:5: no later block uses rig.ini"),
    "saved too late": ([fence("sh", "cat rig.ini"),
                        "<!-- file: rig.ini -->\n", fence("ini", "[rig]")],
                       "page.md:9: no later block uses rig.ini"),
}


@pytest.mark.parametrize("parts", RIGHT.values(), ids=RIGHT)
def test_right(parts, read, tree):
    blocks = page(*parts)
    check(blocks, tree, ["other.test", "rig.docs"])
    read(blocks, tree)
    # What the page wrote is not here.
    assert sorted(path.name for path in tree.iterdir()) == ["README.md", "job"]


@pytest.mark.parametrize("parts, said", WRONG.values(), ids=WRONG)
def test_wrong(parts, said, read, tree):
    error = error_of(read, page(*parts), tree)
    for part in said:
        assert part in error


def test_block_that_hangs_is_ended(read, tree):
    error = error_of(read, page(fence("sh", "echo first\nsleep 100")), tree, patience_s=1)
    assert error.startswith("page.md:4: not done after 1 s") and "first" in error


@pytest.mark.parametrize("parts, said", MARKED.values(), ids=MARKED)
def test_marked_wrong(parts, said, tree):
    assert error_of(lambda: check(page(*parts), tree, ["other.test"])).startswith(said)


@pytest.mark.parametrize("where, said", [("here", "echo here"), ("guest", "echo guest")])
def test_runs_only_what_is_for_this_place(where, said, read, tree):
    blocks = page(fence("sh", "echo here; false"),
                  "<!-- run: guest -->\n", fence("sh", "echo guest; false"))
    assert said in error_of(read, blocks, tree, where=where)


def test_c_is_compiled_against_the_build(read, tree):
    repository = Path(__file__).resolve().parents[3]
    good = page(fence("c", PROGRAM_C.replace("RETURNED", "0")), fence("text", "linked"))
    read(good, repository)
    bad = page(fence("c", PROGRAM_C.replace("RETURNED", "3")))
    assert "page.md:4: exit status 3" in error_of(read, bad, repository)
    wrong = page(fence("c", PROGRAM_C.replace("RETURNED", "nothing")))
    assert "page.md.c:9:" in error_of(read, wrong, repository)


def test_rig_file_is_started_and_stopped(read, tree, rig):
    read(page(fence("ini", "[rig]\n[encoder a]"), fence("text", "ready s3684-rs485...\nready rig"),
              fence("sh", "test -e ended")), tree, rig)
    error = error_of(read, page(fence("ini", "[encoder b]")), tree, rig)
    assert "page.md:4: exit status 1" in error and "page.md.ini:4: no encoder" in error


def test_saved_rig_file_is_run_by_a_later_block(read, tree, rig):
    read(page("## One\n\n", "<!-- file: rig.ini -->\n", fence("ini", "[encoder a]"),
              fence("sh", "test ! -e ended\ndrehgeber run rig.ini"),
              fence("text", "...\nready rig"),
              "## Two\n\n", fence("sh", "test -e ended")), tree, rig)


@pytest.mark.parametrize("wanted, output, same", [
    ("a\nb", "x\na\nb\ny", True),
    ("a\nb", "a\n\nb", False),
    ("a...c", "abc", True),
    ("a...c", "ab\nc", False),
    ("a\n...\nc", "a\nb\nb\nc", True),
    ("a\n...\nc", "a\nc", True),
    ("a\n...\nc", "c\na", False),
    ("a.b", "axb", False),
    ("a", "a  ", True),
    ("a", "ab", False),
])
def test_matches(wanted, output, same):
    assert matches(wanted, output) == same
