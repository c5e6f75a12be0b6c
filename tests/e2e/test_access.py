# SPDX-License-Identifier: MIT
"""Who may connect to the control plane, and who is sent away before anything is executed."""
import os
import pty
import re
import select
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rig import PATIENCE_S, PROGRAM, REPOSITORY, Client, Rigs, run, run_refused, start_rig

sys.path.insert(0, str(REPOSITORY / "tools/python"))
import drehgeber  # noqa: E402

ENCODER = "[encoder biss]\nmodel = s3684-biss\nwire = sim\n"
SECRET = "5f1c-0a.B_correct"
WRONG_SECRET = "5f1c-0a.B_corrupt"
CLIENTS_MAX = 32
SPEED = "SHAF:VEL 60RPM"
FILE = 'SHAF:REC:STAR "evil.csv"'
BODY = f"{SPEED}\n{FILE}\n"


@pytest.fixture
def rig(tmp_path):
    """Start a rig: rig("tcp:127.0.0.1:0", ...); its files are in tmp_path. Nothing unasked is said."""
    rigs = Rigs(tmp_path)

    def begin(*addresses, **options):
        keys = "".join(f"control = {a}\n" for a in addresses)
        one = rigs.begin(f"[rig]\n{keys}{ENCODER}", **options)
        one.controls = [address.partition(",token=")[0] for address in one.controls]
        one.port = int(one.controls[0].rpartition(":")[2]) if "tcp:" in one.controls[0] else None
        return one

    yield begin
    assert rigs.end() == []


def swallowed(line: socket.socket) -> bytes:
    """What comes until the other side has closed."""
    got = b""
    line.settimeout(PATIENCE_S)
    try:
        while data := line.recv(65536):
            got += data
    except ConnectionResetError:
        pass
    return got


def attack(port: int, packets: list, pause_s: float = 0.02) -> bytes:
    """Send these packets; what was answered until the connection was closed by the other side."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            for packet in packets:
                line.sendall(packet)
                time.sleep(pause_s if len(packets) > 1 else 0)
        except (BrokenPipeError, ConnectionResetError):
            pass
        return swallowed(line)


def assert_nothing_happened(bench, folder: Path):
    with Client(bench.port) as client:
        speed, recorded = client.ask("SHAF:VEL?"), (folder / "evil.csv").exists()
        client.send("SHAF:REC:STOP;:SHAF:STOP;POS 0")  # for the next test
        assert client.ask("*IDN?") != ""
    (folder / "evil.csv").unlink(missing_ok=True)
    assert (speed, recorded) == ("0.000", False)


# --- programs that speak something else -----------------------------------------------------------

HEADERS = ("Host: 127.0.0.1:5025\nOrigin: https://evil.example\nUser-Agent: Mozilla/5.0\n"
           "Content-Type: text/plain;charset=UTF-8\nContent-Length: 47\n\n")
POST = f"POST / HTTP/1.1\n{HEADERS}{BODY}"
METHODS = ["GET", "POST", "PUT", "HEAD", "DELETE", "OPTIONS", "PATCH", "CONNECT", "TRACE", "PROPFIND",
           "SEARCH", "QUERY", "M-SEARCH", "post", "Get", "SHAF"]
HELLO = bytes.fromhex("16030100c8010000c40303") + bytes(range(32)) + b"\x20"
UPGRADE = ("GET /chat HTTP/1.1\nHost: x\nUpgrade: websocket\nConnection: Upgrade\n"
           "Sec-WebSocket-Key: x\nSec-WebSocket-Version: 13\n\n")
FOREIGN = {
    **{f"method {method}": f"{method} / HTTP/1.1\n{HEADERS}{BODY}" for method in METHODS},
    "command in the path": f"GET /;:{SPEED} HTTP/1.0\n{HEADERS}{BODY}",
    "command as the path": f"GET ;:{SPEED};\n\n{BODY}",
    "proxy": f"POST http://127.0.0.1/{SPEED} HTTP/1.1\n{HEADERS}{BODY}",
    "no version": f"GET /\n{BODY}",
    "blanks in front": f"  \t POST / HTTP/1.1\n{HEADERS}{BODY}",
    "lines in front": f"\n\n\nPOST / HTTP/1.1\n{HEADERS}{BODY}",
    "Host first": f"Host: 127.0.0.1\n\n{BODY}",
    "host first": f"host:127.0.0.1\n\n{BODY}",
    "HTTP/2": f"PRI * HTTP/2.0\n\nSM\n\n{BODY}",
    "websocket": UPGRADE + BODY,
    "answer": f"HTTP/1.1 200 OK\n\n{BODY}",
    "SSH": f"SSH-2.0-x\n{BODY}",
    "STUN": b"\x00\x03\x00\x40\x21\x12\xa4\x42;:" + BODY.encode() * 2,
    "quotes": f'"{SPEED}"\n{BODY}',
    "NUL": f"\0\n{BODY}",
    "NUL in front": f"\0{SPEED}\n{BODY}",
    "long": "x" * 5000 + f"\n{BODY}",
    "long POST": f"POST /{'x' * 100000} HTTP/1.1\n{HEADERS}{BODY}",
    "long beginning": " " * 700 + f"POST / HTTP/1.1\n{HEADERS}{BODY}",
    "TLS": HELLO + f"\n{BODY}".encode(),
    "TLS and a command": HELLO + SPEED.encode() + b"\n" + BODY.encode(),
    "SSL 2": b"\x80\x2e\x01\x00\x02\n" + BODY.encode(),
    "HTTP behind SCPI": f"*CLS\n{POST}",
    "TLS behind SCPI": b"*CLS\n" + HELLO + b"\n" + BODY.encode(),
}


def as_bytes(text) -> bytes:
    return text if isinstance(text, bytes) else text.encode()


@pytest.fixture(scope="module")
def target(tmp_path_factory):
    folder = tmp_path_factory.mktemp("target")
    (folder / "rig.ini").write_text("[rig]\ncontrol = tcp:127.0.0.1:0\n" + ENCODER)
    one = start_rig(folder / "rig.ini", "--files", folder)
    one.port, one.folder = int(one.controls[0].rpartition(":")[2]), folder
    yield one
    status = one.end()
    assert (status, one.clean_up()) == (0, [])


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"], ids=["LF", "CRLF", "CR"])
@pytest.mark.parametrize("name", FOREIGN)
def test_a_foreign_language_executes_nothing(target, name, ends):
    text = as_bytes(FOREIGN[name]).replace(b"\n", ends.encode()) + b"\n\n"
    answer = attack(target.port, [text])
    assert b"evil" not in answer and len(answer) < 1000
    assert_nothing_happened(target, target.folder)


@pytest.mark.parametrize("ends", ["\n", "\r\n"], ids=["LF", "CRLF"])
@pytest.mark.parametrize("cut", [[1], [2], [4], [5], [6], [15], [16], [17], [40], [3, 6, 17, 60],
                                 [16, 150, 170], [-len(BODY)], [-len(BODY) - 1, -20]], ids=str)
def test_a_post_in_several_packets(target, cut, ends):
    text = POST.replace("\n", ends).encode()
    bounds = [0, *(place % len(text) for place in cut), len(text)]
    attack(target.port, [text[a:b] for a, b in zip(bounds, bounds[1:])])
    assert_nothing_happened(target, target.folder)


def test_a_post_byte_by_byte(target):
    attack(target.port, [bytes([byte]) for byte in POST.encode()], 0.0005)
    assert_nothing_happened(target, target.folder)


def test_a_real_client_of_http(target):
    """As a browser sends it: the standard library's client, a body of plain text."""
    import http.client
    for body in (BODY, BODY.replace("\n", "\r\n"), f"\n{BODY}", f"{BODY};" * 1000):
        line = http.client.HTTPConnection("127.0.0.1", target.port, timeout=PATIENCE_S)
        with pytest.raises((http.client.HTTPException, OSError)):
            line.request("POST", f"/;:{SPEED}".replace(" ", "%20"), body,
                         {"Content-Type": "text/plain"})
            line.getresponse()
        line.close()
    assert_nothing_happened(target, target.folder)


@pytest.mark.parametrize("first", ["*IDN?", "*CLS", ":SHAF:POS?", "shaft:position?", "  *RST", "\t*CLS",
                                   "\r\n\r\n*IDN?", "SYST:ERR?", "INST:SEL biss", "SHAF:POS 0;VEL?"])
def test_scpi_in_all_its_forms_is_let_in(target, first):
    with Client(target.port) as client:
        client.send(first)
        client.send("*CLS;:TRAC:LAST?;*CLS")
        client.send('INST:SEL?;:SYST:VERS?')
        answers = [client.answers.readline().strip()]
        while answers[-1] != '"biss";1999.0':
            assert answers[-1] != "" or len(answers) < 3, answers
            answers.append(client.answers.readline().strip())
        client.send("GETTING:ON")  # an error like any other, once the language is clear
        assert client.ask("SYST:ERR?").startswith("-113,")
        assert client.ask("INST:SEL?") == '"biss"'


def test_a_mistake_behind_a_right_line_is_no_reason(target):
    with Client(target.port) as client:
        assert client.ask("*IDN?")
        for _ in range(5):
            assert client.error("nothing of the kind") == -113
        assert client.ask("INST:SEL?") == '"biss"'


def test_half_a_line_and_the_end(target):
    for text in (b"", b"\n", b"G", b"POST / HT", b"\x16", b"\x16\x03", SPEED.encode(), b"SHAF:VEL"):
        with socket.create_connection(("127.0.0.1", target.port), PATIENCE_S) as line:
            line.sendall(text)
            line.shutdown(socket.SHUT_WR)
            swallowed(line)
    assert_nothing_happened(target, target.folder)


def test_who_was_sent_away_leaves_nothing_open(target):
    descriptors = Path(f"/proc/{target.pid}/fd")
    before = len(list(descriptors.iterdir()))
    for name in list(FOREIGN) * 3:
        attack(target.port, [as_bytes(FOREIGN[name]) + b"\n"])
    assert_nothing_happened(target, target.folder)
    deadline = time.monotonic() + PATIENCE_S
    while len(list(descriptors.iterdir())) > before:
        assert time.monotonic() < deadline
        time.sleep(0.01)


# --- beyond loopback ------------------------------------------------------------------------------

@pytest.mark.parametrize("address", ["tcp:0.0.0.0:0", "tcp:[::]:0", "tcp:[::ffff:0.0.0.0]:0",
                                     "tcp::0", "tcp:*:0"])
def test_beyond_loopback_only_when_it_is_said(tmp_path, address):
    ended = run("run", "s3684-biss", "--control", address)
    assert ended.returncode in (1, 2) and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1
    if address.count(":") > 1 and address[4] not in ":*":
        assert ",open" in ended.stderr
    file = tmp_path / "rig.ini"
    file.write_text(f"[rig]\ncontrol = {address}\n{ENCODER}")
    ended = run("run", file)
    assert ended.returncode in (1, 2) and f"{file}:2: " in ended.stderr
    assert len(ended.stderr.splitlines()) == 1


@pytest.mark.parametrize("address", ["tcp:127.0.0.1:0", "tcp:127.1.2.3:0", "tcp:localhost:0",
                                     "tcp:[::1]:0", "tcp:127.0.0.1:0,open"])
def test_loopback_needs_no_word_and_has_no_warning(rig, address):
    bench = rig(address)
    assert ",open" not in bench.controls[0]
    assert bench.client().ask("INST:SEL?") == '"biss"'
    assert bench.errors.so_far() == []


@pytest.mark.parametrize("address", ["tcp:0.0.0.0:0,open", "tcp:[::]:0,open"])
def test_with_the_word_it_warns_once(rig, address):
    bench = rig(address)
    said = bench.errors.wait()
    assert "loopback" in said or "network" in said, said
    with Client(bench.port) as client:
        assert client.ask("INST:SEL?") == '"biss"'
    with Client(bench.port) as client:
        assert client.ask("INST:SEL?") == '"biss"'
    assert bench.errors.so_far() == []


@pytest.mark.parametrize("address", ["0.0.0.0:0", "[::]:0"])
def test_a_ring_beyond_loopback_is_asked_for(address):
    line = run_refused(1, "run", "ocd-ib-k3", "--modbus", address)
    assert line.endswith(f"use {address},open if you want that"), line


def test_a_ring_beyond_loopback_is_said_once(start):
    encoder = start(model="ocd-ib-k3", wire=["--modbus", "0.0.0.0:0,open"])
    assert "loopback" in encoder.errors.wait()
    assert re.fullmatch(r"ready ocd-ib-k3 modbus:0\.0\.0\.0:\d+", encoder.ready_line)
    start("--quiet", model="ocd-ib-k3", wire=["--modbus", "0.0.0.0:0,open"])
    start(model="ocd-ib-k3", wire=["--modbus", "127.0.0.1:0"])


def test_a_refused_start_warns_of_nothing(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text(f"[rig]\ncontrol = tcp:0.0.0.0:0,open\ncontrol = unix:{'none/' * 3}s\n{ENCODER}")
    assert f"{file}:3: control: " in run_refused(1, "run", file)


@pytest.mark.parametrize("address", [
    "tcp:127.0.0.1:0,shut", "tcp:127.0.0.1:0,", "tcp:127.0.0.1:0,open,", "tcp:127.0.0.1:0,OPEN",
    "tcp:127.0.0.1:0,token=", "tcp:127.0.0.1:0,token", "tcp:127.0.0.1:0,openly",
    "tcp:127.0.0.1:0,open,open"])
def test_words_behind_an_address_that_are_none(address):
    ended = run("run", "s3684-biss", "--control", address)
    assert ended.returncode in (1, 2) and ended.stdout == "" and len(ended.stderr.splitlines()) == 1
    assert "--control" in ended.stderr


# --- tokens ---------------------------------------------------------------------------------------

@pytest.fixture
def token(tmp_path):
    file = tmp_path / "token"
    file.write_text(SECRET + "\n")
    file.chmod(0o600)
    return file


@pytest.fixture(params=["tcp:127.0.0.1:0", "unix:{}/s"], ids=["tcp", "unix"])
def guarded(request, rig, token):
    bench = rig(f"{request.param.format(token.parent)},token={token}")
    assert f"control {bench.controls[0]},token={token}" in bench.lines  # as clients take it
    bench.token = token
    return bench


def said_to(address: str, *lines: str) -> str:
    """All that is answered to these lines at once, up to the end of the connection."""
    client = Client(address)
    try:
        client.line.sendall("".join(f"{line}\n" for line in lines).encode())
        client.line.shutdown(socket.SHUT_WR)
    except OSError:
        pass  # it was closed before all was sent
    answer = swallowed(client.line).decode()
    client.close()
    return answer


def speed(bench) -> str:
    """As somebody sees it who knows the token."""
    with Client(bench.controls[0]) as client:
        client.send(f'SYST:TOK "{SECRET}"')
        return client.ask("SHAF:VEL?")


def test_the_right_token_opens(guarded):
    for line in (f'SYST:TOK "{SECRET}"', f'SYSTem:TOKen "{SECRET}"', f':syst:tok "{SECRET}"',
                 f"SYST:TOK '{SECRET}'", f'  SYST:TOKEN \t"{SECRET}"\r'):
        with Client(guarded.controls[0]) as client:
            client.send(line)
            assert client.ask("INST:SEL?") == '"biss"', line
            assert client.ask("SYST:ERR?").startswith("0,"), line
            assert client.error(line) in (0, -113)  # once more does no harm
            assert client.ask("INST:SEL?") == '"biss"', line


def test_token_and_commands_at_once(guarded):
    assert '"biss"' in said_to(guarded.controls[0], f'SYST:TOK "{SECRET}"', "INST:SEL?")


WRONG = {
    "wrong": f'SYST:TOK "{WRONG_SECRET}"',
    "prefix": f'SYST:TOK "{SECRET[:-1]}"',
    "longer": f'SYST:TOK "{SECRET}x"',
    "empty": 'SYST:TOK ""',
    "none": "SYST:TOK",
    "bare": f"SYST:TOK {SECRET}",
    "blank behind": f'SYST:TOK "{SECRET} "',
    "capitals": f'SYST:TOK "{SECRET.upper()}"',
    "two": f'SYST:TOK "{SECRET}","{SECRET}"',
    "half a string": f'SYST:TOK "{SECRET}',
    "NUL behind": f'SYST:TOK "{SECRET}\0"',
    "query": f'SYST:TOK? "{SECRET}"',
    "query without": "SYST:TOK?",
    "file": 'SYST:TOK "token"',
    "long": f'SYST:TOK "{"x" * 300}"',
    "longer than a line": f'SYST:TOK "{"x" * 5000}"',
    "missing": "*CLS",
    "command first": f'{SPEED};:SYST:TOK "{SECRET}"',
    "identity": "*IDN?",
}


@pytest.mark.parametrize("name", WRONG)
def test_without_the_right_token_nothing_is_executed(guarded, name):
    address = guarded.controls[0]
    answer = said_to(address, WRONG[name], SPEED, FILE, "INST:SEL?", "SYST:ERR?")
    assert "biss" not in answer and SECRET not in answer
    # ... and there is no second attempt on this connection
    answer = said_to(address, WRONG[name], f'SYST:TOK "{SECRET}"', SPEED, FILE, "INST:SEL?")
    assert "biss" not in answer
    assert speed(guarded) == "0.000"
    assert not (guarded.token.parent / "evil.csv").exists()


@pytest.mark.parametrize("blanks", ["\n\r\n", " " * 600, " " * 1023, " " * 1024, " " * 1100, " " * 5000,
                                    "\t" * 1024])
def test_blanks_open_nothing(guarded, blanks):
    for ends in ("", "\n"):
        answer = said_to(guarded.controls[0], f"{blanks}{ends}{SPEED}", SPEED, "INST:SEL?")
        assert "biss" not in answer
    assert speed(guarded) == "0.000"


def test_a_wrong_token_ends_the_connection(guarded):
    with Client(guarded.controls[0]) as client:
        client.send(f'SYST:TOK "{WRONG_SECRET}"')
        assert swallowed(client.line).startswith(b"-203,")


def test_commands_behind_a_token_in_one_line(guarded):
    """Either way, but never half: what stands behind a wrong one does not happen."""
    said_to(guarded.controls[0], f'SYST:TOK "wrong";:{SPEED}')
    assert speed(guarded) == "0.000"


def test_http_before_the_token(rig, token, tmp_path):
    bench = rig(f"tcp:127.0.0.1:0,token={token}")
    attack(bench.port, [POST.replace(BODY, f'SYST:TOK "{SECRET}"\n{BODY}').encode()])
    assert speed(bench) == "0.000"
    assert not (tmp_path / "evil.csv").exists()


def test_the_token_is_of_its_address(rig, token, tmp_path):
    bench = rig(f"tcp:127.0.0.1:0,token={token}", f"unix:{tmp_path}/s")
    assert bench.client(1).ask("INST:SEL?") == '"biss"'
    assert "biss" not in said_to(bench.controls[0], "INST:SEL?")


def test_the_token_is_told_nowhere(guarded):
    said = "\n".join(guarded.lines)
    assert SECRET not in said
    assert SECRET not in Path(f"/proc/{guarded.pid}/cmdline").read_text()


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o604, 0o620, 0o602, 0o660, 0o777])
def test_a_token_that_others_can_read(token, mode):
    token.chmod(mode)
    said = run_refused(1, "run", "s3684-biss", "--control", f"tcp:127.0.0.1:0,token={token}")
    assert str(token) in said and "600" in said


@pytest.mark.parametrize("what", ["missing", "empty", "blank", "folder", "pipe", "long", "NUL", "quote",
                                  "two lines"])
def test_a_token_file_that_is_none(token, what):
    contents = {"empty": b"", "blank": b"\n", "long": b"x" * 10000, "NUL": b"a\0b\n",
                "quote": b'a"b\n', "two lines": b"a\nb\n"}
    if what in contents:
        token.write_bytes(contents[what])
    else:
        token.unlink()
    if what == "folder":
        token.mkdir(mode=0o700)
    elif what == "pipe":
        os.mkfifo(token, 0o600)
    said = run_refused(1, "run", "s3684-biss", "--control", f"tcp:127.0.0.1:0,token={token}")
    assert str(token) in said


def test_the_token_of_a_rig_file_lies_beside_it(rig, token):
    bench = rig("tcp:127.0.0.1:0,token=token", cwd="/")
    assert speed(bench) == "0.000"
    token.chmod(0o644)
    assert ":2: " in run_refused(1, "run", token.parent / "rig.ini", cwd="/")


@pytest.mark.parametrize("port", ["0x50", "50h", "+80", "-1", "65536", "80 "])
def test_a_port_is_a_decimal_number(port):
    assert f"127.0.0.1:{port}" in run_refused(2, "run", "s3684-biss", "--control", f"tcp:127.0.0.1:{port}")


def test_ctl_with_a_token(guarded, tmp_path):
    address = guarded.controls[0]
    asked = run("ctl", "--control", f"{address},token={guarded.token}", "INST:SEL?", "SHAF:POS?")
    assert (asked.returncode, asked.stderr) == (0, ""), asked
    assert asked.stdout.splitlines()[0] == '"biss"'
    (tmp_path / "wrong").write_text(WRONG_SECRET + "\n")
    (tmp_path / "wrong").chmod(0o600)
    for none in (address, f"{address},token={tmp_path}/wrong", f"{address},token={tmp_path}/none"):
        asked = run("ctl", "--control", none, "INST:SEL?")
        assert asked.returncode == 1 and asked.stdout == "" and asked.stderr, none


def test_python_with_a_token(guarded, tmp_path):
    address = guarded.controls[0]
    control = drehgeber.Control(f"{address},token={guarded.token}")
    assert control.parts("INST:SEL?") == ["biss"]
    control.close()
    (tmp_path / "wrong").write_text(WRONG_SECRET + "\n")
    (tmp_path / "wrong").chmod(0o600)
    for none in (address, f"{address},token={tmp_path}/wrong"):
        control = drehgeber.Control(none)
        with pytest.raises((OSError, drehgeber.ScpiError)):
            control.ask("INST:SEL?")
        control.close()


def test_top_with_a_token(guarded):
    screen, terminal = pty.openpty()
    process = subprocess.Popen(
        [PROGRAM, "top", f"{guarded.controls[0]},token={guarded.token}"], stdin=terminal,
        stdout=terminal, stderr=terminal, start_new_session=True,
        env=os.environ | {"TERM": "vt100", "LINES": "30", "COLUMNS": "100"})
    os.close(terminal)
    try:
        shown, deadline = b"", time.monotonic() + PATIENCE_S
        while b"position 0:0" not in shown:
            assert time.monotonic() < deadline and process.poll() is None, shown
            if select.select([screen], [], [], 0.2)[0]:
                shown += os.read(screen, 65536)
        os.write(screen, b"q")
        assert process.wait(PATIENCE_S) == 0
    finally:
        os.close(screen)
        if process.poll() is None:
            process.kill()
            process.wait(PATIENCE_S)


# --- places ---------------------------------------------------------------------------------------

ADDRESSES = ["tcp:127.0.0.1:0", "unix:s"]


@pytest.mark.parametrize("address", ADDRESSES)
def test_forty_silent_clients_lock_nobody_out(rig, address):
    bench = rig(address)
    silent = [bench.client() for _ in range(40)]
    for _ in range(3):
        assert bench.client().ask("INST:SEL?") == '"biss"'
    for one in silent[:40 - CLIENTS_MAX]:
        assert swallowed(one.line).count(b"\n") <= 1


@pytest.mark.parametrize("address", ADDRESSES)
def test_who_speaks_stays(rig, address):
    bench = rig(address)
    active = bench.client()
    assert active.ask("INST:SEL?") == '"biss"'
    for _ in range(3 * CLIENTS_MAX):
        bench.client()
        assert active.ask("SHAF:POS?") == "0.000000"
    assert bench.client().ask("INST:SEL?") == '"biss"'
    assert active.ask("INST:SEL?") == '"biss"'


@pytest.mark.parametrize("address", ADDRESSES)
def test_half_a_line_now_and_then_keeps_no_place_for_ever(rig, address):
    """Bytes that never become a line, from more clients than there are places."""
    bench = rig(address)
    slow = [bench.client() for _ in range(CLIENTS_MAX)]
    for _ in range(3):
        for one in slow:
            one.line.sendall(b"*")
    assert bench.client().ask("INST:SEL?") == '"biss"'


@pytest.mark.parametrize("address", ADDRESSES)
def test_who_waits_for_an_answer_is_not_silent(rig, address):
    """The move of a client that waits lasts while others come and say nothing."""
    bench = rig(address)
    waiting = bench.client()
    waiting.send("SHAF:ACC 0;MOVE 360DEG,60RPM;*OPC?")
    for _ in range(CLIENTS_MAX + 8):
        bench.client()
        time.sleep(0.01)
    assert waiting.answers.readline() == "1\n"


def test_many_that_do_not_know_the_token_push_out_nobody_who_does(rig, token):
    bench = rig(f"tcp:127.0.0.1:0,token={token}")
    inside = bench.client()
    inside.send(f'SYST:TOK "{SECRET}"')
    assert inside.ask("INST:SEL?") == '"biss"'
    for _ in range(2 * CLIENTS_MAX):
        bench.client()
    assert inside.ask("INST:SEL?") == '"biss"'
    assert speed(bench) == "0.000"


def test_machines_that_are_gone_are_noticed(rig):
    """Each connection has its keepalive timer, as /proc/net/tcp shows it."""
    bench = rig("tcp:127.0.0.1:0")
    clients = [bench.client() for _ in range(3)]
    for client in clients:
        client.ask("*IDN?")
    keepalive, established = "02", "01"
    port = f":{bench.port:04X}"
    rows = [row.split() for row in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    timers = [row[5].split(":")[0] for row in rows
              if row[1].endswith(port) and row[3] == established]
    assert timers == [keepalive] * len(clients)
