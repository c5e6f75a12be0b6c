# SPDX-License-Identifier: MIT
"""What a build tree knows: how each source is compiled, how programs are linked, which tests there are."""

import collections
import concurrent.futures
import functools
import json
import os
import queue
import re
import shlex
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import NamedTuple

import rooms

# A test has looped for ever after this much processor time, or hangs after this much time.
CPU_LEAST_S = 2
CPU_TIMES_USUAL = 10
CPU_S = 60  # of what was not learned
WALL_S = 120  # or what ctest gives it
MEMORY = 8 << 30
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+?::.+?)(?: - .*)?$", re.M)  # of pytest's summary


class Test(NamedTuple):
    name: str
    command: list
    environment: dict = {}
    folder: str = ""  # where ctest runs it
    wall_s: float = WALL_S
    usual_s: float | None = None  # processor time, of what was learned

    @property
    def in_virtual_time(self):
        """It passes or fails whatever the machine does meanwhile."""
        return self.name.startswith(("unit.", "thorough.", "conformance.", "golden."))

    def only(self, case):
        """One case of pytest."""
        place = case.partition("::")
        return self._replace(name=f"{self.name}::{place[2]}",
                             command=[*self.command[:-1], f"{self.command[-1]}::{place[2]}"])


class Outcome(NamedTuple):
    good: bool
    used_s: float  # processor time
    case: str = ""  # of pytest, that failed first


def end_group(group, number):
    """A test, and the programs that it has started."""
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        pass


def run_test(test, place):
    """In the scratch folder `place`, where its output is kept."""
    cpu_s = CPU_S if test.usual_s is None else int(CPU_LEAST_S + CPU_TIMES_USUAL * test.usual_s)
    limits = ["prlimit", f"--cpu={cpu_s}:{cpu_s + 1}", f"--as={MEMORY}", "--core=0"]
    with open(place / "said", "w+", encoding="utf-8", errors="replace") as said:
        process = subprocess.Popen([*limits, *test.command], env=os.environ | test.environment,
                                   cwd=test.folder or place, stdin=subprocess.DEVNULL, stdout=said,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        # First as Ctrl-C does, so that a test can end its programs.
        timers = [threading.Timer(test.wall_s, end_group, [process.pid, signal.SIGINT]),
                  threading.Timer(test.wall_s + 10, end_group, [process.pid, signal.SIGKILL])]
        for timer in timers:
            timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        for timer in timers:
            timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        failed = FAILED.search(said.read()) if process.returncode else None
    return Outcome(process.returncode == 0, usage.ru_utime + usage.ru_stime, failed.group(1) if failed else "")


def read_test(entry):
    """Of what ctest tells of a test: one, or one for each file where pytest runs several."""
    properties = {each["name"]: each["value"] for each in entry["properties"]}
    environment = dict(word.split("=", 1) for word in properties.get("ENVIRONMENT", []))
    command = entry.get("command")
    if not command or "PASS_REGULAR_EXPRESSION" in properties:
        return
    folder = "" if entry["name"].startswith(("unit.", "thorough.")) else properties["WORKING_DIRECTORY"]
    test = Test(entry["name"], command, environment, folder, max(WALL_S, properties.get("TIMEOUT", 0)))
    if "pytest" not in command:
        yield test
        return
    at = command.index("pytest") + 1
    paths = [Path(word) for word in command if word.endswith(".py") or Path(word).is_dir()]
    options = [word for word in command[at:] if Path(word) not in paths]
    files = [file for path in paths for file in (sorted(path.glob("test_*.py")) if path.is_dir() else [path])]
    for file in files:
        name = test.name if paths == [file] else f"{test.name}/{file.stem.removeprefix('test_')}"
        yield test._replace(name=name, command=[*command[:at], "-x", *options, str(file)])


class Tree:
    """A build tree."""

    def __init__(self, place, root):
        self.place = place
        self.root = root
        if not (place / "compile_commands.json").is_file():
            sys.exit(f"no tree {place}: cmake --preset {place.name} && cmake --build --preset {place.name}")
        self.compiled = collections.defaultdict(list)  # source: how, and its object, for each target
        for entry in json.loads((place / "compile_commands.json").read_text(encoding="utf-8")):
            words = shlex.split(entry["command"])
            source = os.path.relpath(entry["file"], root)
            self.compiled[source].append((words, words[words.index("-o") + 1]))
        told = json.loads(subprocess.check_output(["ctest", "--test-dir", place, "--show-only=json-v1"]))
        self.tests = [test for entry in told["tests"] for test in read_test(entry)]
        self.links = {}
        self.good = {}  # tests, and cases of them: whether they pass with nothing broken
        self.lock = threading.Lock()

    @functools.cached_property
    def users(self):
        """file: the sources that include it, as the compiler said"""
        users = collections.defaultdict(set)
        objects = {output: source for source, entries in self.compiled.items() for _, output in entries}
        said = subprocess.check_output(["ninja", "-C", self.place, "-t", "deps", *objects], text=True)
        source = None
        for line in said.splitlines():
            if line and not line.startswith((" ", "ninja:")):
                source = objects.get(line.split(":")[0])
            elif line.startswith("    ") and source:
                name = os.path.normpath(self.place / line.strip())
                users[os.path.relpath(name, self.root)].add(source)
        return users

    def link_words(self, product):
        """How a program or library of this tree is linked; None of what is not linked."""
        if product not in self.links:
            said = subprocess.run(["ninja", "-C", self.place, "-t", "commands", "-s", product], text=True,
                                  capture_output=True, check=False)
            words = shlex.split(said.stdout)
            linked = said.returncode == 0 and "-o" in words
            self.links[product] = words[2: words.index("&&", 2)] if linked else None
        return self.links[product]

    def judges(self, path):
        """The tests of a file, in their order; those of a pattern that were learned, the quick ones first."""
        chosen = []
        for pattern in rooms.judges_of(path):
            found = [test for test in self.tests if re.match(pattern, test.name) and test not in chosen]
            chosen += sorted(found, key=lambda test: (test.name.startswith("conformance."), test.usual_s or 0))
        return chosen

    def learn(self, pattern, places):
        """The tests of this pattern pass as things are, and take this long."""

        def try_out(test):
            place = free.get()
            outcome = run_test(test, place)
            free.put(place)
            return outcome

        free = queue.SimpleQueue()
        for place in places:
            free.put(place)
        chosen = [at for at, test in enumerate(self.tests) if re.match(pattern, test.name)]
        with concurrent.futures.ThreadPoolExecutor(len(places)) as pool:
            for at, outcome in zip(chosen, pool.map(try_out, [self.tests[at] for at in chosen])):
                if not outcome.good:
                    sys.exit(f"{self.tests[at].name} fails with nothing broken")
                self.good[self.tests[at].name] = True
                self.tests[at] = self.tests[at]._replace(usual_s=outcome.used_s)

    def passes_unbroken(self, test, place):
        """Tried once for all; what fails is tried again, since a busy machine may have failed it."""
        with self.lock:
            if test.name not in self.good:
                self.good[test.name] = any(run_test(test, place).good for _ in range(2))
            return self.good[test.name]
