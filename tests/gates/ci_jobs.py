# SPDX-License-Identifier: MIT
"""The jobs of GitHub's and GitLab's files: in which container each runs, and the commands that it runs there."""
import glob
import os
import re
from dataclasses import dataclass

import yaml

GITLAB, GITLAB_WORDS = ".gitlab-ci.yml", {"default", "stages", "variables", "include", "workflow"}
VARIABLE = re.compile(r"\$\{\{ *matrix\.(\w+) *\}\}|\$(\w+)")


@dataclass(frozen=True)
class Job:
    file: str
    name: str
    images: list
    commands: list


def paths(tree):
    """Of the files, relative to the tree."""
    found = sorted(glob.glob(os.path.join(tree, ".github/**/*.yml"), recursive=True))
    return [os.path.relpath(path, tree) for path in found] + [GITLAB]


def _images(image, matrix):
    """One, or one for each value of the matrix' variable that its name has."""
    variable = VARIABLE.search(image)
    if not variable:
        return [image]
    return [image.replace(variable[0], value) for value in matrix[variable[1] or variable[2]]]


def _read_github(document):
    for name, job in document["jobs"].items():
        container = job.get("container", "")
        image = container if isinstance(container, str) else container["image"]
        yield name, _images(image, job.get("strategy", {}).get("matrix", {})), \
            [step["run"] for step in job["steps"] if "run" in step]


def _read_gitlab(document):
    usual = document.get("default", {})
    for name, job in document.items():
        if name in GITLAB_WORDS:
            continue
        [matrix] = job.get("parallel", {"matrix": [{}]})["matrix"]
        yield name, _images(job.get("image", usual.get("image", "")), matrix), \
            job.get("before_script", usual.get("before_script", [])) + job["script"]


def read(tree, path):
    """The jobs of a file; a workflow of GitHub's, GitLab's file, or one without jobs."""
    with open(os.path.join(tree, path), encoding="utf-8") as file:
        document = yaml.safe_load(file)
    reader = _read_github if "/workflows/" in path else _read_gitlab if path == GITLAB else None
    return [Job(path, *row) for row in reader(document)] if reader else []
