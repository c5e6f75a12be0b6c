# SPDX-License-Identifier: MIT
"""The plant of tools/examples: 10 000 encoders in one simulation, their positions checked against their shafts. It prints
its figures, which nobody judges."""
import itertools
import os
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("DREHGEBER", str(TREE / "build/release/drehgeber"))
LIBRARY = os.environ.get("DREHGEBER_SILKIT_LIBRARY", str(TREE / "build/silkit/SilKit_py/libSilKit.so"))
MASTER = os.environ.get("DREHGEBER_PLANT_MASTER", str(TREE / "build/release/tests/plant-master"))
PLANT = TREE / "tools/examples/plant/plant.py"
FORGED_RIG = Path(__file__).with_name("forged_rig.py")
MS = int(os.environ.get("DREHGEBER_PLANT_MS", "1000"))
PATIENCE_S = 120 + MS // 50
SMALL = ("--processes", "2", "--buses", "2", "--nodes", "3", "--ms", "300")
# SYNC comes three times.
ONE_BUS = ("--buses", "1", "--nodes", "3", "--ms", "300")


def command(*arguments, program=PROGRAM, master=MASTER):
    """With master=None, the script makes its own."""
    made = () if master is None else ("--master", str(master))
    return [sys.executable, "-B", str(PLANT), "--program", str(program), *made, *arguments]


def run(*arguments, program=PROGRAM, master=MASTER, **environment):
    return subprocess.run(command(*arguments, program=program, master=master), stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, **environment})


def printed(result, name):
    return re.search(rf"^{re.escape(name)}\s+(.*)$", result.stdout, re.M)[1]


def figure(result, name):
    assert result.returncode == 0, result.stdout + result.stderr
    return printed(result, name)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def wrapped(tmp_path):
    """The program with its rig files changed: wrapped("s/A/B/")."""

    def make(edit):
        path = tmp_path / "drehgeber"
        path.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/pids\nsed -i '{edit}' \"$3\"\nexec {PROGRAM} \"$@\"\n")
        path.chmod(0o755)
        return path

    return make


@pytest.fixture
def forged(tmp_path):
    """A plant of one rig, which is forged: forged(HOW, ARGUMENTS...)."""
    program = tmp_path / "forged"
    program.write_text(f"#!/bin/sh\nexec {sys.executable} -B {FORGED_RIG} \"$@\"\n")
    program.chmod(0o755)
    said = {"FORGED_LOG": str(tmp_path / "log"), "DREHGEBER_SILKIT": str(Path(LIBRARY).parent)}
    return lambda how, *arguments: run(*ONE_BUS, *arguments, program=program, FORGED=how, **said)


def test_ten_thousand_encoders(capsys):
    result = run("--ms", str(MS))
    assert figure(result, "encoders").startswith("10000 = 1 rigs x 80 buses x 125 nodes")
    assert figure(result, "positions") == f"{MS // 100 * 10000} checked, 0 wrong"
    for name in ("start-up", "memory", "virtual s per s", "steps/s", "frames/s", "processor", "a frame"):
        assert re.search(r"\d", figure(result, name))
    with capsys.disabled():
        print(*(f"\nnote: plant: {line}" for line in result.stdout.splitlines()), sep="")


def test_other_steps():
    """SYNC in each fourth one."""
    result = run(*SMALL, "--step-us", "250", "--sync-ms", "1")
    assert figure(result, "positions") == f"{300 * 2 * 2 * 3} checked, 0 wrong"


def test_angles_are_rounded_down():
    """So many that one of them, of a shaft that turns back, is another position if it is rounded up."""
    result = run("--buses", "400", "--nodes", "1", "--sync-ms", "4")
    assert figure(result, "positions") == "100000 checked, 0 wrong"


@pytest.mark.parametrize("arguments", [("--frames", "can"), ("--aggregate", "0"), ("--frames", "can", "--aggregate", "0")])
def test_messages_of_other_kinds(arguments):
    """Frames on CAN networks, and what is sent without SIL Kit's aggregation."""
    result = run(*SMALL, *arguments)
    assert figure(result, "positions") == "36 checked, 0 wrong"


def test_rig_files_of_other_kinds():
    rig = (*SMALL, "--rig", "0", "--registry", "silkit://a:1")
    plain = run(*rig, "--frames", "can", "--aggregate", "0").stdout
    assert plain.count("\naggregate = 0\n") == plain.count("[bus ") == 2 and "frames = " not in plain
    usual = run(*rig).stdout
    assert usual.count("\nframes = packed\n") == usual.count("[bus ") == 2 and "aggregate" not in usual


def test_several_machines():
    """As two of them have it, here on one: rigs with the master, and others that join."""
    registry = f"silkit://127.0.0.1:{free_port()}"
    with subprocess.Popen(command(*SMALL, "--registry", registry, "--here", "0"), stdin=subprocess.DEVNULL, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as first:
        try:
            wait_for_port(int(registry.rpartition(":")[2]), first)
            other = run(*SMALL, "--registry", registry, "--here", "1", "--join")
            said, _ = first.communicate(timeout=PATIENCE_S)
        finally:
            first.terminate()
    assert first.returncode == 0 and "36 checked, 0 wrong" in said, said
    assert other.returncode == 0 and other.stdout == f"1 rigs are ready, for {registry}\n", other.stderr


def wait_for_port(port, process):
    end = time.monotonic() + PATIENCE_S
    while process.poll() is None and time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
            return
        except OSError:
            time.sleep(0.05)
    raise AssertionError("nobody listens")


@pytest.mark.parametrize("edit, complaint", [
    ("s/^node = 1..3/node = 1..2/", r"step \d+: bus\d+: 283h is missing"),
    ("s/^shaft = s1/shaft = s0/", r"step \d+: bus1: 28[123]h tells [0-9a-f]{8}, not [0-9a-f]{8}"),
])
@pytest.mark.parametrize("frames", ["packed", "can"])
def test_what_is_wrong_is_found(wrapped, edit, complaint, frames):
    result = run(*SMALL, "--frames", frames, program=wrapped(edit))
    assert result.returncode == 1
    assert re.search(complaint, result.stderr), result.stderr
    assert not re.search(r"checked, 0 wrong", result.stdout)


@pytest.mark.parametrize("how", ["right", "reversed", "halves", "beside"])
def test_what_is_right_in_another_order(forged, how):
    """A message that is not the usual one is checked frame by frame."""
    result = forged(how)
    assert figure(result, "positions") == "9 checked, 0 wrong"


@pytest.mark.parametrize("how, complaint, positions", [
    ("twice", "281h without SYNC", "9 checked, 3 wrong"),
    ("again", "281h without SYNC", "9 checked, 9 wrong"),
    ("late", r"281h is of \d+ ns, not of \d+ ns", "9 checked, 9 wrong"),
    ("damaged", "282h tells [0-9a-f]{8}, not [0-9a-f]{8}", "9 checked, 3 wrong"),
    ("longer", "281h tells [0-9a-f]{8}00, not [0-9a-f]{8}", "9 checked, 3 wrong"),
    ("remote", "281h is missing", "6 checked, 3 wrong"),
    ("other", "283h is missing", "6 checked, 3 wrong"),
    ("cut", "a message of 47 bytes is cut", "6 checked, 6 wrong"),
    ("fewer", "a message of 48 bytes is cut", "9 checked, 3 wrong"),
    ("padded", "a message of 49 bytes is cut", "9 checked, 3 wrong"),
    ("headless", "a message of 11 bytes is cut", "0 checked, 12 wrong"),
    ("silent", "281h is missing", "0 checked, 9 wrong"),
])
def test_each_forgery_is_found(forged, how, complaint, positions):
    result = forged(how)
    assert (result.returncode, printed(result, "positions")) == (1, positions), result.stderr
    complaints = result.stderr.splitlines()
    assert len(complaints) == min(10, int(positions.split()[2])), complaints
    assert re.fullmatch(rf"plant: step \d+: bus0: {complaint}", complaints[0]), complaints


def fnv(content, so_far=0xCBF29CE484222325):
    """FNV-1a, 64 bits."""
    for byte in content:
        so_far = (so_far ^ byte) * 0x100000001B3 % 2**64
    return so_far


@pytest.mark.parametrize("how", ["right", "halves"])
def test_the_hash_is_of_the_frames(forged, tmp_path, how):
    """As the forged rig has logged them: moment, identifier, data of each. How they share messages does not matter."""
    bus = fnv((0).to_bytes(4, "little"))
    told = figure(forged(how, "--hash"), "hash")
    log = (tmp_path / "log").read_bytes()
    assert len(log) == 9 * 14
    assert told == f"{fnv(fnv(log, bus).to_bytes(8, 'little')):016x}"


def test_the_hash_does_not_depend_on_rigs_and_threads():
    told = {}
    for processes, threads in itertools.product((1, 4, 16), (1, 2)):
        result = run("--processes", str(processes), "--threads", str(threads), "--buses", str(16 // processes), "--nodes", "3",
                     "--ms", "300", "--hash")
        assert figure(result, "positions") == "144 checked, 0 wrong"
        told[processes, threads] = figure(result, "hash")
    assert len(set(told.values())) == 1, told
    fewer = run("--buses", "16", "--nodes", "2", "--ms", "300", "--hash")
    assert re.fullmatch("[0-9a-f]{16}", told[1, 1]) and figure(fewer, "hash") != told[1, 1]


def test_a_master_of_its_own():
    """The script compiles it."""
    assert figure(run(*SMALL, master=None), "positions") == "36 checked, 0 wrong"


def test_no_compiler(tmp_path):
    """Nothing is started then."""
    result = run(*SMALL, master=None, program="/nowhere", PATH=str(tmp_path))
    assert (result.returncode, result.stderr) == (
        1, "plant: cc: No such file or directory; a C compiler makes the master, or --master names one that is made\n")


def test_a_compiler_that_fails(tmp_path):
    (tmp_path / "cc").write_text("#!/bin/sh\necho no space left >&2\nexit 1\n")
    (tmp_path / "cc").chmod(0o755)
    result = run(*SMALL, master=None, program="/nowhere", PATH=f"{tmp_path}:{os.environ['PATH']}")
    assert (result.returncode, result.stderr) == (1, "plant: cc has ended with 1: no space left\n")


def test_a_master_that_ends_by_itself(tmp_path):
    (tmp_path / "master").write_text("#!/bin/sh\nexit 3\n")
    (tmp_path / "master").chmod(0o755)
    result = run(*SMALL, master=tmp_path / "master")
    assert (result.returncode, result.stderr) == (1, "plant: the master has ended with 3\n")


@pytest.mark.parametrize("arguments, complaint", [
    ((), "usage: master silkit://HOST:PORT [NAME=NUMBER]..."),
    (("silkit://127.0.0.1:1", "nodes"), "nodes: expected NAME=NUMBER"),
    (("silkit://127.0.0.1:1", "colour=1"), "colour=1: expected NAME=NUMBER"),
    (("silkit://127.0.0.1:1", "nodes=128"), "nodes=128: expected 1..127"),
    (("silkit://127.0.0.1:1", "nodes=0"), "nodes=0: expected 1..127"),
    (("silkit://127.0.0.1:1", "nodes="), "nodes=: expected 1..127"),
    (("silkit://127.0.0.1:1", "nodes=-1"), "nodes=-1: expected 1..127"),
    (("silkit://127.0.0.1:1", "nodes=1x"), "nodes=1x: expected 1..127"),
    (("silkit://127.0.0.1:1", "buses=100000", "processes=2"), "expected 100000 buses at most"),
    (("silkit://127.0.0.1:1", "sync_ms=3"), "expected SYNC in each fourth step at most"),
    (("silkit://127.0.0.1:1", "step_us=300"), "expected SYNC in each fourth step at most, and in a step"),
    (("silkit://127.0.0.1:1",), "SIL Kit: Participant_Create: "),
])
def test_what_the_master_refuses(arguments, complaint):
    result = subprocess.run([MASTER, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                            timeout=PATIENCE_S, env={**os.environ, "DREHGEBER_SILKIT_LIBRARY": LIBRARY})
    assert result.returncode == 2 and result.stderr.startswith(f"plant: {complaint}"), result.stderr


def test_a_rig_that_does_not_start(wrapped):
    result = run(*SMALL, program=wrapped("s/f3668/f9999/"))
    assert result.returncode == 1
    assert re.search(r"^plant: plant-\d has ended with 2: .*f9999 is unknown", result.stderr, re.M), result.stderr


def test_what_it_started_ends_with_it(wrapped, tmp_path):
    (tmp_path / "tmp").mkdir()
    four = command("--processes", "4", "--buses", "20", "--ms", "1000000", program=wrapped("s/a/a/"))
    with subprocess.Popen(four, stdin=subprocess.DEVNULL, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          env={**os.environ, "TMPDIR": str(tmp_path / "tmp")}) as plant:
        assert re.match(r"plant: step \d+ of 1000\d+, \d+ positions checked, 0 wrong, \d+ s", plant.stderr.readline())
        pids = [int(line) for line in (tmp_path / "pids").read_text().split()]
        assert len(pids) == 4 and all(Path(f"/proc/{pid}").exists() for pid in pids)
        plant.send_signal(signal.SIGTERM)
        plant.wait(PATIENCE_S)
        assert plant.returncode == 143
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)
    assert [path.name for path in (tmp_path / "tmp").iterdir() if not path.name.startswith("drehgeber-")] == []


def is_alive(pid):
    """A zombie is not: who takes the place of its parent has its own time."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][0] not in "ZX"
    except OSError:
        return False


@pytest.fixture
def for_long(wrapped, tmp_path):
    """A plant of two rigs and a master in a group of their own, which has done some steps, and their three pids."""
    (tmp_path / "tmp").mkdir()
    master = tmp_path / "master"
    master.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/pids\nexec {MASTER} \"$@\"\n")
    master.chmod(0o755)
    small = command("--processes", "2", "--buses", "20", "--ms", "1000000", program=wrapped("s/a/a/"), master=master)
    with subprocess.Popen(small, stdin=subprocess.DEVNULL, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          start_new_session=True, env={**os.environ, "TMPDIR": str(tmp_path / "tmp")}) as plant:
        assert re.match(r"plant: step \d+ of 1000\d+", plant.stderr.readline())
        pids = [int(line) for line in (tmp_path / "pids").read_text().split()]
        assert len(pids) == 3 and all(map(is_alive, pids))
        yield plant, pids
        plant.kill()
    for pid in filter(is_alive, pids):
        os.kill(pid, signal.SIGKILL)


def test_all_end_when_the_script_is_killed(for_long):
    """The master at once, as its input ends. Then time stands still, and the rigs end."""
    plant, pids = for_long
    plant.kill()
    plant.wait(PATIENCE_S)
    end = time.monotonic() + PATIENCE_S
    while any(map(is_alive, pids)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not any(map(is_alive, pids))


def test_ctrl_c(for_long):
    """A terminal sends it to all. The master leaves after the rigs, and leaves nothing behind."""
    plant, pids = for_long
    socket_of_master = f"master-{pids[-1]}-*"
    assert len(list(Path("/tmp").glob(socket_of_master))) == 1
    os.killpg(plant.pid, signal.SIGINT)
    said = plant.communicate(timeout=PATIENCE_S)[1]
    assert plant.returncode == 130
    assert re.fullmatch(r"(plant: step .*\n)*", said), said
    assert not any(map(is_alive, pids)) and list(Path("/tmp").glob(socket_of_master)) == []


def wait_for_pids(plant, folder, count):
    """The file that rigs write theirs to."""
    pids = folder / "pids"
    end = time.monotonic() + PATIENCE_S
    while not pids.exists() or len(pids.read_text().splitlines()) < count:
        assert plant.poll() is None and time.monotonic() < end, "the plant starts no rigs"
        time.sleep(0.01)
    return pids


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_what_it_has_started_so_far_ends_with_it(tmp_path, number):
    """Rigs that never are ready, of which there are a few when it is told to end."""
    program = tmp_path / "slow"
    program.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/pids\nexec sleep {PATIENCE_S}\n")
    program.chmod(0o755)
    plant = subprocess.Popen(command("--processes", "256", "--buses", "1", "--nodes", "1", program=program),
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    pids = wait_for_pids(plant, tmp_path, 5)
    plant.send_signal(number)
    time.sleep(0.02)
    plant.send_signal(number)
    said = plant.communicate(timeout=PATIENCE_S)[1]
    assert (plant.returncode, said) == (128 + number, "")
    started = pids.read_text().split()
    left = [pid for pid in started if Path(f"/proc/{pid}").exists()]
    for pid in left:
        os.kill(int(pid), signal.SIGKILL)
    assert len(started) < 256 and left == []


def test_rigs_that_hear_nothing_are_waited_for_together(tmp_path):
    """Ten seconds for all of them; a rig that joins is deaf for a while."""
    program = tmp_path / "deaf"
    program.write_text(f"#!/bin/sh\ntrap '' TERM\necho $$ >> {tmp_path}/pids\nexec sleep {PATIENCE_S}\n")
    program.chmod(0o755)
    plant = subprocess.Popen(command("--processes", "12", "--buses", "1", "--nodes", "1", program=program),
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    pids = wait_for_pids(plant, tmp_path, 12)
    plant.send_signal(signal.SIGTERM)
    assert plant.wait(60) == 143
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids.read_text().split())


@pytest.mark.parametrize("arguments, environment, complaint", [
    (SMALL, {"DREHGEBER_SILKIT_LIBRARY": "/nowhere.so"}, "no SIL Kit library: /nowhere.so"),
    (("--program", "/nowhere"), {}, "plant: /nowhere: No such file or directory; --program"),
    ((*SMALL, "--master", "/nowhere"), {}, "plant: /nowhere: No such file or directory; --master"),
    (("--hash", "--frames", "can"), {}, "--hash is of packed frames"),
    (("--join",), {}, "--registry silkit://HOST:PORT says where the master is"),
    (("--nodes", "128"), {}, "a bus has at most 127 nodes"),
    (("--threads", "65"), {}, "--threads 65: expected 1..64"),
    (("--registry", "foo", "--rig", "0"), {}, "--registry foo: expected silkit://HOST:PORT"),
    (("--processes", "1000"), {}, "256 processes at most"),
    (("--here", "3..1"), {}, "invalid numbers value: '3..1'"),
    (("--processes", "4", "--here", "3..4"), {}, "the rigs of 4 processes are 0..3"),
    (("--processes", "4", "--here=-1"), {}, "the rigs of 4 processes are 0..3"),
    (("--processes", "4", "--rig", "4", "--registry", "silkit://a:1"), {}, "the rigs of 4 processes are 0..3"),
    (("--processes", "4", "--rig", "-1", "--registry", "silkit://a:1"), {}, "the rigs of 4 processes are 0..3"),
    (("--sync-ms", "3"), {}, "SYNC comes each fourth step at most"),
])
def test_what_cannot_be(arguments, environment, complaint):
    result = run(*arguments, **environment)
    assert result.returncode != 0 and complaint in result.stderr, result.stderr


def test_a_rig_file_by_itself(tmp_path):
    """For rigs that somebody else starts: the command takes it as far as the registry, which is not there."""
    registry = f"silkit://127.0.0.1:{free_port()}"
    file = tmp_path / "plant-3.ini"
    file.write_text(subprocess.run(command("--processes", "4", "--buses", "20", "--rig", "3", "--registry", registry),
                                   check=True, capture_output=True, text=True, timeout=PATIENCE_S).stdout)
    assert len(file.read_text().splitlines()) < 250
    result = subprocess.run([PROGRAM, "run", str(file)], capture_output=True, text=True, timeout=PATIENCE_S)
    assert result.returncode == 1 and "silkit:silkit://127.0.0.1:" in result.stderr, result.stderr


def test_the_drop_in_for_services(tmp_path):
    unit = (TREE / "tools/systemd/drehgeber@.service.in").read_text()
    (tmp_path / "drehgeber@.service").write_text(unit.replace("@DREHGEBER_BINDIR@/drehgeber", PROGRAM))
    folder = tmp_path / "drehgeber@.service.d"
    folder.mkdir()
    (folder / "silkit.conf").write_text((PLANT.parent / "silkit.conf").read_text())
    result = subprocess.run(["systemd-analyze", "verify", "--man=no", "--no-pager", tmp_path / "drehgeber@.service"],
                            capture_output=True, text=True, timeout=PATIENCE_S)
    assert (result.returncode, result.stdout + result.stderr) == (0, "")
