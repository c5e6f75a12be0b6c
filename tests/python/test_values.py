# SPDX-License-Identifier: MIT
"""Values that cannot be: said at once, with what could be, and nothing has happened."""

import math
import socket
import warnings
from decimal import Decimal
from fractions import Fraction

import can
import numpy
import pytest

from drehgeber import Clock, Control, Encoder, EncoderError, HintWarning, RangeError, Rig, ScpiError, Shaft

NAN = math.nan
BEYOND = (NAN, math.inf, -math.inf, 1e30, 10**400, Decimal("NaN"), numpy.float32("nan"), Fraction(10**400))


def repr_of(value):
    return repr(value)[:8]


def refuses(call, *words):
    """Its error has these words."""
    with pytest.raises(RangeError) as caught:
        call()
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, EncoderError)
    for word in words:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("seconds", (*BEYOND, -1.0), ids=repr_of)
def test_time_is_as_long_as_a_clock_goes(seconds):
    encoder = Encoder("s3684-rs485")
    before = encoder.clock.now
    refuses(lambda: encoder.request(b"\x40\x42\x02", timeout=seconds), "timeout", "expected 0..")
    refuses(lambda: encoder.clock.advance(seconds), "expected 0..")
    refuses(lambda: encoder.positions(None, seconds, 2), "dt")
    if seconds != -1.0:
        refuses(lambda: encoder.positions(seconds, 0.1, 2), "moment")
    assert encoder.clock.now == before
    assert encoder.request(b"\x40\x42\x02")[:2] == b"\x40\x42"


def test_a_clock_ends_without_harm():
    encoder = Encoder("ssi-25")
    encoder.clock.advance(8.9e9)
    refuses(lambda: encoder.clock.advance(1e9), "expected 0..")
    assert encoder.ssi.frame().good


@pytest.mark.parametrize("timeout", BEYOND, ids=repr_of)
def test_timeouts_of_can(timeout):
    encoder = Encoder("f3668")
    refuses(lambda: encoder.can.wait(timeout), "timeout", "expected 0..")
    with can.Bus(interface="drehgeber", channel="f3668") as bus:
        refuses(lambda: bus._recv_internal(timeout), "timeout")
    encoder.can.send(0x63F, b"\x40\x00\x10\x00" + bytes(4))
    assert encoder.can.wait(0.1).id == 0x5BF


@pytest.mark.parametrize("value", (*BEYOND, 3e6), ids=repr_of)
def test_numbers_of_shafts(value):
    encoder = Encoder("f3668", shaft="90DEG")
    shaft = encoder.shaft
    refuses(lambda: setattr(shaft, "velocity", value), "rpm", "expected -2147483..2147483" if value == 3e6 else "")
    refuses(lambda: setattr(shaft, "acceleration", value))
    refuses(lambda: shaft.move(90, value), "rpm")
    if value != 3e6:
        refuses(lambda: setattr(shaft, "position", value), "degrees", "expected -")
        refuses(lambda: shaft.move(value), "degrees")
        refuses(lambda: shaft.replay([(value, 90)]), "seconds")
        refuses(lambda: shaft.replay([(1, value)]), "degrees")
    refuses(lambda: shaft.replay([(-1, 90)]), "seconds", "expected 0..")
    assert encoder.position == 16384


@pytest.mark.parametrize("motion", [
    "999999999999999RPM", "ramp:1RPM,-1S", "ramp:1RPM,1S,-1S", "sine:90DEG,-2S", "9" * 400 + "DEG", "9" * 400 + "RPM",
    f"ramp:1RPM,{'9' * 400}S",
])  # fmt: skip
def test_words_of_shafts(motion):
    refuses(lambda: Shaft(Clock(), motion), f"motion {motion!r}: '", "valid: 0, 90DEG")


def test_numbers_of_the_world_and_of_settings():
    encoder = Encoder("f3668", power=False)
    refuses(lambda: encoder.set("node", 128), "expected 1..127")
    refuses(lambda: encoder.set("mt_bits", 13), "expected 12 or 16")
    refuses(lambda: Encoder("s3684-rs485", date="today"), "expected 8..8 characters")
    for value in (*BEYOND, 1001):
        refuses(lambda value=value: setattr(encoder.world, "temperature", value), "temperature", "expected -")
    refuses(lambda: Shaft(driver=Shaft(), ratio=(1 << 40, 1)), "ratio")


def test_numbers_of_wires():
    biss, ring = Encoder("s3684-biss"), Encoder("ocd-ib-k3").ring
    refuses(lambda: biss.biss.register(300), "address", "expected 0..127")
    refuses(lambda: biss.biss.register(0, 0), "count", "expected 1..64")
    refuses(lambda: biss.biss.register(0, 1 << 40), "count")
    refuses(lambda: biss.biss.write_register(-1, b"1"), "address")
    refuses(lambda: ring.cycle((1 << 16,)))
    refuses(lambda: ring.cycle((0, 0, 0)), "expected 0..2")
    refuses(lambda: Encoder("f3668").can.send(-1))
    refuses(lambda: Encoder("f3668").can.send(1, dlc=-1))
    refuses(lambda: Encoder("f3668").can.send(NAN), "id nan: expected 0..2047")
    refuses(lambda: Encoder("f3668").can.send(1, dlc=NAN), "dlc")
    refuses(lambda: ring.cycle((NAN,)), "word nan")
    refuses(lambda: biss.biss.clock(2), "level 2: expected 0..1")


def test_texts_end_where_they_end():
    encoder = Encoder("s3684-rs485")
    refuses(lambda: Encoder("s3684-rs485\0x"), "NUL")
    refuses(lambda: Encoder("f3668", node="5\0"), "NUL")
    refuses(lambda: encoder.get("serial\0"), "NUL")
    refuses(lambda: encoder.set_fault("wire_drop\0"), "NUL")
    refuses(lambda: encoder.ask("*IDN?\0*RST"), "NUL")
    refuses(lambda: encoder.ask("ä"), "ASCII")
    assert encoder.active_faults() == []


def test_other_types():
    encoder = Encoder("s3684-rs485")
    for call in (lambda: Encoder(5), lambda: Encoder("f3668", shaft=5), lambda: setattr(encoder, "shaft", 5),
                 lambda: encoder.request("text"), lambda: encoder.request(b"\x40\x42\x02", timeout="1"),
                 lambda: encoder.restore("text"), lambda: encoder.ask(b"*IDN?"), lambda: Encoder("f3668").can.send(1, 5),
                 lambda: encoder.shaft.move("90"), lambda: setattr(encoder.world, "temperature", "80")):  # fmt: skip
        with pytest.raises(TypeError, match="expected"):
            call()
    assert encoder.request(memoryview(b"\x40\x42\x02")) == encoder.request(bytearray(b"\x40\x42\x02")) != b""


def test_a_closed_encoder_says_so():
    rs485, node, biss = Encoder("s3684-rs485"), Encoder("f3668", name="n"), Encoder("s3684-biss")
    port, clocked = node.can, biss.biss
    for encoder in (rs485, node, biss):
        encoder.close()
        encoder.close()
    for call in (lambda: node.can.send(0, b"\x01\x00"), lambda: port.send(0, b"\x01\x00"), lambda: node.ask("*IDN?"),
                 lambda: node.position, lambda: node.world.temperature, lambda: rs485.request(b"\x40\x42\x02"),
                 lambda: rs485.sincos, lambda: rs485.get("serial"), lambda: node.power(True), lambda: biss.save(),
                 lambda: biss.restore(b""), lambda: node.set_fault("wire_drop"), clocked.frame, lambda: node.powered,
                 lambda: biss.memory, lambda: node.state()):  # fmt: skip
        with pytest.raises(EncoderError, match="closed"):
            call()


def test_state_has_numbers():
    encoder = Encoder("f3668", shaft="90DEG", node=5)
    state = encoder.state()
    assert (state["position"], state["power"], state["node"], state["causes"]) == (16384, 1, 5, 0)
    assert state["mode"] == "preoperational" and state["errors"] is None
    assert encoder.state(raw=True)["position"] == "16384" and encoder.state(raw=True)["errors"] == "-"
    encoder.world.temperature = 200
    encoder.clock.advance(1)
    assert encoder.state()["errors"] == "4200" and encoder.state()["causes"] > 0
    assert Encoder("s3684-rs485", address=0x42).state()["address"] == 0x42
    for cob_id in (0x80000185, 0x185):  # TPDO2 gets that of TPDO1: 1801h:1, off and on again
        encoder.can.send(0x605, b"\x23\x01\x18\x01" + cob_id.to_bytes(4, "little"))
    assert encoder.state()["shared_ids"] == "185"
    encoder.power(False)
    assert encoder.state()["position"] is None and encoder.state()["power"] == 0


# ---------------------------------------------------------------- courses


@pytest.mark.parametrize("points", [
    [(0, 2000)], [(0, 20), (1, 2000)], [(0, 20), (1, -274)], [(0, NAN)], [(math.inf, 5)], [(NAN, 5)], [(-1, 5)], [(1e30, 5)],
    [(0, Decimal("NaN"))], [(0, 10**400)],
])  # fmt: skip
def test_a_refused_course_is_not_kept(points):
    encoder = Encoder("f3668")
    encoder.world.play("temperature", [(0, 20), (10, 30)])
    refuses(lambda: encoder.world.play("temperature", points), "expected")
    encoder.clock.advance(3)
    assert encoder.clock.now == 3 and encoder.world.temperature == 23  # that of before goes on


def test_points_of_files_and_states_can_be(tmp_path):
    path, encoder = tmp_path / "x.csv", Encoder("f3668")
    path.write_text("0,20\n1,1000.5\n")
    refuses(lambda: encoder.world.play("temperature", path), "temperature 1000.5: expected -273..1000")
    refuses(lambda: encoder.world.begin("temperature", path), "temperature")
    refuses(lambda: encoder.world.play("singleturn_ok", [(1, 2)]), "singleturn_ok 2: expected 0..1")
    encoder.clock.advance(3)
    assert encoder.world.temperature == Encoder("f3668").world.temperature and encoder.world.singleturn_ok
    path.write_text("0,-273.0009\n1,1000.0009\n")  # cut, as the command does
    encoder.world.play("temperature", path)
    assert encoder.world.temperature == -273
    encoder.clock.advance(1)
    assert encoder.world.temperature == 1000


@pytest.mark.parametrize("value", (*BEYOND, Decimal("sNaN"), 1e6, -274), ids=repr_of)
def test_a_refused_value_ends_no_course(value):
    encoder = Encoder("f3668")
    encoder.world.play("temperature", [(0, 20), (10, 30)])
    refuses(lambda: setattr(encoder.world, "temperature", value), "temperature ", ": expected -273..1000")
    encoder.clock.advance(5)
    assert encoder.world.temperature == 25


def test_a_closed_encoder_ends_its_courses():
    clock = Clock()
    other, encoder = Encoder("f3668", clock=clock), Encoder("f3668", clock=clock)
    for one in (other, encoder):
        one.world.play("temperature", [(0, 20), (10, 30)])
    encoder.world.play("supply_mv", [(0, 24000), (10, 20000)])
    encoder.close()
    clock.advance(5)
    assert other.world.temperature == 25 and len(clock._courses) == 1


# ---------------------------------------------------------------- faults, closed ones, power


LIMITS = [
    {"count": 0}, {"count": -1}, {"count": 1 << 32}, {"count": NAN}, {"probability": 2}, {"probability": -0.1},
    {"probability": NAN}, {"duration_ms": -5}, {"duration_ms": 0}, {"duration_ms": 1e-9}, {"duration_ms": 1e20}, {"duration_ms": NAN},
]  # fmt: skip


@pytest.mark.parametrize("limits", LIMITS, ids=str)
@pytest.mark.parametrize("name", ["wire_drop", "led_current_high"])
def test_a_refused_fault_does_nothing(name, limits):
    encoder = Encoder("s3684-rs485")
    refuses(lambda: encoder.set_fault(name, **limits), next(iter(limits)), "expected")
    refuses(lambda: encoder.fault(name, **limits).__enter__())
    assert encoder.active_faults() == []
    assert encoder.request(b"\x40\x42\x02")[:2] == b"\x40\x42"


def test_faults_that_are_refused_for_other_reasons_do_nothing():
    encoder = Encoder("s3684-rs485")
    with pytest.raises(ScpiError, match="single frames"):
        encoder.set_fault("led_current_high", count=3)
    for name in ("no_such_fault", "wire_drop,COUN 1", "wire_drop,COUN 1;:FAUL:SET wire_delay"):
        with pytest.raises(EncoderError, match="no_such_fault|wire_drop"):
            encoder.set_fault(name, count=3)
    for limits in ({"count": 1.5}, {"count": "3"}, {"duration_ms": "5,COUN 3"}, {"probability": "1"}):
        with pytest.raises(TypeError, match="expected"):
            encoder.set_fault("wire_drop", **limits)
    assert encoder.active_faults() == []


@pytest.mark.parametrize("limits", [
    {"count": numpy.int64(2)}, {"probability": 1e-6}, {"duration_ms": 1e-6}, {"duration_ms": Fraction(1, 3)}, {"duration_ms": 8e12},
    {"duration_ms": Decimal(5), "count": 3},
], ids=str)  # fmt: skip
def test_a_fault_takes_all_that_can_be(limits):
    encoder = Encoder("s3684-rs485")
    encoder.set_fault("wire_drop", **limits)
    assert encoder.active_faults() == ["wire_drop"]


def test_a_closed_encoder_that_had_a_panel_says_so(tmp_path):
    encoder = Encoder("s3684-rs485", shaft="90DEG")
    rig = Rig.of_text("[encoder a]\nmodel = f3668\nwire = slcan\nnvm = a.nvm\n[encoder b]\nmodel = s3684-rs485\nwire = pty\n", tmp_path)
    for one in (encoder, *rig.encoders.values()):
        assert one.ask("*IDN?") and one.active_faults() == []
    image = rig.encoders["a"].memory
    encoder.close()
    rig.close()
    rig.close()
    assert (tmp_path / "a.nvm").read_bytes() == image
    for one in (encoder, *rig.encoders.values()):
        for call in (lambda one=one: one.ask("*IDN?"), lambda one=one: one.ask("POW OFF"), lambda one=one: one.state(),
                     lambda one=one: one.set_fault("wire_drop"), lambda one=one: one.set_fault("wire_drop", count=1),
                     lambda one=one: one.clear_fault("wire_drop"), lambda one=one: one.clear_fault(), lambda one=one: one.faults(),
                     lambda one=one: setattr(one, "shaft", Shaft(one.clock)),
                     lambda one=one: one.world.play("temperature", [(0, 20)])):  # fmt: skip
            with pytest.raises(EncoderError, match="closed"):
                call()


def test_power_is_on_or_off():
    encoder = Encoder("f3668")
    for state in ("OFF", "ON", "cycle", None, 0.0, b"CYCLE", [1]):
        with pytest.raises(TypeError, match='expected True, False or "CYCLE"'):
            encoder.power(state)
        assert encoder.powered
    refuses(lambda: encoder.power(2), "power 2: expected 0..1")
    encoder.power(0)
    assert not encoder.powered
    encoder.power(1)
    assert encoder.powered
    encoder.power(False)
    encoder.power("CYCLE")
    assert encoder.powered


# ---------------------------------------------------------------- numbers of others


SECONDS = (numpy.float32(0.5), numpy.float16(0.5), numpy.int8(1), Fraction(1, 4), Decimal("0.25"))


@pytest.mark.parametrize("seconds", SECONDS, ids=repr)
def test_seconds_of_other_libraries(seconds):
    encoder = Encoder("f3668")
    encoder.clock.advance(seconds)
    assert encoder.clock.now == float(seconds)
    assert encoder.can.wait(seconds / 1000 if isinstance(seconds, Fraction) else 0 * seconds) is None
    assert Encoder("s3684-rs485").request(b"\x40\x42\x02", timeout=seconds)[:2] == b"\x40\x42"


def test_numbers_of_other_libraries():
    encoder = Encoder("s3684-biss")
    encoder.shaft.position = numpy.int8(90)
    assert encoder.shaft.position == 90
    assert len(encoder.positions(None, numpy.float32(0.001), numpy.int64(3))) == 3
    encoder.shaft.replay(numpy.array([[0, 0], [1, 90]]))
    encoder.shaft.move(Fraction(180, 2), numpy.int16(6000))
    assert encoder.shaft.position == 90
    encoder.world.temperature = Fraction(99, 2)
    encoder.world.singleturn_ok = numpy.bool_(False)
    encoder.world.play("supply_mv", numpy.array([[0, 5000], [1, 4000]], dtype=numpy.float32))
    encoder.clock.advance(1)
    assert (encoder.world.temperature, encoder.world.supply_mv, encoder.world.singleturn_ok) == (49.5, 4000, False)
    assert encoder.biss.register(numpy.uint8(0x78), numpy.uint8(4)) == encoder.biss.register(0x78, 4)
    assert Shaft(driver=encoder.shaft, ratio=(numpy.int8(2), -1)).position == -180
    node = Encoder("f3668")
    node.can.send(numpy.int16(0x63F), b"\x40\x00\x10\x00" + bytes(4))
    assert node.can.wait(0).id == 0x5BF
    assert len(Encoder("ocd-ib-k3").ring.cycle((numpy.uint16(1), numpy.uint16(0)))) == 2


def test_what_has_to_be_whole():
    shaft, encoder = Shaft(), Encoder("s3684-biss")
    for call in (lambda: Shaft(driver=shaft, ratio=(1.5, 1)), lambda: Shaft(driver=shaft, ratio=(1, Fraction(2))),
                 lambda: encoder.positions(None, 0.1, 2.5), lambda: encoder.biss.register(1.0), lambda: encoder.biss.register(0, 1.5),
                 lambda: Encoder("f3668").can.send(1.0), lambda: encoder.biss.clock(0.5)):  # fmt: skip
        with pytest.raises(TypeError, match="expected a whole number"):
            call()


# ---------------------------------------------------------------- texts and notes


def test_a_line_to_a_running_rig_is_ascii(tmp_path):
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "s"))
        listener.listen()
        control = Control(f"unix:{tmp_path}/s")
        server, _ = listener.accept()
        refuses(lambda: control.ask("ü"), "a line 'ü': expected ASCII")
        control.close()
        assert server.recv(1) == b""  # nothing was sent
        server.close()


@pytest.mark.parametrize("motion", ["٣RPM", "9٠DEG", "sine:90DEG,٢S", "\u20030"])
def test_digits_of_motions_are_ascii(motion):
    with pytest.raises(EncoderError, match="is not a number with a unit"):
        Shaft(Clock(), motion)


def test_a_note_points_at_who_called():
    encoder = Encoder("s3684-biss")
    with pytest.warns(HintWarning) as caught:
        encoder.clock.advance(0.2)
    assert issubclass(HintWarning, UserWarning) and [note.filename for note in caught] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", HintWarning)
        Encoder("s3684-biss", clock=encoder.clock)
        encoder.clock.advance(0.2)
