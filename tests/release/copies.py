# SPDX-License-Identifier: MIT
"""Copies of the tree as it is now, committed, in which tools/release can run."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
sys.path.append(str(TREE / "tests/gates"))
from versions import parts, version_of  # noqa: E402

VERSION = version_of(str(TREE))[0]
SONAME = parts(VERSION)["soname"]
AUTHOR = ("-c", "user.name=A Tester", "-c", "user.email=tester@example.org")


def git(folder: Path, *words: str) -> str:
    return subprocess.run(["git", "-C", str(folder), *AUTHOR, *words], check=True, text=True, stdout=subprocess.PIPE).stdout


def copy_tree(folder: Path) -> Path:
    """The files of the tree, whether they are committed there or not, as a commit of a new repository that could be
    released: its change log has nothing that is not."""
    shutil.rmtree(folder, ignore_errors=True)
    for path in filter(None, git(TREE, "ls-files", "-z", "--cached", "--others", "--exclude-standard").split("\0")):
        if os.path.lexists(TREE / path):
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(TREE / path, folder / path, follow_symlinks=False)
    changelog = folder / "CHANGELOG.md"
    text = changelog.read_text(encoding="utf-8")
    changelog.write_text(re.sub(r"^## Unreleased\n.*?(?=^## )", "## Unreleased\n\n", text, flags=re.M | re.S), encoding="utf-8")
    git(folder, "init", "-q", "-b", "main")
    git(folder, "add", "--all", ".")
    git(folder, "commit", "-q", "-m", "A release")
    return folder


def release(folder: Path, *words: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([folder / "tools/release", *words], check=False, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, **options)


def change(folder: Path, path: str, pattern: str, new: str):
    """One place of a file becomes another."""
    text = (folder / path).read_text(encoding="utf-8")
    changed, count = re.subn(pattern, new, text, count=1, flags=re.M)
    assert count == 1 and changed != text, f"{path} has no {pattern}"
    (folder / path).write_text(changed, encoding="utf-8")
