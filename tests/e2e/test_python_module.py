# SPDX-License-Identifier: MIT
"""The Python module: starting and ending rigs, what it says when that fails, and its words."""
import os
import signal
import socket
import sys
import threading
import time
from pathlib import Path

import pytest

from rig import PATIENCE_S, PROGRAM

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/python"))
import drehgeber  # noqa: E402
from drehgeber.control import split  # noqa: E402

RIG_MODULE = sys.modules["drehgeber.running"]

SIMULATED = "[encoder axis]\nmodel = s3684-biss\nwire = sim\n"
RING = "[encoder lift]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:0\n"


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setenv("DREHGEBER", PROGRAM)


def script(path: Path, text: str) -> str:
    """A program that is none of ours."""
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


# Lines of a rig, and (name, model, wire, address, place).
READY = [
    ("ready f3668 can:vcan0/5 a1", ("a1", "f3668", "can", "vcan0", 5)),
    ("ready f3668 slcan:/dev/pts/5/63 a1", ("a1", "f3668", "slcan", "/dev/pts/5", 63)),
    ("ready f3668 slcan:tcp:127.0.0.1:29535/7 a", ("a", "f3668", "slcan", "tcp:127.0.0.1:29535", 7)),
    ("ready f3668 socketcand:127.0.0.1:29536,can0/7 a", ("a", "f3668", "socketcand", "127.0.0.1:29536,can0", 7)),
    ("ready f3668 later:127.0.0.1:20000/5 a", ("a", "f3668", "later", "127.0.0.1:20000", 5)),
    ("ready s3684-rs485 rs485:rfc2217:127.0.0.1:2217 a", ("a", "s3684-rs485", "rs485", "rfc2217:127.0.0.1:2217", None)),
    ("ready f3668 silkit:silkit://127.0.0.1:8501,CAN1/7 a", ("a", "f3668", "silkit", "silkit://127.0.0.1:8501,CAN1", 7)),
    ("ready s3684-rs485 silkit:silkit://[::1]:8501,L a", ("a", "s3684-rs485", "silkit", "silkit://[::1]:8501,L", None)),
    ("ready f3668 slcan:/dev/pts/5", ("f3668", "f3668", "slcan", "/dev/pts/5", None)),
    ("ready s3684-rs485 pty:/dev/pts/4 m", ("m", "s3684-rs485", "pty", "/dev/pts/4", None)),
    ("ready ocd-ib-k3 modbus:[::1]:5020/2 k", ("k", "ocd-ib-k3", "modbus", "[::1]:5020", 2)),
    ("ready s3684-biss sim: axis", ("axis", "s3684-biss", "sim", "", None)),
]


@pytest.mark.parametrize("line, parts", READY, ids=[line for line, _ in READY])
def test_ready_lines(line, parts):
    found = RIG_MODULE.parse_ready(None, line)
    assert (found.name, found.model, found.wire, found.address, found.place) == parts


@pytest.mark.parametrize("line", ["ready rig", "control unix:/tmp/x", "", "MT 2  ST 15", "ready"])
def test_other_lines(line):
    assert RIG_MODULE.parse_ready(None, line) is None


def test_parts_of_an_answer():
    assert split('1,"a, b","say ""no""",-2') == ["1", "a, b", 'say "no"', "-2"]
    assert split("") == split(None) == []


def test_what_it_said_when_it_does_not_start():
    with pytest.raises(drehgeber.RigError, match=r":2: .*model"):
        with drehgeber.rig("[encoder a]\nmodel = s9\nwire = pty\n"):
            pass


def test_no_program(monkeypatch):
    monkeypatch.delenv("DREHGEBER")
    monkeypatch.setenv("PATH", "/nonexistent")
    with pytest.raises(drehgeber.RigError, match="DREHGEBER"):
        drehgeber.run("rig.ini")


def test_a_program_that_is_not_there(monkeypatch):
    monkeypatch.setenv("DREHGEBER", "/nonexistent/drehgeber")
    with pytest.raises(drehgeber.RigError, match="/nonexistent/drehgeber"):
        drehgeber.run("rig.ini")


def test_one_that_is_never_ready(monkeypatch, tmp_path):
    monkeypatch.setenv("DREHGEBER", script(tmp_path / "mute", "echo ready soon; exec sleep 60"))
    monkeypatch.setattr(RIG_MODULE, "READY_S", 2.5)  # in which a busy machine has started a shell
    begin = time.monotonic()
    with pytest.raises(drehgeber.RigError, match="not ready after 2.5 s: .*ready soon"):
        drehgeber.run("rig.ini")
    assert time.monotonic() - begin < PATIENCE_S


def test_one_that_ends_without_a_word(monkeypatch, tmp_path):
    monkeypatch.setenv("DREHGEBER", script(tmp_path / "short", "exit 3"))
    with pytest.raises(drehgeber.RigError, match="ended without a word"):
        drehgeber.run("rig.ini")


def test_nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    before = threading.active_count()
    with drehgeber.rig(SIMULATED) as rig:
        pid = rig.pid
        assert list(tmp_path.iterdir()) != []
    assert list(tmp_path.iterdir()) == []
    assert threading.active_count() == before
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_file_where_the_program_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bench.ini").write_text(SIMULATED)
    with drehgeber.run("bench.ini") as rig:
        assert list(rig.encoders) == ["axis"]


def test_killed_while_it_runs():
    rig = drehgeber.run("s3684-biss", "--sim")
    os.kill(rig.pid, signal.SIGKILL)
    with pytest.raises((ConnectionError, drehgeber.RigError)):
        while True:
            rig.ask("*IDN?")
    with pytest.raises(drehgeber.RigError, match="ended .*with -9"):
        rig.close()


def test_what_went_wrong_inside_is_not_hidden():
    with pytest.raises(ZeroDivisionError):
        with drehgeber.rig(SIMULATED) as rig:
            os.kill(rig.pid, signal.SIGKILL)
            raise ZeroDivisionError


def test_two_at_once():
    with drehgeber.rig(SIMULATED) as one, drehgeber.rig(SIMULATED) as other:
        one.encoders["axis"].shaft.position = 90
        assert one.encoders["axis"].shaft.position == 90
        assert other.encoders["axis"].shaft.position == 0


def test_free_ports():
    with drehgeber.rig(RING) as one, drehgeber.rig(RING) as other:
        places = {rig.encoders["lift"].address for rig in (one, other)}
        assert len(places) == 2
        for place in places:
            host, _, port = place.rpartition(":")
            socket.create_connection((host, int(port)), PATIENCE_S).close()


def test_refusals_are_exceptions():
    with drehgeber.rig(SIMULATED) as rig:
        axis = rig.encoders["axis"]
        with pytest.raises(drehgeber.ScpiError) as caught:
            axis.set_fault("no_such_fault")
        assert caught.value.code < 0 and "no_such_fault" in str(caught.value)
        assert axis.shaft.position == 0  # the session goes on


def test_words_of_an_encoder():
    with drehgeber.rig(SIMULATED) as rig:
        axis = rig.encoders["axis"]
        names = [entry["name"] for entry in axis.faults()]
        assert "led_current_high" in names and len(names) == len(set(names))
        assert all(entry["cause"] and entry["effect"] for entry in axis.faults())
        with axis.fault("led_current_high", duration_ms=60000):
            assert axis.ask("FAUL:ACT?").strip('"') == "led_current_high"
        assert axis.ask("FAUL:ACT?") in (None, "", '""')
        axis.world("TEMP", "85 DEGC")
        assert float(axis.world("TEMP")) == 85
        axis.power(False)
        assert axis.state()["power"] == 0
        axis.power("CYCLE")
        assert axis.state()["power"] == 1


def test_words_of_a_shaft():
    with drehgeber.rig(SIMULATED) as rig:
        shaft = rig.encoders["axis"].shaft
        shaft.velocity = 60
        assert shaft.velocity == 60
        shaft.stop()
        shaft.acceleration = 0
        shaft.position = 0
        shaft.move(36, rpm=600)
        assert shaft.position == 36
        shaft.play("sine:90DEG,2S")
        shaft.stop()
        assert isinstance(shaft.name, str)


def test_threads_share_a_rig():
    with drehgeber.rig(SIMULATED) as rig:
        wrong = []

        def ask():
            wrong.extend(1 for _ in range(50) if not rig.ask("*IDN?"))

        threads = [threading.Thread(target=ask) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE_S)
        assert wrong == []
