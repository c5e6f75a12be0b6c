# SPDX-License-Identifier: MIT
"""Runs the blocks of one page in order, as a reader who pastes them one after the other.

A block runs in a folder that looks like the root of the tree and takes what it writes;
build/quickstart/drehgeber there is the program under test. /tmp is a folder of the page's own.
Lines that call `drehgeber run` go to the background until the section ends, that is until a heading
of the same or a higher level. Every wait has an end.
"""
import ctypes
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pages import COMMANDS, Block, PageError, matches

SHELL = Path(__file__).resolve().with_name("shell.sh")
PATIENCE_S = 30.0
END_S = 10.0  # for what was told to end
PR_SET_CHILD_SUBREAPER = 36
# A whole command with its continuation lines.
RUN_LINE = re.compile(r"^( *)((?:build/quickstart/)?drehgeber run\b(?:[^\n\\]|\\.)*)$",
                      re.M | re.S)


def _to_background(match: re.Match) -> str:
    return match[0] if match[2].rstrip().endswith("&") else f"{match[1]}background {match[2]}"


class Group:
    """What one block has started: its processes share a process group."""

    def __init__(self, block: Block, command: str, folder: Path, environment: dict):
        self.block = block
        self.started = folder / "started"
        self.line = folder / "line"
        self.output = folder / "output"
        named = {"DOCS_STARTED": str(self.started), "DOCS_LINE": str(self.line)}
        with self.output.open("wb") as output:
            self.shell = subprocess.Popen(
                ["bash", "-eu", "-c", f". '{SHELL}'\n{command}"], cwd=folder.parents[1],
                env={**environment, **named}, stdin=subprocess.DEVNULL, stdout=output,
                stderr=subprocess.STDOUT, start_new_session=True)

    def wait(self, patience_s: float) -> str:
        """What is wrong with the block's end; empty when nothing is."""
        try:
            status = self.shell.wait(patience_s)
        except subprocess.TimeoutExpired:
            return f"not done after {patience_s:.0f} s"
        return f"exit status {status}" if status else ""

    def failed_line(self) -> int:
        """In the page: of the command that failed, or of the block."""
        if self.block.language == "sh" and self.line.exists():
            return int(self.line.read_text())
        return self.block.line

    def encoders(self) -> list:
        """Those in the background, as (process, log, command)."""
        if not self.started.exists():
            return []
        rows = [row.split(" ", 2) for row in self.started.read_text().splitlines()]
        return [(int(process), Path(log), command) for process, log, command in rows]

    def _signal(self, number: int):
        try:
            os.killpg(self.shell.pid, number)
        except ProcessLookupError:
            pass  # all have ended

    def end(self) -> str:
        """Ends them all; what an encoder has to say when it did not end well."""
        statuses = {}
        self._signal(signal.SIGTERM)
        deadline = time.monotonic() + END_S
        while True:
            try:
                process, status = os.waitpid(-self.shell.pid, os.WNOHANG)
            except ChildProcessError:
                break
            if process:
                statuses[process] = os.waitstatus_to_exitcode(status)
                continue
            if time.monotonic() > deadline:
                self._signal(signal.SIGKILL)
            time.sleep(0.01)
        self.shell.poll()
        return "".join(f"exit status {statuses[process]}: {command}\n{log.read_text()}"
                       for process, log, command in self.encoders() if statuses.get(process))


class Reader:
    """Goes through one page. Use as a context; what is still running in the end is ended."""

    def __init__(self, tree: Path, program: Path, where: str = "here", patience_s=PATIENCE_S):
        self.where, self.patience_s = where, patience_s
        self.groups = []   # what may still be running
        self.outputs = {}  # of the blocks that were run
        self.place = tempfile.TemporaryDirectory(prefix="drehgeber-docs-")
        place = Path(self.place.name)
        self.root, self.temporary = place / "tree", place / "tmp"
        self.blocks = self.root / ".blocks"
        built = self.root / "build/quickstart"
        for folder in (self.temporary, place / "run", self.blocks, built):
            folder.mkdir(mode=0o700, parents=True)
        for entry in tree.iterdir():
            if entry.name != "build":
                (self.root / entry.name).symlink_to(entry)
        (built / "drehgeber").symlink_to(program)
        for library in program.parent.glob("libdrehgeber.*"):
            (built / library.name).symlink_to(library)
        self.environment = {
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}:{built}:{os.environ['PATH']}",
            "PYTHONPATH": str(self.root),  # where pages save what later blocks import
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTEST_ADDOPTS": "-p no:cacheprovider",
            "TMPDIR": str(self.temporary),
            "XDG_RUNTIME_DIR": str(place / "run"),
        }
        self.replaced = {"/tmp": str(self.temporary)}

    def __enter__(self) -> "Reader":
        # What a shell leaves behind becomes a child of ours: we end it and see how it ended.
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        return self

    def __exit__(self, *_):
        for group in self.groups:
            group.end()
        self.place.cleanup()

    def read(self, blocks: list):
        """Runs, saves and compares; raises PageError at the first block that is not as it says."""
        for block in blocks:
            self._leave(block.path)
            if block.where != self.where:
                continue
            if block.prints:
                self._compare(block)
            elif block.file:
                (self.root / block.file).write_text(self._here(block.text), encoding="utf-8")
            elif block.language in COMMANDS:
                self._run(block)
        self._end(self.groups)

    def _here(self, text: str) -> str:
        for there, here in self.replaced.items():
            text = re.sub(rf"(?<![\w./]){re.escape(there)}\b", here, text)
        return text

    def _there(self, text: str) -> str:
        for there, here in self.replaced.items():
            text = text.replace(here, there)
        return text.replace(f"{self.root}/", "")

    def _leave(self, path: tuple):
        """Ends what was started in sections that do not go on at `path`."""
        self._end([group for group in self.groups
                   if path[:len(group.block.path)] != group.block.path])

    def _end(self, groups: list):
        self.groups = [group for group in self.groups if group not in groups]
        for block, complaint in [(group.block, group.end()) for group in groups]:
            if complaint:
                raise block.error(self._there(complaint))

    def _run(self, block: Block):
        folder = self.blocks / f"{block.line}"
        folder.mkdir()
        file = folder / f"{Path(block.page).name}.{block.language}"
        text = self._here(block.text)
        if block.language == "sh":
            text = RUN_LINE.sub(_to_background, text)
        # Every language names lines in its messages: let them be the page's.
        file.write_text("\n" * (block.line - 1) + text, encoding="utf-8")
        command = COMMANDS[block.language].replace("FILE", f"{file}")
        group = Group(block, command, folder, self.environment)
        self.groups.append(group)
        wrong = group.wait(self.patience_s)
        output = self._there(group.output.read_text(errors="replace"))
        if wrong:
            raise self._error(group, wrong, output)
        self.outputs[block] = output
        if block.language == "ini":
            self._end([group])

    def _error(self, group: Group, wrong: str, output: str) -> PageError:
        block, line = group.block, group.failed_line()
        logs = "".join(f"\nmeanwhile {command}:\n{self._there(log.read_text())}"
                       for other in self.groups for _, log, command in other.encoders())
        return PageError(f"{block.page}:{line}: {wrong}: "
                         f"{block.text.splitlines()[line - block.line]}\n{output}{logs}")

    def _compare(self, block: Block):
        output = self.outputs[block.prints]
        if not matches(block.text, output):
            raise block.error(f"the block in line {block.prints.line} does not print this:\n"
                              f"{block.text}but:\n{output}")
