# SPDX-License-Identifier: MIT
"""drehgeber web as somebody meets it who means no good: names, origins, tokens, frames, floods. What a browser makes of
it is in e2e/panel."""
import base64
import contextlib
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import time
from pathlib import Path

import pytest

from rig import HELD_UP, PATIENCE_S, PROGRAM, Lines, free_port, run_refused

MODEL = "s3684-rs485"
# How long a connection has to name the token, and a second for the sweep.
TOKEN_WITHIN_S = 11
TEXT, BINARY, CLOSE = 1, 2, 8
TRANSFERRED_MAX = 300_000


class Process:
    """A command until it is ready; its first line."""

    def __init__(self, *arguments, **options):
        self.process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
        self.said = Lines(self.process.stderr, HELD_UP)
        self.ready = Lines(self.process.stdout).wait()

    def end(self, signal_number=signal.SIGTERM):
        self.process.send_signal(signal_number)
        status = self.process.wait(PATIENCE_S)
        self.process.stdout.close()
        return status, self.said.so_far()


@pytest.fixture
def control(tmp_path):
    return f"unix:{tmp_path}/rig.sock"


@pytest.fixture
def rig(control):
    """An encoder at rest."""
    process = Process("run", MODEL, "--pty", "--shaft", "90DEG", "--control", control)
    yield process
    if process.process.poll() is None:
        assert process.end() == (0, [])


class Web(Process):
    def __init__(self, control, *arguments):
        super().__init__("web", control, "--listen", "127.0.0.1:0", *arguments)
        found = re.fullmatch(r"ready web http://127\.0\.0\.1:(\d+)/(?:#token=([0-9a-f]{32}))?", self.ready)
        self.port = int(found[1])
        self.token = found[2]
        self.name = f"127.0.0.1:{self.port}"

    def cpu_ticks(self):
        """User and system time so far, in 10 ms."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return int(fields[11]) + int(fields[12])

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), PATIENCE_S)

    def raw(self, data: bytes) -> bytes:
        """All that comes back until the other side closes."""
        with self.connect() as link:
            link.sendall(data)
            return received(link)

    def get(self, path="/", host=None, method="GET") -> tuple:
        """Status, headers, body."""
        name = self.name if host is None else host
        answer = self.raw(f"{method} {path} HTTP/1.1\r\nHost: {name}\r\nConnection: close\r\n\r\n".encode())
        if not answer:
            return None, {}, b""
        head, _, body = answer.partition(b"\r\n\r\n")
        first, *lines = head.decode().split("\r\n")
        return int(first.split()[1]), dict(line.split(": ", 1) for line in lines), body


def received(link) -> bytes:
    data = b""
    with contextlib.suppress(OSError):
        while piece := link.recv(65536):
            data += piece
    return data


@pytest.fixture
def web(rig, control):
    process = Web(control)
    yield process
    assert process.end() == (0, [])


class Page:
    """A WebSocket, as a page opens it unless told otherwise."""

    def __init__(self, web, *, origin=None, host=None, path="/rig", protocol="drehgeber", token=None, name=True):
        self.link = web.connect()
        headers = {"Host": host or web.name, "Upgrade": "websocket", "Connection": "Upgrade",
                   "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(), "Sec-WebSocket-Version": "13",
                   "Origin": f"http://{host or web.name}" if origin is None else origin,
                   "Sec-WebSocket-Protocol": protocol}
        lines = "".join(f"{key}: {value}\r\n" for key, value in headers.items() if value)
        self.link.sendall(f"GET {path} HTTP/1.1\r\n{lines}\r\n".encode())
        self.data = b""
        while b"\r\n\r\n" not in self.data:
            piece = self.link.recv(65536)
            if not piece:
                break
            self.data += piece
        head, _, self.data = self.data.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head else None
        if self.status == 101 and name:
            self.send(f'SYST:TOK "{token or web.token}"')

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.link.close()

    def frame(self, payload: bytes, kind=TEXT, final=True):
        mask = os.urandom(4)
        length = bytes([0x80 | len(payload)]) if len(payload) < 126 else struct.pack(">BH", 0xFE, len(payload))
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
        self.link.sendall(bytes([(0x80 if final else 0) | kind]) + length + mask + masked)

    def send(self, line: str):
        self.frame(line.encode())

    def take(self, n: int) -> bytes:
        while len(self.data) < n:
            piece = self.link.recv(65536)
            if not piece:
                raise EOFError
            self.data += piece
        taken, self.data = self.data[:n], self.data[n:]
        return taken

    def message(self):
        """The next text; or the code that it was closed with; None: closed without."""
        whole = b""
        while True:
            try:
                first, length = self.take(2)
                if length == 126:
                    length, = struct.unpack(">H", self.take(2))
                elif length == 127:
                    length, = struct.unpack(">Q", self.take(8))
                payload = self.take(length)
            except (EOFError, ConnectionError):
                return None
            if first & 0x0F == CLOSE:
                return struct.unpack(">H", payload[:2])[0] if payload else None
            whole += payload
            if first & 0x80:
                return whole.decode()

    def ask(self, line: str) -> str:
        self.send(line)
        return self.message()


# ---------------------------------------------------------------- the page

def files_of(web) -> dict:
    """The page and all that it names, by path."""
    texts = {"/": web.get()[2].decode()}
    for path, text in texts.copy().items():
        todo = re.findall(r'(?:src|href)="([\w.]+)"', text)
        while todo:
            name = "/" + todo.pop()
            if name not in texts:
                texts[name] = web.get(name)[2].decode()
                todo += re.findall(r'from "\./([\w.]+)"', texts[name])
    return texts


def test_the_page_is_whole_small_and_without_the_token(web):
    files = files_of(web)
    assert {"/", "/style.css", "/main.js", "/live.js", "/view.js"} <= files.keys()
    assert sum(map(len, files.values())) < TRANSFERRED_MAX
    assert all(web.token not in text for text in files.values())
    assert not re.search(r"<script>|<style|\son\w+=|style=", files["/"])


def test_headers(web):
    for path, kind in (("/", "text/html"), ("/style.css", "text/css"), ("/main.js", "text/javascript")):
        status, headers, body = web.get(path)
        assert status == 200
        assert headers["content-type"] == f"{kind}; charset=utf-8"
        assert int(headers["content-length"]) == len(body)
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cache-control"] == "no-store"
        assert headers["referrer-policy"] == "no-referrer"
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy and "unsafe" not in policy
        assert f"connect-src 'self' ws://{web.name};" in policy


@pytest.mark.parametrize("path", ["/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/rig",
                                  "/nothing", "/main.js%00", "/live.js/"])
def test_no_other_file(web, path):
    status, _, body = web.get(path)
    assert status in (None, 400, 403, 404) and b"root:" not in body


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_nothing_but_get(web, method):
    answer = web.raw(f"{method} / HTTP/1.1\r\nHost: {web.name}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".encode())
    assert answer == b"" or answer.split()[1] in (b"405", b"400", b"404"), answer
    assert web.get()[0] == 200


def test_head_is_a_get_without_the_body(web):
    _, headers, _ = web.get("/main.js")
    assert web.get("/main.js", method="HEAD") == (200, headers, b"")
    assert web.get("/nothing", method="HEAD")[0] == 404
    assert web.get("/", method="HEAD", host="evil.example")[0] == 403


# ---------------------------------------------------------------- who may come in

@pytest.mark.parametrize("host", ["localhost", "localhost:9", "127.0.0.1", "127.0.0.1:9000", "[::1]:9", "LOCALHOST"])
def test_names_of_this_machine(web, host):
    assert web.get(host=host)[0] == 200


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example",
                                  "localhost:8080@evil.example", "127.0.0.1:80:80", "[::1", "a" * 300,
                                  "localhost; script-src *", ""])
def test_other_names_lead_here_by_rebinding(web, host):
    assert web.get(host=host)[0] == 403
    with Page(web, host=host or "x") as page:
        assert page.status == 403


def test_no_host(web):
    assert web.raw(b"GET / HTTP/1.0\r\n\r\n").split()[1:2] in ([b"403"], [b"400"], [])


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://{name}", "http://127.0.0.1", "http://{name}/",
                                    "http://localhost:{port}", "http://{name}.evil.example", "file://"])
def test_pages_of_others_are_refused(web, origin):
    with Page(web, origin=origin.format(name=web.name, port=web.port)) as page:
        assert page.status == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://{name}/", "https://{name}",
                                    pytest.param("http://" + "a" * 400, id="long")])
@pytest.mark.parametrize("method", ["GET", "POST", "HEAD", "OPTIONS"])
def test_files_are_not_for_pages_of_others_either(web, method, origin):
    text = f"{method} /main.js HTTP/1.1\r\nHost: {web.name}\r\nOrigin: {origin}\r\nContent-Length: 0\r\n\r\n"
    assert web.raw(text.format(name=web.name).encode()).startswith(b"HTTP/1.1 403 ")
    text = f"GET /main.js HTTP/1.1\r\nHost: {web.name}\r\nOrigin: http://{web.name}\r\nConnection: close\r\n\r\n"
    assert web.raw(text.encode()).startswith(b"HTTP/1.1 200 ")


# HTTP/2, RFC 7540: SETTINGS as 3.2.1 has them, the preface of 3.5 and an empty SETTINGS frame behind it.
SETTINGS = "HTTP2-Settings: AAMAAABkAARAAAAAAAIAAAAA\r\n"
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])


@pytest.mark.parametrize("host", ["{name}", "evil.example"])
@pytest.mark.parametrize("upgrade", ["h2c", "H2C", "TLS/1.0", "h2c, websocket", "websocket, h2c", "x"])
def test_no_upgrade_but_websocket(web, upgrade, host):
    head = (f"GET / HTTP/1.1\r\nHost: {host.format(name=web.name)}\r\nConnection: Upgrade, HTTP2-Settings\r\n"
            f"Upgrade: {upgrade}\r\n{SETTINGS}\r\n")
    answer = web.raw(head.encode() + PREFACE)
    assert answer == b"" or re.match(rb"HTTP/1\.[01] 4\d\d ", answer), answer
    assert upgrade.lower() != "h2c" or answer.split()[1] == b"400"
    assert b"101" not in answer.split(b"\r\n")[0] and b"<script" not in answer
    assert web.get()[0] == 200


def test_http_2_is_not_spoken(web):
    """Somebody who begins with it, as one who has been told that it is there."""
    answer = web.raw(PREFACE)
    assert answer == b"" or answer.startswith(b"HTTP/1."), answer
    assert web.get()[0] == 200


@pytest.mark.parametrize("version", ["8", "0", "14", "131", ""])
def test_another_version_of_websockets(web, version):
    """RFC 6455, 4.4: 426, and the one that is spoken."""
    head = (f"GET /rig HTTP/1.1\r\nHost: {web.name}\r\nOrigin: http://{web.name}\r\nConnection: Upgrade\r\n"
            "Upgrade: websocket\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Protocol: drehgeber\r\n"
            f"Sec-WebSocket-Version: {version}\r\n\r\n")
    lines = web.raw(head.encode()).split(b"\r\n")
    assert lines[0].split()[1] == b"426" and b"sec-websocket-version: 13" in lines


def test_no_origin_is_no_page(web):
    with Page(web, origin=False) as page:
        assert page.status == 403


def test_other_sockets_are_not_there(web):
    for options in ({"path": "/"}, {"path": "/rig2"}, {"protocol": "http"}, {"protocol": ""}, {"protocol": "loop"}):
        with Page(web, **options) as page:
            assert page.status != 101, options


def test_the_token_opens(web):
    with Page(web) as page:
        assert page.status == 101
        assert page.message() == "ready"
        assert page.ask("*IDN?").startswith("drehgeber,")
        assert page.ask("SHAF:POS?") == "90.000000"


@pytest.mark.parametrize("first", ['SYST:TOK "{wrong}"', 'SYST:TOK ""', 'SYST:TOK "{token}x"', "*IDN?", "SHAF:POS 1", "{token}"])
def test_without_the_token_nothing_opens(web, first):
    """One attempt; what follows is not executed."""
    with Page(web, name=False) as page:
        page.send(first.format(token=web.token, wrong="0" * 32))
        page.send("SHAF:POS 10")
        assert page.message() == 4001
    with Page(web) as page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "90.000000"


def test_a_token_of_ones_own(rig, control, tmp_path):
    file = tmp_path / "token"
    file.write_text("a-token-of-my-own-42\n")
    file.chmod(0o644)
    assert "chmod 600" in run_refused(1, "web", control, "--listen", "127.0.0.1:0", "--token", file)
    file.chmod(0o600)
    web = Web(control, "--token", file)
    assert web.token is None
    with Page(web, token="a-token-of-my-own-42") as page:
        assert page.message() == "ready"
    assert web.end() == (0, [])


def test_two_starts_have_two_tokens(rig, control):
    webs = [Web(control), Web(control)]
    assert webs[0].token != webs[1].token
    assert [web.end() for web in webs] == [(0, []), (0, [])]


# ---------------------------------------------------------------- what a page may say

@pytest.mark.parametrize("kind, payload", [
    (TEXT, b"A" * 1100), (TEXT, b"A" * 60000), (BINARY, b"*IDN?"), (TEXT, b"*IDN?\nSHAF:POS 1"), (TEXT, b"\x00"),
    (TEXT, "SHAF:POS 1°".encode()),
])
def test_a_message_is_a_short_line(web, kind, payload):
    with Page(web) as page:
        assert page.message() == "ready"
        page.frame(payload, kind)
        assert page.message() in (4003, None)
    with Page(web) as page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "90.000000"


def test_pieces_of_a_message(web):
    with Page(web) as page:
        assert page.message() == "ready"
        page.frame(b"SHAF:", final=False)
        page.frame(b"POS", 0, final=False)
        page.frame(b"?", 0)
        assert page.message() == "90.000000"
        for _ in range(20):
            page.frame(b"A" * 100, 0 if _ else TEXT, final=False)
        assert page.message() == 4003


def test_a_frame_without_an_end(web):
    """It says that 2^62 bytes follow."""
    with Page(web) as page:
        assert page.message() == "ready"
        page.link.sendall(b"\x81\xff" + struct.pack(">Q", 1 << 62) + b"mask" + b"A" * 5000)
        assert page.message() in (4003, 1002, 1009, None)
    assert web.get()[0] == 200


def test_a_flood_is_slowed_down_and_answered(web):
    """Whoever says too much is heard later; another one at once."""
    count = 1500
    with Page(web) as flood, Page(web) as other:
        assert (flood.message(), other.message()) == ("ready", "ready")
        began = time.monotonic()
        for _ in range(count):
            flood.send("SHAF:POS?")
        assert other.ask("*IDN?").startswith("drehgeber,")
        assert {flood.message() for _ in range(count)} == {"90.000000"}
        assert time.monotonic() - began > 1


def test_a_page_that_does_not_read(web):
    """Its answers wait; others do not."""
    with Page(web) as deaf, Page(web) as other:
        deaf.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        for _ in range(25):
            deaf.send("FAUL:CAT?")
        time.sleep(0.5)
        before = web.cpu_ticks()
        time.sleep(1)
        assert web.cpu_ticks() - before < 50  # it waits, and does not look again and again
        assert other.message() == "ready"
        assert other.ask("SHAF:POS?") == "90.000000"
        assert deaf.message() == "ready"
        assert [deaf.message()[:18] for _ in range(25)] == ['"led_current_high"'] * 25


def test_who_watches_changes_nothing(rig, control):
    web = Web(control, "--watch")
    for line in ("SHAF:POS?", "STAT?;:FAUL:ACT?", f'INST:SEL "{MODEL}";:TIME?', ":SYST:VERS?",
                 *(f'{word} "{MODEL}";:TIME?' for word in ("INST:SELECT", ":instrument:sel", "INSTrument:SELect"))):
        with Page(web) as page:
            assert page.message() == "ready watch"
            assert isinstance(page.ask(line), str), line
    for line in ("SHAF:POS 10", "SHAF:POS?;POS 10", "SHAF:POS?; POS 10", "*RST", "POW OFF", "FAUL:SET led_current_high",
                 'SHAF:PROF? "a;b";POS 10', "SHAF:POS?;VEL 1;VEL?", "BISS:FRAM?", ":BISS:REG? 0", "SHAF:STOP ?", "SHAF:STOP;",
                 f'INST:SELE "{MODEL}"', f'I "{MODEL}"', f'INST:SELECTS "{MODEL}"'):
        with Page(web) as page:
            assert page.message() == "ready watch"
            page.send(line)
            assert page.message() == 4003, line
    with Page(web) as page:
        assert page.message() == "ready watch"
        assert page.ask("SHAF:POS?;VEL?;:POW?;:FAUL:ACT?") == '90.000000;0.000;1;""'
    assert web.end() == (0, [])


# ---------------------------------------------------------------- crowds, and who does not come to the point

def test_a_hundred_connections_do_not_lock_out(web):
    with contextlib.ExitStack() as stack:
        for _ in range(100):
            stack.enter_context(web.connect())
        unnamed = [stack.enter_context(Page(web, name=False)) for _ in range(60)]
        assert unnamed[-1].status == 101
        assert web.get()[0] == 200
        page = stack.enter_context(Page(web))
        assert page.message() == "ready"
        for _ in range(100):
            stack.enter_context(web.connect())
        assert page.ask("SHAF:POS?") == "90.000000"


def test_pages_have_a_limit(web):
    with contextlib.ExitStack() as stack:
        pages = [stack.enter_context(Page(web)) for _ in range(24)]
        assert [page.message() for page in pages] == ["ready"] * 24
        assert stack.enter_context(Page(web)).status == 503
        assert pages[0].ask("SHAF:POS?") == "90.000000"
        pages[0].link.close()
        deadline = time.monotonic() + PATIENCE_S
        while stack.enter_context(Page(web)).status != 101:
            assert time.monotonic() < deadline
            time.sleep(0.1)


def test_the_limit_holds_for_those_who_come_at_once(web):
    """A handshake is not the token: who names it last is sent away."""
    with contextlib.ExitStack() as stack:
        pages = [stack.enter_context(Page(web, name=False)) for _ in range(30)]
        for page in pages:
            page.send(f'SYST:TOK "{web.token}"')
        said = [page.message() for page in pages]
        assert (said.count("ready"), said.count(4002)) == (24, 6)
        assert {page.ask("SHAF:POS?") for page, word in zip(pages, said) if word == "ready"} == {"90.000000"}


def test_who_does_not_come_to_the_point_is_sent_away(web):
    """Half a handshake, a header byte by byte, a socket without a token: all are gone in time."""
    with contextlib.ExitStack() as stack:
        links = [stack.enter_context(web.connect()) for _ in range(3)]
        links[0].sendall(b"GET /rig HTTP/1.1\r\nHost: ")
        links.append(stack.enter_context(Page(web, name=False)).link)
        deadline = time.monotonic() + TOKEN_WITHIN_S + PATIENCE_S
        for link in links:
            link.settimeout(0)
        gone = set()
        while len(gone) < len(links):
            assert time.monotonic() < deadline, gone
            with contextlib.suppress(OSError):
                links[1].send(b"X")
            for i, link in enumerate(links):
                try:
                    if link.recv(4096) == b"":
                        gone.add(i)
                except BlockingIOError:
                    pass
                except ConnectionError:
                    gone.add(i)
            time.sleep(0.2)
        assert web.get()[0] == 200


@pytest.mark.parametrize("noise", ids=range(8), argvalues=[b"\x16\x03\x01\x02\x00\x01\x00", b"\xff" * 4000, b"GET " + b"/" * 20000 + b" HTTP/1.1\r\n\r\n",
                                   b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 5000 + b"\r\n", b"SHAF:POS 10\n" * 10,
                                   b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"\r\n\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n"])
def test_noise(web, noise):
    with web.connect() as link:
        with contextlib.suppress(OSError):  # it may have hung up already
            link.sendall(noise)
            link.shutdown(socket.SHUT_WR)
        received(link)
    assert web.get()[0] == 200
    with Page(web) as page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "90.000000"


# ---------------------------------------------------------------- the rig

def test_the_rig_goes_and_comes_back(rig, control, web):
    with Page(web) as page:
        assert page.message() == "ready"
        rig.process.kill()
        rig.process.wait(PATIENCE_S)
        assert page.message() == 4002
    with Page(web) as page:
        assert page.message() in ("ready", 4002)
    again = Process("run", MODEL, "--pty", "--shaft", "45DEG", "--control", control)
    with Page(web) as page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "45.000000"
    assert again.end() == (0, [])


def test_a_rig_without_a_place_in_its_queue_is_tried_again(rig, control, web):
    """Others have filled it while the rig stands still; they keep their places until it goes on."""
    os.kill(rig.process.pid, signal.SIGSTOP)
    try:
        with contextlib.suppress(BlockingIOError):
            while True:
                with socket.socket(socket.AF_UNIX) as other:
                    other.setblocking(False)
                    other.connect(control.removeprefix("unix:"))
        page = Page(web)
        page.link.settimeout(0.5)
        with pytest.raises(TimeoutError):
            page.message()
    finally:
        os.kill(rig.process.pid, signal.SIGCONT)
    page.link.settimeout(PATIENCE_S)
    with page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "90.000000"
    status, said = rig.end()
    assert status == 0 and [line for line in said if "stopped and continued" not in line] == []


def test_a_rig_that_asks_for_a_token(tmp_path):
    file = tmp_path / "rig-token"
    file.write_text("the-token-of-the-rig\n")
    file.chmod(0o600)
    control = f"tcp:127.0.0.1:{free_port()},token={file}"
    rig = Process("run", MODEL, "--pty", "--shaft", "90DEG", "--control", control)
    web = Web(control)
    with Page(web) as page:
        assert page.message() == "ready"
        assert page.ask("SHAF:POS?") == "90.000000"
    assert web.end() == (0, [])
    assert rig.end() == (0, [])


def test_it_ends_by_a_signal(rig, control):
    for number in (signal.SIGINT, signal.SIGHUP):
        web = Web(control)
        with Page(web) as page:
            assert page.message() == "ready"
            assert web.end(number) == (0, [])


# ---------------------------------------------------------------- what is refused at the start

def test_nothing_runs_there(tmp_path):
    line = run_refused(1, "web", f"unix:{tmp_path}/none.sock")
    assert "is a drehgeber running there?" in line


def test_a_port_that_is_taken(rig, control):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        where = f"127.0.0.1:{taken.getsockname()[1]}"
        line = run_refused(1, "web", control, "--listen", where)
        assert where in line and "Address already in use" in line and "port 0" in line


def test_beyond_loopback_has_to_be_meant(rig, control):
    line = run_refused(1, "web", control, "--listen", "0.0.0.0:0")
    assert "use 0.0.0.0:0,open" in line
    process = Process("web", control, "--listen", "0.0.0.0:0,open")
    assert process.ready.startswith("ready web http://0.0.0.0:")
    status, said = process.end()
    assert status == 0
    assert len(said) == 1 and "beyond loopback" in said[0]


@pytest.mark.parametrize("arguments, right", [
    (["--listen", "8080"], "expected HOST:PORT"),
    (["--listen", "127.0.0.1:0,word"], "expected HOST:PORT"),
    (["--listen", ""], "expected --listen HOST:PORT"),
    (["--nvm", "x"], "web [ADDRESS]"),
])
def test_usage(rig, control, arguments, right):
    assert right in run_refused(2, "web", control, *arguments)


def test_others_do_not_listen():
    assert "list takes no option --listen" in run_refused(2, "list", "--listen", "127.0.0.1:0")


def test_a_command_without_its_panel(rig, control, tmp_path):
    """As it is when the package drehgeber-web is not installed."""
    alone = shutil.copy(PROGRAM, tmp_path / "drehgeber")
    ended = subprocess.run([alone, "web", control], capture_output=True, text=True, timeout=PATIENCE_S)
    assert ended.returncode == 1
    assert "drehgeber-web is not installed" in ended.stderr and "libwebsockets-dev" in ended.stderr


def test_a_panel_that_cannot_be_started(rig, control, tmp_path):
    """As it is when what stands beside the command is no program."""
    alone = shutil.copy(PROGRAM, tmp_path / "drehgeber")
    (tmp_path / "drehgeber-web").write_bytes(b"\x7fELF")
    (tmp_path / "drehgeber-web").chmod(0o755)
    ended = subprocess.run([alone, "web", control], capture_output=True, text=True, timeout=PATIENCE_S)
    assert ended.returncode == 1
    assert f"cannot start {tmp_path}/drehgeber-web: Exec format error" in ended.stderr


def test_the_panel_is_started_by_the_command():
    ended = subprocess.run([Path(PROGRAM).parent / "drehgeber-web"], capture_output=True, text=True, timeout=PATIENCE_S)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == "drehgeber: drehgeber-web is started by 'drehgeber web'\n"


def test_nobody_reads_that_it_is_ready(rig, control):
    with open("/dev/full", "wb") as full:
        ended = subprocess.run([PROGRAM, "web", control, "--listen", "127.0.0.1:0"], stdout=full, stderr=subprocess.PIPE,
                               text=True, timeout=PATIENCE_S)
    assert ended.returncode == 1 and ended.stderr == "drehgeber: cannot write to stdout\n"


@pytest.mark.parametrize("behind, status", [("", 200), (".local", 200), (".evil.example", 403), ("x", 403)])
def test_beyond_loopback_it_has_the_name_of_its_machine(rig, control, behind, status):
    process = Process("web", control, "--listen", "0.0.0.0:0,open")
    port = int(process.ready.split("#")[0].rstrip("/").rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as link:
        link.sendall(f"GET / HTTP/1.1\r\nHost: {socket.gethostname()}{behind}:{port}\r\nConnection: close\r\n\r\n".encode())
        assert int(received(link).split()[1]) == status
    assert process.end()[0] == 0
