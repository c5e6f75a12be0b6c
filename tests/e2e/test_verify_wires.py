# SPDX-License-Identifier: MIT
"""verify: wires that fail, adapters and nodes that misbehave, files that cannot be written, clauses that cannot be
read. The encoder is a few lines of Python behind a network, which does what no encoder of ours would."""
import contextlib
import json
import os
import pty
import re
import select
import socket
import subprocess
import threading
import time
import tty
from xml.etree import ElementTree

import pytest

from rig import PROGRAM, Encoder, free_port, run, run_refused
from verified import WIRES, Server

NODE = 63
CLAUSE = "M12-7"  # it asks for a constant, and nothing else
OBJECTS = {0x1000: 0x00020196, 0x6004: 1000, 0x2160: 1000}
LIMIT_S = 20.0


class Node(Server):
    """A node behind an SLCAN adapter on TCP, for one master. change(number, index, line) makes of the answer to the
    n-th upload what is sent in its place; None: the connection ends."""

    def __init__(self, change=lambda number, index, line: line, node: int = NODE):
        super().__init__()
        self.change, self.node = change, node
        self.option = f"--slcan=tcp:{self.where}"
        self.lines = []
        self.number = 0

    def answer(self, line: bytes):
        """What is sent for a line of the master; None: the connection ends."""
        self.lines.append(line)
        found = re.fullmatch(rb"t%03X840(..)(..)(..)0{8}" % (0x600 + self.node), line)
        if not found:
            return b"\r"
        index = int(found[2] + found[1], 16)
        value = OBJECTS.get(index, 0).to_bytes(4, "little").hex().upper().encode()
        self.number += 1
        return self.change(self.number, index, b"t%03X843%s%s%s%s\r" % (0x580 + self.node, *found.groups(), value))

    def run(self):
        rest = b""
        with contextlib.suppress(OSError), self.listener.accept()[0] as wire:
            while data := wire.recv(4096):
                *lines, rest = (rest + data).split(b"\r")
                for line in lines:
                    sent = self.answer(line)
                    if sent is None:
                        return
                    wire.sendall(sent)


def verify(node: Node, *arguments, **options) -> subprocess.CompletedProcess:
    return subprocess.run([PROGRAM, "verify", "f3668", node.option, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          text=True, timeout=LIMIT_S,
                          **({"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options))


# --- adapters

ADAPTERS = {
    "as they are": lambda _, __, line: line,
    "small letters": lambda _, __, line: line.lower(),
    "bells": lambda _, __, line: b"\a" + line,
    "a long line": lambda _, __, line: b"t" * 200 + b"\r" + line,
    "extended frames": lambda _, __, line: b"T0000073F17F\r" + line,
    "remote frames": lambda _, __, line: b"r73F1\r" + line,
    "other nodes": lambda _, __, line: line.replace(b"t5BF", b"t585") + line,
    "late answers to other uploads": lambda _, __, line: line[:9] + b"FF" + line[11:] + line,
    "half a frame": lambda _, __, line: line[:12] + b"\r" + line,
    "no digits": lambda _, __, line: b"tXYZ0\rt5BFX\rt5BF9\rtFFF0\r" + line,
}


@pytest.mark.parametrize("change", ADAPTERS.values(), ids=ADAPTERS)
def test_what_adapters_send_beside_it_does_not_matter(change):
    with Node(change) as node:
        ended = verify(node, CLAUSE, "--quiet")
    assert ended.stdout.startswith("f3668: device type 00020196h, product 00000000h, revision 0, firmware 0\n")
    assert ended.stderr == ""
    assert node.lines[:3] == [b"", b"C", b"S5"] and node.lines[-1] == b"C"


def test_another_node():
    with Node(node=5) as node:
        ended = verify(node, CLAUSE, "--node", 5)
    assert ended.stdout.startswith("f3668: device type 00020196h")
    assert not any(line.startswith((b"t63F", b"r73F")) for line in node.lines)


def test_node_guarding_asks_for_one_byte():
    """Some nodes answer no remote frame of another length."""
    class Guarded(Node):
        toggle = 0x80

        def answer(self, line):
            if line != b"r73F1":
                return super().answer(line)
            self.toggle ^= 0x80
            return b"\rt73F1%02X\r" % (self.toggle | 0x7F)

    with Guarded() as node:
        ended = verify(node, "CIA-5-1", "--quiet")
    assert "\nagrees   CIA-5-1\n" in ended.stdout, ended.stdout


UNKNOWN = {
    "no object": (b"80000000" b"01000405", "agrees"),
    "the object of the last transfer": (b"80046000" b"01000405", "agrees"),
    "another code": (b"80001000" b"00000008", "differs"),
}


@pytest.mark.parametrize("refusal, became", UNKNOWN.values(), ids=UNKNOWN)
def test_which_object_an_unknown_command_is_about_is_not_asked(refusal, became):
    """CiA 301 does not say it."""
    class Refusing(Node):
        def answer(self, line):
            return b"\rt5BF8" + refusal + b"\r" if line.startswith(b"t63F8E0") else super().answer(line)

    with Refusing() as node:
        ended = verify(node, "CIA-2-16", "--quiet")
    assert f"\n{became:8} CIA-2-16" in ended.stdout, ended.stdout


class Held(Server):
    """A network between the command and an encoder that holds up answers to uploads, and nothing else."""

    def __init__(self, path):
        super().__init__()
        self.option = f"--slcan=tcp:{self.where}"
        self.path = path

    def run(self):
        far = os.open(self.path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(far)
        with contextlib.suppress(OSError), self.listener.accept()[0] as near:
            near.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            while ready := select.select([near, far], [], [], LIMIT_S)[0]:
                if near in ready:
                    data = near.recv(4096)
                    if not data:
                        break
                    os.write(far, data)
                if far in ready:
                    data = os.read(far, 4096)
                    time.sleep(0.08 if b"t5BF84" in data else 0)
                    near.sendall(data)
        os.close(far)


def test_a_network_that_holds_up_some_answers(tmp_path):
    """The time-out of an upload comes a second after an answer that was held up."""
    encoder = Encoder(["f3668", f"--slcan={tmp_path}/link"])
    with Held(tmp_path / "link") as wire:
        ended = verify(wire, "C27-1", "--quiet")
    assert encoder.clean_up() == []
    assert "\nagrees   C27-1\n" in ended.stdout, ended.stdout


# --- nodes

SILENT = "node 63 does not answer; expected its node-ID with --node, and a bus at 250 kBd"
NODES = {
    "gone": (lambda *_: None, SILENT),
    "gone later": (lambda number, _, line: line if number < 10 else None, SILENT),
    "aborting": (lambda _, __, line: line.replace(b"t5BF843", b"t5BF880"), SILENT),
    "of another object": (lambda _, __, line: line[:9] + b"FF" + line[11:], SILENT),
    "short": (lambda _, __, line: line[:4] + b"4" + line[5:13] + b"\r", SILENT),
    "turning": (lambda number, index, line: line if index != 0x6004 else line[:13] + b"%08X\r" % (number << 16),
                "the shaft turns; expected a shaft at rest"),
    "babbling": (lambda *_: b"t1010\r" * 5000, SILENT),
}


@pytest.mark.parametrize("change, refusal", NODES.values(), ids=NODES)
def test_nodes_that_are_refused(change, refusal):
    with Node(change) as node:
        ended = verify(node)
    assert (ended.returncode, ended.stdout) == (1, "")
    (line,) = ended.stderr.splitlines()
    assert line == f"drehgeber: {node.option.partition('=')[2]}: {refusal}"


LOST = {
    "gone": lambda number, _, line: line if number < 27 else None,
    "babbling": lambda number, _, line: line if number < 27 else b"t1010\r" * 5000,
}


@pytest.mark.parametrize("change", LOST.values(), ids=LOST)
def test_nodes_that_are_lost_end_it(change):
    with Node(change) as node:
        ended = verify(node, CLAUSE, "--quiet")
    assert ended.returncode == 1
    line = r"^it ended early: the encoder stopped answering in the row '.+'$"
    assert re.search(line, ended.stdout, re.M), ended.stdout


def test_a_wrong_constant_is_told_in_every_form(tmp_path):
    """Everything is zero: what is asked for has to differ."""
    files = [tmp_path / "junit.xml", tmp_path / "report.txt"]
    with Node() as node:
        ended = verify(node, CLAUSE, "--junit", files[0], "--report", files[1])
    assert ended.returncode == 1
    (why,) = re.findall(rf"^differs  {CLAUSE}: (.*)$", ended.stdout, re.M)
    assert "sent 63F 40 " in why and "expected 5BF" in why and "came 5BF" in why
    (failure,) = ElementTree.parse(files[0]).getroot().findall(f"testcase[@name='{CLAUSE}']/failure")
    assert failure.get("message") == why
    assert f" {CLAUSE}: differs: {why}\n" in files[1].read_text("utf-8")


def test_who_is_not_alone_is_told(tmp_path):
    """Another node answers what all nodes are asked."""
    class Two(Node):
        def answer(self, line):
            return b"t5858430010009601020" + b"0\r" if line.startswith(b"t605840001000") else super().answer(line)

    with Two() as node:
        ended = verify(node, CLAUSE, "--alone")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == ("drehgeber: another device is on the bus: 585h was received; without --alone, verify disturbs "
                            "no other device\n")


def test_another_encoder_on_a_line_is_told(tmp_path):
    link = tmp_path / "line"
    (tmp_path / "rig.ini").write_text(
        f"[bus line]\nwire = pty\naddress = {link}\n"
        + "".join(f"[encoder {name}]\nmodel = s3684-rs485\nbus = line\naddress = {address}\npace = 0\n"
                  for name, address in (("asked", "0x40"), ("other", "0x43"))))
    encoders = Encoder([tmp_path / "rig.ini"])
    try:
        ended = run("verify", "s3684-rs485", f"--pty={link}", "--alone", "3.2-2")
        assert (ended.returncode, ended.stdout, ended.stderr) == (
            1, "", "drehgeber: another device is on the wire: 43h was received; without --alone, verify disturbs no other device\n")
    finally:
        encoders.clean_up()


def test_who_is_alone_is_left_as_it_was():
    with Node() as node:
        ended = verify(node, CLAUSE, "--alone")
    assert ended.stdout.startswith("f3668: ")
    asked = {line[:4] for line in node.lines if line[4:13] == b"840001000"}
    assert asked == {b"t%03X" % (0x600 + node) for node in range(1, 128)}
    assert b"t00028" + b"03F" in node.lines  # pre-operational again


# --- wires

def test_wires_that_are_not_there(tmp_path):
    port = free_port()
    for where in "--can=nowhere0", f"--slcan={tmp_path}/none", f"--slcan=tcp:127.0.0.1:{port}", "--slcan=/dev/null":
        assert where.partition("=")[2] in run_refused(1, "verify", "f3668", where)


@pytest.mark.parametrize("node", ["0", "128", "x", "5x"])
def test_nodes_that_there_are_not(node):
    assert f"--node {node}; " in run_refused(1, "verify", "f3668", "--slcan=/dev/null", f"--node={node}")


# --- serial ports and buses of a network

class Telnet(threading.Thread):
    """A serial port behind telnet, which offers and wants more than the command knows."""
    OFFERS = b"\xff\xfb\x01\xff\xfd\x18\xff\xfd\x2c\xff\xfa\x2c\x6b\xff\xff\xff\xf0"  # echo, terminal type; COM port; a modem state
    LEFT = b"\x40\x42\x00\x01" * 200  # what others have asked for: more than is read at once

    def __init__(self, port: int):
        super().__init__(daemon=True)
        self.far = socket.create_connection(("127.0.0.1", port))
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.where = f"--rs485=rfc2217:127.0.0.1:{self.listener.getsockname()[1]}"
        self.sent = b""

    def run(self):
        with contextlib.suppress(OSError), self.listener.accept()[0] as near, self.far as far:
            for wire in near, far:
                wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            near.sendall(self.OFFERS + self.LEFT)
            while ready := select.select([near, far], [], [], LIMIT_S)[0]:
                for wire in ready:
                    data = wire.recv(4096)
                    if not data:
                        return
                    self.sent += data if wire is near else b""
                    (far if wire is near else near).sendall(data)


def test_a_serial_port_behind_telnet():
    """It is told the setting, FFh is doubled both ways, what it offers beside that is declined, and what is left over of
    others is no answer."""
    port = free_port()
    encoder = Encoder(["s3684-rs485", f"--rs485=rfc2217:127.0.0.1:{port}", "--shaft", "359.997DEG", "--set", "pace=0"])
    telnet = Telnet(port)
    telnet.start()
    ended = run("verify", "s3684-rs485", telnet.where, "5.1.2.1-", "5.1.2.14-6")
    telnet.join(LIMIT_S)
    assert encoder.clean_up() == []
    assert ended.stdout.startswith("s3684-rs485: type code 27h, firmware v1.0.8, 12072019\n"), ended
    assert ended.returncode == 0 and "agrees   5.1.2.14-6" in ended.stdout and ", 0 differ, " in ended.stdout, ended
    assert b"\xff\xfa\x2c\x01\0\0\x25\x80\xff\xf0" in telnet.sent and b"\xff\xfa\x2c\x03\x03\xff\xf0" in telnet.sent
    assert b"\xff\xfe\x01" in telnet.sent and b"\xff\xfc\x18" in telnet.sent and b"\xff\xfc\x2c" not in telnet.sent


def test_a_bus_behind_socketcand():
    """It has no remote frames: clauses of node guarding are not seen."""
    port = free_port()
    encoder = Encoder(["f3668", f"--socketcand=127.0.0.1:{port}"])
    where = f"--socketcand=127.0.0.1:{port}"
    found = run("verify", "f3668", where, "M12", "M19", "--quiet")
    guarded = run("verify", "f3668", where, "CIA-5-1")
    assert encoder.clean_up() == []
    assert "agrees" not in guarded.stdout.splitlines()[1] and "that this host cannot make exactly" in guarded.stdout, guarded
    assert found.returncode == 0 and "agrees   M12-7" in found.stdout and ", 0 differ, " in found.stdout, found


SERVERS = {
    "silent": b"",
    "another one": b"HTTP/1.1 400\r\n\r\n",
    "without the bus": b"< hi >< error could not open bus >",
    "endless": b"< hi >" + b"< frame 5BF 1.0 00 >" * 500,
}


@pytest.mark.parametrize("greeting", SERVERS.values(), ids=SERVERS)
def test_servers_without_a_bus(greeting):
    def greet():
        with contextlib.suppress(OSError), listener.accept()[0] as wire:
            wire.sendall(greeting)
            while wire.recv(4096):
                pass

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=greet, daemon=True)
        thread.start()
        where = "127.0.0.1:%d" % listener.getsockname()[1]
        assert run_refused(1, "verify", "f3668", f"--socketcand={where}").startswith(
            f"drehgeber: {where}: no socketcand that opens this bus; ")
        thread.join(LIMIT_S)


# --- files

@pytest.mark.parametrize("option", ["--junit", "--report"])
def test_files_that_cannot_be_written(tmp_path, option):
    for path in tmp_path / "none/file", "/dev/full":
        with Node() as node:
            ended = verify(node, CLAUSE, option, path)
        assert ended.returncode == 1
        assert ended.stderr.startswith(f"drehgeber: {path}: ") and ended.stderr.count("\n") == 1


def test_an_output_that_takes_nothing():
    with Node() as node, open("/dev/full", "wb") as full:
        ended = verify(node, CLAUSE, stdout=full)
    assert (ended.returncode, ended.stderr) == (1, "drehgeber: cannot write to stdout\n")


# --- clauses

CLAUSES = "M1 | a clause\n# a comment\n\nM2 | another\n"
ROWS = "[M1] a row\n  given f3668\n  read 1000:0 96 01 02 00\n"
FORGED = {
    "no bar": ("M1\n", ROWS, "canopen.clauses:1: not `ID | text`"),
    "no text": ("M1 | a\nM2 |\n", ROWS, "canopen.clauses:2: ID or text is missing"),
    "no ID": (" | a\n", ROWS, "canopen.clauses:1: ID or text is missing"),
    "listed": ("M1 | a | 28\n", ROWS, "canopen.clauses:1: not `ID | text | listed KEY`"),
    "listed nowhere": ("M1 | a | listed \n", ROWS, "canopen.clauses:1: not `ID | text | listed KEY`"),
    "too many clauses": ("".join(f"M{i} | a\n" for i in range(4001)), ROWS, "canopen.clauses:4001: not `ID | text`"),
    "no bracket": (CLAUSES, "[M1 a row\n", "canopen.rows:1: not `[IDs] title`"),
    "no title": (CLAUSES, "[M1]\n", "canopen.rows:1: not `[IDs] title`"),
    "no row": (CLAUSES, "# rows\n  given f3668\n", "canopen.rows:2: step before the first row"),
    "too many rows": (CLAUSES, "[M1] a\n" * 4001, "canopen.rows:4001: not `[IDs] title`, or too many rows"),
    "too many steps": (CLAUSES, ROWS + "  wait 1ms\n" * 8000, "canopen.rows:8002: step before the first row"),
    "crowded": (CLAUSES, "[1 2 3 4 5 6 7 8 9] a row\n", "canopen.rows:1: row cites too many clauses"),
    "no rows": (CLAUSES, None, "canopen.rows: cannot be read"),
    "no clauses": (None, ROWS, "canopen.clauses: cannot be read"),
}


def write_clauses(folder, clauses, rows):
    for name, content in (("clauses", clauses), ("rows", rows)):
        for suite in WIRES["f3668"][2]:
            if content is not None:
                (folder / f"{suite}.{name}").write_text(content)


@pytest.mark.parametrize("clauses, rows, refusal", FORGED.values(), ids=FORGED)
def test_clauses_that_cannot_be_read(tmp_path, monkeypatch, clauses, rows, refusal):
    write_clauses(tmp_path, clauses, rows)
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path))
    ended = run("verify", "f3668", "--slcan=/dev/null")
    told, sum_of_it = ended.stderr.splitlines()
    assert (ended.returncode, ended.stdout) == (1, "")
    assert told.startswith(f"{tmp_path}/{refusal}"), told
    assert sum_of_it == f"drehgeber: {tmp_path}: these clauses cannot be read"


def test_clauses_of_ones_own(tmp_path, monkeypatch):
    write_clauses(tmp_path, CLAUSES + "M3 | a contradiction | listed 1\nM4 | a \"turned\" <shaft>\n", ROWS + """
[M2] another value\n  given f3668\n  read 1000:0 97 01 02 00
[M4] a shaft\n  given f3668\n  turn 90DEG\n  read 1000:0 96 01 02 00
""")
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path))
    with Node() as node:
        ended = verify(node, "--junit", tmp_path / "junit.xml")
    assert ended.returncode == 0, ended.stdout
    for line in ("agrees   M1", "not seen M2: is about an encoder with other figures",
                 "not seen M3: the manual contradicts itself; see 'Inaccuracies and choices'",
                 "not seen M4: needs a shaft that is turned as the row says"):
        assert ended.stdout.count(f"\n{line}\n") == 2, ended.stdout
    assert ended.stdout.splitlines()[-1] == "2 clauses agree, 0 differ, 6 were not seen"
    assert len(ElementTree.parse(tmp_path / "junit.xml").getroot().findall("testcase/skipped")) == 6


@pytest.mark.parametrize("quiet", [(), ("--quiet",)])
def test_a_terminal_is_told_how_far_it_is(tmp_path, monkeypatch, quiet):
    write_clauses(tmp_path, CLAUSES, ROWS + "[M2] another row\n  given f3668\n  read 1000:0 96 01 02 00\n")
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path))
    near, far = pty.openpty()
    tty.setraw(far)
    with Node() as node:
        assert verify(node, *quiet, stderr=far).returncode == 0
    os.write(far, b"the end")
    rows = b"".join(b"\r%s %d of 2 " % (suite.encode(), row) for suite in WIRES["f3668"][2] for row in (1, 2))
    told = b""
    while not told.endswith(b"the end") and select.select([near], [], [], LIMIT_S)[0]:
        told += os.read(near, 4096)
    os.close(near)
    os.close(far)
    assert told == (b"" if quiet else rows + b"\r\n") + b"the end"


def in_xml(text: str) -> str:
    return re.sub('[<>&"]', lambda found: f"&#{ord(found[0])};", text)


def test_every_form_says_the_same_of_a_clause(tmp_path, monkeypatch):
    """Clauses that agree, that are a choice, that differ, that no row can prove; one of them with a strange name."""
    (tmp_path / "canopen.clauses").write_text('M1 | a clause\nC1 | a choice\nM2<&>" | another\nM3 | no row | listed 28\n')
    (tmp_path / "canopen.rows").write_text("[M1 C1] a row\n  given f3668\n  read 1000:0 96 01 02 00\n"
                                           '[M2<&>"] the vendor\n  given f3668\n  read 1018:1 13 00 00 00\n')
    (tmp_path / "cia406.clauses").write_text("X1 | of the profile\n")
    (tmp_path / "cia406.rows").write_text("[X1] a row\n  given f3668\n  read 1000:0 96 01 02 00\n")
    bus, profile = WIRES["f3668"][2]
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path))
    with Node() as node:
        lines = verify(node, "--junit", tmp_path / "junit.xml", "--report", tmp_path / "report.txt")
    with Node() as node:
        as_json = verify(node, "--json")
    assert lines.returncode == as_json.returncode == 1
    (why,) = re.findall(r'^differs  M2<&>": (.*)$', lines.stdout, re.M)
    assert why == "canopen:6: sent 63F 40 18 10 01 00 00 00 00; expected 5BF 43 18 10 01 13 00 00 00; came 5BF 43 18 10 01 00 00 00 00"
    identity = "device type 00020196h, product 00000000h, revision 0, firmware 0"
    two_things = "the manual contradicts itself; see 'Inaccuracies and choices'"
    total = "3 clauses agree, 1 differ, 1 were not seen\n"
    assert lines.stdout == (f'f3668: {identity}\nagrees   M1\nagrees   C1\ndiffers  M2<&>": {why}\nnot seen M3: {two_things}\n'
                            f"agrees   X1\n{total}")
    assert (tmp_path / "junit.xml").read_text("utf-8") == (
        '<?xml version="1.0" encoding="UTF-8"?>\n<testsuite name="f3668" tests="5" failures="1" skipped="1">\n'
        f'  <testcase classname="{bus}" name="M1"/>\n  <testcase classname="{bus}" name="C1"/>\n'
        f"""  <testcase classname="{bus}" name="{in_xml('M2<&>"')}"><failure message="{why}"/></testcase>\n"""
        f'  <testcase classname="{bus}" name="M3"><skipped message="{two_things}"/></testcase>\n'
        f'  <testcase classname="{profile}" name="X1"/>\n</testsuite>\n')
    version = run("--version").stdout.split()[1]
    assert (tmp_path / "report.txt").read_text("utf-8") == (
        f"Model: f3668\nThe encoder says: {identity}\ndrehgeber: {version}\n\n{total}\nDifferences\n\n"
        f'- canopen M2<&>": differs: {why}\n\nChoices that this encoder settles\n\n- canopen C1: agrees\n')
    assert json.loads(as_json.stdout) == [
        {"suite": suite, "clause": clause, "result": result, "why": text} for suite, clause, result, text in (
            (bus, "M1", "agrees", ""), (bus, "C1", "agrees", ""), (bus, 'M2<&>"', "differs", why),
            (bus, "M3", "not seen", two_things), (profile, "X1", "agrees", ""))]


def test_a_report_of_nothing(tmp_path, monkeypatch):
    write_clauses(tmp_path, "M1 | a clause\n", ROWS)
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path))
    with Node() as node:
        ended = verify(node, "--report", tmp_path / "report.txt")
    assert ended.returncode == 0
    assert (tmp_path / "report.txt").read_text("utf-8").endswith(
        "\nDifferences\n\n- none\n\nChoices that this encoder settles\n\n- none\n")
