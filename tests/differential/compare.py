# SPDX-License-Identifier: MIT
"""Logs of scripts: cut into operations, compared, and told apart by sums.

An operation's part of a log is what the encoder has sent up to its moment, and its own line with the answer."""

import zlib
from pathlib import Path

HERE = Path(__file__).parent
EXPECTED = HERE / "expected"
DIFFERENCES = HERE / "differences"
SUMS_IN_LINE = 20
HEADER = """\
# SPDX-License-Identifier: MIT
# Sums of the logs that every host has to write: the whole one, then one for each operation.
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


def without_events(log: Log, kinds: frozenset[str]) -> Log:
    """The log of a host that does not tell such events."""
    return [[line for line in lines if not line.startswith("  @") or line.split()[1] not in kinds] for lines in log]


def say_difference(host: str, script: list[str], number: int, expected: str, got: str) -> str:
    """Host, model, seed, operation, and both lines."""
    _, model, seed = script[0].split()
    operation = script[number] if number < len(script) else "its end"
    return (f"host {host}: model {model}, seed {seed}, operation {number} ({operation}):\n"
            f"  expected {expected}\n  got      {got}")


def compare(host: str, script: list[str], expected: Log, got: Log) -> None:
    """Line by line. Raises Broken at the first one that differs."""
    for i in range(max(len(expected), len(got))):
        pair = [log[i] if i < len(log) else [] for log in (expected, got)]
        for k in range(max(map(len, pair))):
            left, right = (lines[k].strip() if k < len(lines) else "nothing" for lines in pair)
            if left != right:
                raise Broken(say_difference(host, script, i + 1, left, right))


# ------------------------------------------------------------ what logs have to be, as sums

def sum_of(lines: list[str]) -> str:
    """16 bits: enough to name an operation; the sum of a whole log has 32."""
    return f"{zlib.crc32(chr(10).join(lines).encode()) & 0xFFFF:04x}"


def total_of(log: Log) -> str:
    return f"{zlib.crc32(chr(10).join(line for lines in log for line in lines).encode()):08x}"


def write_expected(logs: dict[str, Log]) -> str:
    """The file `expected` of these logs."""
    rows = [HEADER]
    for name, log in logs.items():
        sums = [sum_of(lines) for lines in log]
        rows.append(f"script {name} {total_of(log)}")
        rows += [" ".join(sums[i : i + SUMS_IN_LINE]) for i in range(0, len(sums), SUMS_IN_LINE)]
    return "\n".join(rows) + "\n"


def read_expected(text: str) -> dict[str, tuple[str, list[str]]]:
    """By the names of the scripts: the sum of the whole log, and those of the operations."""
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
    """Raises Broken at the first operation whose sum differs."""
    total, sums = expected
    for i in range(max(len(sums), len(got))):
        lines = got[i] if i < len(got) else []
        want = sums[i] if i < len(sums) else "nothing"
        if not lines or sum_of(lines) != want:
            raise Broken(say_difference(host, script, i + 1, f"sum {want}", " / ".join(map(str.strip, lines))))
    if total_of(got) != total:
        raise Broken(say_difference(host, script, len(sums), f"sum {total} of all", total_of(got)))


# ------------------------------------------------------------ what is known to differ

def read_differences(host: str, text: str | None = None) -> dict[str, str]:
    """What a host does not have or does otherwise, operations and kinds of events, with the reason."""
    rows = (DIFFERENCES.read_text() if text is None else text).splitlines()
    found: dict[str, str] = {}
    for row in rows:
        name, _, rest = row.partition(" ")
        word, _, reason = rest.strip().partition(" ")
        if name == host:
            if not reason.strip() or word in found:
                raise Broken(f"differences: {row}: expected HOST OPERATION REASON, once")
            found[word] = reason.strip()
    return found
