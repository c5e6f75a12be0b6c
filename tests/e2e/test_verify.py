# SPDX-License-Identifier: MIT
"""`drehgeber verify`: our own encoders agree with every clause that can be seen and are left as they were; encoders that
are broken on purpose, each in one answer, are found."""
import json
import os
import random
import re
import select
import subprocess
import threading
import time
import tty
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rig import PROGRAM, REPOSITORY, run_refused

LIMIT_S = 60.0
SEED = 20261123
BROKEN = 5
SERIAL = "987654321"
# model: what makes it a wire, and a clause of it that needs nothing; how many clauses agree at least.
WIRES = {
    "s3684-rs485": ("pty", ["--set", "pace=0"], "5.1.2.14-6", 65),
    "f3668": ("slcan", [], "M12-7", 65),
}
SUITES = {"s3684-rs485": ["hiperface"], "f3668": ["canopen", "cia406"]}
MODELS = list(WIRES)


def verify(model: str, path, *arguments, status: int = 0) -> subprocess.CompletedProcess:
    """Ask the encoder at this pseudo-terminal."""
    ended = subprocess.run([PROGRAM, "verify", model, f"--{WIRES[model][0]}={path}", *map(str, arguments)],
                           stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT_S)
    assert ended.returncode == status, (ended.stdout[-2000:], ended.stderr)
    return ended


def quick(model: str) -> list:
    """All clauses but those that take seconds: timeouts of SDO."""
    if model != "f3668":
        return []
    text = "".join((REPOSITORY / f"tests/conformance/{suite}.clauses").read_text("utf-8") for suite in SUITES[model])
    return [clause for clause in re.findall(r"^(\S+) +\|", text, re.M) if not clause.startswith("C27")]


def results(ended: subprocess.CompletedProcess) -> dict:
    """(suite, clause): what became of it, and why."""
    return {(row["suite"], row["clause"]): (row["result"], row["why"]) for row in json.loads(ended.stdout)}


def those(found: dict, result: str) -> set:
    return {clause for clause, (became, _) in found.items() if became == result}


@pytest.fixture
def encoder(start, tmp_path):
    """Run one, behind a link: encoder(model, ...)."""
    def begin(model: str, *arguments):
        wire, settings, *_ = WIRES[model]
        link = tmp_path / f"{model}.link"
        start(*settings, *arguments, model=model, wire=[f"--{wire}={link}"])
        return link
    return begin


class Between(threading.Thread):
    """A wire between the command and an encoder, which alters answers: alter(request, answer) returns what is sent, and
    what it returns None for is lost. Without an encoder it answers alone."""

    def __init__(self, path, alter, ends: bytes = b""):
        super().__init__(daemon=True)
        self.alter, self.ends = alter, ends
        self.near, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.path = os.ttyname(self.slave)
        self.far = os.open(path, os.O_RDWR | os.O_NOCTTY) if path else None
        if self.far is not None:
            tty.setraw(self.far)
        self.stopping = False
        self.request = b""

    def pieces(self, data: bytes) -> list:
        """Lines of an adapter are apart, whatever read() makes of them."""
        if not self.ends:
            return [data]
        return re.findall(b"[^" + self.ends + b"]*[" + self.ends + b"]?", data)[:-1]

    def answer(self, data: bytes):
        for piece in self.pieces(data):
            sent = self.alter(self.request, piece)
            if sent:
                os.write(self.near, sent)

    def run(self):
        fresh = True
        while not self.stopping:
            ready = select.select([self.near] + ([self.far] if self.far is not None else []), [], [], 0.05)[0]
            if self.near in ready:
                data = os.read(self.near, 4096)
                self.request = data if fresh else self.request + data
                fresh = False
                if self.far is None:
                    self.answer(b"")
                else:
                    os.write(self.far, data)
            if self.far in ready:
                data = os.read(self.far, 4096)
                while not self.ends and select.select([self.far], [], [], 0.01)[0]:
                    data += os.read(self.far, 4096)  # the whole of a frame
                self.answer(data)
                fresh = True

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stopping = True
        self.join()
        for end in (self.near, self.slave, self.far):
            if end is not None:
                os.close(end)


# --- our own encoders ---------------------------------------------------------------------------

@pytest.mark.parametrize("model", MODELS)
def test_our_own_agrees_and_stays_as_it_was(encoder, tmp_path, model):
    image = tmp_path / "encoder.nvm"
    link = encoder(model, "--nvm", image, "--serial", SERIAL, "--shaft", "12.3DEG")
    before = image.read_bytes()
    files = [tmp_path / "junit.xml", tmp_path / "report.txt"]
    found = results(verify(model, link, "--json", "--junit", files[0], "--report", files[1]))
    assert those(found, "differs") == set()
    agree = those(found, "agrees")
    assert len(agree) >= WIRES[model][3]
    assert all(why for result, why in found.values() if result == "not seen")
    assert image.read_bytes() == before

    cases = ElementTree.parse(files[0]).getroot()
    passed = {(case.get("classname"), case.get("name")) for case in cases if len(case) == 0}
    assert passed == agree and len(cases) == len(found) == int(cases.get("tests"))
    report = files[1].read_text("utf-8")
    assert f"{len(agree)} clauses agree, 0 differ" in report and model in report
    assert SERIAL not in report
    for suite, clause in agree:
        choice = clause[0] in "RCD" and not clause.startswith("CIA")
        assert (f"- {suite} {clause}: agrees\n" in report) == choice, clause


@pytest.mark.parametrize("model", MODELS)
def test_nothing_is_sent_that_another_device_obeys(encoder, model):
    sent = []

    def listen(request, answer):
        sent.append(request)
        return answer

    with Between(encoder(model), listen, b"\r\a" if model == "f3668" else b"") as wire:
        verify(model, wire.path, "--quiet", *quick(model))
    if model == "f3668":
        frames = {frame for request in sent for frame in request.split(b"\r") if frame[:1] in (b"t", b"r")}
        # SDO uploads, aborts and what no server knows; no downloads; guarding of the one node
        assert all(re.match(b"t63F8([46789ABEF]|5)|r73F", frame) for frame in frames), frames
    else:
        assert all(request[0] == 0x40 for request in sent)
        assert not {request[1] for request in sent if len(request) > 1} & {0x43, 0x47, 0x49, 0x4B, 0x4D, 0x4F, 0x53,
                                                                          0x55, 0x57, 0x6A}
    assert len(sent) > 100


@pytest.mark.parametrize("model", MODELS)
def test_one_clause(encoder, model):
    clause = WIRES[model][2]
    ended = verify(model, encoder(model), clause)
    lines = ended.stdout.splitlines()
    assert f"agrees   {clause}" in lines
    assert all(line.split()[1].startswith(clause) for line in lines[1:-1])
    assert lines[-1].endswith("0 differ, 0 were not seen")


# --- broken on purpose --------------------------------------------------------------------------

def rows_of(model: str) -> list:
    """(suite, clauses, requests) of rows that only ask what does not move; requests as they are sent."""
    rows = []
    for suite in SUITES[model]:
        text = (REPOSITORY / f"tests/conformance/{suite}.rows").read_text("utf-8")
        for ids, body in re.findall(r"^\[([^\]]+)\][^\n]*\n((?:  [^\n]+\n)+)", text, re.M):
            steps = [line.split() for line in body.splitlines()]
            if steps[0] == ["given", model]:
                rows.append((suite, ids.split(), steps[1:]))
    return rows


def last_upload(steps: list):
    """The row's last request as it is sent, if it ends with an upload; else None."""
    if any(verb not in ("read", ">", "<") for verb, *_ in steps) or steps[-1][0] != "read":
        return None
    index, sub = (int(part, 16) for part in steps[-1][1].split(":"))
    return b"t63F840%02X%02X%02X00000000" % (index & 0xFF, index >> 8, sub)


def last_frame(steps: list):
    """The row's last request as it is sent, if its answer is the same wherever the encoder is; else None."""
    if any(verb not in (">", ">+", "<", "<+") for verb, *_ in steps):
        return None
    requests = [step for step in steps if step[0][0] == ">"]
    if not requests:
        return None
    verb, *words = requests[-1]
    if len(words) < 2 or any(not re.fullmatch("[0-9A-F]{2}", word) for word in words) or words[1] in ("42", "44", "46", "50", "56"):
        return None
    request = bytes(int(word, 16) for word in words)
    total = 0
    for byte in request:
        total ^= byte
    return request + bytes([total]) if verb == ">+" else request


LAST = {"s3684-rs485": last_frame, "f3668": last_upload}


def broken(model: str, request: bytes):
    """alter() of an encoder whose answer to this request is another one, in good form."""
    def alter(asked, answer):
        if request not in asked:
            return answer
        if model == "f3668":
            if not answer.startswith(b"t5BF8"):
                return answer
            aborted = answer.startswith(b"t5BF880")
            at, flip = (19, 1) if aborted else (6, 4)
            return answer[:at] + b"%X" % (int(answer[at:at + 1], 16) ^ flip) + answer[at + 1:]
        return answer[:-2] + bytes([answer[-2] ^ 1, answer[-1] ^ 1]) if len(answer) > 3 else answer
    return alter


def drawn(model: str, agree: set) -> list:
    """(suite, clause, request): some of what was seen, by a fixed seed."""
    choices = {}
    for suite, ids, steps in rows_of(model):
        request = LAST[model](steps)
        for clause in ids:
            if request and (suite, clause) in agree:
                choices.setdefault((suite, clause), request)
    assert len(choices) >= 2 * BROKEN
    return [(*key, choices[key]) for key in random.Random(SEED).sample(sorted(choices), BROKEN)]


@pytest.mark.parametrize("model", MODELS)
def test_each_broken_encoder_is_found_and_named(encoder, model):
    link = encoder(model)
    ends = b"\r\a" if model == "f3668" else b""
    agree = those(results(verify(model, link, "--json", *quick(model))), "agrees")
    missed = []
    for suite, clause, request in drawn(model, agree):
        with Between(link, broken(model, request), ends) as wire:
            ended = verify(model, wire.path, clause, "--json", status=1)
        result, why = results(ended).get((suite, clause), ("", ""))
        if result != "differs" or "sent" not in why or "expected" not in why or f"{suite}:" not in why:
            missed.append((suite, clause, request, result, why))
    assert missed == []


# --- devices that behave badly --------------------------------------------------------------------

def test_a_late_answer_is_a_difference(encoder):
    def late(_, answer):
        time.sleep(0.15)
        return answer

    clause = "5.1.2.14-6"  # 52h answers within 5 ms
    with Between(encoder("s3684-rs485"), late) as wire:
        ended = verify("s3684-rs485", wire.path, clause, status=1)
    assert re.search(rf"differs  {re.escape(clause)}: hiperface:\d+: sent 40 52 12; expected an answer within", ended.stdout)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("noise", [b"\x00\xff\x40\x42", b"t5BF8\rt5BF84300\r\a", bytes(range(256)) * 8])
def test_garbage_is_no_encoder(model, noise):
    with Between(None, lambda *_: noise) as wire:
        ended = verify(model, wire.path, status=1)
    assert ended.stdout == "" and ended.stderr.count("\n") == 1 and "answer" in ended.stderr


@pytest.mark.parametrize("model", MODELS)
def test_one_that_dies_is_told_and_ends_it(encoder, model):
    count = [0]

    def die(_, answer):
        count[0] += 1
        return answer if count[0] < 60 else None

    with Between(encoder(model), die, b"\r\a" if model == "f3668" else b"") as wire:
        ended = verify(model, wire.path, *quick(model), status=1)
    assert "it ended early: the encoder was lost in the row" in ended.stdout


# --- refusals -------------------------------------------------------------------------------------

def test_what_is_refused(tmp_path):
    nowhere = tmp_path / "nothing"
    assert "wire" in run_refused(2, "verify", "s3684-rs485")
    assert "model" in run_refused(2, "verify", "--tty=/dev/null")
    assert "s3684-rs485" in run_refused(2, "verify", "s3684-biss", "--gpio=gpiochip0:1,2")
    assert "no clause 9.9" in run_refused(2, "verify", "s3684-rs485", "9.9", f"--tty={nowhere}")
    assert str(nowhere) in run_refused(1, "verify", "s3684-rs485", f"--tty={nowhere}")
    assert "--node" in run_refused(1, "verify", "f3668", f"--slcan={nowhere}", "--node", "200")


def test_the_folder_of_clauses(tmp_path, monkeypatch):
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path / "none"))
    assert "DREHGEBER_CLAUSES" in run_refused(1, "verify", "s3684-rs485", "--tty=/dev/null")
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(Path(REPOSITORY) / "tests/conformance"))
    assert "/dev/null" in run_refused(1, "verify", "s3684-rs485", "--tty=/dev/null")
