# SPDX-License-Identifier: MIT
"""What runs of ctest came to. A test that is listed and was not run has failed. A test that several
trees run is one test: it has passed when it has passed in each of them.

What has failed has failed, but for one case: a test in real time whose rig has counted a stall itself, and
says so in a line `stall: ...`. It is repeated, alone. If it passes then, it has passed, and is named: more
than three of them are no accident, nor is the same one twice in ten runs. They have failed.

How many tests each preset has stands in the file `counts` beside the tree's tests: one that is gone is missed.

usage: tally.py again PRESET JUNIT            repeats them; what came of it into again-JUNIT beside JUNIT; no
                                              success unless everything that failed passes now
       tally.py run PRESET JUNIT RESULTS      names and last lines of what failed, notes, to stdout;
                                              `passed|again|failed SECONDS TREE TEST` a line into RESULTS
       tally.py total REPEATS RESULTS...      the slowest tests, those that were repeated, and
                                              `N passed, N failed`; REPEATS has a line for each of the last runs
       tally.py count PRESET...               writes `counts`
"""

import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree

LAST_LINES = 15
SLOWEST = 10
TIMED = {"realtime", "e2e", "soak", "guest"}  # labels of tests in real time
STALL = re.compile(r"^stall: ", re.MULTILINE)
AGAIN_MOST = 3
RUNS_KEPT = 10
COUNTS = os.path.join("tests", "counts")


def read_cases(junit):
    try:
        root = xml.etree.ElementTree.parse(junit).getroot()
    except (OSError, xml.etree.ElementTree.ParseError):
        return {}
    return {case.get("name"): case for case in root.iter("testcase")}


def beside(junit):
    """Where the second try is."""
    folder, name = os.path.split(junit)
    return os.path.join(folder, f"again-{name}")


def read_labels(preset):
    """Of every test that the preset lists."""
    listing = ["ctest", "--preset", preset, "--show-only=json-v1"]
    tests = json.loads(subprocess.check_output(listing))["tests"]
    return {test["name"]: {label for entry in test.get("properties", []) if entry["name"] == "LABELS"
                           for label in entry["value"]} for test in tests}


def passed(case):
    return case is not None and case.get("status") == "run"


def again(preset, junit):
    cases = read_cases(junit)
    labels = read_labels(preset)
    missed = [name for name in labels if not passed(cases.get(name))]
    # What was not run waits behind one of those that failed.
    wanted = [name for name in missed if labels[name] & TIMED and name in cases]
    failed = [name for name in wanted if cases[name].get("status") == "fail"]
    if not 0 < len(failed) <= AGAIN_MOST or not all(STALL.search(output_of(cases[name])) for name in failed):
        return False
    print("a stall: once more, alone:", *failed, flush=True)
    # The guest boots for these jobs only.
    jobs = " ".join(name.removeprefix("rig.") for name in wanted)
    done = subprocess.run(["ctest", "--preset", preset, "--output-junit", os.path.abspath(beside(junit)),
                           "-R", f"^({'|'.join(map(re.escape, wanted))})$"],
                          env={**os.environ, "GUEST_JOBS": jobs}, check=False)
    return done.returncode == 0 and wanted == missed


def status_of(case):
    return "not listed by the run" if case is None else case.get("status")


def judge(case, second):
    """The result, and the try that says so."""
    if case is None or second is None or passed(case):
        return "passed" if passed(case) else "failed", case
    if not passed(second):
        return "failed", second
    # What only waited behind another one has failed at no time.
    return "again" if case.get("status") == "fail" else "passed", second


def output_of(case):
    return "" if case is None else case.findtext("system-out") or ""


def tell_last_lines(case):
    for line in output_of(case).rstrip().split("\n")[-LAST_LINES:]:
        print(f"        {line}")


def read_counts():
    """How many tests each preset has."""
    try:
        with open(COUNTS, encoding="utf-8") as file:
            return {preset: int(number) for preset, number in (line.split() for line in file if line[0] != "#")}
    except FileNotFoundError:
        return {}


def count(*presets):
    counts = read_counts() | {preset: len(read_labels(preset)) for preset in presets}
    with open(COUNTS, "w", encoding="utf-8") as file:
        file.write("# SPDX-License-Identifier: MIT\n")
        file.writelines(f"{preset} {number}\n" for preset, number in sorted(counts.items()))


def run(preset, junit, results):
    cases, second = read_cases(junit), read_cases(beside(junit))
    lines = []
    names = read_labels(preset)
    wanted = read_counts().get(preset)
    if not names or len(names) != wanted:
        print(f"    preset {preset} has {len(names)} tests, {COUNTS} says {wanted}: tests/gates/tally.py count {preset}")
        lines.append(f"failed 0 {preset} counts.{preset}")
    for name in names:
        case = cases.get(name)
        result, last = judge(case, second.get(name))
        seconds = 0 if case is None else float(case.get("time") or 0)
        lines.append(f"{result} {seconds:.1f} {preset} {name}")
        if last is not case:
            print(f"    {name}: {status_of(case)}, then {status_of(last)}")
            tell_last_lines(case)
        if result == "failed":
            print(f"    {name}: {status_of(last)}")
            tell_last_lines(last)
        for note in re.findall(r"^note: .*", output_of(last), re.MULTILINE):
            print(f"    {name}: {note}")
    with open(results, "w", encoding="utf-8") as file:
        print(*lines, sep="\n", file=file)


def read_runs(paths):
    """Result, seconds, tree and name of each."""
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                lines = file.read().split("\n")
        except OSError:
            lines = []
        # A run that left nothing was not run.
        yield from [line.split(maxsplit=3) for line in lines if line] or [("failed", 0, path, path)]


def keep_repeats(path, names):
    """@return those of `names` that were repeated in the runs before, too"""
    try:
        with open(path, encoding="utf-8") as file:
            runs = [line.split() for line in file]
    except FileNotFoundError:
        runs = []
    runs = runs[1 - RUNS_KEPT:] + [sorted(names)]
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(" ".join(run) + "\n" for run in runs)
    return {name for name in names if any(name in run for run in runs[:-1])}


def total(repeats, *paths):
    runs = list(read_runs(paths))
    second = [(name, tree) for result, _, tree, name in runs if result == "again"]
    often = keep_repeats(repeats, {name for name, _ in second})
    few = len(second) <= AGAIN_MOST
    good = {}
    for result, _, _, name in runs:
        right = result == "passed" or (result == "again" and few and name not in often)
        good[name] = good.get(name, True) and right
    print("the slowest tests:")
    for seconds, tree, name in sorted(((float(run[1]), *run[2:]) for run in runs), reverse=True)[:SLOWEST]:
        print(f"    {seconds:6.1f} s  {name} ({tree})")
    print(f"{len(good)} tests, {len(runs)} runs of them")
    for name, tree in second:
        print(f"repeated after a stall: {name} ({tree})" + (f", and in the last {RUNS_KEPT} runs before" if name in often else ""))
    if not few:
        print(f"more than {AGAIN_MOST} of those have failed")
    passes = sum(good.values())
    print(f"{passes} passed, {len(good) - passes} failed")
    return passes == len(good) and passes > 0


def main():
    match sys.argv[1:]:
        case ["again", preset, junit]:
            sys.exit(0 if again(preset, junit) else 1)
        case ["run", preset, junit, results]:
            run(preset, junit, results)
        case ["total", repeats, *results] if results:
            sys.exit(0 if total(repeats, *results) else 1)
        case ["count", *presets] if presets:
            count(*presets)
        case _:
            sys.exit(__doc__.strip())


main()
