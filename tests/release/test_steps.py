# SPDX-License-Identifier: MIT
"""The steps of .ci/release that GitHub and GitLab call for a tag, in a clone of the tree that has a small release. What
reaches others goes through programs that only write down how they were called. `make` and `try` are
release.two-roots and release.smoke."""

import json
import os
import subprocess
import tarfile
from pathlib import Path

import pytest
import yaml

from copies import TREE, VERSION, copy_tree, git

TAG = f"v{VERSION}"
RECORD = '#!/bin/sh\n{{ printf "%s " "${{0##*/}}" "$@"; echo; }} >>{said}\n'
GITHUB = {"GITHUB_REF_NAME": TAG, "GITHUB_REPOSITORY": "Some/Drehgeber", "GITHUB_ACTOR": "somebody", "GITHUB_TOKEN": "x"}
GITLAB = {"GITLAB_CI": "true", "CI_COMMIT_TAG": TAG, "CI_API_V4_URL": "https://example.org/api/v4", "CI_PROJECT_ID": "7",
          "CI_JOB_TOKEN": "x", "CI_REGISTRY": "registry.example.org", "CI_REGISTRY_IMAGE": "registry.example.org/some/drehgeber",
          "CI_REGISTRY_USER": "somebody", "CI_REGISTRY_PASSWORD": "x"}
FOLDER = f"build/releases/drehgeber-{VERSION}"
# What a forge has published: programs that answer as it does, from archives in {archives}.
EARLIER = "0.2.9"
PUBLISHED = {"gh": """case "$1 $2" in
"release list") printf 'v{earlier}\\n{tag}\\n' ;;
"release download") cp "{archives}/$5" "$7" ;;
esac
""", "curl": """for word; do
    [ "${{before-}}" != --output ] || output=$word
    before=$word
done
case $word in
*/releases*) echo '[{{"tag_name": "v{earlier}"}}, {{"tag_name": "{tag}"}}]' ;;
*) cp "{archives}/${{word##*/}}" "$output" ;;
esac
"""}
FILES = ("NOTES.md", f"drehgeber-{VERSION}-site.tar.gz", "f3668.eds")


@pytest.fixture(scope="module", name="origin")
def fixture_origin():
    origin = copy_tree(Path(os.environ["RELEASE_WORK"]) / "steps")
    git(origin, "tag", "-a", "-m", "x", TAG)
    return origin


@pytest.fixture(name="tree")
def fixture_tree(origin, tmp_path):
    """As a runner has it: the commit under the tag's name, not the tag."""
    tree = tmp_path / "tree"
    git(tmp_path, "clone", "-q", "--no-tags", str(origin), str(tree))
    git(tree, "tag", TAG)
    return tree


@pytest.fixture(name="released")
def fixture_released(tree, tmp_path):
    folder = tree / FOLDER
    folder.mkdir(parents=True)
    (folder / "NOTES.md").write_text("# News\n", encoding="utf-8")
    (folder / "f3668.eds").write_text("x", encoding="utf-8")
    (folder / f"drehgeber-{VERSION}-site.tar.gz").write_bytes(b"")
    return tree


def pack_site(folder: Path, version: str) -> None:
    """An archive of a page that has the version as text."""
    (folder / "site").mkdir(parents=True, exist_ok=True)
    (folder / "site/index.html").write_text(version, encoding="utf-8")
    with tarfile.open(folder / f"drehgeber-{version}-site.tar.gz", "w:gz") as packed:
        packed.add(folder / "site", f"drehgeber-{version}-site")


def step(tree: Path, name: str, variables: dict, status: int = 0, answers: dict | None = None) -> list[str]:
    """@return how others were called"""
    said, programs = tree / "build/said", tree / "build/programs"
    programs.mkdir(parents=True, exist_ok=True)
    for program in ("gh", "curl", "docker"):
        (programs / program).write_text(RECORD.format(said=said) + (answers or {}).get(program, ""), encoding="utf-8")
        (programs / program).chmod(0o755)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("GITHUB_", "GITLAB_", "CI_"))}
    ended = subprocess.run([tree / ".ci/release", name], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                           env={**environment, **variables, "PATH": f"{programs}:{os.environ['PATH']}"})
    assert ended.returncode == status, ended.stdout
    return said.read_text(encoding="utf-8").splitlines() if said.exists() else []


@pytest.mark.parametrize("variables", [GITHUB, GITLAB], ids=["github", "gitlab"])
def test_the_tag_is_fetched_and_taken(tree, variables):
    step(tree, "tag", variables)
    assert git(tree, "cat-file", "-t", TAG) == "tag\n"


def test_a_tag_of_another_version_is_refused(tree, origin):
    git(origin, "tag", "-f", "-a", "-m", "x", "v9.8.7")
    step(tree, "tag", {"GITHUB_REF_NAME": "v9.8.7"}, status=1)


def published(archives: Path, *versions: str) -> dict:
    """What step() needs for a forge that has released two versions, and has sites of these."""
    for version in versions:
        pack_site(archives, version)
    return {name: text.format(tag=TAG, earlier=EARLIER, archives=archives) for name, text in PUBLISHED.items()}


@pytest.mark.parametrize("variables", [GITHUB, GITLAB], ids=["github", "gitlab"])
def test_the_sites(tree, tmp_path, variables):
    """Of all releases; what a run before has left is gone."""
    (tree / "public/0.0.1").mkdir(parents=True)
    (tree / "public/0.0.1/index.html").touch()
    step(tree, "site", variables, answers=published(tmp_path / "archives", EARLIER, VERSION))
    rows = json.loads((tree / "public/versions.json").read_text(encoding="utf-8"))
    assert [row["version"] for row in rows] == [VERSION, EARLIER]
    for version in (EARLIER, VERSION):
        assert (tree / f"public/{version}/index.html").read_text(encoding="utf-8") == version


def test_a_site_that_cannot_be_fetched_is_an_error(tree, tmp_path):
    step(tree, "site", GITHUB, status=1, answers=published(tmp_path / "archives", VERSION))


def test_a_release_on_github(released):
    files = " ".join(f"{FOLDER}/{name}" for name in FILES)
    assert step(released, "publish", GITHUB) == [
        f"gh release create {TAG} --verify-tag --title drehgeber {VERSION} --notes-file {FOLDER}/NOTES.md {files} "]


def test_a_release_on_gitlab(released):
    *uploads, last = step(released, "publish", GITLAB)
    place = f"https://example.org/api/v4/projects/7/packages/generic/drehgeber/{VERSION}"
    assert [line.split()[-2:] for line in uploads] == [[f"{FOLDER}/{name}", f"{place}/{name}"] for name in FILES]
    assert last.split()[-3:] == ["--data", "@build/release.json", "https://example.org/api/v4/projects/7/releases"]
    told = json.loads((released / "build/release.json").read_text(encoding="utf-8"))
    assert (told["tag_name"], told["description"]) == (TAG, "# News\n")
    assert told["assets"]["links"] == [{"name": name, "url": f"{place}/{name}"} for name in FILES]


@pytest.mark.parametrize("variables, name", [(GITHUB, "ghcr.io/some/drehgeber"), (GITLAB, "registry.example.org/some/drehgeber")],
                         ids=["github", "gitlab"])
def test_the_image(tree, variables, name):
    assert step(tree, "image", variables) == [
        f"docker login --username somebody --password-stdin {name.partition('/')[0]} ",
        f"docker build --file Containerfile --tag {name}:{VERSION} --tag {name}:latest . ",
        f"docker push {name}:{VERSION} ", f"docker push {name}:latest "]


def test_what_pypi_is_offered(tmp_path):
    """Wheels and the sources for pip, not the source archive."""
    jobs = yaml.safe_load((TREE / ".github/workflows/release.yml").read_text(encoding="utf-8"))["jobs"]
    [command] = [row["run"] for row in jobs["pypi"]["steps"] if "run" in row]
    folder = tmp_path / FOLDER
    folder.mkdir(parents=True)
    offered = [f"drehgeber-{VERSION}-py3-none-manylinux_2_17_x86_64.whl", f"drehgeber-{VERSION}.tar.gz"]
    for name in (*offered, *FILES, f"drehgeber-{VERSION}-sources.tar.gz"):
        (folder / name).touch()
    subprocess.run(["bash", "-euc", command], cwd=tmp_path, check=True, env={**os.environ, "GITHUB_REF_NAME": TAG})
    assert sorted(path.name for path in (tmp_path / "dist").iterdir()) == offered
