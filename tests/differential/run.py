# SPDX-License-Identifier: MIT
"""Play the scripts in a host, and see whether it does what all others do.

usage: run.py [--wires|--rings] [--seeds N] [--host NAME PROGRAM...] -- PLAYER...

PLAYER is the player of the C handle, with what starts it. Its logs have the sums in `expected`, and none of the
disturbances changes them; with --host the logs of another player are compared with them line by line. Scripts are
without the operations that `differences` names for a host. N scripts for each model are disturbed, or compared.

With --wires the same of several encoders on a wire: PLAYER is that of the command, its sums are in `expected-wires`. With --rings the same of rings, where PLAYER is that of the C handle, with `expected-rings`."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from compare import (
    ALL, EXPECTED, EXPECTED_OF_RINGS, EXPECTED_OF_WIRES, Broken, Leave, Log, compare, compare_sums, cut, read_differences, read_expected,
)  # fmt: skip
from script import MODELS, leave_out, write_whole_script
from wires import MASTERS, write_whole_wire

RECORDED = 100  # those that `expected` has
SEEDS = 2  # of these it has each operation
PATIENCE_S = 600

Scripts = dict[str, list[str]]


class Kind(NamedTuple):
    """What scripts are about."""

    subjects: tuple[str, ...]
    write: Callable[[str, int], tuple[str, ...]]
    reference: str  # the host that all others are compared with
    expected: Path
    quick: bool  # it plays all that is recorded, else as many seeds as are asked for
    disturbances: tuple[str, ...]


ENCODERS = Kind(MODELS, write_whole_script, "handle", EXPECTED, True, ("steps", "looks", "restore", "fresh", "steps looks restore"))
RING = "ring"  # that of a rig cycles by itself: the C player has one that does what a script says
WIRES = Kind(tuple(name for name in MASTERS if name != RING), write_whole_wire, "command", EXPECTED_OF_WIRES, False, ())
RINGS = Kind((RING,), write_whole_wire, "handle", EXPECTED_OF_RINGS, True, ("restore",))
KINDS = {"--wires": WIRES, "--rings": RINGS}  # else ENCODERS


def write_scripts(kind: Kind, seeds: int, host: str) -> Scripts:
    """By their names, without what the host does not have."""
    scripts: Scripts = {}
    for subject in kind.subjects:
        # The reference does all of it.
        without = frozenset(read_differences(host, subject) if host != kind.reference else ())
        for seed in range(1, seeds + 1) if ALL not in without else ():
            scripts[f"{subject} {seed}"] = leave_out(kind.write(subject, seed), without)
    return scripts


def play(host: str, command: list[str], scripts: Scripts) -> dict[str, Log]:
    """The logs of a player, one for each script."""
    text = "".join("\n".join(script) + "\n" for script in scripts.values())
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=PATIENCE_S)
    logs = cut(done.stdout)
    if done.returncode != 0:
        last = list(logs)[-1] if logs else "none"
        raise Broken(f"host {host}: script {last} ends with {done.returncode}:\n{done.stderr}")
    if list(logs) != list(scripts):
        raise Broken(f"host {host}: expected a log of each of {len(scripts)} scripts, got {len(logs)}")
    return logs


def check_expected(kind: Kind, player: list[str], seeds: int) -> int:
    """The recorded seeds in the reference."""
    expected = read_expected(kind.expected.read_text())
    names = [f"{subject} {seed}" for subject in kind.subjects for seed in range(1, RECORDED + 1)]
    if list(expected) != names:
        raise Broken(f"{kind.expected.name}: {len(expected)} scripts, not these {len(names)}: tests/differential/update")
    scripts = write_scripts(kind, RECORDED if kind.quick else seeds, kind.reference)
    logs = play(kind.reference, player, scripts)
    for name, log in logs.items():
        compare_sums(kind.reference, scripts[name], expected[name], log)
    return sum(map(len, logs.values()))


def check_host(kind: Kind, host: str, command: list[str], player: list[str], seeds: int) -> int:
    """Another host, or the reference with a disturbance."""
    scripts = write_scripts(kind, seeds, host)
    expected = play(kind.reference, player, scripts)
    got = play(host, command, scripts)
    for name, script in scripts.items():
        compare(host, script, expected[name], got[name], Leave(read_differences(host, name.split()[0])))
    return sum(map(len, got.values()))


def check(options: list[str], player: list[str]) -> None:
    kind, seeds = ENCODERS, SEEDS
    if options and options[0] in KINDS:
        kind, options = KINDS[options[0]], options[1:]
    if options[:1] == ["--seeds"]:
        seeds, options = int(options[1]), options[2:]
    if options[:1] == ["--host"]:
        print(f"{options[1]}: {check_host(kind, options[1], options[2:], player, seeds)} operations")
        return
    print(f"{kind.reference}: {check_expected(kind, player, seeds)} operations as recorded")
    for disturbance in kind.disturbances:
        host = disturbance.replace(" ", "+")
        print(f"{host}: {check_host(kind, host, player + disturbance.split(), player, seeds)} operations")


def main() -> None:
    words = sys.argv[1:]
    if "--" not in words or words[-1] == "--":
        sys.exit(__doc__)
    middle = words.index("--")
    try:
        check(words[:middle], words[middle + 1 :])
    except Broken as broken:
        sys.exit(str(broken))


if __name__ == "__main__":
    main()
