# SPDX-License-Identifier: MIT
"""What the first page and docs/install.md say about installing, below a folder in place of / and with a tree
that is built already: installed, a program built as the page says, uninstalled again. The jobs of tools/examples/ci are
held to the same commands.

usage: install.py TREE BUILD WORK
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

MARKED = re.compile(r"^<!-- run: elsewhere, docs\.install -->\n(?:<!--[^\n]*\n)*```(\w+)\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?",
                    re.M | re.S)
# Nobody needs to be root here, and the folder has no /etc; packages and a build are there (docs.quickstart).
SHELL = 'set -eu; sudo() { "$@"; }; ldconfig() { :; }\n'
DONE_BEFORE = re.compile(r"^.*(?:install-deps|--preset).*\n", re.M)
JOBS = "tools/examples/ci"


def run(commands, folder, **environment):
    return subprocess.run(["bash", "-c", SHELL + commands], cwd=folder, check=True, text=True, capture_output=True,
                          env={**os.environ, **environment}).stdout


def files_below(root):
    return sorted(path for path in root.rglob("*") if not path.is_dir())


def build_program(tree, place, root, listing, commands, printed):
    place.mkdir()
    (place / "CMakeLists.txt").write_text(listing, encoding="utf-8")
    shutil.copy(tree / "tools/examples/consumers/find-package/main.c", place)
    said = run(commands, place, CMAKE_PREFIX_PATH=str(root / "usr/local"))
    assert said.splitlines()[-1].strip() == printed.strip(), said


def check_jobs(tree, commands):
    """Both jobs have what the page says, line by line, in that order."""
    wanted = [line.removeprefix("sudo ") for line in commands.splitlines()]
    gitlab = yaml.safe_load((tree / JOBS / "gitlab.yml").read_text(encoding="utf-8"))["test"]["before_script"]
    steps = yaml.safe_load((tree / JOBS / "github.yml").read_text(encoding="utf-8"))["jobs"]["test"]["steps"]
    github = [line for step in steps for line in step.get("run", "").splitlines()]
    for name, lines in (("gitlab", gitlab), ("github", github)):
        assert [line for line in lines if line in wanted] == wanted, f"{name}: {lines} has not {wanted}"


def main():
    tree, build, work = (Path(argument).resolve() for argument in sys.argv[1:])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    first, page = ((tree / name).read_text(encoding="utf-8") for name in ("README.md", "docs/install.md"))
    [(_, install, _)] = MARKED.findall(first)
    (_, listing, _), (_, commands, printed) = MARKED.findall(page)
    [uninstall] = re.findall(r"`(sudo cmake --build \S+ --target uninstall)`", page)
    root = work / "root"

    run(DONE_BEFORE.sub("", install).replace("build/quickstart", str(build)), tree, DESTDIR=str(root))
    assert (root / "usr/local/bin/drehgeber").is_file(), files_below(root)
    build_program(tree, work / "user", root, listing, commands, printed)
    run(uninstall.replace("build/quickstart", str(build)), tree, DESTDIR=str(root))
    assert not files_below(root), files_below(root)
    assert not [path for path in root.rglob("*") if path.name == "drehgeber"], "folders are left"
    check_jobs(tree, install)


main()
