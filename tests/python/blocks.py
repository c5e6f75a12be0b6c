# SPDX-License-Identifier: MIT
"""Python blocks of a page, literally, with nothing but the standard library.

usage: blocks.py line PAGE      the line that has to come before
       blocks.py run PAGE...    each Python block, beside the commands of the pages that it needs; it has to print what
                                the page says. A test that a page saves is run as the page says
"""
import os
import re
import subprocess
import sys
import time
from pathlib import Path

BLOCK = re.compile(r"^(?:<!-- file: (\S+) -->\n)?```(\w+)\n(.*?)^```$", re.M | re.S)
PYTEST = "python3 -m pytest "
# Lines of shell blocks that a Python block relies on, by what they make.
MAKES = {"/tmp/enc": "/tmp/enc", "/tmp/can": "/tmp/can"}
PATIENCE_S = 20


def blocks(page: str) -> list:
    return BLOCK.findall(Path(page).read_text(encoding="utf-8"))


def start(rows: list) -> list:
    """Encoders of the page in the background, and files that its commands write."""
    processes = []
    for _, language, text in rows:
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
    """In the last lines: what pytest says before is its own."""
    return re.search("(?m)^" + ".*".join(map(re.escape, wanted.strip().split("..."))) + r"\Z", printed.strip()) is not None


def run(rows: list) -> None:
    os.environ["PATH"] = f"{os.getcwd()}/build/quickstart:{os.environ['PATH']}"
    processes = start(rows)
    count = 0
    for (file, language, text), (_, _, wanted) in zip(rows, rows[1:]):
        if file:
            Path(file).write_text(text, encoding="utf-8")
        elif language == "python" or text.startswith(PYTEST):
            command = [sys.executable, "-c", text] if language == "python" else ["bash", "-c", text]
            done = subprocess.run(command, text=True, stdout=subprocess.PIPE, timeout=60, check=True)
            assert same(wanted, done.stdout), f"{done.stdout!r} is not {wanted!r}"
            count += 1
    for process in processes:
        process.terminate()
        process.wait()
    assert count >= 4, count
    print(f"{count} Python blocks")


rows = [row for page in sys.argv[2:] for row in blocks(page)]
if sys.argv[1] == "line":
    (line,) = [text for _, language, text in rows if language == "sh" and text.startswith("pip install")]
    print(line)
else:
    run(rows)
