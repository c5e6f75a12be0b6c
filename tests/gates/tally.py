# SPDX-License-Identifier: MIT
"""What a run of ctest came to: `PASSED FAILED` into the file COUNT, and to stdout the name and the
last lines of each test that did not pass. A test that is listed and was not run has failed.

usage: tally.py BUILD JUNIT COUNT
"""

import json
import subprocess
import sys
import xml.etree.ElementTree

LAST_LINES = 15


def main():
    build, junit, count = sys.argv[1:]
    listing = ["ctest", "--test-dir", build, "--show-only=json-v1"]
    names = [test["name"] for test in json.loads(subprocess.check_output(listing))["tests"]]
    try:
        cases = {
            case.get("name"): case
            for case in xml.etree.ElementTree.parse(junit).getroot().iter("testcase")
        }
    except (OSError, xml.etree.ElementTree.ParseError):
        cases = {}
    passed = [name for name in names if name in cases and cases[name].get("status") == "run"]
    if not names:
        print(f"    there are no tests in {build}")
    for name in names:
        if name in passed:
            continue
        case = cases.get(name)
        status = "not listed by the run" if case is None else case.get("status")
        print(f"    {name}: {status}")
        output = "" if case is None else case.findtext("system-out") or ""
        for line in output.rstrip().split("\n")[-LAST_LINES:]:
            print(f"        {line}")
    with open(count, "w", encoding="utf-8") as file:
        print(len(passed), len(names) - len(passed) or int(not names), file=file)


main()
