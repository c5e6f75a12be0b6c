# SPDX-License-Identifier: MIT
"""What other machines are told to do for a change is there to be done: the files of GitHub and GitLab are
YAML with jobs, every program of the tree that they start is one and takes these arguments, as its `usage:` says,
and both start the same ones. Actions of others are named by a commit. tests/package/roots runs the commands.

usage: ci.py TREE
"""
import os
import re
import sys

import yaml

import ci_jobs
from sources import finish, read


def started(lines):
    """Commands that begin with a program of the tree: a word with a slash."""
    for line in lines:
        for command in re.split(r"&&|\|\||[;|\n]", line):
            words = command.split()
            if words and "/" in words[0]:
                yield words


def pattern_of(word):
    """What a word of a usage stands for: [MAY BE], one|of|these, NAME, or itself."""
    if word.startswith("["):
        return f"(?:{pattern_of(word[1:-1])})?"
    choices = [r"\S+" if choice.isupper() else re.escape(choice) for choice in word.split("|")]
    return f"(?: (?:{'|'.join(choices)}))"


def refusal(tree, words):
    """Why this command does not start, or None."""
    program, *arguments = words
    if not os.access(os.path.join(tree, program), os.X_OK):
        return f"{program} is no program of the tree"
    name = re.escape(os.path.basename(program))
    usage = re.search(rf"^# usage: (?:\S*/)?{name}(( [^\s;]+)*)", read(tree, program), re.M)
    if not usage:
        return f"{program} has no line '# usage: '"
    taken = "".join(map(pattern_of, usage[1].split()))
    return None if re.fullmatch(taken, "".join(f" {word}" for word in arguments)) else \
        f"{' '.join(words)}: expected {program}{usage[1]}"


def unpinned(text):
    """Actions of others that may be another one tomorrow: not named by a commit."""
    return [action for action in re.findall(r"^ *(?:- )?uses: *(\S+)", text, re.M)
            if not re.search(r"@[0-9a-f]{40}$", action) and not action.startswith("./")]


def main():
    tree = sys.argv[1]
    complaints, commands = [], {}
    paths = ci_jobs.paths(tree)
    for path in paths:
        complaints += [f"{path}: {action} is not named by its commit" for action in unpinned(read(tree, path))]
        try:
            jobs = ci_jobs.read(tree, path)
        except (OSError, yaml.YAMLError, AttributeError, KeyError, TypeError) as error:
            complaints.append(f"{path}: {type(error).__name__}: {error}")
            continue
        for job in jobs:
            for words in started(job.commands):
                commands.setdefault(path.split("/")[0], set()).add(" ".join(words))
                wrong = refusal(tree, words)
                if wrong:
                    complaints.append(f"{path}: {job.name}: {wrong}")
    if len(set(map(frozenset, commands.values()))) != 1:
        complaints.append(f"GitHub and GitLab start other programs: {commands}")
    finish(len(paths), complaints)


main()
