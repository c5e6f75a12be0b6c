# SPDX-License-Identifier: MIT
"""clang-tidy over all C that a host compiles, but for files that it has seen as they are.

usage: clang_tidy.py TREE BUILD [--changed COMMIT | FOLDER]

BUILD has compile_commands.json; sources of platform/web have their flags beside them. With COMMIT only what has
changed since, and what includes it. What was good is remembered in $DREHGEBER_CACHE, if that is said: by the
text of the source, of all that it includes, and of the settings.
"""

import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from sources import finish

# Boards and browsers have compilers of their own.
FOLDERS = ("src", "platform", "tools/drehgeber")
ELSEWHERE = ("platform/rp2040", "platform/web")
WEB = "platform/web"


class Tidy:
    def __init__(self, tree, build):
        self.tree = tree
        self.build = build
        database = build / "compile_commands.json"
        entries = json.loads(database.read_text(encoding="utf-8")) if database.exists() else []
        self.commands = {os.path.relpath(entry["file"], tree): shlex.split(entry["command"]) for entry in entries}
        version = subprocess.check_output(["clang-tidy", "--version"], text=True)
        self.settings = version + (tree / ".clang-tidy").read_text(encoding="utf-8")
        cache = os.environ.get("DREHGEBER_CACHE")
        self.stamps = Path(cache, "clang-tidy") if cache else None
        if self.stamps:
            self.stamps.mkdir(parents=True, exist_ok=True)

    def is_of_web(self, source):
        return source.startswith(WEB + "/")

    def compiler_of(self, source):
        """How it is compiled, but for the output and the source; None when nobody says it."""
        if self.is_of_web(source):
            flags = (self.tree / WEB / "compile_flags.txt").read_text(encoding="utf-8").split("\n")
            return ["clang", *(flag for flag in flags if flag)]
        words = self.commands.get(source)
        return words and words[:words.index("-o")]

    def includes_of(self, source):
        """The files of the tree that make it up, with itself."""
        command = [*self.compiler_of(source), "-MM", self.tree / source]
        where = self.tree / WEB if self.is_of_web(source) else self.build
        said = subprocess.run(command, cwd=where, capture_output=True, text=True, check=False)
        if said.returncode != 0:
            return {source}  # clang-tidy says why
        names = said.stdout.partition(":")[2].replace("\\\n", " ").split()
        paths = {os.path.relpath(os.path.join(where, name), self.tree) for name in names}
        return {path for path in paths if not path.startswith("..")}

    def stamp_of(self, source, includes):
        text = hashlib.sha256(self.settings.encode())
        text.update("\0".join(self.compiler_of(source)).replace(str(self.tree), "").encode())
        for path in sorted(includes):
            text.update(path.encode() + (self.tree / path).read_bytes())
        return self.stamps / text.hexdigest()

    def look_at(self, source, includes):
        """What it says against one source; one a run: with more, clang-tidy 14 takes every va_list of the second for
        uninitialised."""
        stamp = self.stamps and self.stamp_of(source, includes)
        if stamp and stamp.exists():
            return ""
        database = [] if self.is_of_web(source) else ["-p", self.build]
        done = subprocess.run(["clang-tidy", *database, "--quiet", source], cwd=self.tree, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode == 0 and stamp:
            stamp.touch()
        return done.stdout if done.returncode else ""


def changed_since(tree, commit):
    """Paths that differ from it; None when this clone does not have it."""
    git = ["git", "-C", tree]
    if subprocess.run([*git, "cat-file", "-e", commit], capture_output=True, check=False).returncode != 0:
        return None
    return set(subprocess.check_output([*git, "diff", "--name-only", commit], text=True).splitlines())


def sources_of(tree, folder):
    roots = [folder] if folder else [*FOLDERS, WEB]
    found = {str(path.relative_to(tree)) for root in roots for path in (tree / root).rglob("*.c")}
    if not folder:
        found = {path for path in found if not path.startswith(tuple(f"{other}/" for other in ELSEWHERE))
                 or path.startswith(WEB + "/")}
    return sorted(found)


def main():
    tree, build = (Path(word).resolve() for word in sys.argv[1:3])
    commit = sys.argv[4] if sys.argv[3:4] == ["--changed"] else None
    tidy = Tidy(tree, build)
    sources = sources_of(tree, None if commit else next(iter(sys.argv[3:]), None))
    complaints = [f"error: {build.name} does not compile {source}; for libgpiod 2 it needs what tools/environments all fetches"
                  for source in sources if not commit and tidy.compiler_of(source) is None]
    sources = [source for source in sources if tidy.compiler_of(source)]
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        includes = dict(zip(sources, pool.map(tidy.includes_of, sources)))
        changed = changed_since(tree, commit) if commit else None
        if changed is not None and ".clang-tidy" not in changed:
            sources = [source for source in sources if includes[source] & changed]
        print(f"{len(sources)} of {len(includes)} files")
        said = "".join(pool.map(lambda source: tidy.look_at(source, includes[source]), sources))
    complaints += sorted(set(re.findall(r"^.*(?:error|warning):.*$", said, re.M)))
    if complaints:
        print(said)
    # Nothing has changed: that is good, too.
    finish(len(sources) or len(includes), complaints)


main()
