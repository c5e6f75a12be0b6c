# SPDX-License-Identifier: MIT
"""The client of the control plane, of rigs that run: over TCP, with a token, over a serial line; what it says when
the other end is silent, or gone."""
import os
import signal
import socket
import subprocess
import tempfile
import termios
import time
import tty

import drehgeber
import pytest
from drehgeber import Control, RigError, ScpiError

SIMULATED = "[encoder axis]\nmodel = s3684-biss\nwire = sim\n"
SECRET = "sixteen-characters"
PATIENCE_S = 20


@pytest.fixture
def listening(tmp_path):
    """listening(CONTROL): a rig whose control plane is there, too; where it is."""
    rigs = []

    def go(control):
        (tmp_path / "rig.ini").write_text(f"[rig]\ncontrol = {control}\n{SIMULATED}")
        rigs.append(drehgeber.run(tmp_path / "rig.ini"))
        return next(line for line in rigs[-1].lines if line.startswith("control tcp:")).removeprefix("control ").partition(",")[0]

    yield go
    for rig in rigs:
        rig.close()


@pytest.fixture
def open_control():
    """open_control(ADDRESS, ...): a session, closed at the end."""
    opened = []

    def go(address, **options):
        opened.append(Control(address, **options))
        return opened[-1]

    yield go
    for control in opened:
        control.close()


@pytest.mark.parametrize("host", ["127.0.0.1", "[::1]"])
def test_over_tcp(listening, open_control, host):
    control = open_control(listening(f"tcp:{host}:0"))
    assert control.ask("SHAF:POS 90DEG") is None
    assert control.ask("SHAF:POS?") == "90.000000"
    assert control.parts("INST:CAT?") == ["axis"]


def test_who_has_the_token(listening, open_control, tmp_path):
    for name, secret in (("token", SECRET), ("wrong", SECRET[::-1])):
        (tmp_path / name).write_text(f"{secret}\n")
        (tmp_path / name).chmod(0o600)
    address = listening(f"tcp:127.0.0.1:0,token={tmp_path}/token")
    assert open_control(f"{address},token={tmp_path}/token").parts("INST:SEL?") == ["axis"]
    for other in (address, f"{address},token={tmp_path}/wrong"):
        with pytest.raises((OSError, ScpiError)):
            open_control(other).ask("INST:SEL?")
    with pytest.raises(FileNotFoundError):
        Control(f"{address},token={tmp_path}/none")


@pytest.mark.parametrize("address", ["", "/run/rig.sock", "udp:127.0.0.1:5025"])
def test_another_address_is_refused(address):
    with pytest.raises(ValueError, match="expected unix:PATH, tcp:HOST:PORT or tty:PATH"):
        Control(address)


@pytest.fixture
def console(listening, tmp_path):
    """A board's: a serial line with a rig behind it."""
    path = tmp_path / "console"
    board = subprocess.Popen(["socat", f"PTY,link={path},rawer", listening("tcp:127.0.0.1:0")])
    end = time.monotonic() + PATIENCE_S
    while not path.exists():
        assert time.monotonic() < end
        time.sleep(0.01)
    yield f"tty:{path}"
    board.terminate()
    board.wait(PATIENCE_S)


def test_over_a_serial_line(console, open_control):
    control = open_control(console)
    assert control.ask("SHAF:POS 45DEG") is None
    assert control.ask("SHAF:POS?") == "45.000000"
    with pytest.raises(ScpiError) as caught:
        control.ask("NONSENSE")
    assert caught.value.code == -113  # SCPI 1999: undefined header
    assert control.ask("*IDN?").startswith("drehgeber,")


def test_a_serial_line_that_says_nothing():
    """It waits as long as it was told. What is no terminal does not stay open."""
    master, slave = os.openpty()
    tty.setraw(slave)
    control = Control(f"tty:{os.ttyname(slave)}", timeout=0.3)
    begin = time.monotonic()
    with pytest.raises(ConnectionError, match="closed"):
        control.ask("*IDN?")
    assert 0.2 < time.monotonic() - begin < PATIENCE_S
    control.close()
    os.close(slave)
    os.close(master)
    before = os.listdir("/proc/self/fd")
    with pytest.raises(termios.error):
        Control("tty:/dev/null")
    assert os.listdir("/proc/self/fd") == before


def test_a_socket_that_says_nothing(open_control, tmp_path):
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "s"))
        listener.listen()
        control = open_control(f"unix:{tmp_path}/s", timeout=0.1)
        server, _ = listener.accept()
        with server, pytest.raises(TimeoutError):
            control.ask("*IDN?")


def test_a_rig_that_has_ended():
    with pytest.raises(RigError, match="ended .*with -9"), drehgeber.rig(SIMULATED) as rig:
        assert rig.ask("INST:SEL?") == '"axis"'
        os.kill(rig.pid, signal.SIGKILL)
        with pytest.raises(ConnectionError):
            while True:
                rig.ask("*IDN?")
    with pytest.raises(RigError, match="it has ended"):
        rig.ask("*IDN?")


def test_a_rig_is_steered():
    with drehgeber.rig(SIMULATED) as rig:
        axis = rig.encoders["axis"]
        shaft = axis.shaft
        assert (axis.model, axis.wire, axis.place, shaft.name) == ("s3684-biss", "sim", None, "main")
        shaft.acceleration = 1000
        assert shaft.acceleration == 1000
        shaft.acceleration = 0
        shaft.velocity = 60
        assert shaft.velocity == 60
        shaft.stop()
        shaft.position = 0
        shaft.move(36, rpm=600)
        assert shaft.position == 36
        shaft.play("90DEG")
        assert shaft.position == 90
        axis.world("TEMP", "85 DEGC")
        assert float(axis.world("TEMP")) == 85
        axis.power(False)
        assert axis.state()["power"] == 0
        axis.power("CYCLE")
        assert axis.state()["power"] == 1
    with pytest.raises(ProcessLookupError):
        os.kill(rig.pid, 0)
    assert not os.path.exists(rig.socket)


def test_one_that_does_not_end(monkeypatch):
    """It is killed, and that is told."""
    monkeypatch.setattr("drehgeber.running.STOP_S", 0.3)
    rig = drehgeber.run("s3684-biss", "--sim")
    os.kill(rig.pid, signal.SIGSTOP)
    with pytest.raises(RigError, match="ended with -9"):
        rig.close()
    with pytest.raises(ProcessLookupError):
        os.kill(rig.pid, 0)


def test_one_that_is_not_ready_leaves_nothing(monkeypatch, tmp_path):
    """It says no, or nothing within the time that there is."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(RigError, match="--shaft nonsense"):
        drehgeber.run("s3684-rs485", "--pty", "--shaft", "nonsense")
    silent = tmp_path / "silent"
    silent.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/pid\necho starting\nexec sleep 60\n")
    silent.chmod(0o755)
    monkeypatch.setenv("DREHGEBER", str(silent))
    monkeypatch.setattr("drehgeber.running.READY_S", 3.5)  # a busy machine takes its time to start a shell
    with pytest.raises(RigError, match=r"not ready after 3.5 s: \['starting'\]"):
        drehgeber.run("s3684-biss", "--sim")
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
    assert list(folder.iterdir()) == []
