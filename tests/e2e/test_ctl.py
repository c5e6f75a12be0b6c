# SPDX-License-Identifier: MIT
"""drehgeber ctl in front of a server that is no rig: what it says, and what it does not say."""
import contextlib
import os
import socket
import subprocess
import threading
import time

import pytest

from rig import PATIENCE_S, PROGRAM, run_refused

TITLE = b"\x1b]0;title\x07"
# Orders to a terminal: C0, ESC, DEL, C1 as bytes and as UTF-8, and what turns the direction of text.
ORDERS = TITLE + b"\r\x1b[2J\x7f\x9b2J\xc2\x9b2J\xe2\x80\xae\x00\t ~\x1fend"
SHOWN = (rb"\x1B]0;title\x07\x0D\x1B[2J\x7F\x9B2J\xC2\x9B2J\xE2\x80\xAE\x00\x09 ~\x1Fend")


class Server:
    """Takes clients, and says this to each, line by line: bytes, or seconds to wait; .heard is what the last one said."""

    def __init__(self, path, *says):
        self.address = f"unix:{path}"
        self.heard = b""
        self.says = says
        self.over = threading.Event()
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.bind(str(path))
        self.socket.listen()
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        with contextlib.suppress(OSError):
            while True:
                self.serve_one(self.socket.accept()[0])

    def serve_one(self, client):
        with contextlib.suppress(OSError), client:
            for say in self.says:
                if isinstance(say, bytes):
                    client.sendall(say)
                else:
                    self.over.wait(say)
            self.heard = b""
            while more := client.recv(4096):  # what is closed with something unread is reset
                self.heard += more

    def await_heard(self, text: bytes):
        """Until the last client has said exactly this: who has ended may not have been heard yet."""
        deadline = time.monotonic() + PATIENCE_S
        while self.heard != text:
            assert time.monotonic() < deadline, self.heard
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.over.set()
        with contextlib.suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.thread.join(PATIENCE_S)
        self.socket.close()


def ctl(server, *arguments, stdin=subprocess.DEVNULL):
    """Status, stdout, stderr, and how long it took."""
    begin = time.monotonic()
    done = subprocess.run([PROGRAM, "ctl", "--control", server.address, *arguments], stdin=stdin, capture_output=True,
                          timeout=30)
    return done.returncode, done.stdout, done.stderr, time.monotonic() - begin


@pytest.fixture
def serve(tmp_path):
    """serve(...): a Server until the test ends."""
    with contextlib.ExitStack() as servers:
        yield lambda *says: servers.enter_context(Server(tmp_path / "s", *says))


def test_a_terminal_is_shown_what_it_would_obey(serve):
    server = serve(ORDERS + b"\n", b'0,"No error"\n')
    master, slave = os.openpty()
    done = subprocess.run([PROGRAM, "ctl", "--control", server.address, "*IDN?"], stdin=subprocess.DEVNULL, stdout=slave,
                          stderr=subprocess.PIPE, timeout=PATIENCE_S)
    os.close(slave)
    seen = os.read(master, 4096)
    os.close(master)
    assert (done.returncode, done.stderr, seen) == (0, b"", SHOWN + b"\r\n")


def test_a_program_gets_the_bytes(serve):
    status, out, err, _ = ctl(serve(ORDERS + b"\n", b'0,"No error"\n'), "*IDN?")
    assert (status, out, err) == (0, ORDERS + b"\n", b"")


def test_an_error_is_shown_wherever_stderr_goes(serve):
    status, out, err, _ = ctl(serve(b'-100,"' + TITLE + b'"\n'), "*IDN?")
    assert (status, out, err) == (1, b"", rb'drehgeber: -100,"\x1B]0;title\x07"' + b"\n")


def test_a_silence_is_told_and_has_an_end(serve):
    server = serve(30)
    status, out, err, took = ctl(server, "--timeout", "6S", "*IDN?")
    told, ended = err.decode().splitlines()
    assert told == f"drehgeber: {server.address}: no answer for 5 s; ctl waits for 6S, --timeout SPAN changes that"
    assert ended == f"drehgeber: {server.address}: no answer for 6S"
    assert (status, out) == (1, b"") and 6 <= took < 6 + PATIENCE_S


def test_a_silence_is_told_without_a_limit_of_the_users(serve):
    """That there is one, and how long. Whoever answers later is heard."""
    server = serve(6, b'yes\n0,"No error"\n')
    status, out, err, _ = ctl(server, "*IDN?")
    assert (status, out) == (0, b"yes\n") and b"no answer for 5 s; ctl waits for 60S" in err and err.count(b"\n") == 1


@pytest.mark.parametrize("command", ["SHAF:MOVE 1REV;*opc?", "*WAI", "*OPC?"])
def test_a_motion_takes_as_long_as_it_takes(serve, command):
    status, out, err, _ = ctl(serve(5.5, b'1\n0,"No error"\n'), command)
    assert (status, out, err) == (0, b"1\n", b"")


def test_a_limit_holds_for_motions_when_the_user_says_so(serve):
    server = serve(30)
    status, _, err, _ = ctl(server, "--timeout", "500MS", "*OPC?")
    assert (status, err) == (1, f"drehgeber: {server.address}: no answer for 500MS\n".encode())


def test_somebody_who_types_slowly_is_no_silence(serve):
    """Nothing is asked, so nothing is missing; then something is. A wait may come in two pieces."""
    server = serve(30)
    read, write = os.pipe()
    process = subprocess.Popen([PROGRAM, "ctl", "--control", server.address, "--timeout", "1S"], stdin=read,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    os.close(read)
    os.write(write, b"SHAF:VEL 1RPM\n")
    time.sleep(2)
    assert process.poll() is None
    os.write(write, b"*IDN?\n")
    out, err = process.communicate(timeout=PATIENCE_S)
    os.close(write)
    assert (process.returncode, out) == (1, b"") and err.endswith(b": no answer for 1S\n")


def test_a_wait_in_two_pieces_is_seen(serve):
    server = serve(5.5, b'1\n0,"No error"\n')
    read, write = os.pipe()
    process = subprocess.Popen([PROGRAM, "ctl", "--control", server.address], stdin=read, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
    os.close(read)
    os.write(write, b"*OP")
    time.sleep(0.3)
    os.write(write, b"C?\n")
    os.close(write)
    assert process.communicate(timeout=PATIENCE_S) == (b"1\n", b"") and process.returncode == 0


@pytest.mark.parametrize("span", ["5", "-1S", "0S", "soon", "9000H"])
def test_a_limit_is_a_span(span):
    line = run_refused(2, "ctl", f"--timeout={span}", "*IDN?")
    assert line == f"drehgeber: --timeout {span}: expected a span such as 10S, 5MIN or 1H; up to 8760H"


# ---------------------------------------------------------------- which rig, and what is said to it

def ctl_of_folder(folder, *arguments, stdin=subprocess.DEVNULL):
    """ctl that looks for the one rig that runs; status, stdout, stderr."""
    done = subprocess.run([PROGRAM, "ctl", *arguments], stdin=stdin, capture_output=True, timeout=PATIENCE_S, text=True,
                          env={"XDG_RUNTIME_DIR": str(folder), "PATH": os.environ["PATH"]})
    return done.returncode, done.stdout, done.stderr


def test_the_one_that_runs_is_found(tmp_path):
    """Among names that are no sockets, and sockets at which nobody listens."""
    folder = tmp_path / "drehgeber"
    folder.mkdir()
    for name in ("text.txt", "a.sock", ".sock", "sock", "b.sockx"):
        (folder / name).write_text("")
    with socket.socket(socket.AF_UNIX) as gone:
        gone.bind(f"{folder}/gone.sock")
    with Server(folder / "x.socket", b"wrong\n"), Server(folder / "s.sock", b'yes\n0,"No error"\n') as server:
        assert ctl_of_folder(tmp_path, "*IDN?", "SHAF:POS?") == (0, "yes\n", "")
        server.await_heard(b"*IDN?\nSHAF:POS?\nSYSTem:ERRor:ALL?\n")


def test_several_that_run_are_named(tmp_path):
    folder = tmp_path / "drehgeber"
    folder.mkdir()
    with Server(folder / "two.sock"), Server(folder / "one.sock"):
        assert ctl_of_folder(tmp_path, "*IDN?") == (
            1, "", f"drehgeber: several are running; --control with one of: unix:{folder}/one.sock unix:{folder}/two.sock\n")


def test_a_folder_with_a_long_name(tmp_path):
    said = "drehgeber: RUNTIME_DIRECTORY or XDG_RUNTIME_DIR is too long; expected --control ADDR\n"
    assert ctl_of_folder("/" + "x" * 5000, "*IDN?") == (1, "", said)


def test_commands_of_stdin(serve, tmp_path):
    """As they are; none at all is a mistake."""
    server = serve(b'one\ntwo\n0,"No error"\n')
    (tmp_path / "commands").write_text("*IDN?\nSHAF:POS?")
    with open(tmp_path / "commands") as commands:
        assert ctl(server, stdin=commands)[:3] == (0, b"one\ntwo\n", b"")
    server.await_heard(b"*IDN?\nSHAF:POS?\nSYSTem:ERRor:ALL?\n")
    assert ctl(server)[:3] == (2, b"one\ntwo\n",
                               b"drehgeber: no command, and none on stdin; 'drehgeber ctl SYST:HELP?' lists them\n")


def test_the_oldest_error_decides(serve):
    server = serve(b'7\n-113,"Undefined header;x",-222,"Data out of range"\n')
    assert ctl(server, "x")[:3] == (1, b"7\n", b'drehgeber: -113,"Undefined header;x",-222,"Data out of range"\n')


def test_a_connection_that_breaks(tmp_path):
    """Before the answer; what has come whole is printed."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"{tmp_path}/b")
        listener.listen()
        process = subprocess.Popen([PROGRAM, "ctl", "--control", f"unix:{tmp_path}/b", "*IDN?"], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        client = listener.accept()[0]
        while b"ALL?" not in client.recv(4096):
            pass
        client.close()
        assert process.communicate(timeout=PATIENCE_S) == ("", f"drehgeber: unix:{tmp_path}/b: the connection broke\n")
        assert process.returncode == 1
