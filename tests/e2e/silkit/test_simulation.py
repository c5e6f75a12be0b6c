# SPDX-License-Identifier: MIT
"""Rigs in a SIL Kit simulation, with a master in this process: what goes over each wire, and that it is the same each
time."""
import struct

import pytest

from simulation import AUTONOMOUS, STEP_NS, Registry, Participant, Rig, pack, unpack

CHARACTERS = "application/vnd.drehgeber.characters.v1"
LATCH = "application/vnd.drehgeber.latch.v1"
FRAME = "application/vnd.drehgeber.frame.v1"
INTERBUS = "application/vnd.drehgeber.interbus.v1"
SHAFT = "application/vnd.drehgeber.shaft.v1"
PACKED = "application/vnd.drehgeber.can.v1"
POSITION_42H = bytes.fromhex("404202")
SECOND = 1_000_000_000
TURN = 1 << 32
UPLOAD_POSITION = bytes.fromhex("4004600000000000")
START_ALL = b"\x01\x00"


def rig_file(folder, name, uri, text):
    """Two buses of a rig have to be at the same registry; REGISTRY stands for it."""
    path = folder / f"{name}.ini"
    path.write_text(f"[rig]\nname = {name}\n" + text.replace("REGISTRY", uri))
    return path


def one(model, network):
    return f"[encoder a]\nmodel = {model}\nwire = silkit:REGISTRY,{network}\n"


def bus(name, *encoders, more=""):
    """Encoders, (name, model, lines...), on one wire."""
    text = f"[bus {name}]\nwire = silkit\naddress = REGISTRY,{name}\n{more}"
    for encoder, model, *lines in encoders:
        text += f"[encoder {encoder}]\nmodel = {model}\nbus = {name}\n" + "".join(f"{line}\n" for line in lines)
    return text


@pytest.fixture
def run(registry, tmp_path, rig, join):
    """run(text, steps, step, prepare): one rig and a master that calls step(master, k) in step k."""
    def begin(text, steps, step, prepare=lambda master: None):
        def each(master, now):
            k = now // STEP_NS
            if k == steps:
                master.stop()
            else:
                step(master, k)

        master = join("master", each, required=["cell", "master"])
        prepare(master)
        program = rig(rig_file(tmp_path, "cell", registry.uri, text))
        program.ready("ready rig")
        master.start()
        master.wait()
        assert program.wait() == 0
        assert program.errors.so_far() == ["drehgeber: SIL Kit: the simulation has ended"]
        return master

    return begin


def of(master, topic):
    return [(time, content) for time, name, content in master.data if name == topic]


def test_frames_are_handled_at_their_own_moment(run):
    """A SYNC of a step latches where the shaft is then; what that makes a node send is there a step later."""
    def step(master, k):
        if k == 200:
            master.send(0, START_ALL)
        if k > 200:
            master.send(0x80, b"")

    master = run("[shaft s]\nmotion = 60RPM\n" + one("f3668", "CAN1"), 700, step, lambda m: m.can("CAN1"))
    told = [(time, struct.unpack("<I", content)[0]) for time, name, content, _ in master.frames if name == 0x2BF]
    assert len(told) > 490
    assert told == [(time, (time - STEP_NS) * 65536 // SECOND) for time, _ in told]
    assert master.frames[0][:3] == (0, 0x73F, b"\0")


def test_packed_frames_are_those_of_a_can_bus(run):
    """Two buses with the same encoders are told the same; each frame of the packed one has its own moment."""
    def step(master, k):
        frames = {200: [(0, START_ALL)]}.get(k, [(0x605 + k % 2, UPLOAD_POSITION), (0x80, b"")] if k > 200 else [])
        for frame in frames:
            master.send(*frame)
        if frames:
            master.publish("CAN2/frames/to", PACKED, pack(k * STEP_NS, *frames))

    def prepare(master):
        master.can("CAN1")
        master.subscribe("CAN2/frames", PACKED)
        master.publish("CAN2/frames/to", PACKED)

    two = ("a", "f3668", "node = 5", "shaft = s"), ("b", "f3658", "node = 6", "shaft = s")
    more = [(name + "2", *lines) for name, *lines in two]
    master = run("[shaft s]\nmotion = 60RPM\n" + bus("CAN1", *two) + bus("CAN2", *more, more="frames = packed\n"), 700, step,
                 prepare)
    end = 700 * STEP_NS  # whether a message of the last moment arrives before the end is open
    alone = [(time, name, content) for time, name, content, _ in master.frames if time < end]
    packed = [(time, frame) for time, message in of(master, "CAN2/frames") if time < end for frame in unpack(message)]
    assert [(time, name, content) for time, (_, name, content) in packed] == alone
    assert len(alone) > 3 * 490
    told = [(time, at) for time, (at, name, _) in packed if name in (0x285, 0x286, 0x585, 0x586)]
    assert {time - at for time, at in told} == {STEP_NS}


@pytest.mark.parametrize("message", [b"", bytes(11), pack(0, (0x800, b"")), pack(0, (0x80, b"")) + b"\0", bytes(2_000_000)],
                         ids=["empty", "short", "identifier", "surplus", "long"])
def test_what_is_no_packed_frames_is_said_once(registry, tmp_path, rig, join, message):
    def step(master, now):
        master.publish("CAN1/frames/to", PACKED, message)
        if now == 20 * STEP_NS:
            master.stop()

    master = join("master", step, required=["cell", "master"])
    master.publish("CAN1/frames/to", PACKED)
    program = rig(rig_file(tmp_path, "cell", registry.uri, "[shaft s]\n" + bus("CAN1", ("a", "f3668"), more="frames = packed\n")))
    master.start()
    master.wait()
    assert program.wait() == 0
    assert program.errors.so_far() == [
        f"drehgeber: SIL Kit: CAN1/frames/to: a message of {len(message)} bytes is ignored, and so are all others of a wrong length; "
        "expected packed frames", "drehgeber: SIL Kit: the simulation has ended"]


def test_sdo_and_node_id_by_lss(run):
    """LSS: switch all, node-ID 5, store; then it answers as 5 after a reset."""
    lss = {210: bytes.fromhex("0401"), 220: bytes.fromhex("1105"), 230: bytes.fromhex("17"), 240: bytes.fromhex("0400")}

    def step(master, k):
        if k in lss:
            master.send(0x7E5, lss[k].ljust(8, b"\0"))
        if k == 250:
            master.send(0, bytes.fromhex("8200"))
        if k == 800:
            master.send(0x605, UPLOAD_POSITION)

    master = run("[shaft s]\nmotion = 90DEG\n" + one("f3668", "CAN1"), 1000, step, lambda m: m.can("CAN1"))
    seen = [(name, content) for _, name, content, _ in master.frames]
    assert (0x7E4, bytes.fromhex("1100000000000000")) in seen and (0x7E4, bytes.fromhex("1700000000000000")) in seen
    assert (0x705, b"\0") in seen
    assert (0x585, bytes.fromhex("4304600000400000")) in seen


def test_what_is_no_can_2_frame_is_left_alone(run):
    def step(master, k):
        for flags, content in ((0x200, bytes(8)), (0x1000, bytes(8)), (0x1000, bytes(64)), (0x8000, bytes(2000))):
            master.send(0x63F, content, flags=flags)
        master.send(0x63F, bytes(12))
        if k == 300:
            master.send(0x63F, UPLOAD_POSITION)

    master = run(one("f3668", "CAN1"), 400, step, lambda m: m.can("CAN1"))
    assert [content for _, name, content, _ in master.frames if name == 0x5BF] == [bytes.fromhex("4304600000000000")]


def test_rs485_requests_and_replies(run):
    """At 9600 Bd a request takes 3.4 ms, the silence behind it 4.6, its reaction 1, and a reply's first character
    1.1: with the step of 1 ms that follows it is there."""
    def step(master, k):
        if k >= 1500 and k % 50 == 0:
            master.publish("LINE/request", CHARACTERS, POSITION_42H)

    def prepare(master):
        master.subscribe("LINE/reply", CHARACTERS)
        master.publish("LINE/request", CHARACTERS)

    master = run("[shaft s]\nmotion = 90DEG\n" + bus("LINE", ("a", "s3684-rs485")), 2000, step, prepare)
    got = of(master, "LINE/reply")
    assert b"".join(content for _, content in got) == 10 * bytes.fromhex("40420000400042")
    assert {len(content) for _, content in got} == {1}
    first = [time for time, _ in got[::7]]
    assert first == [(1500 + 11 + 50 * n) * STEP_NS for n in range(10)]


@pytest.mark.parametrize("model, bits, life", [("s3684-biss", 21, True), ("ssi-25", 13, False)])
def test_clocked_lines(run, model, bits, life):
    """A frame at each step; once somebody latches, at each latch."""
    def step(master, k):
        if k >= 600 and k % 10 == 0:
            master.publish("CHAIN/latch", LATCH, b"")

    def prepare(master):
        master.subscribe("CHAIN/frame", FRAME)
        master.publish("CHAIN/latch", LATCH)

    master = run("[shaft s]\nmotion = 60RPM\n" + bus("CHAIN", ("a", model)), 1000, step, prepare)
    frames = [struct.unpack("<Q4B3IQ", content) for _, content in of(master, "CHAIN/frame")]
    good = [frame for frame in frames if frame[1:3] == (0, 0)]  # none of them before the encoder has begun
    assert len(good) > 440
    for time, _, _, _, count, multi, single, zero, raw in good:
        low, high = (((time + late) << bits) // SECOND for late in (0, 25_000))
        assert low <= multi << bits | single <= high and zero == 0
        assert raw >> count == 0 and raw != 0
    assert len({frame[3] for frame in good}) == (63 if life else 1)
    assert [frame[0] % (10 * STEP_NS) for frame in frames[-20:]] == 20 * [0]


def test_a_ring_cycles_with_the_steps(run):
    """The preset of a K2: 1 in bit 31 of OUT takes the present position to 0."""
    def step(master, k):
        if k == 500:
            master.publish("RING/out", INTERBUS, struct.pack("<4H", 0, 0, 0, 0))

    def prepare(master):
        master.subscribe("RING/in", INTERBUS)
        master.publish("RING/out", INTERBUS)

    master = run("[shaft s]\nmotion = 90DEG\n" + bus("RING", ("a", "ocd-ib-k2"), ("b", "ocd-ib-k2")), 1000, step,
                 prepare)
    cycles = [struct.unpack("<6H", content) for _, content in of(master, "RING/in")]
    assert len(cycles) == 1001 or len(cycles) == 1000
    assert cycles[900][:2] == (0, 2)
    assert cycles[900][2:4] == cycles[900][4:6] == (0, 1024)


def test_shafts_turn_and_are_turned(run):
    """Angle and speed go on until the next message, so there is none while they do, but one a second; a geared shaft
    follows."""
    def step(master, k):
        if k == 500:
            master.publish("cell/shaft/motor/turn", SHAFT, struct.pack("<qq", 10 * TURN, -2 * TURN))

    def prepare(master):
        master.subscribe("cell/shaft/motor", SHAFT)
        master.subscribe("cell/shaft/axis", SHAFT)
        master.publish("cell/shaft/motor/turn", SHAFT)

    text = "[shaft motor]\nmotion = 60RPM\n[shaft axis]\ndriver = motor\nratio = 1:2\n" + one("f3668", "CAN1")
    master = run(text, 2000, step, prepare)
    for shaft, ratio in ("motor", 1), ("axis", 2):
        told = of(master, f"cell/shaft/{shaft}")
        assert [time for time, _ in told] == [0, 501 * STEP_NS, 1501 * STEP_NS]
        for time, content in told:
            before, since = time < 501 * STEP_NS, time - 500 * STEP_NS
            wanted = (time * TURN // SECOND, TURN) if before else (10 * TURN - 2 * TURN * since // SECOND, -2 * TURN)
            angle, speed = struct.unpack("<qq", content)
            assert abs(angle - wanted[0] // ratio) <= 1 and speed == wanted[1] // ratio, (shaft, time)


def test_a_shaft_that_does_not_go_on_as_said_is_said_in_each_step(run):
    """A sine, until somebody stops it."""
    def step(master, k):
        if k == 100:
            master.publish("cell/shaft/motor/turn", SHAFT, struct.pack("<qq", 0, 0))

    def prepare(master):
        master.subscribe("cell/shaft/motor", SHAFT)
        master.publish("cell/shaft/motor/turn", SHAFT)

    master = run("[shaft motor]\nmotion = SINE:30DEG,2S\n" + one("f3668", "CAN1"), 1000, step, prepare)
    told = of(master, "cell/shaft/motor")
    assert [time // STEP_NS for time, _ in told] == [*range(102)]


def test_wrong_lengths_are_said_once(registry, tmp_path, rig, join):
    topics = {"LINE/request": CHARACTERS, "RING/out": INTERBUS, "cell/shaft/motor/turn": SHAFT, "CHAIN/latch": LATCH}

    def step(master, now):
        for topic, media in topics.items():
            for length in (5000, 3, 1):
                master.publish(topic, media, bytes(length))
        if now == 1500 * STEP_NS:
            master.publish("LINE/request", CHARACTERS, bytes(20_000_000))
        if now == 1600 * STEP_NS:
            master.stop()

    text = ("[shaft motor]\nmotion = 90DEG\n" + bus("LINE", ("a", "s3684-rs485")) + bus("CHAIN", ("b", "s3684-biss")) +
            bus("RING", ("c", "ocd-ib-k1")))
    master = join("master", step, required=["cell", "master"])
    for topic, media in topics.items():
        master.publish(topic, media)
    program = rig(rig_file(tmp_path, "cell", registry.uri, text))
    master.start()
    master.wait()
    assert program.wait() == 0
    *lines, end = program.errors.so_far()
    assert end == "drehgeber: SIL Kit: the simulation has ended"
    assert sorted(line.split(": ")[2] for line in lines) == sorted(topics)
    assert [line for line in lines if "; expected " not in line] == []


TWO = {
    "left": "[shaft s]\nmotion = SINE:30DEG,2S\n" + bus("CAN1", ("a", "f3668", "node = 5"), ("b", "f3658", "node = 6"),
                                                more="trace = left.log\n") +
            bus("LINE", ("c", "s3684-rs485"), ("d", "s3684-rs485", "address = 0x41"), more="trace = line.vcd\n"),
    "right": "[shaft s]\nmotion = 120RPM\n" + bus("CAN1", ("e", "f3668", "node = 7"), more="trace = right.log\n") +
             bus("CHAIN", ("f", "s3684-biss"), ("g", "s3684-biss"), more="trace = chain.vcd\n"),
}


def two_rigs(folder, keys=""):
    """Two rigs, with more keys of their first bus, and a master for two seconds. What the rigs have written, and what
    the master has heard."""
    def step(master, now):
        k = now // STEP_NS
        if k == 200:
            master.send(0, START_ALL)
        if k > 210:
            master.send(0x80, b"")
            master.send((0x605, 0x606, 0x607)[k % 3], UPLOAD_POSITION)
        if k > 1500 and k % 40 == 0:
            master.publish("LINE/request", CHARACTERS, POSITION_42H)
            master.publish("right/shaft/s/turn", SHAFT, struct.pack("<qq", k << 25, k << 30))

    registry = Registry()
    master = Participant(registry.uri, "master", step, required=["left", "right", "master"])
    rigs = []
    try:
        master.can("CAN1")
        for topic, media in (("LINE/reply", CHARACTERS), ("CHAIN/frame", FRAME), ("left/shaft/s", SHAFT),
                             ("right/shaft/s", SHAFT)):
            master.subscribe(topic, media)
        for topic, media in (("LINE/request", CHARACTERS), ("right/shaft/s/turn", SHAFT)):
            master.publish(topic, media)
        rigs = [Rig(rig_file(folder, name, registry.uri, text.replace("wire = silkit\n", f"wire = silkit\n{keys}", 1)),
                    "--quiet", "--time=virtual:2S") for name, text in TWO.items()]
        master.start()
        master.wait()
        assert [one.wait() for one in rigs] == [0, 0]
        assert [one.errors.so_far() for one in rigs] == [[], []]
    finally:
        master.close()
        for program in rigs:
            program.close()
        registry.end()
    traces = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".log", ".vcd")}
    before_the_end = [[entry for entry in sorted(heard) if entry[0] < 2 * SECOND - STEP_NS]
                      for heard in (master.frames, master.data)]
    return traces, *before_the_end


def test_three_runs_of_two_rigs_are_the_same(tmp_path):
    """Also when messages are sent one by one."""
    runs = []
    for name, keys in ("1", ""), ("2", ""), ("3", "aggregate = 0\n"):
        (tmp_path / name).mkdir()
        runs.append(two_rigs(tmp_path / name, keys))
    traces, frames, data = runs[0]
    assert sorted(traces) == ["chain.vcd", "left.log", "line.vcd", "right.log"]
    assert len(frames) > 3 * 1700 and len(data) > 3900
    for other in runs[1:]:
        for name, content in traces.items():
            assert other[0][name] == content, name
        assert other[1:] == (frames, data)


@pytest.mark.parametrize("step_us", [250, 20000])
def test_step_size_is_the_rigs_own(registry, rig, join, step_us):
    """A rig may step finer or coarser than its master; a frame is handled at its moment all the same."""
    def step(master, now):
        k = now // STEP_NS
        if k == 200:
            master.send(0, START_ALL)
        if k > 200:
            master.send(0x80, b"")
        if k == 600:
            master.stop()

    master = join("master", step, required=["f3668", "master"])
    master.can("CAN1")
    program = rig("f3668", f"--silkit={registry.uri},CAN1", "--shaft", "60RPM", "--set", f"step_us={step_us}", "--quiet")
    master.start()
    master.wait()
    assert program.wait() == 0 and program.errors.so_far() == []
    told = [struct.unpack("<I", content)[0] for _, name, content, _ in master.frames if name == 0x2BF]
    at = [position * 1000 / 65536 for position in told]
    assert len(at) > 370 and at == sorted(at)
    assert all(abs(moment - round(moment)) < 0.02 for moment in at)


def test_autonomous_time_begins_by_itself(registry, rig, join):
    """Nobody has to wait, and nobody coordinates."""
    program = rig("f3668", f"--silkit={registry.uri},CAN1,node", "--set", "time=autonomous")
    program.ready()

    def step(master, now):
        if now // STEP_NS % 100 == 0:
            master.send(0x63F, UPLOAD_POSITION)
        if any(frame[1] == 0x5BF for frame in master.frames):
            master.stop()

    master = join("master", step, mode=AUTONOMOUS)
    master.can("CAN1")
    master.start()
    master.wait()
    assert program.end() == 0
    assert program.errors.so_far() in ([], ["drehgeber: SIL Kit: master has left the simulation"])


def test_real_time_needs_no_steps(registry, rig, join):
    program = rig("f3668", f"--silkit={registry.uri},CAN1", "--set", "time=real", "--shaft", "90DEG")
    program.ready()
    master = join("master", mode=AUTONOMOUS)
    number = master.can("CAN1")
    master.subscribe("f3668/shaft/main", SHAFT)
    master.start()
    master.until(lambda: master.is_ready)
    for _ in range(10):
        seen = len(master.frames)
        master.send(0x63F, UPLOAD_POSITION, number=number)
        master.until(lambda: len(master.frames) > seen)
        assert master.frames[-1][1:3] == (0x5BF, bytes.fromhex("4304600000400000"))
    master.until(lambda: of(master, "f3668/shaft/main"))
    assert of(master, "f3668/shaft/main")[-1][1] == struct.pack("<qq", TURN // 4, 0)
    assert program.end() == 0
