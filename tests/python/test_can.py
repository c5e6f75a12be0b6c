# SPDX-License-Identifier: MIT
"""A CAN bus in this process, by itself, by python-can and by canopen."""
import threading
import time

import can
import canopen
import drehgeber
import pytest
from drehgeber import CanBus, Clock, Encoder, EncoderError

PATIENCE_S = 20  # for a thread of python-can on a busy machine
UPLOAD = bytes.fromhex("40 04 60 00 00 00 00 00")  # 6004h, position
START = (0, b"\x01\x00")
SYNC = 0x80


def heartbeat_every(ms):
    """A download of 1017h. The first heartbeat comes at once."""
    return bytes.fromhex("2b 17 10 00") + ms.to_bytes(4, "little")


# What a fault of the controller says to a request while it lasts, and behind its end: codes of EMCYs
# and the answer.
CONTROLLER = {
    "bus_off": ([], [0x8140, 0, "answer"]),
    "error_passive": ([0x8120, "answer"], [0, "answer"]),
    "overrun": ([0x8110, 0], ["answer"]),
}
BEGIN = {
    "call": lambda encoder, name: encoder.set_fault(name),
    "SCPI": lambda encoder, name: encoder.ask(f"FAUL:SET {name}"),
}
END = {
    "call": lambda encoder, name: encoder.clear_fault(name),
    "all": lambda encoder, name: encoder.clear_fault(),
    "SCPI": lambda encoder, name: encoder.ask("FAUL:CLE"),
}


def said(port):
    port.send(0x63F, UPLOAD)
    heard = []
    while frame := port.recv():
        heard.append("answer" if frame.id == 0x5BF else int.from_bytes(frame.data[:2], "little"))
    return heard


@pytest.fixture
def node():
    encoder = Encoder("f3668", bus=CanBus(clock=Clock()))
    port = encoder.bus.port()
    return encoder, port


@pytest.mark.parametrize("end", END)
@pytest.mark.parametrize("begin", BEGIN)
@pytest.mark.parametrize("name", CONTROLLER)
def test_faults_of_the_controller(node, name, begin, end):
    encoder, port = node
    during, behind = CONTROLLER[name]
    BEGIN[begin](encoder, name)
    assert encoder.active_faults() == [name] and said(port) == during
    END[end](encoder, name)
    assert encoder.active_faults() == [] and said(port) == behind


@pytest.mark.parametrize("begin", ["call", "SCPI"])
@pytest.mark.parametrize("name", CONTROLLER)
def test_faults_of_the_controller_with_an_end(node, name, begin):
    encoder, port = node
    during, behind = CONTROLLER[name]
    if begin == "call":
        encoder.set_fault(name, duration_ms=100)
    else:
        encoder.ask(f"FAUL:SET {name},DUR 100MS")
    encoder.clock.advance(0.099)
    assert said(port) == during
    encoder.clock.advance(0.002)
    assert encoder.active_faults() == [] and said(port) == behind


@pytest.fixture
def eds(tmp_path):
    path = tmp_path / "f3668.eds"
    path.write_text(drehgeber.eds("f3668"))
    return str(path)


def test_an_eds_is_the_commands(eds):
    assert "[6004]" in drehgeber.eds("f3668") and "f3658" in drehgeber.eds("f3658")
    for model in ("s3684-biss", "s9"):
        with pytest.raises(EncoderError, match=f"{model} is no CANopen model"):
            drehgeber.eds(model)


# ---------------------------------------------------------------- the bus


def test_masters_hear_each_other_and_all_nodes():
    clock = Clock()
    bus = CanBus(clock=clock)
    nodes = [Encoder("f3668", bus=bus, node=i, shaft=f"{i * 90}DEG") for i in (1, 2, 3)]
    assert bus.nodes == tuple(nodes) and nodes[0].bus is bus
    one, other = bus.port(), bus.port()
    one.send(*START)
    one.send(SYNC)
    heard = []
    while frame := other.recv():
        heard.append(frame)
    sync = [i for i, frame in enumerate(heard) if frame.id == SYNC]
    assert len(sync) == 1
    positions = {frame.id: frame.data[:4] for frame in heard[sync[0] :]}
    for i in (1, 2, 3):
        assert positions[0x280 + i] == (i << 14).to_bytes(4, "little")
    assert one.recv() is not None
    other.close()
    one.send(SYNC)
    assert other.recv() is None


def test_nodes_hear_each_other():
    """1016h: node 2 watches the heartbeat of node 1, and tells when it ends (8130h)."""
    bus = CanBus()
    nodes = [Encoder("f3668", bus=bus, node=i) for i in (1, 2)]
    master = bus.port()
    master.send(0x601, heartbeat_every(100))
    master.send(0x602, bytes.fromhex("23 16 10 01 2c 01 01 00"))
    assert [frame.data[0] for frame in iter(master.recv, None) if frame.id & 0x580 == 0x580] == [0x60, 0x60]
    bus.clock.advance(1)
    assert {frame.id for frame in iter(master.recv, None)} == {0x701}
    nodes[0].power(False)
    bus.clock.advance(1)
    assert [frame.id for frame in iter(master.recv, None)] == [0x082]


def test_a_full_bus():
    """127 nodes, which all answer one SYNC: more frames than wait for a node at once."""
    bus = CanBus()
    nodes = [Encoder("f3668", bus=bus, node=i, shaft=f"{i}DEG") for i in range(1, 128)]
    master = bus.port()
    master.send(*START)
    for _ in iter(master.recv, None):
        pass
    master.send(SYNC)
    heard = {frame.id - 0x280: int.from_bytes(frame.data[:4], "little") for frame in iter(master.recv, None)}
    assert heard == {i: node.position for i, node in enumerate(nodes, 1)}
    assert heard[90] == 1 << 14


def test_frames_come_at_their_moments():
    """A heartbeat of 100 ms in one long advance: none is lost, none is late."""
    encoder = Encoder("f3668")
    port = encoder.can
    port.send(0x63F, heartbeat_every(100))
    assert {frame.id for frame in iter(port.recv, None)} == {0x5BF, 0x73F}
    encoder.clock.advance(100)
    frames = list(iter(port.recv, None))
    assert len(frames) == 1000 and {frame.id for frame in frames} == {0x73F}
    assert [round(b.at - a.at, 9) for a, b in zip(frames, frames[1:])] == [0.1] * 999


def test_a_node_that_is_switched_on_says_so_at_once():
    encoder = Encoder("f3668", bus=CanBus())
    port = encoder.bus.port()
    encoder.power("CYCLE")
    frame = port.recv()
    assert frame is not None and (frame.at, frame.id, frame.data) == (0, 0x73F, b"\0")


def test_remote_frames():
    encoder = Encoder("f3668")
    encoder.can.send(*START)
    assert list(iter(encoder.can.recv, None))  # asynchronous PDOs tell where it is
    encoder.can.send(0x73F, remote=True, dlc=1)  # node guarding
    answer = encoder.can.recv()
    assert answer is not None and (answer.id, answer.data, answer.remote) == (0x73F, b"\x05", False)


@pytest.mark.parametrize(
    "id, data, said",
    [
        (0x800, b"", "id 2048: expected 0..2047"),
        (-1, b"", "id -1: expected 0..2047"),
        (1, bytes(9), "length of data 9: expected 0..8"),
    ],
)
def test_frames_that_are_none(id, data, said):
    with pytest.raises(EncoderError, match=said):
        Encoder("f3668").can.send(id, data)


def test_names_of_buses():
    bus = CanBus("test-names")
    assert CanBus.named("test-names") is bus
    with pytest.raises(EncoderError, match="already") as caught:
        CanBus("test-names")
    assert caught.value.code == 0  # not the library's
    with pytest.raises(EncoderError, match="has no CAN"):
        Encoder("s3684-biss", bus=bus)
    with pytest.raises(EncoderError, match="no.*canopen|speaks biss"):
        _ = Encoder("s3684-biss").bus


# ---------------------------------------------------------------- python-can


def test_python_can_joins_a_bus_by_name():
    rig = CanBus("rig")
    Encoder("f3668", bus=rig, node=7, shaft="90DEG")
    with can.Bus(interface="drehgeber", channel="rig") as bus:
        bus.send(can.Message(arbitration_id=0x607, data=UPLOAD, is_extended_id=False))
        answer = bus.recv(0)
        assert answer.arbitration_id == 0x587 and answer.data[4:] == (16384).to_bytes(4, "little")
        assert answer.timestamp == 0 and not answer.is_extended_id
        assert answer.is_rx and "rig" in answer.channel
        for refused in (
            can.Message(arbitration_id=0x607, data=UPLOAD, is_extended_id=True),
            can.Message(arbitration_id=0x607, data=UPLOAD, is_extended_id=False, is_fd=True),
        ):
            bus.send(refused)
            assert bus.recv(0) is None


def test_python_can_makes_an_encoder():
    with can.Bus(interface="drehgeber", channel="f3668?node=5&shaft=60RPM") as bus:
        bus.advance(1.5)
        bus.set_filters([{"can_id": 0x585, "can_mask": 0x7FF}])
        bus.send(can.Message(arbitration_id=0x605, data=UPLOAD, is_extended_id=False))
        answer = bus.recv(0)
        assert int.from_bytes(answer.data[4:], "little") == bus.encoder.position
        assert int.from_bytes(answer.data[4:], "little") / 65536 == pytest.approx(1.5, abs=0.01)
        bus.send(can.Message(arbitration_id=0x605, data=heartbeat_every(100), is_extended_id=False))
        assert bus.recv(0.01).data[0] == 0x60
        bus.advance(1)  # heartbeats that pass no filter
        assert bus.recv(0) is None


@pytest.mark.parametrize("channel", ["nobody", "s9?shaft=60RPM", ""])
def test_python_can_has_no_such_channel(channel):
    with pytest.raises(can.CanInitializationError, match="and no model, e.g. channel='f3668"):
        can.Bus(interface="drehgeber", channel=channel)


@pytest.mark.parametrize("channel", ["s3684-biss", "f3668?node=200", "f3668?shaft=fast", "f3668?nod=1"])
def test_python_can_makes_no_such_encoder(channel):
    with pytest.raises(EncoderError):
        can.Bus(interface="drehgeber", channel=channel)


def test_waiting_moves_no_virtual_time():
    with can.Bus(interface="drehgeber", channel="f3668") as bus:
        begin = time.monotonic()
        assert bus.recv(0.05) is None
        assert time.monotonic() - begin >= 0.05 and bus.bus.clock.now == 0
        notifier = can.Notifier(bus, [can.BufferedReader()], timeout=0.01)
        time.sleep(0.05)
        notifier.stop()
        assert bus.bus.clock.now == 0


SAVE = bytes.fromhex("23 10 10 01") + b"save"


def test_an_answer_that_takes_its_time_is_waited_for():
    """14 ms (line 778), and not longer than the timeout."""
    with can.Bus(interface="drehgeber", channel="f3668") as bus:
        bus.send(can.Message(arbitration_id=0x63F, data=SAVE, is_extended_id=False))
        assert bus.recv(0) is None and bus.bus.clock.now == 0
        assert bus.recv(0.005) is None and bus.bus.clock.now == 0.005
        assert bus.recv(1).data[:4] == bytes.fromhex("60 10 10 01")
        assert bus.bus.clock.now == pytest.approx(0.014)
        assert bus.recv(0.05) is None and bus.bus.clock.now == pytest.approx(0.014)
        bus.send(can.Message(arbitration_id=0x63F, data=SAVE, is_extended_id=False))
        bus.encoder.power(False)  # nobody answers any more
        before = bus.bus.clock.now
        assert bus.recv(0.05) is None and bus.bus.clock.now == before


def test_canopen_stores(eds):
    network = canopen.Network()
    network.connect(interface="drehgeber", channel="f3668")
    try:
        node = network.add_node(63, eds)
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        node.sdo["Producer heartbeat time"].raw = 700
        node.sdo["Node number"].raw = 9
        node.store()
        node.sdo.download(0x2105, 0, b"save")
        assert network.bus.bus.clock.now == pytest.approx(0.028)
        network.bus.encoder.power("CYCLE")
        node = network.add_node(9, eds)
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        assert node.sdo["Producer heartbeat time"].raw == 700
    finally:
        network.disconnect()


def test_who_waits_is_woken_by_whoever_moves_time():
    with can.Bus(interface="drehgeber", channel="f3668") as bus:
        bus.send(can.Message(arbitration_id=0x63F, data=heartbeat_every(1000), is_extended_id=False))
        while bus.recv(0):
            pass
        thread = threading.Timer(0.02, bus.advance, [1.0])
        thread.start()
        heartbeat = bus.recv(10)
        thread.join()
        assert heartbeat.arbitration_id == 0x73F and heartbeat.timestamp == pytest.approx(1.0)


def test_real_time_comes_by_itself():
    with can.Bus(interface="drehgeber", channel="f3668", time="real") as bus:
        bus.send(can.Message(arbitration_id=0x63F, data=heartbeat_every(20), is_extended_id=False))
        while bus.recv(0):
            pass
        begin = time.monotonic()
        stamps = [bus.recv(10).timestamp for _ in range(5)]
        assert 0.08 <= time.monotonic() - begin < 5
        assert [round(b - a, 6) for a, b in zip(stamps, stamps[1:])] == [0.02] * 4


# ---------------------------------------------------------------- canopen


def await_emergency(node, code):
    """In the log: wait() of canopen's misses what has come before it."""
    end = time.monotonic() + PATIENCE_S
    while code not in [error.code for error in node.emcy.log]:
        assert time.monotonic() < end, node.emcy.log
        time.sleep(0.01)


@pytest.mark.parametrize("how", ["virtual", "real"])
def test_canopen_talks_to_it(how, eds):
    network = canopen.Network()
    network.connect(interface="drehgeber", channel="f3668?shaft=90DEG", time=how)
    try:
        node = network.add_node(63, eds)
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        assert node.sdo["Position value"].raw == 16384
        assert node.sdo[0x1008].raw.startswith("F36")
        node.nmt.state = "OPERATIONAL"
        with network.bus.encoder.fault("led_current_high"):
            if how == "virtual":
                network.bus.advance(0.1)
            await_emergency(node, 0x5200)
    finally:
        network.disconnect()


def test_a_bus_that_was_shut_down_is_over():
    bus = can.Bus(interface="drehgeber", channel="f3668?node=5")
    message = can.Message(arbitration_id=0x605, data=UPLOAD, is_extended_id=False)
    bus.send(message)
    bus.shutdown()
    with pytest.raises(can.CanOperationError, match="shut down"):
        bus.send(message)
    with pytest.raises(can.CanOperationError, match="shut down"):
        bus.recv(0)
    bus.shutdown()


def test_a_time_that_there_is_not_is_refused():
    with pytest.raises(can.CanInitializationError, match="expected 'virtual' or 'real'"):
        can.Bus(interface="drehgeber", channel="f3668", time="rael")
