# SPDX-License-Identifier: MIT
"""Encoders in this process: each model through its own wire, shafts, world, faults, memories, time. Golden
bytes are those of tests/unit/test_host.c, from the manuals."""
import resource
import warnings

import drehgeber
import pytest
from drehgeber import Clock, Encoder, EncoderError, Medium, ScpiError, Shaft, _native

ASK = bytes.fromhex("40 42 02")  # 42h, position
# Positions at 3.25 turns.
POSITIONS = {
    "s3674-rs485": 1 << 14,
    "s3684-rs485": 13 << 14,
    "s3674-biss": 1 << 19,
    "s3684-biss": 13 << 19,
    "f3658": 1 << 14,
    "f3668": 13 << 14,
    "ocd-ib-k1": 1 << 10,
    "ocd-ib-k2": 13 << 10,
    "ocd-ib-k3": 13 << 10,
    "ssi-13": 1 << 11,
    "ssi-25": 13 << 11,
    "ssi-28": 13 << 14,
}


def hiperface(reply: bytes) -> int:
    """The position in a reply to 42h, which has to be whole."""
    total = 0
    for byte in reply:
        total ^= byte
    assert len(reply) == 7 and reply[:2] == b"\x40\x42" and total == 0
    return int.from_bytes(reply[2:6], "big")


def read(encoder: Encoder) -> int:
    """The position as its own wire tells it."""
    if encoder.medium is Medium.CHARACTERS:
        return hiperface(encoder.request(ASK))
    if encoder.medium is Medium.FRAMES:
        encoder.can.send(0x63F, bytes.fromhex("40 04 60 00 00 00 00 00"))
        answer = encoder.can.recv()
        assert answer is not None and answer.id == 0x5BF and answer.data[:4] == b"\x43\x04\x60\0"
        return int.from_bytes(answer.data[4:], "little")
    if encoder.medium is Medium.WORDS:
        words = encoder.ring.cycle()
        return words[-1] | (words[0] << 16 if len(words) == 2 else 0)
    frame = encoder.clocked.frame()
    assert frame.good and not frame.error and not frame.warning
    return frame.position


@pytest.mark.parametrize("model", ["s3684-biss", "f3668", "s3684-rs485"])
def test_by_a_real_clock_too_it_was_on_for_a_second(model):
    """Time had gone on when it was made."""
    encoder = Encoder(model, clock=Clock(real=True))
    assert encoder.state()["mode"] != "initialising"
    if encoder.medium is Medium.EDGES:
        assert encoder.clocked.frame().error is False


def test_the_list_of_models_is_the_librarys():
    assert sorted(drehgeber.models()) == sorted(POSITIONS)


@pytest.mark.parametrize("model", POSITIONS)
def test_a_model_answers_on_its_wire(model):
    encoder = Encoder(model, shaft=f"{3.25 * 360}DEG")
    assert encoder.position == POSITIONS[model]
    assert read(encoder) == POSITIONS[model]


@pytest.mark.parametrize("model", POSITIONS)
def test_wires_that_it_has_not_are_refused(model):
    encoder = Encoder(model)
    own = {Medium.CHARACTERS: {"rs485"}, Medium.FRAMES: {"can"}, Medium.EDGES: {"clocked", encoder.protocol}, Medium.WORDS: {"ring"}}
    for wire in {"rs485", "can", "ring", "clocked", "biss", "ssi"} - own[encoder.medium]:
        with pytest.raises(EncoderError, match=f"speaks {encoder.protocol}"):
            getattr(encoder, wire)


class Later:
    """A library with a protocol and a medium that this package has not heard of."""

    def __init__(self, lib, ffi, medium):
        self.lib, self.medium, self.word = lib, medium, ffi.new("char[]", b"unheard-of")

    def __getattr__(self, name):
        return getattr(self.lib, name)

    def dg_host_protocol(self, host):
        return self.word

    def dg_host_medium(self, host):
        return self.medium


def test_a_medium_of_a_later_library_is_refused_by_name(monkeypatch):
    ffi, lib = _native.load()
    monkeypatch.setattr(_native, "load", lambda: (ffi, Later(lib, ffi, len(Medium))))
    with pytest.raises(EncoderError, match="f3668 speaks unheard-of, over a wire that is unknown here"):
        Encoder("f3668")


def test_a_protocol_of_a_later_library_has_the_wires_of_its_medium(monkeypatch):
    """And no master of another protocol, not even of one with the same medium."""
    ffi, lib = _native.load()
    monkeypatch.setattr(_native, "load", lambda: (ffi, Later(lib, ffi, int(Medium.EDGES))))
    encoder = Encoder("ssi-25", shaft="90DEG")
    assert encoder.clocked.frame().position == 1 << 11
    for wire in ("ssi", "biss", "rs485", "can", "ring"):
        with pytest.raises(EncoderError, match="ssi-25 speaks unheard-of"):
            getattr(encoder, wire)


def test_no_such_model():
    with pytest.raises(EncoderError, match="no model 's9'; there are .*f3668"):
        Encoder("s9")


# ---------------------------------------------------------------- time


def test_an_exchange_takes_its_time_on_the_line():
    """3 characters of 11 bits, 44 bit times of silence, 1 ms, 7 characters: 9600 Bd."""
    encoder = Encoder("s3684-rs485")
    assert encoder.clock.now == 0
    encoder.request(ASK)
    assert encoder.clock.now == pytest.approx((3 * 11 + 44 + 7 * 11) / 9600 + 0.001, abs=2e-6)


def test_encoders_share_a_line():
    line = drehgeber.Line()
    near = Encoder("s3684-rs485", line=line, shaft="90DEG")
    far = Encoder("s3674-rs485", line=line, address=0x41, shaft=Shaft(line.clock, "180DEG"))
    assert line.encoders == (near, far) and near.rs485 is far.rs485 is line
    assert line.uart == (9600, "E", 44)
    assert hiperface(line.request(ASK)) == 16384
    assert line.request(bytes.fromhex("41 42 03"))[2:6] == (32768).to_bytes(4, "big")
    near.power(False)
    assert line.request(ASK) == b"" and line.request(bytes.fromhex("41 42 03")) != b""
    far.close()
    assert line.encoders == (near,)
    with pytest.raises(EncoderError, match="has no RS485"):
        Encoder("f3668", line=line)


def test_silence_takes_its_timeout():
    encoder = Encoder("s3684-rs485")
    assert encoder.request(b"\x41\x42\x03", timeout=0.25) == b""
    assert encoder.clock.now == pytest.approx(3 * 11 / 9600 + 0.25, abs=1e-6)
    assert hiperface(encoder.request(ASK)) == 0


def test_time_passes_by_advance_alone():
    encoder = Encoder("f3668", shaft="60RPM")
    before = encoder.position
    assert encoder.position == before and encoder.can.recv() is None and encoder.clock.now == 0
    encoder.clock.advance(1.5)
    assert encoder.clock.now == 1.5 and encoder.position == 65536 * 3 // 2 + before
    with pytest.raises(ValueError, match="expected 0"):
        encoder.clock.advance(-1)


def test_real_time_passes_by_itself():
    clock = Clock(real=True)
    encoder = Encoder("f3668", clock=clock, shaft="60RPM")
    first = encoder.position
    before = clock.now
    while clock.now < before + 0.02:
        pass
    assert encoder.position > first
    with pytest.raises(ValueError, match="real time"):
        clock.advance(1)


def test_encoders_on_a_shaft_agree_at_one_instant():
    clock = Clock()
    shaft = Shaft(clock, "ramp:3000RPM,1S")
    encoders = [Encoder(model, shaft=shaft) for model in ("s3684-rs485", "s3684-biss", "f3668", "ssi-28")]
    for _ in range(50):
        clock.advance(0.0137)
        a, b, c, d = (encoder.position for encoder in encoders)
        assert a == b >> 5 == c == d


def test_a_clock_is_one():
    with pytest.raises(EncoderError, match="same clock"):
        Encoder("f3668", clock=Clock(), shaft=Shaft(Clock()))
    with pytest.raises(EncoderError, match="same clock"):
        Encoder("f3668").shaft = Shaft()
    with pytest.raises(EncoderError, match="same clock"):
        Shaft(Clock(), driver=Shaft())


def test_an_encoder_that_was_closed_is_left_alone():
    clock = Clock()
    encoder = Encoder("s3684-biss", clock=clock)
    encoder.close()
    encoder.close()
    clock.advance(1)
    node = Encoder("f3668", clock=clock)
    node.close()
    assert node.bus.nodes == ()


# ---------------------------------------------------------------- looks in a row


def test_positions_in_a_row_are_those_of_the_wire():
    encoder = Encoder("s3684-biss", shaft="sine:90DEG,2S")
    counts = encoder.positions(encoder.clock.now, 0.001, 100)
    assert len(set(counts)) == 100 and encoder.clock.now == 0
    for i in range(100):
        assert encoder.biss.frame().position == counts[i]
        encoder.clock.advance((i + 1) * 0.001 - encoder.clock.now)


def test_positions_of_one_without_power_are_refused():
    encoder = Encoder("s3684-biss")
    encoder.power(False)
    with pytest.raises(EncoderError, match="position"):
        encoder.positions(None, 0.001, 3)


def test_sine_and_cosine():
    """A quarter of a turn is 512 whole periods: sin 0, cos at its peak."""
    levels = Encoder("s3684-rs485", shaft="90DEG").sincos
    assert levels.sin_plus == levels.sin_minus
    assert levels.cos_plus - levels.cos_minus == pytest.approx(0.5, abs=0.001)
    with pytest.raises(EncoderError):
        _ = Encoder("f3668").sincos


# ---------------------------------------------------------------- shafts


@pytest.mark.parametrize(
    "motion, after, degrees",
    [
        ("0", 1, 0),
        ("90DEG", 1, 90),
        ("2.5rev", 1, 900),
        ("60RPM", 1.5, 540),
        ("-60RPM", 0.5, -180),
        ("sine:90DEG,2S", 0.5, 90),
        ("ramp:60RPM,1S", 2, 540),
        ("ramp:60RPM,1S,500MS", 10, 540),
    ],
)
def test_motions(motion, after, degrees):
    shaft = Shaft(motion=motion)
    shaft.clock.advance(after)
    assert shaft.position == pytest.approx(degrees, abs=1e-6)


@pytest.mark.parametrize(
    "motion", ["90", "1S", "sine:90DEG", "sine:2S,90DEG", "ramp:60RPM,1S,1S,1S", "saw:1DEG,1S", "fast", "5 REF", "60 RPM"]
)
def test_motions_that_are_none(motion):
    with pytest.raises(EncoderError, match="^motion '.*(; expected .*|valid: 0, 90DEG, .* FILE.csv)$"):
        Shaft(motion=motion)


def test_motions_out_of_range():
    with pytest.raises(EncoderError, match="sine:300REV,1S"):
        Shaft(motion="sine:300REV,1S")


def test_a_shaft_is_steered():
    shaft = Shaft()
    shaft.velocity = 60
    shaft.clock.advance(0.25)
    assert (shaft.position, shaft.velocity) == (90, 60)
    shaft.stop()
    shaft.position = 10
    shaft.clock.advance(5)
    assert (shaft.position, shaft.velocity) == (10, 0)
    shaft.acceleration = 600
    assert shaft.acceleration == 600
    shaft.move(370, rpm=600)
    assert shaft.position == 370 and shaft.clock.now > 5.25
    now = shaft.clock.now
    shaft.move(0, wait=False)
    assert shaft.clock.now == now
    with pytest.raises(EncoderError, match="2000000"):
        shaft.velocity = 2e6


def test_a_gear_follows_and_takes_no_command():
    motor = Shaft()
    wheel = Shaft(driver=motor, ratio=(1, 10))
    back = Shaft(driver=wheel, ratio=(1, -2))
    encoder = Encoder("f3668", shaft=wheel)
    motor.position = 900
    assert (wheel.position, back.position, encoder.position) == (90, -45, 16384)
    wheel.position = 180  # its offset
    motor.position = 0
    assert wheel.position == 90
    with pytest.raises(EncoderError, match="turned by its driver"):
        wheel.velocity = 1
    with pytest.raises(EncoderError, match="gear"):
        Shaft(driver=motor, ratio=(1, 0))


def test_a_recording_is_played(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("time_s,angle_deg\n0,0 # here\n\n1,90\n2,-90\n")
    shaft = Shaft(motion=str(path))
    for at, degrees in ((0.5, 45), (1, 90), (1.5, 0), (9, -90)):
        shaft.clock.advance(at - shaft.clock.now)
        assert shaft.position == pytest.approx(degrees, abs=1e-6)
    path.write_text("0,0\n1\n")
    with pytest.raises(EncoderError, match="run.csv:2: "):
        shaft.play(str(path))


def test_an_encoder_moves_to_another_shaft():
    clock = Clock()
    one, other = Shaft(clock, "90DEG"), Shaft(clock, "180DEG")
    encoder = Encoder("f3668", shaft=one)
    assert encoder.faults()  # with a panel, or without
    encoder.shaft = other
    assert encoder.position == 32768 and encoder.shaft is other
    with pytest.raises(ScpiError, match="encoder's .shaft"):
        encoder.ask("SHAF:VEL 60")


# ---------------------------------------------------------------- settings, world, faults


def test_settings_by_name():
    encoder = Encoder("f3668", node=5, power=False)
    names = {setting.name: setting for setting in encoder.settings()}
    assert encoder.get("node") == "5" and names["temperature"].always and not names["node"].always
    assert all(setting.help for setting in names.values())
    assert set(names["singleturn_ok"].words) == {"0", "1"}
    with pytest.raises(EncoderError, match="f3668: nod=5"):
        encoder.set("nod", 5)
    with pytest.raises(EncoderError, match="node=200"):
        encoder.set("node", 200)
    encoder.power(True)
    boot_up = encoder.can.recv()
    assert boot_up is None  # nobody listened
    encoder.power("CYCLE")
    encoder.clock.advance(1)
    boot_up = encoder.can.recv()
    assert boot_up is not None and (boot_up.id, boot_up.data) == (0x705, b"\0")
    with pytest.raises(EncoderError, match="node=6"):
        encoder.set("node", 6)


@pytest.mark.parametrize("model", POSITIONS)
def test_the_world_has_every_quantity(model):
    encoder = Encoder(model)
    names = [setting.name for setting in encoder.settings() if setting.always]
    assert names
    for name in names:
        healthy = getattr(encoder.world, name)
        assert float(encoder.get(name)) == healthy
        setattr(encoder.world, name, healthy)
        assert getattr(encoder.world, name) == healthy
        assert getattr(type(encoder.world), name).__doc__


def test_the_world_is_bent():
    encoder = Encoder("s3684-biss")
    encoder.world.temperature = -12.5
    encoder.clock.advance(1)
    assert int.from_bytes(encoder.biss.register(0x6A, 2), "little", signed=True) == -125
    assert encoder.world.temperature == -12.5
    assert encoder.world.singleturn_ok is True and encoder.world.supply_mv == 5000
    with pytest.raises(EncoderError, match="temperature"):
        encoder.world.temperature = 1e6
    with pytest.raises(AttributeError, match="temperatur'"):
        encoder.world.temperatur = 20


def test_an_led_ages_over_ten_minutes():
    encoder = Encoder("s3684-rs485")
    encoder.world.play("led_current_ua", [(0, 12000), (600, 60000)])
    seen = []
    for minute in range(11):
        encoder.clock.advance(minute * 60 - encoder.clock.now)
        seen.append(encoder.world.led_current_ua)
    assert seen == [12000 + 4800 * minute for minute in range(11)]
    encoder.clock.advance(60)
    assert encoder.world.led_current_ua == 60000 and encoder.clock._courses == []
    assert encoder.request(ASK) == bytes.fromhex("40 d0 1d 8d")  # it has told so by itself


def test_a_course_in_real_time():
    clock = Clock(real=True)
    encoder = Encoder("f3668", clock=clock)
    encoder.world.play("temperature", [(0, 20), (0.05, 30)])
    begin = clock.now
    while clock.now < begin + 0.06:
        assert 20 <= encoder.world.temperature <= 30
    assert encoder.world.temperature == 30


def test_what_is_sensed_on_the_way_counts():
    """A short rise within one long advance is on the error stack behind it."""
    encoder = Encoder("s3684-rs485")
    encoder.world.play("temperature", [(10, 37), (10, 200), (11, 200), (11, 37)])
    encoder.clock.advance(100)
    assert encoder.world.temperature == 37
    assert encoder.request(bytes.fromhex("40 50 10"))[2] != 0


def test_courses_are_replaced_and_stopped(tmp_path):
    encoder = Encoder("s3684-biss")
    (tmp_path / "warm.csv").write_text("time_s,degc\n0,20\n10,30\n")
    encoder.world.play("temperature", tmp_path / "warm.csv")
    assert encoder.world.temperature == 20
    encoder.clock.advance(5)
    assert encoder.world.temperature == pytest.approx(25, abs=0.02)
    encoder.world.play("temperature", [(1, 50)])
    encoder.clock.advance(0.5)
    assert encoder.world.temperature == pytest.approx(25, abs=0.02)
    encoder.clock.advance(1)
    assert encoder.world.temperature == 50
    encoder.world.play("singleturn_ok", [(1, 0), (2, 0), (2, 1)])
    encoder.clock.advance(1.5)
    assert not encoder.world.singleturn_ok
    encoder.world.stop("singleturn_ok")
    encoder.world.stop("singleturn_ok")
    encoder.clock.advance(5)
    assert not encoder.world.singleturn_ok


def test_a_course_is_exact_on_its_grid(tmp_path):
    encoder = Encoder("s3684-biss")
    (tmp_path / "warm.csv").write_text("\ufeff# degC\ntime_s,temperature\n0,20\n10,85.0009 # cut\n", encoding="utf-8")
    encoder.world.play("temperature", tmp_path / "warm.csv")
    encoder.clock.advance(1.2345)
    assert encoder.world.temperature == 28.021  # of 1.234 s
    encoder.clock.advance(10)
    assert encoder.world.temperature == 85


def test_a_course_loops_and_holds():
    encoder = Encoder("s3684-biss")
    encoder.world.play("supply_mv", [(0, 5000), (1, 4000), (3, 0)], loop=True, steps=True)
    encoder.world.play("singleturn_ok", [(0, True), (1, False)])
    seen = []
    for _ in range(6):
        encoder.clock.advance(0.9)
        seen.append((encoder.world.supply_mv, encoder.world.singleturn_ok))
    assert seen == [(5000, True), (4000, False), (4000, False), (5000, False), (4000, False), (4000, False)]


def test_what_is_assigned_ends_a_course():
    encoder = Encoder("f3668")
    encoder.world.play("temperature", [(0, 20), (10, 30)])
    encoder.clock.advance(1)
    encoder.world.temperature = 50
    encoder.clock.advance(20)
    assert encoder.world.temperature == 50 and encoder.clock._courses == []


@pytest.mark.parametrize("line", ["1;2", "1,x", "1,2,3", "1,1e3", "1,nan", "x,1"])
def test_lines_of_a_file_that_are_no_points(tmp_path, line):
    (tmp_path / "x.csv").write_text(f"time_s,temperature\n{line}\n")
    with pytest.raises(EncoderError, match="x.csv:2: expected time_s,temperature"):
        Encoder("f3668").world.play("temperature", tmp_path / "x.csv")


NO_TEXT = "no text, as it has a NUL; expected lines of text"
TOO_LONG = "more than 198 characters; expected a shorter line of text"


@pytest.mark.parametrize("name", ["/dev/zero", "sparse.csv", "long.csv", "zero.csv"])
def test_a_file_that_is_no_text_of_lines_ends_soon(tmp_path, name):
    """2 GiB without a line; a line of one character too many; a NUL. Nothing is read on, and memory stays."""
    with (tmp_path / "sparse.csv").open("wb") as file:
        file.truncate(2 << 30)
    (tmp_path / "long.csv").write_text("0,1 #" + "x" * 194)
    (tmp_path / "zero.csv").write_bytes(b"0,1 # \0\n")
    path, encoder = tmp_path / name, Encoder("s3684-biss")
    said = TOO_LONG if name == "long.csv" else NO_TEXT
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(EncoderError, match=f"{path}:1: {said}"):
        encoder.world.play("temperature", path)
    if name.endswith(".csv"):
        with pytest.raises(EncoderError, match=f"{path}:1: {said}"):
            encoder.shaft.play(str(path))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 32 << 10


def test_a_line_may_be_as_long_as_in_a_rig_file(tmp_path):
    """198 bytes and its end; a comment may be in any encoding, as the command takes it."""
    path, encoder = tmp_path / "x.csv", Encoder("f3668")
    path.write_bytes(b"0,20 # " + b"\xb0" * 191 + b"\r\n" + b"10,30 #" + b"x" * 191)
    encoder.world.play("temperature", path)
    encoder.clock.advance(5)
    assert encoder.world.temperature == 25


@pytest.mark.parametrize("points", [[], [(2, 5), (1, 5)]])
def test_points_that_are_no_course(points):
    with pytest.raises(EncoderError, match="needs points that go on in time"):
        Encoder("f3668").world.play("temperature", points)


def test_courses_of_nothing():
    with pytest.raises(EncoderError, match="temperatur'"):
        Encoder("f3668").world.play("temperatur", [(0, 1)])
    with pytest.raises(EncoderError, match="one behind 0"):
        Encoder("f3668").world.play("temperature", [(0, 1)], loop=True)


def test_a_fault_lasts_as_long_as_its_block():
    encoder = Encoder("s3684-rs485")
    with encoder.fault("led_current_high") as same:
        assert same is encoder and encoder.active_faults() == ["led_current_high"]
        # An error: 50h, with the warning bit since the code waits on the stack, too.
        assert encoder.request(ASK) == bytes.fromhex("40 d0 1d 8d")
        assert encoder.request(bytes.fromhex("40 50 10")) == bytes.fromhex("40 50 1d 0d")
    assert encoder.active_faults() == [] and hiperface(encoder.request(ASK)) == 0
    (fault,) = [fault for fault in encoder.faults() if fault["name"] == "led_current_high"]
    assert fault == {"name": "led_current_high", "kind": "WORLD", "chapter": "5.1.3",
                     "cause": "the LED of the scanner is worn out: its current is regulated up",
                     "effect": "1Dh on the error stack; 42h, 43h, 6Ah answer 1Dh; 44h channel 49h reads 40 mA"}


def test_faults_of_the_wire():
    encoder = Encoder("s3684-rs485", shaft="90DEG")
    encoder.set_fault("wire_drop", count=1)
    assert encoder.request(ASK) == b""
    assert hiperface(encoder.request(ASK)) == 16384
    with encoder.fault("wire_delay"):
        before = encoder.clock.now
        assert hiperface(encoder.request(ASK, timeout=1)) == 16384
        assert encoder.clock.now - before > 0.3
    encoder.set_fault("wire_drop", duration_ms=200)
    assert encoder.request(ASK) == b""
    encoder.clock.advance(0.2)
    assert hiperface(encoder.request(ASK)) == 16384


def test_faults_that_are_none_here():
    with pytest.raises(EncoderError, match="no_such_fault"):
        Encoder("f3668").set_fault("no_such_fault")
    with pytest.raises(EncoderError, match="wire_break"):
        Encoder("f3668").set_fault("wire_break")
    with pytest.raises(EncoderError, match="was on"):
        Encoder("f3668", power=False).faults()


def clocked(encoder, wire, count):
    """Levels of the line behind `count` rising edges at 1 MHz, then silence."""
    levels = []
    for _ in range(count):
        wire.clock(False)
        encoder.clock.advance(5e-7)
        levels.append(wire.clock(True))
        encoder.clock.advance(5e-7)
    encoder.clock.advance(1e-4)
    return levels


BENT = {
    "wire_drop": lambda line, good: all(line),  # no Ack
    "wire_delay": lambda line, good: line[:2] == good[:2] and not any(line[2:]),  # no start bit for 100 us
    "wire_damage": lambda line, good: sum(map(bool.__ne__, line, good)) == 1 and line[:4] == good[:4],
}


@pytest.mark.parametrize("fault", BENT)
def test_a_line_that_is_bent(fault):
    """As a master sees it that clocks; without life counter all frames are alike."""
    encoder = Encoder("s3684-biss", shaft="90DEG", lc=0)
    good = clocked(encoder, encoder.biss, 60)
    assert good[:4] == [True, False, False, True] and clocked(encoder, encoder.biss, 60) == good
    with encoder.fault(fault):
        assert encoder.active_faults() == [fault]
        for _ in range(3):
            assert BENT[fault](clocked(encoder, encoder.biss, 60), good)
    assert encoder.active_faults() == [] and clocked(encoder, encoder.biss, 60) == good


@pytest.mark.parametrize("model, open_line", [("s3684-biss", True), ("ssi-28", False)])
def test_a_line_that_is_cut(model, open_line):
    """At once, and as long as it lasts. A master inside stands in front of that."""
    encoder = Encoder(model, shaft="90DEG")
    wire = encoder.biss if model == "s3684-biss" else encoder.ssi
    assert set(clocked(encoder, wire, 60)) == {True, False}
    encoder.set_fault("wire_break")
    assert encoder.active_faults() == ["wire_break"] and wire.clock(True) == open_line
    assert clocked(encoder, wire, 60) == [open_line] * 60
    assert wire.frame().good
    encoder.clear_fault()
    assert encoder.active_faults() == [] and set(clocked(encoder, wire, 60)) == {True, False}


def test_lines_of_scpi():
    encoder = Encoder("f3668", shaft="90DEG")
    assert encoder.state()["position"] == 16384
    assert encoder.ask("WORL:TEMP 80") is None and encoder.world.temperature == 80
    with pytest.raises(ScpiError, match="-113") as caught:
        encoder.ask("NONS")
    assert caught.value.code == -113
    assert encoder.ask("*IDN?") is not None


# ---------------------------------------------------------------- memory, power, states


def test_a_memory_is_another_ones():
    """The mask of warnings, 23h: written, stored by command 01h, read by the next encoder."""
    encoder = Encoder("s3684-biss")
    encoder.biss.write_register(0x23, b"\x5a")
    encoder.biss.write_register(0x60, b"\x01")
    encoder.clock.advance(1)
    assert Encoder("s3684-biss").biss.register(0x23) == b"\0"
    assert Encoder("s3684-biss", memory=encoder.memory).biss.register(0x23) == b"\x5a"
    with pytest.raises(EncoderError, match="image"):
        Encoder("s3684-biss", memory=b"123")
    assert Encoder("ssi-25").memory == b""


def test_power():
    encoder = Encoder("s3684-rs485", power=False)
    assert not encoder.powered
    encoder.power(True)
    assert encoder.powered and hiperface(encoder.request(ASK)) == 0
    assert encoder.request(bytes.fromhex("40 53 13")) == b""  # a reset: deaf for 100 ms
    encoder.clock.advance(1)
    assert hiperface(encoder.request(ASK)) == 0
    encoder.power(False)
    with pytest.raises(EncoderError, match="nobody on the line has power"):
        encoder.request(ASK)
    silent = Encoder("ocd-ib-k3")
    silent.power(False)
    with pytest.raises(EncoderError, match="nothing comes back"):
        silent.ring.cycle()


def test_a_state_goes_on():
    encoder = Encoder("s3684-biss")
    encoder.world.temperature = 50
    encoder.biss.write_register(0x23, b"\x5a")
    state = encoder.save()
    other = Encoder("s3684-biss")
    other.clock.advance(1)
    other.restore(state)
    assert other.world.temperature == 50 and other.biss.register(0x23) == b"\x5a"
    with pytest.raises(EncoderError, match="another model"):
        Encoder("f3668").restore(state)


# ---------------------------------------------------------------- BiSS, SSI, INTERBUS


def test_a_biss_line_without_a_pulse_is_a_warning():
    encoder = Encoder("s3684-biss")
    with pytest.warns(UserWarning, match="s3684-biss: SLO is low until the first MA pulse .* or set sl_low_at_start=0$"):
        encoder.clock.advance(0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        encoder.clock.advance(1)
        Encoder("s3684-biss", hint_us=0, clock=encoder.clock)
        Encoder("ssi-25", clock=encoder.clock)
        clocked = Encoder("s3684-biss", clock=encoder.clock)
        clocked.biss.frame()
        encoder.clock.advance(1)


def test_registers_of_biss():
    biss = Encoder("s3684-biss").biss
    assert biss.register(0x78, 4)[0] == 0x04
    assert biss.write_register(0x23, b"\x5a") == 1 and biss.register(0x23) == b"\x5a"
    with pytest.raises(EncoderError, match="78h"):
        biss.write_register(0x78, b"\0")


def test_edges_of_a_clock():
    """SSI, 13 bits: high at rest, the most significant bit with the second falling edge."""
    encoder = Encoder("ssi-13", shaft="180DEG")
    bits = []
    assert encoder.ssi.clock(True)
    for _ in range(14):
        encoder.ssi.clock(False)
        encoder.clock.advance(1e-6)
        bits.append(encoder.ssi.clock(True))
        encoder.clock.advance(1e-6)
    gray = 4096 ^ 4096 >> 1
    assert bits[:13] == [bool(gray >> i & 1) for i in range(12, -1, -1)]


def test_words_of_a_ring():
    """A K3: the position in two words, the high one first."""
    ring = Encoder("ocd-ib-k3", shaft="540DEG").ring
    assert ring.cycle() == (0, 6144) and ring.cycle([0, 0]) == (0, 6144)
    assert ring.identify() == 0x0237
    with pytest.raises(EncoderError, match="word 65536: expected 0..65535"):
        ring.cycle([0x10000])


@pytest.mark.parametrize("wrong", ["x", [1.0], None])
def test_what_is_no_number_turns_no_shaft(wrong):
    shaft = Shaft()
    for call in (
        shaft.move,
        lambda value: shaft.move(0, rpm=value),
        lambda value: setattr(shaft, "position", value),
        lambda value: setattr(shaft, "velocity", value),
        lambda value: setattr(shaft, "acceleration", value),
        lambda value: shaft.replay([(0, value)]),
    ):
        with pytest.raises(TypeError):
            call(wrong)
    assert shaft.position == 0


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_what_is_not_finite_turns_no_shaft(wrong):
    shaft = Shaft()
    for call in (shaft.move, lambda value: setattr(shaft, "velocity", value)):
        with pytest.raises(EncoderError, match="expected -"):
            call(wrong)


def test_words_are_texts():
    with pytest.raises(TypeError, match="model None: expected a text"):
        Encoder(None)
    with pytest.raises(TypeError, match="motion 60: expected words"):
        Shaft(motion=60)


def test_a_state_of_another_length_is_refused():
    encoder = Encoder("f3668", shaft="90DEG")
    state = encoder.save()
    for wrong in (state + b"\0", state[:-1], b""):
        with pytest.raises(EncoderError, match="the state"):
            encoder.restore(wrong)
    encoder.restore(state)
    assert encoder.position == 1 << 14
