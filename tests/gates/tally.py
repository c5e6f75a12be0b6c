# SPDX-License-Identifier: MIT
"""What runs of ctest came to. A test that is listed and was not run has failed. A test that several
trees run is one test: it has passed when it has passed in each of them.

usage: tally.py run PRESET JUNIT RESULTS    names and last lines of what failed, to stdout;
                                            `passed|failed SECONDS TREE TEST` a line into RESULTS
       tally.py total RESULTS...            the slowest tests, and `N passed, N failed`
"""

import json
import subprocess
import sys
import xml.etree.ElementTree

LAST_LINES = 15
SLOWEST = 12


def read_cases(junit):
    try:
        root = xml.etree.ElementTree.parse(junit).getroot()
    except (OSError, xml.etree.ElementTree.ParseError):
        return {}
    return {case.get("name"): case for case in root.iter("testcase")}


def run(preset, junit, results):
    listing = ["ctest", "--preset", preset, "--show-only=json-v1"]
    names = [test["name"] for test in json.loads(subprocess.check_output(listing))["tests"]]
    cases = read_cases(junit)
    lines = []
    if not names:
        print(f"    preset {preset} has no tests")
        lines.append(f"failed 0 {preset} {preset}")
    for name in names:
        case = cases.get(name)
        status = "not listed by the run" if case is None else case.get("status")
        seconds = 0 if case is None else float(case.get("time") or 0)
        lines.append(f"{'passed' if status == 'run' else 'failed'} {seconds:.1f} {preset} {name}")
        if status != "run":
            print(f"    {name}: {status}")
            output = "" if case is None else case.findtext("system-out") or ""
            for line in output.rstrip().split("\n")[-LAST_LINES:]:
                print(f"        {line}")
    with open(results, "w", encoding="utf-8") as file:
        print(*lines, sep="\n", file=file)


def total(paths):
    runs, passed = [], {}
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                lines = file.read().split("\n")
        except OSError:
            lines = []
        found = [line.split(maxsplit=3) for line in lines if line]
        # A run that left nothing was not run.
        for status, seconds, tree, name in found or [("failed", 0, path, path)]:
            runs.append((float(seconds), tree, name))
            passed[name] = passed.get(name, True) and status == "passed"
    print("the slowest tests:")
    for seconds, tree, name in sorted(runs, reverse=True)[:SLOWEST]:
        print(f"    {seconds:6.1f} s  {name} ({tree})")
    good = sum(passed.values())
    print(f"{len(passed)} tests, {len(runs)} runs of them")
    print(f"{good} passed, {len(passed) - good} failed")
    return good == len(passed) and good > 0


def main():
    if sys.argv[1:2] == ["run"] and len(sys.argv) == 5:
        run(*sys.argv[2:])
    elif sys.argv[1:2] == ["total"] and len(sys.argv) > 2:
        sys.exit(0 if total(sys.argv[2:]) else 1)
    else:
        sys.exit(__doc__.strip())


main()
