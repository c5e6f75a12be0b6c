# SPDX-License-Identifier: MIT
"""`drehgeber verify --write`: what was changed when the command was killed is put back by --restore; what cannot be put back is
not done; the supply is cut by a program or by the user."""
import fcntl
import functools
import os
import pty
import random
import re
import subprocess

import pytest

from rig import run, run_refused
from verified import LIMIT_S, MODELS, WIRES, Between, Crowd, Killer, command, cut, results, state, strange_lines, verify

SEED = 20261123
HIPERFACE_WRITES = {0x43, 0x47, 0x49, 0x4D, 0x4F, 0x55, 0x57}


@pytest.fixture(scope="module")
def crowd():
    crowd = Crowd()
    yield crowd
    assert strange_lines(crowd.end()) == []


def is_write(model: str, request: bytes) -> bool:
    if model == "f3668":
        return any(line[:5] == b"t63F8" and line[5:6] in b"23CD" for line in request.split(b"\r"))
    return len(request) > 1 and request[1] in HIPERFACE_WRITES


# --- killed ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("model", MODELS)
def test_a_killed_run_is_restored(crowd, model):
    def ask(folder, words, at, before):
        was = state(model, folder)
        options = ["--write", "--journal", folder / "journal"]
        killer = Killer(at, before, functools.partial(is_write, model))
        with Between(folder / "link", ends=WIRES[model][3], hear=killer.hear) as wire:
            killer.process = subprocess.Popen(command(model, wire.path, *options, *words), stdin=subprocess.DEVNULL,
                                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            killer.process.communicate(timeout=LIMIT_S)
        if killer.left > 0:
            return 0  # it has fewer writes
        assert killer.process.returncode == -9
        assert (folder / "journal").read_bytes().startswith(b"of " + model.encode() + b"\n")
        refused = verify(model, folder / "link", *options, status=1)
        assert refused.stdout == "" and refused.stderr.count("\n") == 1 and "expected --restore" in refused.stderr
        restored = verify(model, folder / "link", "--restore", "--journal", folder / "journal")
        assert restored.stdout == "the encoder is as it was\n" and (folder / "journal").read_bytes() == b""
        assert state(model, folder) == was
        return 1

    draw = random.Random(SEED)
    running = [crowd.pool.submit(ask, crowd.begin(f"kill.{model}.{part}", model), words, draw.randint(1, 6), part % 2 == 0)
               for part, words in enumerate(cut(model))]
    assert sum(one.result() for one in running) >= 3


class Dying:
    """It obeys one write, and nothing behind it."""

    def __init__(self, model: str):
        self.model, self.dead = model, False

    def hear(self, request: bytes) -> bool:
        if self.dead:
            return False
        self.dead = is_write(self.model, request)
        return True

    def alter(self, _, answer: bytes):
        return None if self.dead else answer


CHANGES = {"s3684-rs485": "5.1.2.2-9", "f3668": "M26-18"}  # model: a clause that changes one value


@pytest.mark.parametrize("model", MODELS)
def test_one_that_dies_changed_is_restored_later(crowd, model):
    folder = crowd.begin(f"dies.{model}", model)
    before, journal, dying = state(model, folder), folder / "journal", Dying(model)
    arguments = [CHANGES[model], "--write", "--journal", journal]
    with Between(folder / "link", dying.alter, WIRES[model][3], dying.hear) as wire:
        ended = verify(model, wire.path, *arguments, status=1)
    assert "does not have its old values" in ended.stdout and "--restore" in ended.stdout
    assert journal.read_bytes().startswith(b"of " + model.encode() + b"\nb ") and state(model, folder) != before
    assert "expected --restore" in verify(model, folder / "link", *arguments, status=1).stderr
    (another,) = set(MODELS) - {model}
    other = verify(another, folder / "link", "--restore", "--journal", journal, status=1)
    assert f"not of a {another}" in other.stderr
    restored = verify(model, folder / "link", "--restore", "--journal", journal)
    assert restored.stdout == "the encoder is as it was\n" and state(model, folder) == before
    again = verify(model, folder / "link", "--restore", "--journal", journal)
    assert again.stdout == "nothing is left to put back\n"


def test_one_whose_answer_from_its_new_address_is_lost_is_found_there(crowd):
    folder = crowd.begin("moved", "s3684-rs485")
    before, lost = state("s3684-rs485", folder), []

    def lose(request, answer):
        if not lost and answer[1:2] == b"\x55":
            lost.append(answer)
            return None
        return answer

    with Between(folder / "link", lose) as wire:
        ended = verify("s3684-rs485", wire.path, "5.1.2.16-7", "--json", "--write", "--journal", folder / "journal")
    assert lost and results(ended)[WIRES["s3684-rs485"][2][0], "5.1.2.16-7"] == ("agrees", "")
    assert state("s3684-rs485", folder) == before


# --- what CiA 301 leaves to a node ----------------------------------------------------------------

def agree(crowd, name: str, clause: str, **options) -> bool:
    """Whether the clause agrees when the encoder is seen through this wire."""
    folder = crowd.begin(name, "f3668")
    with Between(folder / "link", ends=WIRES["f3668"][3], **options) as wire:
        found = results(verify("f3668", wire.path, clause, "--json", "--write", "--journal", folder / "journal"))
    return any(at == clause and became == ("agrees", "") for (_, at), became in found.items())


def test_a_block_may_have_any_size(crowd):
    changed = []

    def enlarge(_, answer):
        other = re.sub(rb"t5BF8(A4......|A201)05", rb"t5BF8\g<1>7F", answer)
        changed.extend([other] if other != answer else [])
        return other

    assert agree(crowd, "blocks", "CIA-2-37", alter=enlarge) and len(changed) >= 2


def test_frames_of_one_moment_come_in_any_order(crowd):
    """The first heartbeat and the answer that begins it."""
    held, swapped = [], []

    def swap(request, answer):
        if b"t63F82B1710001027" in request and answer[:4] == b"t73F":
            held.append(answer)
            return None
        if held and answer[:4] == b"t5BF":
            swapped.append(held.pop())
            return answer + swapped[0]
        return answer

    assert agree(crowd, "order", "C13-2", alter=swap) and swapped


def test_no_upload_is_left_open(crowd):
    """What is longer than four bytes is not noted, and its upload is ended."""
    sent = []
    assert agree(crowd, "open", "M19-8", hear=lambda request: sent.extend(filter(None, request.split(b"\r"))) or True)
    behind = [sent[at + 1][:7] for at, line in enumerate(sent) if line.startswith(b"t63F840081000")]
    assert behind == [b"t63F860", b"t63F880"]  # of the row that reads its segments; before the row that writes


def test_what_is_measured_may_be_something_else_then(crowd):
    """A row writes objects that cannot be written: one of them is a speed."""
    written = []

    def turn(request, answer):
        written.extend([request] if b"t63F823612100" in request else [])
        return answer[:13] + b"07000000\r" if written and answer.startswith(b"t5BF843612100") else answer

    assert agree(crowd, "measured", "M19-16", alter=turn) and written


# --- the journal ----------------------------------------------------------------------------------

HEAD, NOTE = "of s3684-rs485\n", "b 000 42 00 27 25 51 .\n"
LEFT = "an earlier run has left an encoder changed; expected --restore, which puts back the old values"
JOURNALS = {
    "a note": (HEAD + NOTE, ["--write"], LEFT),
    "as many as fit": (HEAD + NOTE * 5000, ["--write"], LEFT),
    "another model": ("of f3668\n" + NOTE, ["--restore"], "not of a s3684-rs485; expected the model of the interrupted run"),
    "a note that is torn": (HEAD + NOTE[:-2], ["--write"], None),
    "a note that is too long": (HEAD + "b 000" + " 00" * 4000 + " .\n", ["--write"], None),
    "other lines": (HEAD + "\nx 000 42 .\nb\n", ["--restore"], None),
}


@pytest.mark.parametrize("text, options, refusal", JOURNALS.values(), ids=JOURNALS)
def test_a_journal_is_read_first(tmp_path, text, options, refusal):
    journal = tmp_path / "journal"
    journal.write_text(text)
    ended = run("verify", "s3684-rs485", "--tty=/dev/null", *options, "--journal", str(journal))
    complaint = ended.stderr.splitlines()[-1]
    assert (ended.returncode, ended.stdout) == (1, "")
    if refusal is None:  # then it is the wire that is missing
        assert complaint.startswith("drehgeber: /dev/null: "), complaint
    else:
        assert complaint == f"drehgeber: {journal}: {refusal}"
    assert journal.read_text() == text


@pytest.mark.parametrize("places, folder", [({"XDG_STATE_HOME": "state", "HOME": "home"}, "state"),
                                            ({"HOME": "home"}, "home/.local/state")])
def test_where_the_journal_is(tmp_path, monkeypatch, places, folder):
    (tmp_path / "home").mkdir()
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    for name, place in places.items():
        monkeypatch.setenv(name, str(tmp_path / place))
    ended = run("verify", "s3684-rs485", "--tty=/dev/null", "--write")
    journal = tmp_path / folder / "drehgeber/verify.journal"
    assert ended.stderr.splitlines()[0].endswith(f"; journal: {journal}") and journal.read_bytes() == b""


def test_a_journal_without_a_place(tmp_path, monkeypatch):
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.delenv("HOME", raising=False)
    arguments = ["verify", "s3684-rs485", "--tty=/dev/null", "--write"]
    assert run_refused(1, *arguments) == "drehgeber: no folder for the journal; expected --journal=FILE"
    path = tmp_path / "missing/journal"
    assert run_refused(1, *arguments, "--journal", str(path)) == f"drehgeber: {path}: No such file or directory"


def test_two_runs_need_two_journals(tmp_path):
    journal = tmp_path / "journal"
    with journal.open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        said = run_refused(1, "verify", "s3684-rs485", "--tty=/dev/null", "--write", "--journal", str(journal))
    assert said == f"drehgeber: {journal}: another run uses it; expected another --journal for another encoder"


# --- what is allowed ------------------------------------------------------------------------------

def test_what_cannot_be_undone_needs_more(crowd):
    folder = crowd.begin("one_way", "f3668")
    ended = verify("f3668", folder / "link", "--write", "--journal", folder / "journal", "--json", "M8-3")
    found = results(ended).values()
    assert any(result == "not seen" and "(--irreversible)" in why for result, why in found)


@pytest.mark.parametrize("option", [["--journal", "x"], ["--irreversible"]])
def test_without_write_nothing_is_changed(tmp_path, option, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "--write" in run_refused(2, "verify", "s3684-rs485", "--tty=/dev/null", *option)
    assert list(tmp_path.iterdir()) == []


# --- the supply -----------------------------------------------------------------------------------

NEEDS_POWER = "5.1.2.19-1"


def test_a_relay_that_fails_is_told(crowd):
    folder = crowd.begin("relay", "s3684-rs485")
    ended = verify("s3684-rs485", folder / "link", "--write", "--journal", folder / "journal", "--power", "false", NEEDS_POWER,
                   status=1)
    assert "'false off' has failed" in ended.stdout


@pytest.mark.parametrize("willing", [True, False])
def test_the_user_is_asked_on_a_terminal(crowd, willing):
    folder = crowd.begin(f"user.{willing}", "s3684-rs485")
    near, far = pty.openpty()
    words = [NEEDS_POWER, "--write", "--journal", folder / "journal"]
    process = subprocess.Popen(command("s3684-rs485", folder / "link", *words),
                               stdin=far, stderr=far, stdout=subprocess.PIPE, text=True)
    os.close(far)
    said, questions = b"", 0
    while process.poll() is None and questions < 20:
        try:
            said += os.read(near, 4096)
        except OSError:
            break  # it has ended
        if b"press Enter. " in said:
            questions += 1
            if willing:
                subprocess.run([folder / "relay", "on" if b"encoder on" in said else "off"], check=True)
            os.write(near, b"\n" if willing else b"n\n")
            said = b""
    out = process.communicate(timeout=LIMIT_S)[0]
    os.close(near)
    assert process.returncode == 0
    if willing:
        assert f"agrees   {NEEDS_POWER}" in out and questions >= 2 and questions % 2 == 0
    else:
        assert f"not seen {NEEDS_POWER}: " in out and "not switched" in out and questions == 1
