# SPDX-License-Identifier: MIT
"""Python blocks of a page, literally, with nothing but the standard library.

usage: blocks.py line PAGE    the line that has to come before
       blocks.py run PAGE     each Python block, beside the commands of the page that it needs; it has to print what
                              the page says
"""
import os
import re
import subprocess
import sys
import time
from pathlib import Path

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
# Lines of shell blocks that a Python block relies on, by what they make.
MAKES = {"/tmp/enc": "/tmp/enc", "/tmp/can": "/tmp/can"}
PATIENCE_S = 20


def blocks(page: str) -> list:
    return BLOCK.findall(Path(page).read_text(encoding="utf-8"))


def start(rows: list) -> list:
    """Encoders of the page in the background, and files that its commands write."""
    processes = []
    for language, text in rows:
        for line in text.splitlines() if language == "sh" else []:
            made = [path for path in MAKES if f"={path} " in line + " "]
            if made:
                processes.append(subprocess.Popen(["bash", "-c", f"exec {line}"]))
                wait_for(made[0])
            elif " eds f3668 > " in line:
                subprocess.run(line, shell=True, check=True)
    return processes


def wait_for(path: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while not os.path.exists(path):
        assert time.monotonic() < end, path
        time.sleep(0.05)


def same(wanted: str, printed: str) -> bool:
    return re.fullmatch(".*".join(map(re.escape, wanted.strip().split("..."))), printed.strip()) is not None


def run(rows: list) -> None:
    os.environ["PATH"] = f"{os.getcwd()}/build/quickstart:{os.environ['PATH']}"
    processes = start(rows)
    count = 0
    for (language, text), (_, wanted) in zip(rows, rows[1:]):
        if language == "python":
            done = subprocess.run([sys.executable, "-c", text], text=True, stdout=subprocess.PIPE, timeout=60, check=True)
            assert same(wanted, done.stdout), f"{done.stdout!r} is not {wanted!r}"
            count += 1
    for process in processes:
        process.terminate()
        process.wait()
    assert count >= 3, count
    print(f"{count} Python blocks")


rows = blocks(sys.argv[2])
if sys.argv[1] == "line":
    (line,) = [text for language, text in rows if language == "sh" and text.startswith("pip install")]
    print(line)
else:
    run(rows)
