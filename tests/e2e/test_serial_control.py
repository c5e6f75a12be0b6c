# SPDX-License-Identifier: MIT
"""The console of a board, tty:PATH, for `drehgeber ctl` and the Python package. A rig behind a pty is the board, as
far as SCPI goes."""
import os
import socket
import subprocess
import sys
import threading
import tty

import pytest

from rig import PATIENCE_S, PROGRAM, REPOSITORY, Rigs

sys.path.insert(0, str(REPOSITORY / "tools/python"))
import drehgeber  # noqa: E402
from drehgeber.control import Control  # noqa: E402

RIG = "[rig]\ncontrol = tcp:127.0.0.1:0\n[encoder biss]\nmodel = s3684-biss\nwire = sim\n"


def carry(read, write):
    """Bytes in one direction, to the end."""
    try:
        while data := read():
            write(data)
    except OSError:
        pass


@pytest.fixture
def console(tmp_path):
    """tty:PATH of a board."""
    rigs = Rigs(tmp_path)
    host, port = rigs.begin(RIG).controls[0].removeprefix("tcp:").rsplit(":", 1)
    master, slave = os.openpty()
    tty.setraw(slave)
    with socket.create_connection((host, int(port)), PATIENCE_S) as line:
        line.settimeout(None)
        for read, write in ((lambda: os.read(master, 4096), line.sendall),
                            (lambda: line.recv(4096), lambda data: os.write(master, data))):
            threading.Thread(target=carry, args=(read, write), daemon=True).start()
        yield f"tty:{os.ttyname(slave)}"
        line.shutdown(socket.SHUT_RDWR)
    os.close(slave)
    os.close(master)
    rigs.end()


def ctl(console, *commands, stdin=""):
    return subprocess.run([PROGRAM, "ctl", "--control", console, *commands], input=stdin, capture_output=True, text=True,
                          timeout=PATIENCE_S)


def test_ctl_asks_a_board(console):
    """Answers, and no more than these; then the next session has the line."""
    done = ctl(console, "SHAF:POS 90DEG", "SHAF:POS?", "SYST:VERS?;VERS?")
    assert (done.stdout, done.stderr, done.returncode) == ("90.000000\n1999.0;1999.0\n", "", 0)
    done = ctl(console, stdin="SHAF:POS 45DEG\nSHAF:POS?\n")
    assert (done.stdout, done.stderr, done.returncode) == ("45.000000\n", "", 0)


def test_ctl_tells_errors_of_a_board(console):
    done = ctl(console, "SHAF:POS?", "SHAF:VEL 1DEG")
    assert done.returncode == 1 and done.stdout == "0.000000\n"
    assert "-131" in done.stderr or "suffix" in done.stderr.lower()


def test_ctl_without_a_board(tmp_path):
    done = ctl(f"tty:{tmp_path}/nothing", "*IDN?")
    assert done.returncode == 1 and "cannot open it" in done.stderr


def test_the_python_package_asks_a_board(console):
    control = Control(console)
    try:
        assert control.ask("SHAF:POS 90DEG") is None
        assert control.ask("SHAF:POS?") == "90.000000"
        with pytest.raises(drehgeber.ScpiError):
            control.ask("NONSENSE")
        assert control.ask("*IDN?").startswith("drehgeber,")
    finally:
        control.close()
