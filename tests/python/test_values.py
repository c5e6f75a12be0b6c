# SPDX-License-Identifier: MIT
"""Values that cannot be: said at once, with what could be, and nothing has happened."""

import math

import can
import pytest

from drehgeber import Clock, Encoder, EncoderError, RangeError, Rig, Shaft

BEYOND = (math.nan, math.inf, -math.inf, 1e30, 10**400)


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
    refuses(lambda: Shaft(Clock(), motion), "expected")


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


def test_rig_files_are_utf_8(tmp_path):
    path = tmp_path / "rig.ini"
    path.write_bytes(b"[rig]\n[encoder a]\nmodel = f3668 ; \xe4\nwire = sim\n")
    refuses(lambda: Rig(path), "rig.ini:3: byte 17", "UTF-8")
    path.write_bytes("[rig]\n[encoder a]\nmodel = f3668 ; ä\nwire = sim\n".encode())
    assert Rig(path).encoders["a"].powered


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
