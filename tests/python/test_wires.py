# SPDX-License-Identifier: MIT
"""What happens between encoders on one wire: tests/unit has the rules, and the differential test the bytes; this is the door."""
import gc
import itertools
import weakref

import pytest
import serial
from drehgeber import CanBus, Clock, Encoder, EncoderError, Line, RangeError

ASK, ASK_FAR, ASK_ALL = (bytes.fromhex(text) for text in ("40 42 02", "41 42 03", "ff 42 bd"))
UPLOAD = bytes.fromhex("40 04 60 00 00 00 00 00")
START = (0, b"\x01\x00")
SYNC = 0x80
NUMBER = itertools.count()


# ---------------------------------------------------------------- a line


@pytest.fixture
def line():
    line = Line()
    Encoder("s3684-rs485", line=line, shaft="90DEG", name=f"near-{next(NUMBER)}")
    Encoder("s3684-rs485", line=line, shaft="180DEG", address=0x41)
    return line


def open_port(line):
    return serial.serial_for_url(f"drehgeber://{line.encoders[0].name}", 9600, parity="E", timeout=0.1)


def test_two_at_once_make_the_and_of_their_characters(line):
    near, far = line.request(ASK), line.request(ASK_FAR)
    assert len(near) == len(far) == 7 and near != far
    assert line.request(ASK_ALL) == bytes(a & b for a, b in zip(near, far))


def test_encoders_hear_each_other(line):
    """What comes at once behind the reply of another one goes on with it; a pause ends that."""
    with open_port(line) as port:
        port.write(ASK)
        assert len(port.read(7)) == 7
        port.write(ASK_FAR)
        assert port.read(7) == b""
        port.write(ASK_FAR)
        assert len(port.read(7)) == 7
        line.clock.advance(0.005)
        port.write(ASK)
        assert len(port.read(7)) == 7


def test_who_sends_is_deaf(line):
    """A request into the reply of another one is lost, and spoils nothing."""
    with open_port(line) as port:
        port.write(ASK)
        assert len(port.read(1)) == 1
        port.write(ASK)
        assert len(port.read(10)) == 6
        line.clock.advance(0.1)
        assert port.read(10) == b""


def test_a_request_forgets_what_was_said_before(line):
    with open_port(line) as port:
        port.write(ASK)
        line.clock.advance(1)
        assert port.in_waiting == 7
        assert line.request(ASK_FAR)[:2] == ASK_FAR[:2]


def test_a_reply_ends_with_the_power(line):
    near = line.encoders[0]
    with open_port(line) as port:
        for state in (False, "CYCLE"):
            port.write(ASK)
            assert len(port.read(2)) == 2
            near.power(state)
            assert port.read(10) == b""
            near.power(True)
            line.clock.advance(1)


def test_a_clock_with_others_on_it_gives_the_same(line):
    """Characters come one by one where something else moves with time, and all at once where nothing does."""
    alone = [(line.request(request), line.clock.now) for request in (ASK, ASK_FAR, ASK_ALL)]
    clock = Clock()
    Encoder("f3668", clock=clock)
    shared = Line(clock)
    for degrees, address in (90, 0x40), (180, 0x41):
        Encoder("s3684-rs485", line=shared, shaft=f"{degrees}DEG", address=address)
    assert [(shared.request(request), clock.now) for request in (ASK, ASK_FAR, ASK_ALL)] == alone


def test_who_was_never_on_is_left_alone():
    """Its shaft may turn; it hears nothing, and says nothing."""
    line, bus = Line(), CanBus()
    for encoder in Encoder("s3684-rs485", line=line, power=False), Encoder("f3668", bus=bus, power=False):
        encoder.shaft.position = 90
        assert not encoder.powered
    Encoder("s3684-rs485", line=line, address=0x41)
    line.encoders[0].shaft.position = 180
    assert (line.request(ASK), len(line.request(ASK_FAR))) == (b"", 7)


def test_a_line_has_an_end():
    line = Line()
    encoders = [Encoder("s3684-rs485", line=line, address=i) for i in range(0x40, 0x60)]
    with pytest.raises(RangeError, match="33 encoders on one wire: expected 32 at most"):
        Encoder("s3684-rs485", line=line)
    encoders[1].close()
    assert line.request(ASK_FAR) == b""
    Encoder("s3684-rs485", line=line, address=0x41, shaft="90DEG")  # has its place
    assert line.request(ASK_FAR)[3:5] == b"\x00\x40" and line.encoders[1] is encoders[2]
    assert line.request(bytes.fromhex("5f 42 1d"))[:1] == b"\x5f"


# ---------------------------------------------------------------- a CAN bus


def bus_of(*nodes, **words):
    bus = CanBus(**words)
    for node in nodes:
        Encoder("f3668", bus=bus, node=node)
    return bus, bus.port()


def heard(port):
    return list(iter(port.recv, None))


def test_each_frame_has_its_time():
    """Three TPDOs of 8 bytes or less at 250 kBd, sent at one moment."""
    bus, master = bus_of(1, 2, 3, pace=True)
    master.send(*START)
    bus.clock.advance(0.1)
    heard(master)
    seen = bus.watch()
    master.send(SYNC)
    bus.clock.advance(0.1)
    assert [frame.id for frame in seen] == [SYNC, 0x281, 0x282, 0x283] and {frame.at for frame in seen} == {0.1}
    frames = heard(master)
    gaps = [b.at - a.at for a, b in zip(frames, frames[1:])]
    assert [frame.id for frame in frames] == [0x281, 0x282, 0x283] and all(0.0002 < gap < 0.0006 for gap in gaps)


@pytest.mark.parametrize("arbitrate, order", [(False, [3, 1, 2]), (True, [1, 2, 3])])
def test_a_lower_identifier_goes_first(arbitrate, order):
    bus, master = bus_of(3, 1, 2, arbitrate=arbitrate)
    master.send(*START)
    heard(master)
    master.send(SYNC)
    assert [frame.id - 0x280 for frame in heard(master)] == order


def test_another_bit_rate_is_not_heard():
    """250 kBd as delivered."""
    for rate, answers in (250_000, 1), (500_000, 0), (0, 1):
        _, master = bus_of(1, bit_rate=rate)
        master.send(0x601, UPLOAD)
        assert len(heard(master)) == answers
    with pytest.raises(RangeError, match="bit_rate 1000001: expected 0..1000000"):
        CanBus(bit_rate=1_000_001)


def test_controllers_follow_their_bus():
    bus, master = bus_of(1, 2)
    bus.controller("passive")
    assert [(frame.id, frame.data[:2]) for frame in heard(master)] == [(0x81, b"\x20\x81"), (0x82, b"\x20\x81")]
    bus.controller("off")
    master.send(0x601, UPLOAD)
    assert heard(master) == []
    bus.controller("active")
    master.send(0x601, UPLOAD)
    assert [frame.id for frame in heard(master)][-1] == 0x581
    bus.controller("overrun")
    assert {frame.data[:2] for frame in heard(master)} >= {b"\x10\x81"}
    with pytest.raises(RangeError, match="'broken': expected active, passive, off or overrun"):
        bus.controller("broken")


def test_a_port_that_left_says_nothing():
    _, master = bus_of(1)
    master.close()
    with pytest.raises(EncoderError, match="the port, .* is closed"):
        master.send(0x601, UPLOAD)


def test_nobody_acknowledges():
    """Encoders show it on their LEDs."""
    bus, _ = bus_of(1)
    shown = [bus.nodes[0].state()["leds"]]
    for who in ("nobody", "somebody"):
        bus.company(who)
        bus.clock.advance(1)
        shown.append(bus.nodes[0].state()["leds"])
    assert shown[0] == shown[2] != shown[1]
    with pytest.raises(RangeError, match="expected unknown, somebody or nobody"):
        bus.company("everybody")


def test_nodes_come_and_go():
    """More than a bus has places for, one after the other; those that stay go on."""
    bus, master = bus_of(1)
    master.send(0x601, bytes.fromhex("2b 17 10 00 64 00 00 00"))
    for _ in range(200):
        node = Encoder("f3668", bus=bus, node=2)
        node.set_fault("wire_drop")
        node.close()
    heard(master)
    Encoder("f3668", bus=bus, node=2)
    bus.clock.advance(1)
    assert {frame.id for frame in heard(master)} == {0x701} and len(bus.nodes) == 2
    master.send(0x602, UPLOAD)
    assert [frame.id for frame in heard(master)] == [0x582]


def test_a_bus_that_another_one_joins():
    """One that was made with its encoder has room for others, who hear it."""
    first = Encoder("f3668", node=1)
    first.set_fault("wire_duplicate", count=3)
    second = Encoder("f3668", node=2, bus=first.bus)
    master = first.can
    for node in (1, 2, 1, 1):
        master.send(0x600 + node, UPLOAD)
    assert [frame.id for frame in heard(master)] == [0x581] * 2 + [0x582] + [0x581] * 4
    assert first.bus.nodes == (first, second)
    with pytest.raises(EncoderError, match="closed"):
        second.close()
        _ = second.bus.nodes and second.position


def test_an_encoder_with_a_fault_is_closed():
    """It may be closed again, and the bus holds it no longer."""
    bus, master = bus_of(2)
    node = Encoder("f3668", bus=bus, node=1)
    node.set_fault("wire_drop", duration_ms=10)
    node.close()
    node.close()
    bus.clock.advance(1)
    gone = weakref.ref(node)
    del node
    gc.collect()
    assert gone() is None
    master.send(0x602, UPLOAD)
    assert [frame.id for frame in heard(master)] == [0x582]


# ---------------------------------------------------------------- a clocked line


def test_levels_of_a_line_are_told():
    """SSI: the first falling edge latches; each rising one brings a bit, here a 1 and zeros, and the monoflop time ends it."""
    encoder = Encoder("ssi-13", shaft="180DEG", code="binary")
    levels = encoder.clocked.watch()
    assert not levels and encoder.clocked.watch() is levels
    for i in range(4):
        encoder.ssi.clock(i % 2 == 1)
        assert len(levels) == i // 3  # at once
        encoder.clock.advance(1e-6)
    told = [tuple(level) for level in levels]
    levels.clear()
    encoder.clock.advance(0.001)
    assert told == [(pytest.approx(3e-6), False)]
    assert [level.level for level in levels] == [True] and 20e-6 < levels[0].at < 40e-6


def test_levels_of_before_are_not_told():
    encoder = Encoder("ssi-13", shaft="180DEG", code="binary")
    for i in range(4):
        encoder.ssi.clock(i % 2 == 1)
        encoder.clock.advance(1e-6)
    encoder.clock.advance(1)
    levels = encoder.clocked.watch()
    encoder.clock.advance(1)
    assert not levels


def test_the_line_of_the_next_encoder_goes_through():
    """Behind its own frame an encoder shows what stands at SLI."""
    shown = []
    for level in (False, True):
        encoder = Encoder("s3674-biss")
        encoder.biss.sli(level)
        bits = []
        for i in range(2 * 60):
            bits.append(encoder.biss.clock(i % 2 == 1))
            encoder.clock.advance(0.5e-6)
        shown.append(bits[-1])
        assert encoder.biss.sli(level) is level
        encoder.clock.advance(0.001)
        assert encoder.biss.frame().good
    assert shown == [False, True]
    with pytest.raises(EncoderError, match="SLI"):
        Encoder("s3674-biss", power=False).biss.sli(True)
