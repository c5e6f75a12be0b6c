# SPDX-License-Identifier: MIT
import os
import subprocess


def test_answer():
    assert subprocess.run([os.environ["DREHGEBER"]], check=False).returncode == 6


def test_that_fails_once():
    if os.path.exists(os.environ["FLAKY"]):
        os.remove(os.environ["FLAKY"])
        raise AssertionError("once")
