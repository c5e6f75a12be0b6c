# SPDX-License-Identifier: MIT
"""Tries mutants, one at a time, in a scratch copy of the sources."""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import python_mutants
import rooms
from trees import run_test

COPIED = ("src", "include", "platform", "tools/drehgeber")


class Verdict(NamedTuple):
    result: str  # killed, survived, the same, not compiled, too late
    why: str = ""


def copy_file(source, to):
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(source, to)


def with_environment(test, more):
    return test._replace(environment=test.environment | more)


class Objects:
    """The objects of one mutant in place of a tree's, and whatever is linked of them, when a test asks for it."""

    def __init__(self, tree, place, broken):
        self.tree = tree
        self.place = place
        self.instead = dict(broken)  # of the tree: here
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        for old, new in broken.items():
            target = re.search(r"CMakeFiles/([^/]+)\.dir/", old)
            archive = f"lib{target.group(1)}.a"
            if (tree.place / archive).is_file():
                if archive not in self.instead:
                    copy_file(tree.place / archive, place / archive)
                    self.instead[archive] = str(place / archive)
                subprocess.run(["ar", "r", place / archive, new], check=True, capture_output=True)

    def link(self, product):
        """@return its path here, or None when nothing of it is broken"""
        words = self.tree.link_words(product)
        if not words or not any(word in self.instead for word in words):
            return None
        output = self.place / product
        output.parent.mkdir(parents=True, exist_ok=True)
        words = [self.instead.get(word, word) for word in words]
        words[words.index("-o") + 1] = str(output)
        subprocess.run(words, cwd=self.tree.place, check=True, capture_output=True)
        return output

    def with_beside(self, product):
        """A program, and what it finds beside itself."""
        beside = rooms.BESIDE.get(product, ())
        made = [self.link(each) for each in (product, *beside)]
        if not any(made):
            return None
        for each, output in zip((product, *beside), made):
            here = self.place / each
            if not output and each == product:
                copy_file(self.tree.place / each, here)
            elif not output and (self.tree.place / each).exists():
                here.parent.mkdir(parents=True, exist_ok=True)
                here.symlink_to(self.tree.place / each)
        return self.place / product

    def exchange(self, text, done):
        """A word of a test, with the broken program where it names one; `done` has those of this mutant."""
        if text not in done:
            path = Path(text)
            output = None
            if path.is_relative_to(self.tree.place) and path.is_file():
                output = self.with_beside(str(path.relative_to(self.tree.place)))
            done[text] = str(output) if output else text
        return done[text]


class Worker:
    """A scratch copy of what the mutants need."""

    def __init__(self, trees, root, place):
        self.trees = trees  # by name
        self.root = root
        self.place = place
        (place / "objects").mkdir(parents=True)
        (place / "here").mkdir()
        for folder in COPIED:
            if (root / folder).is_dir():
                shutil.copytree(root / folder, place / "tree" / folder)
        self.plain = {}
        self.packages = {}
        self.until = float("inf")  # no test begins behind it

    def compile(self, words, output):
        """In the copy of the sources; with the paths of this machine left out."""
        words = [word.replace(f"{self.root}/", "") for word in words if word != "-Werror"]
        words[words.index("-o") + 1] = str(output)
        return subprocess.run([*words, "-w"], cwd=self.place / "tree", stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False).returncode == 0

    def plain_object(self, source, words, name):
        """The object code of the source as it is."""
        if name not in self.plain:
            output = self.place / "plain.o"
            if not self.compile(words, output):
                sys.exit(f"{source} does not compile with nothing broken")
            self.plain[name] = output.read_bytes()
        return self.plain[name]

    def break_objects(self, tree, mutant, text):
        """The objects that the mutant changes, by their names in the tree; None when it does not compile."""
        users = [mutant.path] if mutant.path.endswith(".c") else sorted(tree.users[mutant.path])
        sources = [source for source in users if rooms.room_of(source) == rooms.room_of(mutant.path)]
        entries = [(source, *entry) for source in sources for entry in tree.compiled[source]]
        plain = [self.plain_object(source, words, name) for source, words, name in entries]
        path = self.place / "tree" / mutant.path
        path.write_text(mutant.apply(text), encoding="utf-8")
        broken = {}
        try:
            for (_, words, name), before in zip(entries, plain):
                output = self.place / "objects" / name
                output.parent.mkdir(parents=True, exist_ok=True)
                if not self.compile(words, output):
                    return None
                if output.read_bytes() != before:
                    broken[name] = str(output)
        finally:
            path.write_text(text, encoding="utf-8")
        return broken

    def attempt(self, mutant, text):
        room = rooms.room_of(mutant.path)
        tree = self.trees[room.tree]
        if mutant.path.endswith(".py"):
            return self.attempt_python(tree, mutant, text)
        broken = self.break_objects(tree, mutant, text)
        if broken is None:
            return Verdict("not compiled")
        if not broken:
            return Verdict("the same", "object code")
        objects = Objects(tree, self.place / "products", broken)
        if room.library:
            library = objects.link(room.library)
            if not library:
                sys.exit(f"{room.library} of {tree.place} is not linked of the objects of {room.name}")
            path = {"LD_LIBRARY_PATH": str(library.parent)}
            return self.judge(tree, mutant, lambda test: with_environment(test, path))
        done = {}
        return self.judge(tree, mutant, lambda test: test._replace(
            command=[objects.exchange(word, done) for word in test.command],
            environment={name: objects.exchange(word, done) for name, word in test.environment.items()}))

    def copy_packages(self, tree):
        """The Python package as it is installed, twice: one to break, one that stays."""
        found = list(tree.place.glob("tests/python/env/lib/python3*/site-packages/drehgeber"))
        if not found:
            sys.exit("the Python package is not installed: ctest --preset release -R python.install")
        for name in ("broken", "plain"):
            to = self.place / "env" / name
            shutil.copytree(found[0], to / "drehgeber", ignore=shutil.ignore_patterns("__pycache__"))
            self.packages[name] = {"PYTHONPATH": str(to), "PYTHONDONTWRITEBYTECODE": "1"}

    def attempt_python(self, tree, mutant, text):
        after = python_mutants.object_code(mutant.apply(text))
        if after is None:
            return Verdict("not compiled")
        if after == python_mutants.object_code(text):
            return Verdict("the same", "byte code")
        if not self.packages:
            self.copy_packages(tree)
        path = self.place / "env/broken/drehgeber" / Path(mutant.path).name
        path.write_text(mutant.apply(text), encoding="utf-8")
        try:
            return self.judge(tree, mutant, lambda test: with_environment(test, self.packages["broken"]),
                              lambda test: with_environment(test, self.packages["plain"]))
        finally:
            path.write_text(text, encoding="utf-8")

    def judge(self, tree, mutant, break_test, plain_test=lambda test: test):
        """What the tests say; `break_test` makes a test run what is broken."""
        for test in tree.judges(mutant.path):
            plain = plain_test(test)
            broken = break_test(plain)
            if broken == plain:
                continue  # it runs nothing of what is broken
            if time.monotonic() > self.until:
                return Verdict("too late")
            outcome = run_test(broken, self.place / "here")
            if not outcome.good and self.is_sure(tree, plain, broken, outcome.case):
                return Verdict("killed", test.name)
        return Verdict("survived")

    def is_sure(self, tree, plain, broken, case):
        """A test of real time has to fail twice; and each has to pass with nothing broken."""
        if case:
            plain, broken = plain.only(case), broken.only(case)
        if not plain.in_virtual_time and run_test(broken, self.place / "here").good:
            return False
        if not tree.passes_unbroken(plain, self.place / "here"):
            sys.exit(f"{plain.name} fails with nothing broken")
        return True
