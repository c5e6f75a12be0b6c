# SPDX-License-Identifier: MIT
"""`drehgeber verify --silkit`: our own encoders in a simulation agree with the clauses with which they agree on a wire, and
are as they were; a simulation in which nobody can be asked is said in one line."""
import contextlib
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from rig import PROGRAM, Encoder, end_process, run, run_refused
from simulation import HERE, LIBRARY, PATIENCE_S
from verified import WIRES, results, strange_lines, those

LIMIT_S = 120.0
ENDED = "drehgeber: SIL Kit: the simulation has ended"
NOBODY = "silkit://127.0.0.1:9"  # discard: nobody listens there
WITH_LIBRARY = {**os.environ, "DREHGEBER_SILKIT_LIBRARY": str(LIBRARY)}
TIMES = ["coordinated", "autonomous", "real"]
CLAUSE = {"f3668": "M12-7", "s3684-rs485": "5.1.2.14-6"}  # a constant, and nothing else
# In real time, the clauses of these take as long as all others.
SLOW = {"f3668": ["C27"], "s3684-rs485": []}


@contextlib.contextmanager
def controller(registry, *names):
    """What begins a coordinated simulation of these."""
    process = subprocess.Popen([HERE / "bin/sil-kit-system-controller", "-u", registry.uri, *names],
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        end_process(process)


def command(registry, model, *arguments):
    return [PROGRAM, "verify", model, f"--silkit={registry.uri},WIRE1", *map(str, arguments)]


def verify(registry, model, *arguments, status=0):
    ended = subprocess.run(command(registry, model, *arguments), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                           timeout=LIMIT_S, env=WITH_LIBRARY)
    assert ended.returncode == status, (ended.stdout[-2000:], ended.stderr)
    return ended


@pytest.fixture
def bench(registry, rig):
    """bench(model, ...): run it as the participant `bench`."""
    def begin(model, *arguments, how="coordinated"):
        program = rig(model, f"--silkit={registry.uri},WIRE1,bench", "--shaft", "12.3DEG", "--set", f"time={how}", *arguments)
        program.ready()
        return program

    return begin


def ask_both(registry, bench, folder, model, *arguments):
    """What becomes of all clauses that are not slow, in a simulation and on a wire of this machine."""
    with controller(registry, "bench", "verify"):
        program = bench(model)
        there = results(verify(registry, model, "--json", *arguments))
        assert program.wait() == 0 and program.errors.so_far()[-1] == ENDED
    wire, settings, *_ = WIRES[model]
    encoder = Encoder([model, f"--{wire}={folder}/link", *settings, "--shaft", "12.3DEG"])
    words = [clause for _, clause in there if not clause.startswith(tuple(SLOW[model]) or "?")]
    ended = subprocess.run([PROGRAM, "verify", model, f"--{wire}={folder}/link", "--json", *arguments, *words],
                           stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT_S)
    encoder.clean_up()
    return there, {key: row for key, row in results(ended).items() if key[1] in words}


@pytest.mark.parametrize("model", WIRES)
def test_what_agrees_on_a_wire_agrees_there(registry, bench, tmp_path, model):
    there, here = ask_both(registry, bench, tmp_path, model)
    assert those(there, "differs") == those(here, "differs") == set()
    assert {key: there[key] for key in here} == here
    assert len(those(there, "agrees")) >= 70


# Without a file: an encoder acknowledges a write when it is on the disk, and virtual time does not wait for that.
@pytest.mark.parametrize("model, words, agree", [("f3668", [], 250), ("s3684-rs485", ["5.1.3", "5.1.4"], 30)])
def test_everything_that_is_written_is_put_back(registry, bench, tmp_path, model, words, agree):
    journal = tmp_path / "journal"
    with controller(registry, "bench", "verify"):
        program = bench(model)
        found = results(verify(registry, model, "--json", "--write", "--alone", "--journal", journal, *words))
        assert program.wait() == 0
    assert those(found, "differs") == set() and len(those(found, "agrees")) >= agree
    assert journal.read_bytes() == b""
    assert strange_lines(program.errors.so_far()) == [ENDED]


def test_a_device_and_its_eds_file(registry, bench, tmp_path):
    path = tmp_path / "vendor.eds"
    path.write_text(run("eds", "f3668").stdout)
    with controller(registry, "bench", "verify"):
        program = bench(path)
        ended = verify(registry, path)
        assert program.wait() == 0
    assert ", 0 differ, " in ended.stdout and "\nagrees   1018:1-value\n" in ended.stdout, ended.stdout


@pytest.mark.parametrize("model", WIRES)
@pytest.mark.parametrize("how", ["autonomous", "real"])
def test_other_times(registry, bench, model, how):
    program = bench(model, how=how)
    ended = verify(registry, model, CLAUSE[model], "--set", f"time={how}", "--quiet")
    assert f"\nagrees   {CLAUSE[model]}\n" in ended.stdout and ended.stderr == ""
    assert program.end() == 0


def test_a_supply_that_is_cut(registry, bench, tmp_path):
    """The program of the relay runs while time stands still."""
    control, relay = f"unix:{tmp_path}/ctl", tmp_path / "relay"
    relay.write_text(f"#!/bin/sh\necho $1 >>{tmp_path}/switched\n"
                     f"exec {PROGRAM} ctl --control {control} \"POWer $1\" >/dev/null\n")
    relay.chmod(0o755)
    with controller(registry, "bench", "verify"):
        program = bench("f3668", "--control", control)
        found = results(verify(registry, "f3668", "--json", "--write", "--power", relay, "--journal", tmp_path / "journal"))
        assert program.wait() == 0
    assert those(found, "differs") == set() and len(those(found, "agrees")) >= 180
    switched = (tmp_path / "switched").read_text().split()
    assert switched and switched == ["off", "on"] * (len(switched) // 2)


# --- what cannot be

def refused(*arguments, status=1, env=None):
    return run_refused(status, "verify", *arguments, env=WITH_LIBRARY if env is None else env)


def test_no_library_and_no_registry():
    without = {name: value for name, value in os.environ.items() if name != "DREHGEBER_SILKIT_LIBRARY"}
    assert "no SIL Kit library: libSilKit.so: " in refused("f3668", f"--silkit={NOBODY},CAN1", env=without)
    assert refused("f3668", f"--silkit={NOBODY},CAN1").endswith("; start a registry there, e.g. sil-kit-registry")


@pytest.mark.parametrize("where", ["x", "silkit://h:1", "silkit://h:0,N", "silkit://h:1,N/M", "silkit://h:1,N,A,B"])
def test_what_is_no_address(where):
    assert refused("f3668", f"--silkit={where}").startswith(f"drehgeber: --silkit {where}: expected silkit://HOST:PORT,NETWORK")


@pytest.mark.parametrize("arguments, status, said", [
    (["s3684-biss", f"--silkit={NOBODY},N"], 1, "verify cannot use --silkit; expected --gpio=CHIP:MA,SLO"),
    (["ssi-25", f"--silkit={NOBODY},N"], 1, "verify cannot use --silkit; expected --gpio=CHIP:CLOCK,DATA"),
    (["ocd-ib-k3", f"--silkit={NOBODY},N"], 1, "verify cannot use --silkit; expected --modbus=HOST:PORT"),
    (["f3668", f"--silkit={NOBODY},N", "--set", "time=x"], 1, "--set time=x: expected coordinated, autonomous or real"),
    (["f3668", f"--silkit={NOBODY},N", "--set", "frames=packed"], 2,
     "--set frames: verify has no such setting; expected none but time, with --silkit"),
    (["f3668", "--slcan=/dev/null", "--set", "time=real"], 2,
     "--set time: verify has no such setting; expected none but time, with --silkit"),
])
def test_what_a_simulation_does_not_carry(arguments, status, said):
    assert refused(*arguments, status=status) == f"drehgeber: {said}"


def participants(process) -> list:
    """What the library has in /tmp of a `drehgeber verify` that has joined."""
    return list(Path("/tmp").glob(f"verify-{process.pid}-*.silkit"))


def wait_for_participant(process):
    end = time.monotonic() + PATIENCE_S
    while not participants(process):
        assert time.monotonic() < end and process.poll() is None, "it does not join"
        time.sleep(0.01)


def one_line(registry, *arguments):
    return subprocess.run(command(registry, "f3668", *arguments), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=LIMIT_S, env=WITH_LIBRARY)


def test_a_name_is_there_once(registry, rig):
    rig("f3668", f"--silkit={registry.uri},WIRE1,verify").ready()
    ended = one_line(registry)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == (f"drehgeber: SIL Kit: there is a participant verify already; expected {registry.uri},WIRE1,"
                            "PARTICIPANT with another name\n")


def test_a_simulation_that_does_not_begin(registry, bench):
    program = bench("f3668")
    ended = one_line(registry)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == (
        "drehgeber: SIL Kit: the simulation has not begun after 10 s; expected a system controller that requires verify and "
        "the encoder's participant, or --set time=autonomous or time=real, as the encoder has it\n")
    assert program.end() == 0


def test_another_kind_of_time(registry, bench):
    """Whose time is virtual is not told that others have real time."""
    program = bench("f3668", how="autonomous")
    ended = one_line(registry, "--set", "time=real")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == ("drehgeber: SIL Kit: verify has real time, and others have virtual time; expected the --set time=... of "
                            "the encoder\n")
    assert program.end() == 0


@pytest.mark.parametrize("how", TIMES)
def test_nobody_answers(registry, bench, how):
    program = bench("f3668", "--node", 5, how=how)
    with controller(registry, "bench", "verify") if how == "coordinated" else contextlib.nullcontext():
        ended = one_line(registry, "--set", f"time={how}", "--quiet")
        program.wait() if how == "coordinated" else program.end()
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == (f"drehgeber: {registry.uri},WIRE1: node 63 does not answer; expected its node-ID with --node, and a "
                            "bus at 250 kBd\n")


@pytest.mark.parametrize("number, said", [
    (signal.SIGTERM, "the simulation has ended"),
    (signal.SIGKILL, "no participant advances the time any more"),
])
def test_an_encoder_that_goes_ends_it(registry, bench, tmp_path, number, said):
    with controller(registry, "bench", "verify"):
        program = bench("f3668")
        process = subprocess.Popen(command(registry, "f3668", "--alone", "--write", "--journal", tmp_path / "journal"), text=True,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=WITH_LIBRARY)
        wait_for_participant(process)
        time.sleep(1.0)  # of the four seconds that it takes
        program.process.send_signal(number)
        out, errors = process.communicate(timeout=PATIENCE_S)
    for left in Path("/tmp").glob(f"bench-{program.process.pid}-*.silkit"):
        left.unlink()
    assert process.returncode == 1 and re.search("^it ended early: .", out, re.M), (out[-500:], errors)
    assert errors.splitlines()[-1] == f"drehgeber: SIL Kit: {said}"


def test_a_signal_leaves_nothing_behind(registry, bench):
    """The scan for other devices takes seconds of real time."""
    program = bench("f3668", how="real")
    process = subprocess.Popen(command(registry, "f3668", "--alone", "--set", "time=real", CLAUSE["f3668"]),
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=WITH_LIBRARY)
    wait_for_participant(process)
    time.sleep(1.0)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=PATIENCE_S) == (b"", b"") and process.returncode == -signal.SIGTERM
    assert participants(process) == []
    assert program.end() == 0
