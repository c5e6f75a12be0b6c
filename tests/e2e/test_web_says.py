# SPDX-License-Identifier: MIT
"""drehgeber web: what it answers, whole. Headers, reasons, and several requests on one connection."""
import re
import signal

import pytest

import test_web
from rig import PATIENCE_S, free_port, run
from test_web import BINARY, CLOSE, TEXT, Page, Process, Web

# Fixtures of the other file.
control, rig, web = test_web.control, test_web.rig, test_web.web


class Told(Page):
    """A page that keeps the reason it was closed with."""

    def closed(self):
        """Code and reason; all texts before are left."""
        while True:
            first, length = self.take(2)
            payload = self.take(length)
            if first & 0x0F == CLOSE:
                return int.from_bytes(payload[:2], "big"), payload[2:].decode()


def test_headers_of_a_file(web):
    _, headers, body = web.get("/")
    for header in ("server", "connection"):
        headers.pop(header, None)
    assert headers == {
        "content-type": "text/html; charset=utf-8", "content-length": str(len(body)),
        "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; "
                                   f"connect-src 'self' ws://{web.name}; base-uri 'none'; form-action 'none'; "
                                   "frame-ancestors 'none'",
        "x-content-type-options": "nosniff", "cache-control": "no-store", "referrer-policy": "no-referrer",
        "cross-origin-resource-policy": "same-origin", "cross-origin-opener-policy": "same-origin"}


def test_one_connection_has_many_answers(web):
    """As browsers do; one that is asked for with HEAD has no body."""
    files = {path: web.get(path)[2] for path in ("/main.js", "/style.css", "/")}
    with web.connect() as link, link.makefile("rb") as answers:
        for method, path in (("GET", "/main.js"), ("HEAD", "/style.css"), ("GET", "/"), ("HEAD", "/main.js"),
                             ("GET", "/style.css")):
            link.sendall(f"{method} {path} HTTP/1.1\r\nHost: {web.name}\r\n\r\n".encode())
            assert answers.readline().split()[1] == b"200"
            length = 0
            while (line := answers.readline()) != b"\r\n":
                name, _, value = line.partition(b": ")
                length = int(value) if name == b"content-length" else length
            assert length == len(files[path]) > 1000
            if method == "GET":
                assert answers.read(length) == files[path]
        link.settimeout(0.2)
        with pytest.raises(TimeoutError):
            link.recv(1)


@pytest.mark.parametrize("request_, status, reason", [
    ("GET / HTTP/1.1\r\nHost: evil.example", 403, "This is not a name of this machine, or it is a page of another site; use an address"),
    ("GET / HTTP/1.1\r\nHost: {name}\r\nOrigin: http://evil.example", 403, "a page of another site"),
    ("POST / HTTP/1.1\r\nHost: {name}\r\nContent-Length: 0", 405, "expected GET"),
    ("GET /nothing HTTP/1.1\r\nHost: {name}", 404, ""),
    ("GET /rig HTTP/1.1\r\nHost: {name}\r\nConnection: Upgrade\r\nUpgrade: h2c", 400, "websocket is the only upgrade here"),
    ("GET /rig HTTP/1.1\r\nHost: {name}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
     "Sec-WebSocket-Key: MTIzNDU2Nzg5MDEyMzQ1Ng==\r\nSec-WebSocket-Protocol: drehgeber", 403, "Only for the page from here"),
])
def test_a_refusal_says_why(web, request_, status, reason):
    answer = web.raw((request_.format(name=web.name) + "\r\n\r\n").encode())
    assert int(answer.split()[1]) == status and reason.encode() in answer


@pytest.mark.parametrize("kind, payload, reason", [
    (BINARY, b"*IDN?", "a message is a line of SCPI"), (TEXT, b"", "a message is a line of SCPI"),
    (TEXT, b"A" * 1024, "a message is a line of SCPI"), (TEXT, b"*IDN?\x7f", "a message is a line of SCPI"),
    (TEXT, b"*IDN?\x1f", "a message is a line of SCPI"),
])
def test_what_is_no_line(web, kind, payload, reason):
    with Told(web) as page:
        page.frame(payload, kind)
        assert page.closed() == (4003, reason)


def test_a_line_may_have_1023_characters(web):
    """~ and blank are the outermost ones of a line."""
    with Page(web) as page:
        assert page.message() == "ready"
        page.send("*IDN?" + " " * 1018)  # longer than SCPI lines are: the rig refuses it, the page stays
        assert page.ask("SYST:ERR?").startswith("-363,")
        page.send("~")
        assert page.ask("SYST:ERR?").startswith("-113,")


def test_why_a_page_is_sent_away(rig, control, web):
    with Told(web, name=False) as page:
        page.send('SYST:TOK "wrong"')
        assert page.closed() == (4001, "that is not the token")
    watching = Web(control, "--watch")
    with Told(watching) as page:
        page.send("SHAF:POS 1")
        assert page.closed() == (4003, "this panel only watches")
    assert watching.end() == (0, [])
    pages = [Told(web, name=False) for _ in range(25)]
    for page in pages[:24]:
        page.send(f'SYST:TOK "{web.token}"')
        assert page.message() == "ready"  # of those who name it at the same time anyone may be one too many
    pages[24].send(f'SYST:TOK "{web.token}"')
    assert pages[24].closed() == (4002, "too many pages are open")
    rig.process.send_signal(signal.SIGKILL)
    rig.process.wait(PATIENCE_S)
    for page in pages[:24]:
        assert page.closed() == (4002, "the rig is gone")
        page.link.close()


def test_who_said_too_much_goes_on_later(web):
    """500 lines a second: the next one is answered when a second has passed, and again."""
    with Page(web) as page:
        assert page.message() == "ready"
        for _ in range(3):
            for _ in range(499):
                page.send("*OPC?")
            assert {page.message() for _ in range(499)} == {"1"}


@pytest.mark.parametrize("options, does", [([], "controls"), (["--watch"], "sees")])
def test_beyond_loopback_it_says_who_may_what(rig, control, options, does):
    process = Process("web", control, "--listen", "0.0.0.0:0,open", *options)
    where = re.match(r"ready web http://(0\.0\.0\.0:\d+)/#token=", process.ready)[1]
    assert process.end() == (0, [f"drehgeber: {where}: beyond loopback; every client that knows the token, which is "
                                 f"sent as plain text, {does} this rig"])


def test_it_listens_where_it_is_told(rig, control):
    port = free_port()
    process = Process("web", "--control", control, "--listen", f"[::1]:{port}")
    assert process.ready.startswith(f"ready web http://[::1]:{port}/#token=")
    assert process.end() == (0, [])
    said = run("web", control, "--listen", "8080").stderr
    assert said == ("drehgeber: --listen 8080: expected HOST:PORT, e.g. 127.0.0.1:8080, or HOST:PORT,open beyond "
                    "loopback\n")
    said = run("web", control, "--listen", "0.0.0.0:0").stderr
    assert said == ("drehgeber: --listen 0.0.0.0:0: beyond loopback, where anybody could try to connect; use "
                    "0.0.0.0:0,open if you want that\n")
