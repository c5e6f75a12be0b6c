# SPDX-License-Identifier: MIT
"""What of the page's scripts runs while tests drive a browser, for gate.coverage.javascript: V8 counts, and
$SCRIPT_COVERAGE names the file that keeps it. Without that variable nothing is counted.

The file is JSON: {text of a script: ranges of its characters [begin, end) that ran, ascending}. A script goes by its
text, since `drehgeber web` serves panel.js as main.js. Of what is not a .js file nothing is kept: drehgeber.html has
the same modules in one. Workers, of which the page has none, would need sessions of their own."""

import json
import os
from itertools import groupby
from pathlib import Path

import pytest
from playwright.sync_api import Error

KEPT = os.environ.get("SCRIPT_COVERAGE")
# Chromium's: of a script that comes from the cache, V8 counts functions only, and all of one that was called as run.
COUNTING = ["--js-flags=--no-compilation-cache"] if KEPT else []


class ScriptCoverage:
    def __init__(self):
        self.pages = []
        self.ran = {}

    def watch(self, page):
        """From before the page's first address on."""
        if KEPT:
            session = page.context.new_cdp_session(page)
            session.send("Profiler.enable")
            session.send("Profiler.startPreciseCoverage", {"callCount": False, "detailed": True})
            self.pages.append((page, session))

    def take(self):
        """Add what has run in the pages that are open. The browser forgets it when a page is closed or loaded again."""
        self.pages = [(page, session) for page, session in self.pages if not page.is_closed()]
        for _, session in self.pages:
            scripts = session.send("Profiler.takePreciseCoverage")["result"]
            session.send("Debugger.enable")
            for script in scripts:
                if script["url"].endswith(".js"):
                    self.add_script(session, script)
            session.send("Debugger.disable")

    def add_script(self, session, script):
        """A page that is loaded again may have let go of the script since: then its text is gone, too."""
        try:
            text = session.send("Debugger.getScriptSource", {"scriptId": script["scriptId"]})["scriptSource"]
        except Error as error:
            if "No script for id" not in error.message:
                raise
            return
        self.add(text, script["functions"])

    def add(self, text, functions):
        """An inner range says more than those around it: they are painted by length."""
        painted = bytearray(len(text.encode("utf-16-le")) // 2)
        ranges = [(r["endOffset"] - r["startOffset"], r) for function in functions for r in function["ranges"]]
        for length, one in sorted(ranges, key=lambda pair: -pair[0]):
            painted[one["startOffset"]:one["endOffset"]] = bytes([one["count"] > 0]) * length
        self.ran[text] = self.ran.get(text, 0) | int.from_bytes(painted, "little")

    def write(self):
        if KEPT:
            Path(KEPT).write_text(json.dumps({text: spans(painted) for text, painted in self.ran.items()}))


def spans(painted: int) -> list:
    """[begin, end) of each run of ones among its bytes."""
    found, at = [], 0
    for ran, group in groupby(painted.to_bytes((painted.bit_length() + 7) // 8, "little")):
        end = at + len(list(group))
        if ran:
            found.append([at, end])
        at = end
    return found


@pytest.fixture(scope="module")
def counted():
    """Write what the module's tests have added."""
    coverage = ScriptCoverage()
    yield coverage
    coverage.write()
