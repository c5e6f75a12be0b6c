# SPDX-License-Identifier: MIT
"""What tools/release refuses, in a line each, and which tag it expects."""

import os
from pathlib import Path

import pytest

from copies import SONAME, VERSION, change, copy_tree, git, release

OTHER = "9.8.7"
TAG = f"v{VERSION}"
MINOR = VERSION.rpartition(".")[0]


@pytest.fixture(scope="session", name="kept")
def fixture_kept():
    return copy_tree(Path(os.environ["RELEASE_WORK"]) / "refusals")


@pytest.fixture(name="tree")
def fixture_tree(kept):
    """The copy; afterwards it is what it was."""
    first = git(kept, "rev-parse", "HEAD").strip()
    yield kept
    git(kept, "reset", "-q", "--hard", first)
    git(kept, "clean", "-q", "-d", "--force")
    for tag in git(kept, "tag").split():
        git(kept, "tag", "--delete", tag)


def refused(tree, *said):
    """All of these lines, no other, and nothing was made."""
    ended = release(tree, VERSION, "--check")
    assert ended.returncode == 1, ended.stdout
    assert [line.removeprefix("tools/release: ") for line in ended.stdout.splitlines()] == list(said)
    assert not (tree / "build").exists()


def test_a_clean_tree_is_taken_and_the_tag_named(tree):
    ended = release(tree, VERSION, "--check")
    commit = git(tree, "rev-parse", "--short=12", "HEAD").strip()
    assert (ended.returncode, ended.stdout) == (0, f"expected tag: git tag -a -m 'drehgeber {VERSION}' {TAG} {commit}\n")
    assert git(tree, "tag") == ""


def test_a_changed_file(tree):
    change(tree, "src/core/time.c", r"\Z", "\n")
    refused(tree, "the tree is not clean: changed files: 1, src/core/time.c first")


def test_an_unknown_file(tree):
    (tree / "src/core/new.c").write_text("")
    refused(tree, "the tree is not clean: changed files: 1, src/core/new.c first")


@pytest.mark.parametrize("path, pattern, new, said", [
    ("meson.build", VERSION, OTHER, f"meson.build: version {OTHER} is not {VERSION} of include/drehgeber/version.h"),
    ("library.json", VERSION, OTHER, f"library.json: version {OTHER} is not {VERSION} of include/drehgeber/version.h"),
    ("idf_component.yml", VERSION, OTHER, f"idf_component.yml: version {OTHER} is not {VERSION} of include/drehgeber/version.h"),
    ("debian/changelog", VERSION, OTHER, f"debian/changelog: version {OTHER} is not {VERSION} of include/drehgeber/version.h"),
    ("debian/control", f"libdrehgeber{SONAME} ", "libdrehgeber9 ",
     f"debian/control: soname 9 is not {SONAME} of include/drehgeber/version.h"),
    ("docs/install.md", f"drehgeber {MINOR} ", "drehgeber 9.8 ",
     f"docs/install.md: minor 9.8 is not {MINOR} of include/drehgeber/version.h"),
    ("include/drehgeber/version.h", r"(MAJOR \d+)", r"\g<1>9", f"include/drehgeber/version.h: {VERSION.split('.')[0]}9."
     f"{VERSION.partition('.')[2]} is not {VERSION}"),
    ("CHANGELOG.md", rf"^## {VERSION} - .*$", f"## {VERSION} - 2001-01-01", None),
    ("CHANGELOG.md", r"^## Unreleased\n", "## Unreleased\n\n- More.\n",
     "CHANGELOG.md: what stands below '## Unreleased' would be in no release"),
])
def test_what_disagrees(tree, path, pattern, new, said):
    change(tree, path, pattern, new)
    git(tree, "commit", "-q", "-a", "-m", "Break it")
    if said:
        refused(tree, said)
    else:
        ended = release(tree, VERSION, "--check")
        assert ended.returncode == 1 and "released on 2001-01-01, not on " in ended.stdout


def test_another_version_than_the_tree_has(tree):
    ended = release(tree, OTHER, "--check")
    assert ended.returncode == 1
    assert ended.stdout.splitlines() == [
        f"tools/release: include/drehgeber/version.h: version {VERSION} is not {OTHER}",
        f"tools/release: CHANGELOG.md has nothing below '## {OTHER} - YYYY-MM-DD'"]


def test_tags(tree):
    git(tree, "tag", TAG)
    refused(tree, f"tag {TAG} is not annotated; expected 'git tag -a {TAG}'")
    git(tree, "tag", "--delete", TAG)
    git(tree, "tag", "-a", "-m", "x", TAG)
    assert release(tree, VERSION, "--check").stdout == f"tag {TAG} is of this commit\n"
    old = git(tree, "rev-parse", "--short=12", "HEAD").strip()
    git(tree, "commit", "-q", "--allow-empty", "-m", "Go on")
    new = git(tree, "rev-parse", "--short=12", "HEAD").strip()
    refused(tree, f"tag {TAG} is of commit {old}, and {new} is checked out")


def test_everything_that_is_wrong_is_said_at_once(tree):
    change(tree, "meson.build", VERSION, OTHER)
    refused(tree, "the tree is not clean: changed files: 1, meson.build first",
            f"meson.build: version {OTHER} is not {VERSION} of include/drehgeber/version.h")
