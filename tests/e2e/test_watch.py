# SPDX-License-Identifier: MIT
"""watch.py, as the quickstart uses it."""
import os
import re
import subprocess
import sys
from pathlib import Path

WATCH = Path(__file__).with_name("watch.py")


def watch(path, seconds="1") -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, WATCH, path, "--seconds", seconds],
                          capture_output=True, text=True, timeout=20)


def test_watch(start):
    encoder = start("--shaft", "2.5REV", "--serial", "123456789")
    for _ in range(2):  # the second time on a port that is already set
        ended = watch(encoder.path)
        assert (ended.returncode, ended.stderr) == (0, "")
        for told in ("27h", "1792", "123456789", "2048 periods", "4096 turns", "degC", "rpm"):
            assert told in ended.stdout
        lines = re.findall(r"^position +163840 = +2 turns \+ 180\.000 deg +37 degC +ok$",
                           ended.stdout, re.M)
        assert len(lines) >= 2
        # The last line is no hint at a port that whoever started this takes away: tools/quickstart gives one.
        assert ended.stdout.splitlines()[-1] == lines[-1]


def test_nobody_answers():
    far, near = os.openpty()
    ended = watch(os.ttyname(near))
    os.close(far)
    os.close(near)
    assert ended.returncode == 1 and ended.stdout == ""
    assert re.fullmatch(r"watch\.py: .*no reply.*9600 8E1.*\n", ended.stderr)


def test_no_such_port(tmp_path):
    ended = watch(tmp_path / "none")
    assert ended.returncode == 1 and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1 and "none" in ended.stderr
