# SPDX-License-Identifier: MIT
"""FMUs in an importer that is not ours (fmpy); where it knows no clocks, by its low-level calls."""

import ctypes
import json
import math
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable

import numpy as np
import pytest
from conftest import DREHGEBER, Fmu, Slave
from fmpy import simulate_fmu  # type: ignore[import-untyped]
from fmpy.fmi1 import FMICallException  # type: ignore[import-untyped]
from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]
from fmpy.validation import validate_fmu  # type: ignore[import-untyped]

Make = Callable[..., Fmu]
MODELS = ["s3674-rs485", "s3684-rs485", "s3674-biss", "s3684-biss", "ssi-13", "ssi-25", "ssi-28",
          "f3658", "f3668", "ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3"]
TURN = 2 * math.pi
SPEED = 50 * TURN  # 3000 rpm

# Operations of FMI-LS-BUS 1.0 (its chapter on CAN): code, length, and what belongs to it.
TRANSMIT, BUS_ERROR, CONFIGURATION, STATUS = 0x10, 0x31, 0x40, 0x41


def frame(number: int, data: bytes = b"") -> bytes:
    return struct.pack("<IIIBBH", TRANSMIT, 16 + len(data), number, 0, 0, len(data)) + data


def operations(data: bytes) -> list[tuple[int, bytes]]:
    found = []
    while data:
        code, length = struct.unpack_from("<II", data)
        assert 8 <= length <= len(data)
        found.append((code, data[8:length]))
        data = data[length:]
    return found


def frames(data: bytes) -> list[tuple[int, bytes]]:
    return [(struct.unpack_from("<I", body)[0], body[8:]) for code, body in operations(data) if code == TRANSMIT]


# ------------------------------------------------------------ the description

@pytest.mark.parametrize("version", ["3", "2"])
@pytest.mark.parametrize("model", MODELS)
def test_model_is_valid(make: Make, model: str, version: str) -> None:
    assert validate_fmu(make(model, "--fmi", version).path) == []


def test_command_says_what_is_wrong() -> None:
    for words, wrong in [(["f3668"], "fmu needs --output"),
                         (["f3668", "-o", "x.fmu", "--fmi", "1"], "--fmi"),
                         (["f3699", "-o", "x.fmu"], "unknown model f3699"),
                         (["f3668", "-o", "x.fmu", "--set", "nonsense=1"], "--set nonsense=1"),
                         (["s3684-biss", "-o", "x.fmu", "--set", "clock_hz=100000"], "--set clock_hz=100000: an FMU"),
                         (["f3668", "-o", "x.fmu", "--node", "200"], "--node"),
                         (["f3668", "-o", "x.fmu", "--nvm", "x.nvm"], "fmu takes no option --nvm"),
                         (["f3668", "-o", "x.fmu", "--pty"], "fmu takes no option --pty"),
                         (["-o", "x.fmu"], "fmu needs a model or a rig file"),
                         (["s3684-biss", "-o", "x.fmu", "--set", "st=99"], "--set st=99: out of its range")]:
        done = subprocess.run([DREHGEBER, "fmu", *words], capture_output=True, text=True)
        assert done.returncode == 2 and wrong in done.stderr, (words, done.stderr)
    done = subprocess.run([DREHGEBER, "fmu", "f3668", "-o", "/nowhere/x.fmu"], capture_output=True, text=True)
    assert done.returncode == 1 and "cannot write /nowhere/x.fmu" in done.stderr


def test_rig_file_stays(tmp_path: pathlib.Path) -> None:
    file, link = tmp_path / "rig.ini", tmp_path / "rig.fmu"
    file.write_text(RIG)
    link.symlink_to(file)
    done = subprocess.run([DREHGEBER, "fmu", str(file), "-o", str(link)], capture_output=True, text=True)
    assert done.returncode == 2 and "is the rig file itself" in done.stderr and file.read_text() == RIG


def test_a_file_without_the_ending_is_refused(tmp_path: pathlib.Path) -> None:
    for name in ("axis", "axis.zip"):
        file = tmp_path / name
        done = subprocess.run([DREHGEBER, "fmu", "f3668", "-o", str(file)], capture_output=True, text=True)
        assert done.returncode == 2 and not file.exists()
        assert done.stderr == f"drehgeber: --output {file}: expected {file}.fmu\n"


def limited(output: pathlib.Path, blocks: str, program: str = DREHGEBER) -> subprocess.CompletedProcess[str]:
    """Write an FMU where no file may have more 1024-byte blocks than these."""
    return subprocess.run(["bash", "-c", f'ulimit -f {blocks}; exec "$0" fmu f3668 -o "$1"', program, str(output)],
                          capture_output=True, text=True)


def test_failure_leaves_what_was_there(tmp_path: pathlib.Path) -> None:
    """On a full disk, and where a part of the installation is missing."""
    place, program = tmp_path / "place", tmp_path / "bin" / "drehgeber"
    place.mkdir()
    parts = program.parent / "fmu-parts"
    parts.mkdir(parents=True)
    shutil.copy(DREHGEBER, program)
    shutil.copy(pathlib.Path(DREHGEBER).parent / "fmu-parts" / "sources.list", parts)
    file, link = place / "keep.fmu", tmp_path / "link.fmu"
    file.write_bytes(b"what was there")
    link.symlink_to(file)
    for output in (file, link):
        for done, wrong in ((limited(output, "100"), "cannot write"), (limited(output, "0"), "cannot write"),
                            (limited(output, "unlimited", str(program)), "cannot read")):
            assert done.returncode == 1 and wrong in done.stderr, done.stderr
            assert file.read_bytes() == b"what was there" and os.listdir(place) == ["keep.fmu"]


def test_a_link_to_nothing_stays(tmp_path: pathlib.Path) -> None:
    link = tmp_path / "link.fmu"
    link.symlink_to(tmp_path / "nothing.fmu")
    done = subprocess.run([DREHGEBER, "fmu", "f3668", "-o", str(link)], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr == f"drehgeber: cannot write {link}: No such file or directory\n"
    assert link.is_symlink() and os.listdir(tmp_path) == ["link.fmu"]


def test_whole_file_takes_the_place(tmp_path: pathlib.Path) -> None:
    """That of a link's target, with the mode that it had."""
    place, file, link = tmp_path / "place", tmp_path / "place" / "keep.fmu", tmp_path / "link.fmu"
    place.mkdir()
    file.write_bytes(b"what was there")
    file.chmod(0o640)
    link.symlink_to(file)
    done = limited(link, "unlimited")
    assert done.returncode == 0 and link.is_symlink() and os.listdir(place) == ["keep.fmu"], done.stderr
    assert zipfile.is_zipfile(file) and file.stat().st_mode & 0o7777 == 0o640
    fresh = tmp_path / "fresh.fmu"
    done = subprocess.run(["bash", "-c", 'umask 027; exec "$0" fmu f3668 -o "$1"', DREHGEBER, str(fresh)])
    assert done.returncode == 0 and fresh.stat().st_mode & 0o7777 == 0o640


def test_full_disk_leaves_no_half_file(tmp_path: pathlib.Path) -> None:
    """Of a file; what is none stays."""
    file = tmp_path / "x.fmu"
    done = limited(file, "100")
    assert done.returncode == 1 and "cannot write" in done.stderr and not os.listdir(tmp_path)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["head", "-c", "100", str(pipe)], stdout=subprocess.DEVNULL)
    done = subprocess.run([DREHGEBER, "fmu", "f3668", "-o", str(pipe)], capture_output=True, text=True,
                          preexec_fn=lambda: signal.signal(signal.SIGPIPE, signal.SIG_IGN))
    assert reader.wait() == 0 and done.returncode == 1 and pipe.exists()


def test_settings_of_the_command_are_start_values(make: Make) -> None:
    fmu = make("f3668", "--node", "5", "--set", "mt_bits=16")
    starts = {v.name: v.start for v in fmu.description.modelVariables}
    assert starts["node"] == "5" and starts["mt_bits"] == "16"
    slave = Slave(fmu)
    slave.step(0.5)
    assert (0x705, b"\0") in frames(slave.fetch("CanChannel"))
    slave.close()


def test_same_words_same_file(tmp_path: pathlib.Path) -> None:
    files = [tmp_path / "a.fmu", tmp_path / "b.fmu"]
    for file in files:
        subprocess.run([DREHGEBER, "fmu", "ssi-25", "-o", str(file)], check=True)
    assert files[0].read_bytes() == files[1].read_bytes()


# ------------------------------------------------------------ signals

def turning(end: float) -> np.ndarray:
    rows = [(0.0, 0.0, SPEED), (end, end * SPEED, SPEED)]
    return np.array(rows, dtype=[("time", float), ("shaft.angle", float), ("shaft.speed", float)])


@pytest.mark.parametrize("version", ["3", "2"])
def test_minute_of_signals(make: Make, version: str) -> None:
    """3000 rpm for a minute: 3000 turns, 65536 steps each, below 4096 turns."""
    fmu = make("s3684-rs485", "--fmi", version)
    names = ["position", "sin_plus", "sin_minus", "cos_plus", "cos_minus"]
    result = simulate_fmu(fmu.path, stop_time=60.0, output_interval=1e-2, input=turning(60.0), output=names)
    assert len(result) == 6001
    for row in result[::100]:
        assert abs(int(row["position"]) - row["time"] * 50 * 65536) <= 2
    sine = result["sin_plus"] - result["sin_minus"]
    cosine = result["cos_plus"] - result["cos_minus"]
    # 1 Vpp about 2.5 V, the sine and cosine of 2048 periods a turn: always the same circle.
    radius = np.hypot(sine, cosine)
    assert radius.min() > 0.3 and radius.max() - radius.min() < 1e-3


def test_speed_goes_on_within_a_step(make: Make) -> None:
    slave = Slave(make("s3684-rs485"), shaft__speed=SPEED)
    for _ in range(10):
        slave.step(0.1)
    assert abs(slave.get("position") - 50 * 65536) <= 1
    slave.set("shaft.speed", 0.0)
    slave.step(1.0)
    assert abs(slave.get("position") - 50 * 65536) <= 1
    slave.close()


def test_power(make: Make) -> None:
    slave = Slave(make("f3668"), node=7)
    slave.step(0.5)
    assert frames(slave.fetch("CanChannel"))[0] == (0x707, b"\0")
    slave.set("power", False)
    slave.step(0.5)
    assert slave.send("CanChannel", frame(0x607, bytes.fromhex("4000100000000000"))) == b""
    slave.set("power", True)
    slave.step(0.5)
    assert frames(slave.fetch("CanChannel"))[0] == (0x707, b"\0")
    slave.close()


# ------------------------------------------------------------ CAN

def test_can(make: Make) -> None:
    slave = Slave(make("f3668"), node=5, shaft__speed=SPEED)
    assert slave.step(1e-3)
    first = operations(slave.fetch("CanChannel"))
    assert (CONFIGURATION, struct.pack("<BI", 1, 250000)) in first and (STATUS, b"\1") in first
    for _ in range(499):
        slave.step(1e-3)
    assert frames(slave.fetch("CanChannel"))[:1] in ([], [(0x705, b"\0")])
    slave.send("CanChannel", frame(0, b"\1\5"))
    # 1000h of CiA 301: device type, profile 406.
    answer = frames(slave.send("CanChannel", frame(0x605, bytes.fromhex("4000100000000000"))))
    slave.step(1e-3)
    answer += frames(slave.fetch("CanChannel"))
    device = dict(answer)[0x585]
    assert device[:4] == bytes.fromhex("43001000") and struct.unpack_from("<H", device, 4)[0] == 406
    count = 0
    for _ in range(1000):
        got = frames(slave.send("CanChannel", frame(0x80)))
        slave.step(1e-3)
        count += sum(number == 0x285 for number, _ in got + frames(slave.fetch("CanChannel")))
    assert count == 1000
    slave.close()


def test_minute_of_can(make: Make) -> None:
    """3000 rpm for a minute, below 4096 turns: SYNC each 10 ms, and the position of that moment each time."""
    slave = Slave(make("f3668"), node=5, shaft__speed=SPEED)
    for _ in range(100):
        slave.step(1e-2)
    slave.fetch("CanChannel")
    slave.send("CanChannel", frame(0, b"\1\5"))
    slave.step(1e-2)
    slave.fetch("CanChannel")
    for at in range(101, 6101):
        got = frames(slave.send("CanChannel", frame(0x80)))
        slave.step(1e-2)
        (data,) = [data for number, data in got + frames(slave.fetch("CanChannel")) if number == 0x285]
        assert abs(int.from_bytes(data[:4], "little") - at * 50 * 65536 // 100) <= 1, at
    slave.close()


def test_can_errors_make_the_node_passive_and_bus_off(make: Make) -> None:
    slave = Slave(make("f3668"))
    slave.step(0.5)
    slave.fetch("CanChannel")
    told = []
    error = struct.pack("<IIIBBB", BUS_ERROR, 15, 0x73F, 5, 1, 1)
    for _ in range(32):
        told += [body[0] for code, body in operations(slave.send("CanChannel", error)) if code == STATUS]
        slave.step(1e-3)
    assert told == [2, 3] and slave.get("bus_state") == 2
    slave.close()


def test_damaged_operations_are_refused(make: Make) -> None:
    slave = Slave(make("f3668"))
    slave.step(0.5)
    whole = frame(0x63F, bytes(8))
    for n in range(1, len(whole)):
        with pytest.raises(Exception):
            slave.send("CanChannel", whole[:n])
    slave.close()


# ------------------------------------------------------------ RS485

def characters(data: bytes) -> bytes:
    return struct.pack("<QIHH", 0, 0, len(data), 0) + data


def test_rs485(make: Make) -> None:
    """42h of address 40h: position, check sum (exclusive or)."""
    slave = Slave(make("s3684-rs485"), shaft__angle=TURN / 4)
    slave.step(0.2)
    slave.send("RS485", characters(bytes([0x40, 0x42, 0x02])))
    reply, starts = b"", []
    for _ in range(100):
        slave.step(1e-3)
        data = slave.fetch("RS485")
        while data:
            at, _, n, flags = struct.unpack_from("<QIHH", data)
            starts.append(at)
            assert flags == 0
            reply += data[16:16 + n]
            data = data[16 + n:]
    assert reply[:2] == b"\x40\x42" and int.from_bytes(reply[2:6], "big") == 65536 // 4
    check = 0
    for byte in reply:
        check ^= byte
    assert check == 0 and 200_000_000 < starts[0] < 230_000_000
    slave.close()


def test_early_return_tells_the_moment(make: Make) -> None:
    slave = Slave(make("s3684-rs485"), early=True)
    slave.step(0.2)
    slave.send("RS485", characters(bytes([0x40, 0x42, 0x02])))
    assert slave.step(1.0)
    at, *_ = struct.unpack_from("<QIHH", slave.fetch("RS485"))
    assert 0.2 < slave.time < 0.23 and abs(slave.time * 1e9 - at) < 2000
    slave.close()


# ------------------------------------------------------------ BiSS, SSI

def test_ma_latches_at_its_moment(make: Make) -> None:
    slave = Slave(make("s3684-biss"), shaft__speed=SPEED)
    for step in (0.2, 0.0125, 0.0375, 0.00001, 0.1):
        slave.step(step)
        slave.tick("MA")
        turns = slave.get("frame.position") / 2**21
        if step == 0.00001:  # the frame before is not over: that one stays
            continue
        assert abs(turns - slave.time * 50) < 2e-6 and slave.get("frame.good")
    latched = slave.get("frame")
    slave.step(0.1)
    assert slave.get("frame") == latched  # nobody asked
    assert slave.get("frame.bits") == 33 + 2 + 6 + 6
    slave.close()


def test_ssi_without_clocks_is_read_every_step(make: Make) -> None:
    result = simulate_fmu(make("ssi-25").path, stop_time=1.0, output_interval=1e-3, input=turning(1.0),
                          output=["frame.position", "position"], use_event_mode=False)
    for row in result[200::50]:
        assert abs(row["frame.position"] / 8192 - row["time"] * 50) < 2e-3


def test_faults(make: Make) -> None:
    slave = Slave(make("s3684-biss"))
    slave.step(0.2)
    slave.tick("MA")
    assert slave.get("nERR") and slave.get("nWARN")
    slave.set("fault.led_current_high", True)
    slave.step(0.1)
    slave.tick("MA")
    assert not slave.get("nERR") and slave.get("frame.good")
    slave.set("world.supply_mv", 4750.0)
    assert slave.get("world.supply_mv") == 4750.0
    slave.set("fault.led_current_high", False)
    slave.set("world.temperature", 25.125)
    slave.step(0.1)
    assert slave.get("world.temperature") == 25.125
    slave.close()


def emergencies(data: bytes) -> list[bytes]:
    return [body[:2] for number, body in frames(data) if number == 0xBF]


def test_faults_of_the_controller(make: Make) -> None:
    """Read 6004h while each lasts and behind it."""
    slave = Slave(make("f3668"))
    slave.step(0.5)
    slave.fetch("CanChannel")
    for name, during, behind in [("bus_off", [], ["4081", "0000"]), ("error_passive", ["2081"], ["0000"]),
                                 ("overrun", ["1081", "0000"], [])]:
        for on, codes, answers in [(True, during, name == "error_passive"), (False, behind, True)]:
            slave.set("fault." + name, on)
            data = slave.send("CanChannel", frame(0x63F, bytes.fromhex("4004600000000000")))
            slave.step(1e-3)
            data += slave.fetch("CanChannel")
            assert [code.hex() for code in emergencies(data)] == codes, name
            assert (0x5BF in [number for number, _ in frames(data)]) == answers, name
    slave.close()


def test_faults_and_settings_in_any_order(make: Make) -> None:
    """As importers set start values; and all texts at once."""
    slave = Slave(make("f3668"), fault__temperature_high=True, node=9)
    slave.step(1.0)
    emergencies = [data for number, data in frames(slave.fetch("CanChannel")) if number == 0x89]
    assert emergencies[0][:3] == bytes.fromhex("004209")
    assert (slave.get("error.code"), slave.get("error.register")) == (0x4200, 9)
    slave.close()


def test_texts(make: Make) -> None:
    fmu = make("s3684-rs485")
    texts = [v for v in fmu.description.modelVariables if v.type == "String"]
    slave = Slave(fmu, designation="a longer one")
    got = slave._slave.getString([v.valueReference for v in texts])
    want = ["a longer one" if v.name == "designation" else v.start for v in texts]
    assert len(texts) > 2 and got == want
    slave.close()


# ------------------------------------------------------------ states

@pytest.mark.parametrize("model", ["f3668", "s3684-rs485", "s3684-biss"])
def test_states_go_on_in_another_instance(make: Make, model: str) -> None:
    fmu = make(model)
    fault = next(name for name in fmu.names if name.startswith("fault.temperature"))

    def on(slave: Slave) -> list[object]:
        seen: list[object] = []
        for _ in range(50):
            slave.step(7e-3)
            if "MA" in fmu.names:
                slave.tick("MA")
            seen += [slave.get(v.name) for v in fmu.description.modelVariables
                     if v.causality == "output" and v.type not in ("Binary", "Clock")]
            seen += [slave.fetch(wire) for wire in ("CanChannel", "RS485") if wire + ".Tx_Data" in fmu.names]
        return seen

    first = Slave(fmu, shaft__speed=SPEED)
    first.step(0.3)
    first.set(fault, True)
    state, time = first.save(), first.time
    then = on(first)
    first.restore(state, time)
    assert on(first) == then
    second = Slave(fmu)
    second.restore(state, time)
    assert second.get(fault) and on(second) == then
    with pytest.raises(Exception):
        second.restore(state[:-1], time)
    first.close()
    second.close()


@pytest.mark.parametrize("version", ["3", "2"])
def test_calls_out_of_order_are_errors(make: Make, version: str) -> None:
    """The state machines of FMI 3.0 (2.3.1) and 2.0 (4.2.4); what is refused changes nothing."""
    fmu = make("s3684-biss", "--fmi", version)
    kind = FMU3Slave if version == "3" else FMU2Slave
    slave = kind(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber", instanceName="it")

    def refused(call: Callable[..., object], *arguments: object) -> None:
        with pytest.raises(FMICallException):
            call(*arguments)

    slave.instantiate()
    refused(slave.doStep, 0.0, 1.0)
    refused(slave.exitInitializationMode)
    if version == "2":
        slave.setupExperiment()
    slave.enterInitializationMode()
    refused(slave.enterInitializationMode)
    refused(slave.doStep, 0.0, 1.0)
    slave.exitInitializationMode()
    refused(slave.enterInitializationMode)
    slave.doStep(0.0, 1.0)
    refused(slave.doStep, 0.0, 1.0)
    for step in (-1.0, math.nan, math.inf, 1e12):
        refused(slave.doStep, 1.0, step)
    slave.doStep(1.0, 1.0)
    state = slave.getFMUState()
    refused(slave.setFMUState, None)
    size = len(bytes(slave.serializeFMUState(state)))
    serialize, byte = {"3": ("fmi3SerializeFMUState", ctypes.c_ubyte), "2": ("fmi2SerializeFMUstate", ctypes.c_char)}[version]
    for saved, room in ((state, size - 1), (None, size)):
        refused(getattr(slave, serialize), slave.component, saved, (byte * size)(), room)
    slave.terminate()
    refused(slave.doStep, 2.0, 1.0)
    slave.setFMUState(state)
    slave.doStep(2.0, 1.0)
    slave.freeFMUState(state)
    slave.freeInstance()


@pytest.mark.parametrize("version", ["3", "2"])
def test_a_step_begins_where_the_last_one_ended(make: Make, version: str) -> None:
    """FMI 3.0 (fmi3DoStep) and 2.0 (fmi2DoStep): currentCommunicationPoint is the end of the last step."""
    fmu = make("s3684-biss", "--fmi", version)
    kind = FMU3Slave if version == "3" else FMU2Slave
    slave = kind(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber", instanceName="it")
    slave.instantiate()
    begin = {"startTime": 7.5}
    if version == "2":
        slave.setupExperiment(**begin)
        begin = {}
    slave.enterInitializationMode(**begin)
    slave.exitInitializationMode()

    def state() -> bytes:
        saved = slave.getFMUState()
        data = bytes(slave.serializeFMUState(saved))
        slave.freeFMUState(saved)
        return data

    def only(point: float) -> None:
        before = state()
        for wrong in (0.0, point - 2e-6, point + 2e-6, point + 1e5, math.nan):
            if wrong != point:
                with pytest.raises(Exception, match="Error|error|status 3"):
                    slave.doStep(wrong, 0.5)
        assert state() == before

    only(7.5)
    slave.doStep(7.5, 0.5)
    only(8.0)
    saved = slave.getFMUState()
    for step in range(1000):
        slave.doStep(8.0 + step * 0.1, 0.1)
    only(108.0)
    slave.setFMUState(saved)
    only(8.0)
    slave.doStep(8.0, 0.1)
    slave.freeFMUState(saved)
    slave.freeInstance()


def test_the_next_step_begins_where_one_returned_early(make: Make) -> None:
    slave = Slave(make("s3684-rs485"), early=True)
    slave.step(0.2)
    slave.send("RS485", characters(bytes([0x40, 0x42, 0x02])))
    assert slave.step(1.0)
    moment = slave.time
    assert 0.2 < moment < 0.23
    slave.time = 1.2  # where it would be without early return
    with pytest.raises(Exception, match="Error|error|status 3"):
        slave.step(0.1)
    slave.time = moment
    slave.fetch("RS485")
    slave.step(1.0)
    assert slave.time == moment + 1.0
    slave.close()


NO_INSTANCE = """
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
one, none = (ctypes.c_uint32 * 1)(0), ctypes.c_void_p(None)
room, to = (ctypes.c_double * 8)(), ctypes.c_void_p(None)
wrong = []
for name in sys.argv[2].split():
    if "DoStep" in name or "Setup" in name or "EnterInit" in name:
        arguments = [ctypes.c_double(0)] * 2
    elif "State" in name:
        arguments = [ctypes.byref(to)] * 6
    elif name.startswith(("fmi2Get", "fmi2Set", "fmi3Get", "fmi3Set")):
        arguments = [one, ctypes.c_size_t(1), room, room, ctypes.c_size_t(1)]
        if "Binary" not in name:
            del arguments[3]
    else:
        arguments = []
    if getattr(library, name)(none, *arguments) != 3:
        wrong.append(name)
print(*wrong)
"""
CALLS = {
    "2": "SetupExperiment EnterInitializationMode ExitInitializationMode Terminate Reset DoStep GetReal SetReal "
    "GetInteger SetInteger GetBoolean SetBoolean GetString SetString GetFMUstate SetFMUstate GetStatus",
    "3": "EnterInitializationMode ExitInitializationMode Terminate Reset DoStep GetFloat64 SetFloat64 GetInt64 "
    "SetInt64 GetBoolean SetBoolean GetString SetString GetBinary SetBinary GetClock SetClock GetFloat32 "
    "GetFMUState SetFMUState UpdateDiscreteStates EnterEventMode EnterStepMode",
}


@pytest.mark.parametrize("version", ["3", "2"])
def test_no_instance_is_an_error(make: Make, version: str) -> None:
    fmu = make("s3684-biss", "--fmi", version)
    library = next(pathlib.Path(fmu.folder).glob("binaries/*/*.so"))
    names = " ".join(f"fmi{version}{name}" for name in CALLS[version].split())
    ended = subprocess.run([sys.executable, "-c", NO_INSTANCE, library, names], capture_output=True, text=True)
    assert (ended.returncode, ended.stdout.strip()) == (0, ""), ended.stderr


# ------------------------------------------------------------ rigs

RIG = """[rig]
[shaft main]
[encoder drive]
model = s3684-biss
shaft = main
wire = sim
[encoder second-one]
model = f3668
shaft = main
node = 9
wire = slcan
"""


def test_rig(make: Make, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "axis.ini"
    file.write_text(RIG)
    fmu = make(str(file))
    assert validate_fmu(fmu.path) == []
    assert "drive.shaft.angle" in fmu.names and "second_one.shaft.angle" not in fmu.names
    slave = Slave(fmu, drive__shaft__speed=SPEED)
    slave.step(0.5)
    slave.tick("drive.MA")
    assert (0x709, b"\0") in frames(slave.fetch("second_one.CanChannel"))
    assert abs(slave.get("drive.frame.position") / 2**21 - 25) < 2e-6
    assert slave.get("second_one.position") / 65536 == pytest.approx(25, abs=1e-4)
    slave.close()


def test_nodes_of_the_command_line(make: Make) -> None:
    """They share a shaft and a bus, with a serial number on the command line and without one."""
    for words in ((), ("--serial", "100")):
        slave = Slave(make("f3668", "--node", "1..3", *words), f3668_1__shaft__speed=SPEED)
        slave.step(0.5)
        booted = frames(slave.fetch("bus.CanChannel"))
        assert [one for one in booted if one[0] > 0x700] == [(0x701, b"\0"), (0x702, b"\0"), (0x703, b"\0")]
        for node in (1, 2, 3):
            assert slave.get(f"f3668_{node}.position") / 65536 == pytest.approx(25, abs=1e-4)
        slave.close()


def test_what_a_rig_file_says_for_others_is_named(tmp_path: pathlib.Path) -> None:
    """In one line, each word once."""
    file = tmp_path / "axis.ini"

    def told(text: str) -> str:
        file.write_text(text)
        words = [DREHGEBER, "fmu", str(file), "-o", str(tmp_path / "x.fmu")]
        return subprocess.run(words, capture_output=True, text=True, check=True).stderr

    assert told(RIG) == ""
    assert told(RIG + "pace = 1\nnvm = x.nvm\n") == f"drehgeber: {file}: not in an FMU, left out: nvm\n"
    both = RIG.replace("[encoder drive]", "motion = 60RPM\n[shaft b]\ndriver = main\n[encoder drive]")
    lines = both.replace("wire = sim", "wire = sim\nclock_hz = 100000\nline_delay_ns = 5\ntrace = x.vcd")
    assert told(lines + "trace = x.log\n").endswith(": trace, clock_hz and line_delay_ns\n")


SHARED = """[shaft motor]
motion = turn.csv
[shaft load]
driver = motor
ratio = 1:4
[rig]
include = nodes.ini
[encoder s]
model = s3684-biss
wire = sim
shaft = motor
temperature = warm.csv,STEP
"""
NODES = """[bus field]
wire = slcan
[encoder n]
model = f3668
bus = field
node = 1..2
shaft = load
"""


def test_all_of_a_rig_file_acts(make: Make, tmp_path: pathlib.Path) -> None:
    """Motions, gears, a bus, files that it names: nothing of it is asked for once the FMU is there."""
    texts = {"plant.ini": SHARED, "nodes.ini": NODES, "turn.csv": "0,0\n10,3600\n", "warm.csv": "0,20\n1.5,90\n"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    fmu = make(str(tmp_path / "plant.ini"))
    for name in texts:
        (tmp_path / name).unlink()
    assert validate_fmu(fmu.path) == []
    assert not [name for name in fmu.names if name.endswith(("shaft.angle", "n_1.CanChannel.Tx_Data"))]
    slave = Slave(fmu)
    slave.step(2.0)
    told = frames(slave.fetch("field.CanChannel"))
    assert (0x701, b"\0") in told and (0x702, b"\0") in told
    assert slave.get("n_2.position") == 2 * 65536 // 4
    slave.tick("s.MA")
    assert slave.get("s.frame.position") == 2 << 21
    assert slave.get("s.world.temperature") == 90.0
    state, at = slave.save(), slave.time
    slave.step(1.0)
    slave.restore(state, at)
    slave.step(0.5)
    assert slave.get("n_1.position") == 65536 * 5 // 8
    slave.close()


# ------------------------------------------------------------ other importers

MASTER = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="master" instantiationToken="master">
  <CoSimulation modelIdentifier="master" hasEventMode="true" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.001"/>
  <ModelVariables>
    <Float64 name="time" valueReference="100" causality="independent" variability="continuous"/>
    <Binary name="CanChannel.Rx_Data" valueReference="0" causality="input" variability="discrete" maxSize="2048"
      clocks="2" mimeType="{mime}"><Start value=""/></Binary>
    <Binary name="CanChannel.Tx_Data" valueReference="1" causality="output" variability="discrete" maxSize="2048"
      clocks="3" mimeType="{mime}"/>
    <Clock name="CanChannel.Rx_Clock" valueReference="2" causality="input" intervalVariability="triggered"/>
    <Clock name="CanChannel.Tx_Clock" valueReference="3" causality="output" intervalVariability="triggered"/>
    <Float64 name="count" valueReference="4" causality="output" variability="discrete"/>
    <Float64 name="heard" valueReference="5" causality="output" variability="discrete"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="1"/><Output valueReference="3"/><Output valueReference="4"/><Output valueReference="5"/>
  </ModelStructure>
</fmiModelDescription>
"""


def make_master(encoder: Fmu, folder: pathlib.Path) -> None:
    """master.fmu, with the terminals of the encoder: they have the same names."""
    library = folder / "master.so"
    source = pathlib.Path(__file__).with_name("master.c")
    subprocess.run(["gcc", "-O1", "-fPIC", "-shared", str(source), "-o", str(library)], check=True)
    mime = "application/org.fmi-standard.fmi-ls-bus.can; version=&quot;1.0.0&quot;"
    with zipfile.ZipFile(folder / "master.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", MASTER.format(mime=mime))
        archive.write(library, "binaries/x86_64-linux/master.so")
        name = "terminalsAndIcons/terminalsAndIcons.xml"
        archive.write(pathlib.Path(encoder.folder) / name, name)


def test_container_couples_terminals(make: Make, tmp_path: pathlib.Path) -> None:
    """A master's FMU and an encoder's, coupled terminal to terminal by fmucontainer, which serves the clocks.
    With the master first its release 2.0 sets clocks of the encoder, and no bytes."""
    encoder = make("f3668", "--node", "5")
    shutil.copy(encoder.path, tmp_path / "encoder.fmu")
    make_master(encoder, tmp_path)
    (tmp_path / "both.json").write_text(json.dumps({
        "name": "both.fmu", "step_size": 0.001, "fmu": ["encoder.fmu", "master.fmu"],
        "link": [["encoder.fmu", "CanChannel", "master.fmu", "CanChannel"]],
        "start": [["encoder.fmu", "shaft.speed", SPEED]],
        "output": [["master.fmu", "count", "count"], ["master.fmu", "heard", "heard"],
                   ["encoder.fmu", "position", "position"]]}))
    container = pathlib.Path(sys.executable).with_name("fmucontainer")
    done = subprocess.run([str(container), "-container", "both.json", "-fmi", "3", "-fmu-directory", ".",
                           "-no-auto-input", "-no-auto-output"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    result = simulate_fmu(str(tmp_path / "both.fmu"), stop_time=1.0, output_interval=1e-3,
                          output=["count", "heard", "position"])
    last = result[-1]
    # SYNC every step from 0.501 s on; what is heard in a step was sent in one before.
    assert 495 <= last["count"] <= 500
    assert last["heard"] == pytest.approx(last["position"], abs=2.5e-3 * 50 * 65536)


# ------------------------------------------------------------ the page

def test_page(tmp_path: pathlib.Path) -> None:
    """Its example prints what it says."""
    page = pathlib.Path(__file__).parents[2] / "platform/fmu/README.md"
    code, printed = re.findall(r"^```(?:python|text)\n(.*?)^```", page.read_text(), re.M | re.S)[:2]
    file = tmp_path / "axis.fmu"
    subprocess.run([DREHGEBER, "fmu", "s3684-biss", "--output", str(file)], check=True)
    done = subprocess.run([sys.executable, "-c", code.replace("/tmp/axis.fmu", str(file))], check=True,
                          capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] + "\n" == printed


# ------------------------------------------------------------ cost

def test_cost_of_a_step(make: Make, tmp_path: pathlib.Path) -> None:
    """A figure, and a bound that only a mistake breaks."""
    source = pathlib.Path(__file__).with_name("cost.c")
    program = tmp_path / "cost"
    subprocess.run(["gcc", "-O2", str(source), "-ldl", "-o", str(program)], check=True)
    for model in ("s3684-rs485", "s3684-biss", "f3668"):
        fmu = make(model)
        names = [fmu.names[name] for name in ("shaft.angle", "shaft.speed", "position")]
        library = pathlib.Path(fmu.folder) / "binaries" / "x86_64-linux" / "drehgeber.so"
        done = subprocess.run([str(program), str(library), fmu.description.guid, *map(str, names)],
                              check=True, capture_output=True, text=True)
        print(f"note: {model}: {done.stdout.strip()}", file=sys.stderr)
        assert float(done.stdout.split()[0]) < 100_000
