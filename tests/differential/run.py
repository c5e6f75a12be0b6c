# SPDX-License-Identifier: MIT
"""Play the scripts in a host, and see whether it does what all others do.

usage: run.py [--seeds N] [--host NAME PROGRAM...] -- PLAYER...

PLAYER is the player of the C handle, with what starts it. Its logs have the sums in `expected`, and none of the
disturbances changes them; with --host the logs of another player are compared with them line by line. Scripts are
without the operations that `differences` names for a host. N scripts for each model are disturbed, or compared."""

import subprocess
import sys

from compare import ALL, EXPECTED, Broken, Leave, Log, compare, compare_sums, cut, read_differences, read_expected
from script import MODELS, write_script

SEEDS = 2
RECORDED = 100  # those that `expected` has; of the first SEEDS it has each operation
DISTURBANCES = ("steps", "looks", "restore", "fresh", "steps looks restore")
PATIENCE_S = 600

Scripts = dict[str, list[str]]


def write_scripts(seeds: int, host: str = "handle") -> Scripts:
    """By their names, without what the host does not have."""
    scripts: Scripts = {}
    for model in MODELS:
        without = frozenset(read_differences(host, model))
        for seed in range(1, seeds + 1) if ALL not in without else ():
            scripts[f"{model} {seed}"] = write_script(model, seed, without)
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


def check_expected(player: list[str]) -> int:
    """The recorded seeds in the C handle."""
    expected = read_expected(EXPECTED.read_text())
    scripts = write_scripts(RECORDED)
    if list(expected) != list(scripts):
        raise Broken(f"expected: {len(expected)} scripts, not these {len(scripts)}: tests/differential/update")
    logs = play("handle", player, scripts)
    for name, log in logs.items():
        compare_sums("handle", scripts[name], expected[name], log)
    return sum(map(len, logs.values()))


def check_host(host: str, command: list[str], player: list[str], seeds: int) -> int:
    """Another host, or the handle with a disturbance."""
    scripts = write_scripts(seeds, host)
    expected = play("handle", player, scripts)
    got = play(host, command, scripts)
    for name, script in scripts.items():
        compare(host, script, expected[name], got[name], Leave(read_differences(host, name.split()[0])))
    return sum(map(len, got.values()))


def check(options: list[str], player: list[str]) -> None:
    seeds = SEEDS
    if options[:1] == ["--seeds"]:
        seeds, options = int(options[1]), options[2:]
    if options[:1] == ["--host"]:
        print(f"{options[1]}: {check_host(options[1], options[2:], player, seeds)} operations")
        return
    print(f"handle: {check_expected(player)} operations as recorded")
    for disturbance in DISTURBANCES:
        host = disturbance.replace(" ", "+")
        print(f"{host}: {check_host(host, player + disturbance.split(), player, seeds)} operations")


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
