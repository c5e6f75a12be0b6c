# SPDX-License-Identifier: MIT
"""What other machines are told to do for a change is there to be done: the files of GitHub and GitLab are
YAML with jobs, every program of the tree that they start is one, and both start the same ones.

usage: ci.py TREE
"""
import glob
import os
import re
import sys

import yaml

from sources import finish

GITLAB_WORDS = {"default", "stages", "variables", "include", "workflow"}


def github_jobs(document):
    for name, job in document["jobs"].items():
        yield name, [step["run"] for step in job["steps"] if "run" in step]


def gitlab_jobs(document):
    for name, job in document.items():
        if name not in GITLAB_WORDS:
            yield name, job["script"]


def started(lines):
    """Programs of the tree: words with a slash that begin a command."""
    for line in lines:
        for command in re.split(r"&&|\|\||[;|\n]", line):
            words = command.split()
            if words and "/" in words[0]:
                yield words[0], " ".join(words)


def main():
    tree = sys.argv[1]
    complaints, commands = [], {}
    paths = sorted(glob.glob(os.path.join(tree, ".github/**/*.yml"), recursive=True))
    paths.append(os.path.join(tree, ".gitlab-ci.yml"))
    for path in paths:
        name = os.path.relpath(path, tree)
        try:
            with open(path, encoding="utf-8") as file:
                document = yaml.safe_load(file)
            jobs = github_jobs if "/workflows/" in path else gitlab_jobs if name == ".gitlab-ci.yml" else None
            found = dict(jobs(document)) if jobs else {}
        except (OSError, yaml.YAMLError, AttributeError, KeyError, TypeError) as error:
            complaints.append(f"{name}: {type(error).__name__}: {error}")
            continue
        for job, lines in found.items():
            for program, command in started(lines):
                commands.setdefault(name.split("/")[0], set()).add(command)
                if not os.access(os.path.join(tree, program), os.X_OK):
                    complaints.append(f"{name}: {job}: {program} is no program of the tree")
    if len(set(map(frozenset, commands.values()))) != 1:
        complaints.append(f"GitHub and GitLab start other programs: {commands}")
    finish(len(paths), complaints)


main()
