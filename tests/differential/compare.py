# SPDX-License-Identifier: MIT
"""Logs of scripts: cut into operations, compared, and told apart by sums.

An operation's part of a log is what the encoder has sent up to its moment, and its own line with the answer."""

import functools
import re
import zlib
from collections.abc import Iterable
from pathlib import Path

from script import EVENTS, OPERATIONS, SECOND, SHARED, SUBJECTS, word_of

HERE = Path(__file__).parent
EXPECTED = HERE / "expected"
EXPECTED_OF_WIRES = HERE / "expected-wires"
EXPECTED_OF_RINGS = HERE / "expected-rings"
DIFFERENCES = HERE / "differences"
SUMS_IN_LINE = 20
ALL = "*"  # in place of an operation: the host has no such model
BEGIN = SECOND  # no moment of a log is before it
HEADER = """\
# SPDX-License-Identifier: MIT
# Sums of the logs that every host has to write: the whole one; of the first seeds, too, one for each operation.
# tests/differential/update writes this file."""

Log = list[list[str]]  # operation, line


class Broken(Exception):
    """A host does otherwise than it has to."""


def cut(text: str) -> dict[str, Log]:
    """Logs by the names of their scripts, "MODEL SEED"."""
    logs: dict[str, Log] = {}
    operation: list[str] = []
    for line in text.splitlines():
        if line.startswith("script "):
            logs[line.removeprefix("script ")] = log = []
            operation = []
            continue
        operation.append(line)
        if not line.startswith(" "):
            log.append(operation)
            operation = []
    return logs


class Leave:
    """What a host may do otherwise: the words of its rows in `differences` that are about logs, not scripts.

    byte         events of this kind are not compared
    byte<        they stand behind operations that were before them, and behind the last one they are not compared; else
                 they stand where they are told
    byte@-9..0   their moments may be so many ns later
    world=       answers of this operation are not compared
    read@        moments in them are not"""

    def __init__(self, words: Iterable[str]) -> None:
        self.untold = {word for word in words if word in EVENTS}
        self.sorted = {word[:-1] for word in words if word.endswith("<")}
        self.unsaid = {word[:-1] for word in words if word.endswith("=")}
        self.timeless = {word[:-1] for word in words if word.endswith("@")}
        ranges = [re.fullmatch(r"(\w+)@(-?\d+)\.\.(-?\d+)", word) for word in words]
        self.late = {found[1]: (int(found[2]), int(found[3])) for found in ranges if found}

    def strip(self, script: list[str], log: Log) -> Log:
        """What is compared of it."""
        moments = [int(line.split()[0]) for line in script[1:]]
        left: Log = [[] for _ in log]
        events = sorted((moment_of(line), line) for lines in log for line in lines if self._is_moved(line))
        for number, lines in enumerate(log):
            while events and number < len(moments) and events[0][0] <= moments[number]:
                left[number].append(events.pop(0)[1])
            left[number] += [self._line(line) for line in lines if not self._is_untold(line) and not self._is_moved(line)]
        return left

    def _is_untold(self, line: str) -> bool:
        return line.startswith("  @") and line.split()[1] in self.untold

    def _is_moved(self, line: str) -> bool:
        return line.startswith("  @") and line.split()[1] in self.sorted - self.untold

    def _line(self, line: str) -> str:
        number, name, *answer = line.split() if not line.startswith(" ") else ("", "")
        if word_of(name) in self.unsaid:
            return f"{number} {name}"
        if word_of(name) in self.timeless:
            return " ".join([number, name, *(word for word in answer if not word.isdecimal() or int(word) < BEGIN)])
        return line

    def same(self, expected: str, got: str) -> bool:
        if expected == got:
            return True
        left, right = expected.split(), got.split()
        if not (left[0][0] == right[0][0] == "@" and left[1:] == right[1:] and left[1] in self.late):
            return False
        earliest, latest = self.late[left[1]]
        return earliest <= moment_of(got) - moment_of(expected) <= latest


def moment_of(event: str) -> int:
    return int(event.split()[0].removeprefix("@"))


def say_difference(host: str, script: list[str], number: int, expected: str, got: str) -> str:
    """Host, model or wire, seed, operation, and both lines."""
    _, subject, seed = script[0].split()
    kind = "wire" if subject in SHARED else "model"
    operation = script[number] if number < len(script) else "its end"
    return (f"host {host}: {kind} {subject}, seed {seed}, operation {number} ({operation}):\n"
            f"  expected {expected}\n  got      {got}")


def compare(host: str, script: list[str], expected: Log, got: Log, leave: Leave | None = None) -> None:
    """Line by line, but for what the host may do otherwise. Raises Broken at the first one that differs."""
    if expected == got:  # nearly always, and nothing has to be left out then
        return
    leave = leave or Leave(())
    expected, got = leave.strip(script, expected), leave.strip(script, got)
    for i in range(max(len(expected), len(got))):
        pair = [log[i] if i < len(log) else [] for log in (expected, got)]
        for k in range(max(map(len, pair))):
            left, right = (lines[k].strip() if k < len(lines) else "nothing" for lines in pair)
            if not leave.same(left, right):
                raise Broken(say_difference(host, script, i + 1, left, right))


# ------------------------------------------------------------ what logs have to be, as sums

def sum_of(lines: list[str]) -> str:
    """16 bits: enough to name an operation; the sum of a whole log has 32."""
    return f"{zlib.crc32(chr(10).join(lines).encode()) & 0xFFFF:04x}"


def total_of(log: Log) -> str:
    return f"{zlib.crc32(chr(10).join(line for lines in log for line in lines).encode()):08x}"


def write_expected(logs: dict[str, Log], seeds: int) -> str:
    """The file `expected` of these logs, with the operations of so many seeds of each model."""
    rows = [HEADER]
    for name, log in logs.items():
        sums = [sum_of(lines) for lines in log] if int(name.split()[1]) <= seeds else []
        rows.append(f"script {name} {total_of(log)}")
        rows += [" ".join(sums[i : i + SUMS_IN_LINE]) for i in range(0, len(sums), SUMS_IN_LINE)]
    return "\n".join(rows) + "\n"


def read_expected(text: str) -> dict[str, tuple[str, list[str]]]:
    """By the names of the scripts: the sum of the whole log, and those of the operations, if it has them."""
    expected: dict[str, tuple[str, list[str]]] = {}
    sums: list[str] = []
    for line in text.splitlines():
        if line.startswith("script "):
            _, model, seed, total = line.split()
            sums = []
            expected[f"{model} {seed}"] = total, sums
        elif not line.startswith("#"):
            sums += line.split()
    return expected


def compare_sums(host: str, script: list[str], expected: tuple[str, list[str]], got: Log) -> None:
    """Raises Broken at the first operation whose sum differs, or for all of them."""
    total, sums = expected
    for i in range(max(len(sums), len(got)) if sums else 0):
        lines = got[i] if i < len(got) else []
        want = sums[i] if i < len(sums) else "nothing"
        if not lines or sum_of(lines) != want:
            raise Broken(say_difference(host, script, i + 1, f"sum {want}", " / ".join(map(str.strip, lines))))
    if total_of(got) != total:
        raise Broken(say_difference(host, script, len(got), f"sum {total} of all", total_of(got)))


# ------------------------------------------------------------ what is known to differ

@functools.cache
def read_differences(host: str, subject: str, text: str | None = None) -> dict[str, str]:
    """What a host does not have or does otherwise with a model or a wire, operations and kinds of events, with the reason.
    Rows of a protocol are about one encoder: a wire has its own."""
    rows = (DIFFERENCES.read_text() if text is None else text).splitlines()
    found: dict[str, str] = {}
    names = {host, f"{host}:{subject}"} | ({f"{host}:{SUBJECTS[subject]}"} if subject not in SHARED else set())
    for row in rows:
        name, _, rest = row.partition(" ")
        if name.partition(":")[2] not in ("", *SUBJECTS, *SUBJECTS.values()):
            raise Broken(f"differences: {row}: no such protocol, model or wire")
        word, _, reason = rest.strip().partition(" ")
        if name in names:
            known = {re.split("[:@=<~]", word)[0]} <= {*OPERATIONS, *EVENTS, ALL}
            if not known or not reason.strip() or word in found:
                raise Broken(f"differences: {row}: expected HOST[:PROTOCOL|:MODEL|:WIRE] OPERATION REASON, once")
            found[word] = reason.strip()
    return found
