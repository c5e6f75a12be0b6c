# SPDX-License-Identifier: MIT
"""How a rig's part in a simulation begins and ends: what is missing, who is there already, who goes."""
import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rig import run_refused
from simulation import COORDINATED, LIBRARY, PATIENCE_S, STEP_NS

MODEL = "f3668"
NOBODY = "silkit://127.0.0.1:9"  # discard: nobody listens there
ENDED = "drehgeber: SIL Kit: the simulation has ended"
WITH_LIBRARY = {**os.environ, "DREHGEBER_SILKIT_LIBRARY": str(LIBRARY)}


def refused(status, *arguments, env=None):
    return run_refused(status, "run", MODEL, *arguments, env=WITH_LIBRARY if env is None else env)


@pytest.mark.parametrize("library, said", [
    (None, "no SIL Kit library: libSilKit.so: cannot open shared object file"),
    ("", "no SIL Kit library: libSilKit.so: cannot open shared object file"),
    ("/nowhere/libSilKit.so", "no SIL Kit library: /nowhere/libSilKit.so: cannot open shared object file"),
    (__file__, "no SIL Kit library: "),
    ("libm.so.6", "libm.so.6 has no SilKit_ParticipantConfiguration_FromString"),
])
def test_a_library_that_is_none(library, said):
    environment = {name: value for name, value in os.environ.items() if name != "DREHGEBER_SILKIT_LIBRARY"}
    if library is not None:
        environment["DREHGEBER_SILKIT_LIBRARY"] = library
    line = refused(1, f"--silkit={NOBODY},CAN1", env=environment)
    assert said in line and line.endswith("libSilKit.so of SIL Kit 5, named by DREHGEBER_SILKIT_LIBRARY or where the "
                                          "dynamic linker looks")


RIGHT = "expected silkit://HOST:PORT,NETWORK or silkit://HOST:PORT,NETWORK,PARTICIPANT"


@pytest.mark.parametrize("where", [
    "", ",", "x", "silkit://", "silkit://h:1", "silkit://h:1,", "silkit://h,N", "silkit://:1,N", "silkit://h:0,N",
    "silkit://h:65536,N", "silkit://h:1x,N", "silkit://h h:1,N", "http://h:1,N", "silkit://h:1/x,N", "silkit://h:1,N N",
    "silkit://h:1,N/M", "silkit://h:1,N,", "silkit://h:1,N,A,B", f"silkit://{'h' * 300}:1,N",
    f"silkit://h:1,{'N' * 64}", f"silkit://h:1,N,{'P' * 64}",
])
def test_what_is_no_address(where):
    assert refused(2, f"--silkit={where}").endswith(RIGHT)


@pytest.mark.parametrize("host", ["127.0.0.1:9", "nobody.invalid:8501"])
def test_no_registry(host):
    line = refused(1, f"--silkit=silkit://{host},CAN1")
    assert "SIL Kit: " in line and line.endswith("start a registry there, e.g. sil-kit-registry")


@pytest.mark.parametrize("setting, said", [
    ("time=x", "--set time=x: expected coordinated, autonomous or real"),
    ("step_us=0", "--set step_us=0: expected a number in 1..1000000 us"),
    ("pace=1", "--set pace=1: "),
    ("frames=x", "--set frames=x: expected can or packed"),
])
def test_settings(setting, said):
    assert said in refused(2, f"--silkit={NOBODY},CAN1", "--set", setting)


def test_only_a_can_bus_has_frames():
    line = run_refused(2, "run", "s3684-rs485", f"--silkit={NOBODY},LINE1", "--set", "frames=packed", env=WITH_LIBRARY)
    assert "frames = packed: only a CAN bus has frames" in line


@pytest.mark.parametrize("buses, said", [
    ((f"{NOBODY},A", "silkit://127.0.0.1:10,B"), f"a rig has one registry; expected {NOBODY}, as for the first silkit wire"),
    ((f"{NOBODY},A,p", f"{NOBODY},B,q"), "a rig has one participant; expected p, as for the first silkit wire"),
    ((f"{NOBODY},A", f"{NOBODY},B\ntime = real"), "a rig has one time; expected coordinated, as for the first silkit wire"),
    ((f"{NOBODY},A\nstep_us = 5", f"{NOBODY},B\nstep_us = 6"), "a rig has one step; expected step_us=5, as for the first silkit wire"),
    ((f"{NOBODY},A\naggregate = 0", f"{NOBODY},B\naggregate = 1"),
     "a rig has one way of sending; expected aggregate=0, as for the first silkit wire"),
    ((f"{NOBODY},A", f"{NOBODY},A"), "is the wire in line 1 already"),
])
def test_wires_of_a_rig_are_in_one_simulation(tmp_path, buses, said):
    file = tmp_path / "rig.ini"
    file.write_text("".join(f"[bus b{i}]\nwire = silkit\naddress = {where}\n" for i, where in enumerate(buses)) +
                    "".join(f"[encoder e{i}]\nmodel = {MODEL}\nbus = b{i}\n" for i in range(len(buses))))
    assert said in run_refused(2, "run", file, env=WITH_LIBRARY)


def test_real_wires_are_in_no_simulation(tmp_path):
    file = tmp_path / "rig.ini"
    file.write_text(f"[encoder a]\nmodel = {MODEL}\nwire = silkit:{NOBODY},A\n"
                    "[encoder b]\nmodel = s3684-rs485\nwire = tty:/dev/null\n")
    line = run_refused(2, "run", file, env=WITH_LIBRARY)
    assert "tty has real time, not that of a simulation; " in line
    assert line.partition("; ")[2].startswith("expected pty, rs485, sim, slcan, ")


def test_a_name_is_there_once(registry, rig):
    first = rig(MODEL, f"--silkit={registry.uri},CAN1")
    first.ready()
    assert refused(1, f"--silkit={registry.uri},CAN1").endswith(
        f"SIL Kit: there is a participant {MODEL} already; expected {registry.uri},CAN1,PARTICIPANT with another name")
    second = rig(MODEL, f"--silkit={registry.uri},CAN1,other")
    second.ready()
    assert (first.end(), second.end()) == (0, 0)


def listening(pid):
    """Addresses of TCP ports that a process has open, as /proc/net has them."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            inodes.add(link.readlink().name.removeprefix("socket:[").removesuffix("]"))
    rows = [row.split() for table in ("tcp", "tcp6") for row in Path(f"/proc/net/{table}").read_text().splitlines()[1:]]
    return {row[1].partition(":")[0] for row in rows if row[3] == "0A" and row[9] in inodes}


def test_who_has_a_registry_on_loopback_is_met_there_only(registry, rig):
    before = set(Path("/tmp").glob("closed*.silkit"))
    program = rig(MODEL, f"--silkit={registry.uri},CAN1,closed")
    program.ready()
    assert listening(program.process.pid) == {"0100007F"}
    (place,) = set(Path("/tmp").glob("closed*.silkit")) - before
    assert program.end() == 0 and not place.exists()


def test_beyond_loopback_is_said(registry, rig):
    program = rig(MODEL, f"--silkit={registry.uri.replace('127.0.0.1', '0.0.0.0')},CAN1")
    program.ready()
    assert "00000000" in listening(program.process.pid)
    assert "0.0.0.0" in program.errors.wait(20) and program.end() == 0


@pytest.mark.parametrize("time_", ["coordinated", "autonomous", "real"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals(registry, rig, time_, number):
    program = rig(MODEL, f"--silkit={registry.uri},CAN1", "--set", f"time={time_}")
    program.ready()
    assert program.end(number) == 0 and program.errors.so_far() == []


def started(registry, rig, join, step=lambda master, now: None):
    """A rig and a master that steps."""
    seen = []

    def each(master, now):
        seen.append(now)
        step(master, now)

    master = join("master", each, required=[MODEL, "master"])
    program = rig(MODEL, f"--silkit={registry.uri},CAN1")
    program.ready()
    master.start()
    master.until(lambda: seen and seen[-1] > 100 * STEP_NS)
    return program, master, seen


def test_a_signal_while_it_runs_ends_the_simulation(registry, rig, join):
    program, master, _ = started(registry, rig, join)
    assert program.end() == 0 and program.errors.so_far() == []
    master.wait()


def test_it_ends_with_the_others(registry, rig, join):
    program, master, _ = started(registry, rig, join)
    master.stop()
    master.wait()
    assert program.wait() == 0 and program.errors.so_far() == [ENDED]


def test_an_aborted_simulation(registry, rig, join):
    program, master, _ = started(registry, rig, join)
    master.abort()
    assert program.wait() == 1
    assert program.errors.so_far() == ["drehgeber: SIL Kit: the simulation was aborted"]


def test_a_registry_that_goes_before_the_beginning(registry, rig):
    program = rig(MODEL, f"--silkit={registry.uri},CAN1")
    program.ready()
    registry.end()
    assert program.wait() == 1
    assert program.errors.so_far() == ["drehgeber: SIL Kit: the registry has gone before the simulation has begun"]


def test_a_registry_that_goes_later_is_not_missed(registry, rig, join):
    program, master, seen = started(registry, rig, join)
    registry.end()
    assert program.errors.wait(PATIENCE_S) == \
        "drehgeber: SIL Kit: the registry has gone; present participants continue, no other can join"
    now = seen[-1]
    master.until(lambda: seen[-1] > now + 100 * STEP_NS)
    assert program.end() == 0


MASTER = f"""
import sys, time
sys.path[:0] = {[str(Path(__file__).parent), str(Path(__file__).parents[1])]}
from simulation import Participant
master = Participant(sys.argv[1], "master", lambda master, now: now == 100_000_000 and print("runs", flush=True),
                     mode={COORDINATED}, required=["{MODEL}", "master"])
master.start()
time.sleep({PATIENCE_S})
"""


def test_a_master_that_dies_is_missed(registry, rig):
    """Time would stand still for good."""
    master = subprocess.Popen([sys.executable, "-B", "-c", MASTER, registry.uri], stdout=subprocess.PIPE)
    try:
        program = rig(MODEL, f"--silkit={registry.uri},CAN1")
        program.ready()
        assert master.stdout.readline() == b"runs\n"
    finally:
        master.kill()
        master.wait(PATIENCE_S)
        master.stdout.close()
    assert program.wait() == 1
    assert program.errors.so_far() == ["drehgeber: SIL Kit: master has left the simulation",
                                       "drehgeber: SIL Kit: no participant advances the time any more"]
