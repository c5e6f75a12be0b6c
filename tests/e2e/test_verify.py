# SPDX-License-Identifier: MIT
"""`drehgeber verify`: our own encoders agree with every clause that can be seen and are left as they were; encoders that
are broken on purpose, each in one answer, are found."""
import itertools
import random
import re
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rig import REPOSITORY, run_refused
from verified import MODELS, SERIAL, WIRES, Babbling, Between, Crowd, clauses, results, those, verify

SEED = 20261123
BROKEN = 5
# model: a clause that needs nothing; how many agree at least; beginnings of clauses that take as long as all others.
KNOWN = {
    "s3684-rs485": ("5.1.2.14-6", 65, []),
    "f3668": ("M12-7", 65, ["C27"]),
}


def parts(model: str) -> list:
    """Clauses by how they are asked at a time; without a word it is all of them."""
    slow = KNOWN[model][2]
    return [[clause for clause in clauses(model) if not clause.startswith(tuple(slow))], slow] if slow else [[]]


@pytest.fixture(scope="module")
def crowd():
    crowd = Crowd()
    yield crowd
    assert crowd.end() == []


@pytest.fixture(scope="module", autouse=True)
def asked(crowd):
    """Every clause is asked while the tests run that do not need the answers: [(model, folder, image before, result)]."""
    def ask(model, folder, before, words):
        return model, folder, before, verify(model, folder / "link", "--json", "--junit", folder / "junit.xml", "--report",
                                             folder / "report.txt", *words)

    running = []
    for model in MODELS:
        for words in parts(model):
            folder = crowd.begin(f"asked{len(running)}", model)
            running.append(crowd.pool.submit(ask, model, folder, (folder / "image").read_bytes(), words))
    return running


@pytest.fixture(scope="module", autouse=True)
def heard(crowd):
    """model: what is sent to an encoder, likewise."""
    def listen(model, link):
        sent = []
        with Between(link, ends=WIRES[model][3], hear=lambda request: sent.append(request) or True) as wire:
            verify(model, wire.path, "--quiet", *parts(model)[0])
        return sent

    return {model: crowd.pool.submit(listen, model, crowd.begin(f"heard.{model}", model) / "link") for model in MODELS}


@pytest.fixture
def encoder(crowd, request):
    """Run one, and return its wire: encoder(model)."""
    def begin(model: str):
        name = re.sub(r"\W", "_", request.node.name) + f".{len(crowd.running)}"
        return crowd.begin(name, model) / "link"
    return begin


def agree(asked, model: str) -> set:
    return set().union(*(those(results(one.result()[3]), "agrees") for one in asked if one.result()[0] == model))


@pytest.mark.parametrize("model", MODELS)
def test_one_clause(encoder, model):
    clause = KNOWN[model][0]
    ended = verify(model, encoder(model), clause)
    lines = ended.stdout.splitlines()
    assert f"agrees   {clause}" in lines
    assert all(line.split()[1].startswith(clause) for line in lines[1:-1])
    assert lines[-1].endswith("0 differ, 0 were not seen")


# --- devices that behave badly --------------------------------------------------------------------

def test_a_late_answer_is_a_difference(encoder):
    def late(request, answer):
        time.sleep(0.15 if request == b"\x40\x52\x12" else 0)
        return answer

    clause = "5.1.2.14-6"  # 52h answers within 5 ms
    with Between(encoder("s3684-rs485"), late) as wire:
        ended = verify("s3684-rs485", wire.path, clause, status=1)
    assert re.search(rf"differs  {re.escape(clause)}: hiperface:\d+: sent 40 52 12; expected an answer within", ended.stdout)


def test_a_late_upload_is_a_difference_and_answers_nothing_else(encoder):
    def late(request, answer):
        time.sleep(1.3 if b"t63F840181001" in request else 0)
        return answer

    with Between(encoder("f3668"), late, WIRES["f3668"][3]) as wire:
        ended = verify("f3668", wire.path, "M12-8", "M3-1", status=1)
    (why,) = re.findall("^differs  (.*)$", ended.stdout, re.M)
    assert re.fullmatch(r"M12-8: canopen:\d+: sent 63F 40 18 10 01( 00){4}; expected 5BF 43 18 10 01 13( 00){3}; came nothing", why)
    assert "\nagrees   M3-1\n" in ended.stdout and "ended early" not in ended.stdout


def test_garbage_is_no_encoder(crowd):
    def ask(model, noise):
        with Between(None, lambda *_: noise) as wire:
            ended = verify(model, wire.path, status=1)
        return ended.stdout == "" and ended.stderr.count("\n") == 1 and "answer" in ended.stderr

    noises = [b"\x00\xff\x40\x42", b"t5BF8\rt5BF84300\r\a", bytes(range(256)) * 8]
    running = [crowd.pool.submit(ask, model, noise) for model in MODELS for noise in noises]
    assert all(one.result() for one in running)


def test_one_that_dies_is_told_and_ends_it(crowd, encoder):
    def ask(model, link):
        count = itertools.count()
        with Between(link, lambda _, answer: answer if next(count) < 60 else None, WIRES[model][3]) as wire:
            return verify(model, wire.path, *parts(model)[0], status=1).stdout

    running = [crowd.pool.submit(ask, model, encoder(model)) for model in MODELS]
    assert all("it ended early: the encoder stopped answering in the row" in one.result() for one in running)


NOISE = {"s3684-rs485": bytes(range(64)), "f3668": b"t1010\r" * 10}


def test_one_that_never_stops_is_told_and_ends_it(crowd, encoder):
    def ask(model, link, answers):
        with Babbling(link, answers, NOISE[model], WIRES[model][3]) as wire:
            return verify(model, wire.path, *parts(model)[0], status=1)

    for answers in 0, 60:
        running = [crowd.pool.submit(ask, model, encoder(model), answers) for model in MODELS]
        for ended in (one.result() for one in running):
            if answers == 0:
                assert ended.stdout == "" and ended.stderr.count("\n") == 1 and "answer" in ended.stderr
            else:
                assert "it ended early: the encoder stopped answering in the row" in ended.stdout


# --- refusals -------------------------------------------------------------------------------------

def test_what_is_refused(tmp_path):
    nowhere = tmp_path / "nothing"
    assert "wire" in run_refused(2, "verify", "s3684-rs485")
    assert "model" in run_refused(2, "verify", "--tty=/dev/null")
    assert "--gpio CHIP:CLOCK,DATA" in run_refused(2, "verify", "s3684-biss", "--tty=/dev/null")
    assert "no clause 9.9" in run_refused(2, "verify", "s3684-rs485", "9.9", f"--tty={nowhere}")
    assert str(nowhere) in run_refused(1, "verify", "s3684-rs485", f"--tty={nowhere}")
    assert "--node" in run_refused(1, "verify", "f3668", f"--slcan={nowhere}", "--node", "200")


def test_the_folder_of_clauses(tmp_path, monkeypatch):
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(tmp_path / "none"))
    assert "DREHGEBER_CLAUSES" in run_refused(1, "verify", "s3684-rs485", "--tty=/dev/null")
    monkeypatch.setenv("DREHGEBER_CLAUSES", str(Path(REPOSITORY) / "tests/conformance"))
    assert "/dev/null" in run_refused(1, "verify", "s3684-rs485", "--tty=/dev/null")


# --- our own encoders ---------------------------------------------------------------------------

def obeyed_by_nobody_else(model: str, sent: list) -> bool:
    if model == "f3668":
        frames = {frame for request in sent for frame in request.split(b"\r") if frame[:1] in (b"t", b"r")}
        # SDO uploads, aborts and what no server knows; no downloads; guarding of the one node
        return all(re.match(b"t63F8([46789ABEF]|5)|r73F", frame) for frame in frames)
    writes = {0x43, 0x47, 0x49, 0x4B, 0x4D, 0x4F, 0x53, 0x55, 0x57, 0x6A}
    return all(request[0] == 0x40 for request in sent) and not {request[1] for request in sent if len(request) > 1} & writes


def test_nothing_is_sent_that_another_device_obeys(heard):
    for model, one in heard.items():
        assert len(one.result()) > 100 and obeyed_by_nobody_else(model, one.result()), model


def test_our_own_agrees_and_stays_as_it_was(asked):
    for model, folder, before, ended in (one.result() for one in asked):
        found = results(ended)
        assert those(found, "differs") == set()
        assert all(why for result, why in found.values() if result == "not seen")
        assert (folder / "image").read_bytes() == before
        agrees = those(found, "agrees")
        cases = ElementTree.parse(folder / "junit.xml").getroot()
        passed = {(case.get("classname"), case.get("name")) for case in cases if len(case) == 0}
        assert passed == agrees and len(cases) == len(found) == int(cases.get("tests"))
        report = (folder / "report.txt").read_text("utf-8")
        assert f"{len(agrees)} clauses agree, 0 differ" in report and model in report
        assert SERIAL not in report
        for suite, clause in agrees:
            choice = clause[0] in "RCD" and not clause.startswith("CIA")
            assert (f"- {suite} {clause}: agrees\n" in report) == choice, clause
    for model in MODELS:
        assert len(agree(asked, model)) >= KNOWN[model][1]


# --- broken on purpose --------------------------------------------------------------------------

def rows_of(model: str) -> list:
    """(suite, clauses, requests) of rows that only ask what does not move; requests as they are sent."""
    rows = []
    for suite in WIRES[model][2]:
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


def drawn(model: str, agrees: set) -> list:
    """(suite, clause, request): some of what was seen, by a fixed seed."""
    choices = {}
    for suite, ids, steps in rows_of(model):
        request = LAST[model](steps)
        for clause in ids:
            if request and (suite, clause) in agrees:
                choices.setdefault((suite, clause), request)
    assert len(choices) >= 2 * BROKEN
    return [(*key, choices[key]) for key in random.Random(SEED).sample(sorted(choices), BROKEN)]


@pytest.mark.parametrize("model", MODELS)
def test_each_broken_encoder_is_found_and_named(crowd, encoder, asked, model):
    def ask(link, suite, clause, request):
        with Between(link, broken(model, request), WIRES[model][3]) as wire:
            ended = verify(model, wire.path, clause, "--json", status=1)
        result, why = results(ended).get((suite, clause), ("", ""))
        found = result == "differs" and "sent" in why and "expected" in why and f"{suite}:" in why
        return None if found else (suite, clause, request, result, why)

    running = [crowd.pool.submit(ask, encoder(model), *one) for one in drawn(model, agree(asked, model))]
    assert [one.result() for one in running] == [None] * BROKEN
