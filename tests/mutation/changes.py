# SPDX-License-Identifier: MIT
"""Which mutants stand in what has changed since a commit."""

import re
import subprocess
import sys

import mutants

HUNK = re.compile(r"^@@ -\S+ \+(\d+)(?:,(\d+))? @@", re.M)


def git_diff(root, since, *words):
    said = subprocess.run(["git", "-C", root, "diff", "--no-ext-diff", *words[:1], since, "--", *words[1:]],
                          capture_output=True, text=True, check=False)
    if said.returncode:
        sys.exit(f"git does not know what changed since {since}: {said.stderr.strip()}")
    return said.stdout


def changed_lines(root, since, path):
    """Numbers of the lines of a file that are new or other since the commit, or before which lines went."""
    lines = set()
    for first, count in HUNK.findall(git_diff(root, since, "--unified=0", path)):
        lines |= set(range(int(first), int(first) + max(1, int(count or 1))))
    return lines


def changed_blocks(root, since, path, text):
    """First and last lines of the functions and tables that changed."""
    lines = changed_lines(root, since, path)
    return [(first, last) for first, last in mutants.blocks(path, text)
            if any(first <= line <= last for line in lines)] + [(line, line) for line in lines]


def is_known(root, since):
    """Whether this clone has the commit; one without history has not."""
    return subprocess.run(["git", "-C", root, "cat-file", "-e", f"{since}^{{commit}}"], capture_output=True,
                          check=False).returncode == 0


def in_changed(root, since, texts, found):
    """Those of the mutants that stand there."""
    names = set(git_diff(root, since, "--name-only").split())
    spans = {path: changed_blocks(root, since, path, text) for path, text in texts.items() if path in names}
    return [mutant for mutant in found
            if any(first <= mutant.line <= last for first, last in spans.get(mutant.path, ()))]
