# SPDX-License-Identifier: MIT
"""`drehgeber verify` as a master on two GPIO lines: our own encoders agree and are left as they were, with --write, too; encoders
that are broken on purpose are found and named by their clause; hosts that are held up find nothing wrong. The lines are those of
gpiod_double.c, in virtual time; e2e.gpio has the kernel's."""
import json
import os
import re
import signal
import subprocess
from pathlib import Path

import pytest

from rig import PROGRAM, run_refused

DOUBLE = os.environ.get("GPIOD_DOUBLE", "")
LIMIT_S = 120.0
LINES = "--gpio=gpiochip0:4,5"
BISS = ["s3674-biss", "s3684-biss"]
# model: how many clauses agree at least.
MODELS = {"s3674-biss": 110, "s3684-biss": 100, "ssi-13": 18, "ssi-25": 16, "ssi-28": 5}
AGREE_WRITTEN = 140
STORED = 0x66  # of the image: regions begin here, behind the store's journal


@pytest.fixture
def verify(tmp_path):
    """verify(MODEL, ARGUMENT..., status=0, SETTING=VALUE...): ask an encoder that gpiod_double.c makes of these settings."""
    def ask(model: str, *arguments, status: int = 0, **settings) -> subprocess.CompletedProcess:
        double = {"MODEL": model, "IMAGE": tmp_path / "image", "COUNT": 4779, "LOG": tmp_path / "log", **settings}
        environment = {**os.environ, "LD_PRELOAD": DOUBLE, **{f"DOUBLE_{name}": str(value) for name, value in double.items()}}
        ended = subprocess.run([PROGRAM, "verify", model, LINES, *map(str, arguments)], stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, timeout=LIMIT_S, env=environment)
        assert ended.returncode == status, (ended.returncode, ended.stdout[-3000:], ended.stderr)
        return ended

    return ask


@pytest.fixture
def bare(verify, tmp_path):
    """bare(ARGUMENT..., SETTING=VALUE...): ask one with a position, flags and a CRC, and nothing else."""
    text = tmp_path / "bare.ini"
    text.write_text("[model bare]\nbase = s3674-biss\nlc = 0\n")
    return lambda *arguments, **settings: verify(text, *arguments, **{"MODEL": "s3674-biss", "BARE": 1, **settings})


def results(ended) -> dict:
    return {row["clause"]: (row["result"], row["why"]) for row in json.loads(ended.stdout)}


def those(found: dict, result: str) -> set:
    return {clause for clause, (became, _) in found.items() if became == result}


def differing(found: dict) -> dict:
    return {clause: found[clause] for clause in those(found, "differs")}


def counted(folder: Path) -> dict:
    """What the encoder has counted."""
    return {name: int(value) for name, value in map(str.split, (folder / "log").read_text("utf-8").splitlines())}


# --- our own

@pytest.mark.parametrize("model", MODELS)
def test_our_own_agrees_and_stays_as_it_was(verify, tmp_path, model):
    found = results(verify(model, "--json", "--report", tmp_path / "report", "--junit", tmp_path / "junit"))
    assert differing(found) == {}
    assert len(those(found, "agrees")) >= MODELS[model]
    assert all(why for result, why in found.values() if result == "not seen")
    log = counted(tmp_path)
    assert log["frames"] > 20 and (log["writes"], log["commands"], log["stored"]) == (0, 0, 0)
    report = (tmp_path / "report").read_text("utf-8")
    assert "0 differ" in report and "123456789" not in report and "clock" in report


def test_one_clause(verify):
    ended = verify("s3684-biss", "5.2.2-13")
    assert "agrees   5.2.2-13" in ended.stdout.splitlines()
    assert ended.stdout.endswith("1 clauses agree, 0 differ, 0 were not seen\n")


@pytest.mark.parametrize("model, every", [("s3684-biss", 100003), ("ssi-25", 5003)])
def test_a_host_that_is_held_up_finds_nothing_wrong(verify, model, every):
    found = results(verify(model, "--json", STALL=every))
    assert differing(found) == {}
    assert len(those(found, "agrees")) >= MODELS[model]


def test_a_word_that_is_torn_now_and_then_is_no_turn(verify):
    """SSI has no check sum: one of ten words is wrong here."""
    assert "agrees   R-2" in verify("ssi-13", "R-2", FLICKER=307).stdout


@pytest.mark.parametrize("model, clause", [("s3684-biss", "5.2.1.1-4"), ("ssi-13", "L-6")])
def test_lines_that_are_slow_have_a_slow_clock(verify, model, clause):
    """As those of `drehgeber run`: data comes late, and the encoder has a timeout of 20 ms."""
    ended = verify(model, clause, LAG=200000)
    assert re.search(r"clock \d{2,4} Hz", ended.stdout.splitlines()[0]), ended.stdout
    assert f"agrees   {clause}" in ended.stdout.splitlines()


@pytest.mark.parametrize("model, clause", [("s3684-biss", "5.2.1.1-4"), ("ssi-13", "L-6")])
def test_a_slow_host_keeps_the_clock_that_an_encoder_follows(verify, model, clause):
    """Half of it would be too slow for 13 us and for 20 us."""
    ended = verify(model, clause, ACCESS=1700)
    assert re.search(r"clock 6\d{4} Hz", ended.stdout.splitlines()[0]), ended.stdout
    assert f"agrees   {clause}" in ended.stdout.splitlines()


def test_positions_are_where_the_shaft_is(verify):
    """The last turn is next to the first one."""
    for count in (0, 0x1FFFFFFFF, 0x12345678):
        found = results(verify("s3684-biss", "--json", "5.2.1.2", "G-61", COUNT=count))
        assert differing(found) == {} and found["5.2.1.2-18"][0] == "agrees"


def test_one_without_registers_agrees_with_what_is_about_frames(bare):
    found = results(bare("--json", "--alone"))
    assert differing(found) == {}
    assert {"5.2.1.1-4", "5.2.1.1-8", "5.2.1.2-16", "5.2.1.2-18", "L-1"} <= those(found, "agrees")
    assert re.match(r"bare: no registers, clock \d+ Hz$", bare("L-1").stdout.splitlines()[0])


# --- broken on purpose

BROKEN = {  # model, what is spoiled: the clause that says otherwise, what is told of it
    ("s3684-biss", "crc"): ("5.2.1.2-17", r"sent CDM [01]+; expected CDS [01]+, .*; came CDS [01]+, .*and \d+ frames with wrong CRC"),
    ("s3674-biss", "register"): ("5.2.1.3-11", r"sent read ID 0 register 79h, 1 bytes; expected 00, .*; came 01, "),
    ("ssi-13", "again"): ("R-1", r"sent 28 pulses; expected data [01]{28}; came [01]{28}"),
}


@pytest.mark.parametrize("broken", BROKEN, ids="/".join)
def test_each_broken_encoder_is_found_and_named(verify, broken):
    (model, spoil), (clause, told) = broken, BROKEN[broken]
    ended = verify(model, clause, status=1, SPOIL=spoil)
    (why,) = re.findall(rf"^differs  {re.escape(clause)}: (.*)$", ended.stdout, re.M)
    assert re.search(told, why), why
    assert f"agrees   {clause}" in verify(model, clause).stdout


@pytest.mark.parametrize("count", [4779, 0x1FFFFF])
def test_one_that_takes_the_return_of_ma_for_e1_is_named_and_asked_further(bare, count):
    """As the slave of PandABlocks does (docs/verify.md). A position with ones keeps SL high while the encoder is inside a frame."""
    told = bare("5.2.1.1", "L-1", status=1, SPOIL="return", COUNT=count).stdout
    (why,) = re.findall(r"^differs  (.*)$", told, re.M)
    assert re.search(r"^L-1: .*: sent CDM 10110; expected CDS 00000, .*; came CDS 00000, .*, and \d+ frames with no Ack", why), why
    assert "it ended early" not in told


def test_one_that_needs_a_clock_that_is_high_is_given_it(verify):
    """As the SSI slave of PandABlocks does."""
    ended = verify("ssi-13", SPOIL="link")
    assert "it ended early" not in ended.stdout and "agrees   I-1" in ended.stdout


def test_one_that_reports_an_error_is_told_so(verify):
    first = verify("s3674-biss", "5.2.1.1-4", status=1, SPOIL="error").stdout.splitlines()[0]
    assert re.search(r"clock \d+ Hz, reports an error$", first), first


def test_one_that_dies_is_told_and_ends_it(verify):
    ended = verify("s3684-biss", status=1, DEAF=60000)
    assert "it ended early: the encoder stopped answering in the row" in ended.stdout


# --- writing

@pytest.fixture
def relay(tmp_path):
    """Cuts the supply."""
    program = tmp_path / "relay"
    program.write_text(f"#!/bin/sh\necho $1 >>{tmp_path}/switched\n"
                       f"if [ $1 = off ]; then : >{tmp_path}/unpowered; else rm -f {tmp_path}/unpowered; fi\n")
    program.chmod(0o755)
    return program


def image_of(folder: Path) -> bytes:
    return (folder / "image").read_bytes()[STORED:]


@pytest.mark.parametrize("model", BISS)
def test_everything_that_is_written_is_put_back(verify, relay, tmp_path, model):
    verify(model, "M-5")
    before = image_of(tmp_path)
    ended = verify(model, "--json", "--write", "--power", relay, "--journal", tmp_path / "journal", UNPOWERED=tmp_path / "unpowered")
    found = results(ended)
    assert differing(found) == {}
    assert len(those(found, "agrees")) >= AGREE_WRITTEN
    assert "bank 0" in ended.stderr and (tmp_path / "journal").read_bytes() == b""
    log = counted(tmp_path)
    assert log["writes"] > 100 and log["stored"] > 10 and log["commands"] == 0
    assert image_of(tmp_path) == before
    switched = (tmp_path / "switched").read_text("utf-8").split()
    assert switched and switched == ["off", "on"] * (len(switched) // 2)


def test_commands_need_an_encoder_that_is_alone(verify, tmp_path):
    arguments = ["N", "--json", "--write", "--journal", tmp_path / "journal"]
    assert those(results(verify("s3684-biss", *arguments)), "agrees") == set()
    found = results(verify("s3684-biss", *arguments, "--alone"))
    assert differing(found) == {} and {"N-9", "N-10", "N-11", "N-12"} <= those(found, "agrees")
    assert counted(tmp_path)["commands"] > 4


def test_a_run_that_was_killed_is_restored(verify, tmp_path):
    verify("s3684-biss", "M-5")
    before, journal = image_of(tmp_path), tmp_path / "journal"
    arguments = ["G-user", "--write", "--journal", journal]
    verify("s3684-biss", *arguments, status=-signal.SIGKILL, DIE=8)
    assert image_of(tmp_path) != before and journal.read_bytes() != b""
    assert "expected --restore" in verify("s3684-biss", *arguments, status=1).stderr
    assert verify("s3684-biss", "--restore", "--journal", journal).stdout == "the encoder is as it was\n"
    assert image_of(tmp_path) == before and journal.read_bytes() == b""


# --- refusals

@pytest.mark.parametrize("model", ["s3684-biss", "ssi-25"])
def test_nobody_there(verify, model):
    ended = verify(model, status=1, DEAF=1)
    assert ended.stdout == "" and ended.stderr.startswith("drehgeber: gpiochip0:4,5: no ") and ended.stderr.count("\n") == 1


@pytest.mark.parametrize("model", ["s3684-biss", "ssi-25"])
def test_a_shaft_that_turns(verify, model):
    assert "the shaft turns" in verify(model, status=1, RPM=3000).stderr


def test_what_is_refused():
    assert "only reads" in run_refused(2, "verify", "ssi-25", LINES, "--write")
    assert "no clause 9.9" in run_refused(2, "verify", "s3684-biss", LINES, "9.9")
    assert "--gpio=gpiochip0:4,5" in run_refused(2, "verify", "s3684-biss", "--sim")
    assert "--gpio=CHIP:MA,SLO" in run_refused(1, "verify", "s3684-biss", "--silkit=silkit://127.0.0.1:8500,a")
    assert "CHIP:CLOCK,DATA" in run_refused(1, "verify", "ssi-25", "--gpio=gpiochip0")
    assert "no /dev/gpiochip77" in run_refused(1, "verify", "s3684-biss", "--gpio=gpiochip77:4,5")
