# SPDX-License-Identifier: MIT
"""Two releases of one commit, in folders of other names and lengths, by users with other settings, are the same bytes, and
no file names the folder that it was made in."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from copies import TREE, VERSION, copy_tree, git, release

WORK = Path(os.environ["RELEASE_WORK"])
ROOTS = {"one": {}, "another/of/a-longer-name": {"TZ": "Pacific/Auckland", "LC_ALL": "C", "HOME": "/nonexistent", "LANG": "C"}}
MASKS = (0o022, 0o077)
# Every kind of file that a release has, and how many of it.
KINDS = {
    rf"drehgeber-{VERSION}-sources\.tar\.gz": 1, rf"drehgeber-{VERSION}\.tar\.gz": 1,
    rf"drehgeber-{VERSION}-py3-none-manylinux_2_17_(x86_64|aarch64)\.whl": 2,
    rf"(drehgeber|drehgeber-web|libdrehgeber-dev|libdrehgeber[\d.]+)_{VERSION}_amd64\.deb": 4,
    rf"python3-drehgeber_{VERSION}_all\.deb": 1, rf"drehgeber-(s36|f36|ssi).*-{VERSION}\.uf2": 11,
    rf"drehgeber-{VERSION}-playground\.html": 1, rf"drehgeber-{VERSION}-site\.tar\.gz": 1,
    rf"drehgeber-{VERSION}-hdl-debian12-x86_64\.tar\.gz": 1, rf"f36(58|68)-{VERSION}\.eds": 2,
    rf"drehgeber-{VERSION}\.spdx\.json": 1, r"NOTES\.md": 1, "SHA256SUMS": 1,
}
COPY = ("cp", "{path}", "{place}")
UNPACK = {".deb": ("dpkg-deb", "-x", "{path}", "{place}"), ".gz": ("tar", "-xf", "{path}", "-C", "{place}"),
          ".whl": ("python3", "-m", "zipfile", "-e", "{path}", "{place}")}


def make(name: str, environment: dict, mask: int, commit: Path) -> Path:
    """A release in a clone of the commit."""
    root = WORK / name
    shutil.rmtree(root, ignore_errors=True)
    root.parent.mkdir(parents=True, exist_ok=True)
    git(WORK, "clone", "-q", str(commit), str(root))
    sysroot = TREE / "build/sysroot"
    sysroot.mkdir(exist_ok=True, parents=True)
    (root / "build").mkdir()
    (root / "build/sysroot").symlink_to(sysroot)
    ended = release(root, VERSION, "--output", "made", cwd=root, umask=mask, env={**os.environ, **environment})
    print(ended.stdout)
    assert ended.returncode == 0, ended.stdout
    return root / "made" / f"drehgeber-{VERSION}"


@pytest.fixture(scope="module", name="releases")
def fixture_releases():
    commit = copy_tree(WORK / "commit")
    return [make(name, environment, mask, commit) for (name, environment), mask in zip(ROOTS.items(), MASKS, strict=True)]


def test_the_same_bytes(releases):
    one, another = ((folder / "SHA256SUMS").read_text(encoding="utf-8") for folder in releases)
    assert one.splitlines() == another.splitlines()


def test_every_kind_of_file(releases):
    names = sorted(path.name for path in releases[0].iterdir())
    counts = {kind: sum(bool(re.fullmatch(kind, name)) for name in names) for kind in KINDS}
    assert counts == KINDS
    assert len(names) == sum(KINDS.values())


def test_sums_are_as_sha256sum_reads_them(releases):
    for folder in releases:
        subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=folder, check=True)


def test_no_file_names_the_folder_it_was_made_in(releases):
    for folder in releases:
        inside = WORK / "inside"
        shutil.rmtree(inside, ignore_errors=True)
        for path in folder.iterdir():
            place = inside / path.name
            place.mkdir(parents=True)
            subprocess.run([word.format(path=path, place=place) for word in UNPACK.get(path.suffix, COPY)], check=True)
        found = subprocess.run(["grep", "-rlF", str(WORK), inside], check=False, text=True, stdout=subprocess.PIPE)
        assert found.stdout == ""
        assert len(list(inside.rglob("*"))) > 5000
