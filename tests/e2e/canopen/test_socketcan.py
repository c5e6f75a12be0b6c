# SPDX-License-Identifier: MIT
"""What only SocketCAN has: can-utils beside the client, a flooded bus, 127 nodes in a process."""
import signal
import struct
import subprocess
import time

import can
import pytest
from can_rig import (MODEL, PATIENCE_S, WIRE, Client, Encoder, Lines, Tap, assert_one_line,
                     free_port, open_bus, state_of, wait_for_leds)

FLOOD_S = 20.0
OTHER_WIRE = "vcan1"  # for what must not happen to the client's
NODES = range(1, 128)


def cansend(frame: str):
    subprocess.run(["cansend", WIRE, frame], check=True, timeout=PATIENCE_S)


@pytest.fixture
def background():
    """Start programs that run beside the test. The last one ends first: canbusload sees that it is to end with the
    next frame only, which another one of them sends."""
    running = []

    def begin(*arguments) -> subprocess.Popen:
        running.append(subprocess.Popen(arguments, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL))
        return running[-1]

    yield begin
    for process in reversed(running):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(PATIENCE_S)
        process.stdout.close()


@pytest.fixture
def candump(background):
    """Lines of candump, once it is known to see the bus."""
    lines = Lines(background("stdbuf", "-oL", "candump", "-L", WIRE).stdout)
    deadline = time.monotonic() + PATIENCE_S
    seen = []
    while not seen:
        assert time.monotonic() < deadline
        cansend("7DF#")
        seen = lines.so_far()
    return lines


def wait_for(lines: Lines, frame: str) -> str:
    line = lines.wait()
    while frame not in line:
        line = lines.wait()
    return line


def test_candump_sees_the_boot_up(candump, start):
    start()
    wait_for(candump, f" {WIRE} 73F#00")


def test_cansend_is_a_master(candump, start):
    start()
    wait_for(candump, "73F#00")
    cansend("000#013F")
    wait_for(candump, "1BF#00000000")
    wait_for(candump, "3BF#0000")
    wait_for(candump, "4BF#00000000C084")
    cansend("080#")
    wait_for(candump, "2BF#00000000")
    cansend("1BF#R")
    wait_for(candump, "1BF#00000000")
    cansend("63F#4000100000000000")
    wait_for(candump, "5BF#4300100096010200")
    cansend("000#813F")
    wait_for(candump, "73F#00")


def test_encoder_waits_for_no_client(start):
    rig = start()
    rig.barrier()
    rig.connect()
    rig.use(63)
    rig.barrier()


def flood(background, *kind) -> subprocess.Popen:
    """Frames as fast as they can be sent."""
    return background("cangen", WIRE, "-g", "0", "-i", *kind)


def ask(bus, timeout_s: float) -> bool:
    """One SDO request, and whether its answer comes in time."""
    bus.send(can.Message(arbitration_id=0x63F, data=bytes.fromhex("4000100000000000"),
                         is_extended_id=False), PATIENCE_S)
    answer = bus.recv(timeout_s)
    if answer is not None:
        assert bytes(answer.data) == bytes.fromhex("4300100096010200")
    return answer is not None


@pytest.fixture
def client(rig):
    """A bus that hears SDO answers only; the encoder is operational."""
    rig.start()
    rig.disconnect()
    with can.Bus(interface="socketcan", channel=WIRE,
                 can_filters=[{"can_id": 0x5BF, "can_mask": 0x7FF}]) as bus:
        yield bus


def test_flooded_bus(background, client):
    """Somebody else's frames do not keep the encoder from answering every request."""
    flooding = flood(background, "-I", "555", "-L", "8")
    answers = 0
    end = time.monotonic() + FLOOD_S
    while time.monotonic() < end:
        assert ask(client, PATIENCE_S), f"no answer after {answers} answers"
        answers += 1
    assert flooding.poll() is None
    assert answers > 100


def test_flooded_encoder(background, client):
    """More SYNCs than can be served: requests may be lost like on a bus that is too fast, and a
    client that asks again is answered."""
    flooding = flood(background, "-I", "080", "-L", "0")
    answers, latest, longest = 0, time.monotonic(), 0.0
    end = latest + FLOOD_S / 2
    while time.monotonic() < end:
        if ask(client, 0.2):
            answers += 1
            longest = max(longest, time.monotonic() - latest)
            latest = time.monotonic()
    assert flooding.poll() is None
    assert answers > 10 and longest < 5.0, (answers, longest)


@pytest.fixture
def nodes():
    """127 encoders in one process, and everything they say."""
    tap = Tap()
    with open_bus(WIRE, 0) as bus:
        notifier = can.Notifier(bus, [tap], 0.05)
        encoder = Encoder([MODEL, "--can", WIRE, "--node", "1..127", "--quiet"])
        ready = [encoder.ready_line] + [encoder.out.wait() for _ in NODES[1:]]
        assert sorted(ready) == sorted(f"ready {MODEL} can:{WIRE}/{node}" for node in NODES)
        yield bus, tap, encoder
        notifier.stop()
    assert encoder.clean_up() == []


def send(bus, can_id: int, data: bytes = b""):
    bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), PATIENCE_S)


def collect(tap: Tap, can_ids) -> dict:
    """The first frame of each of these CAN-IDs."""
    missing, found = set(can_ids), {}
    deadline = time.monotonic() + PATIENCE_S
    with tap.arrived:
        while missing:
            while tap.frames:
                frame = tap.frames.popleft()
                if frame.arbitration_id in missing and not frame.is_remote_frame:
                    missing.remove(frame.arbitration_id)
                    found[frame.arbitration_id] = bytes(frame.data)
            if missing and not tap.arrived.wait(max(0.0, deadline - time.monotonic())):
                raise AssertionError(f"nothing from {sorted(map(hex, missing))}")
    return found


def test_127_nodes_answer(nodes):
    bus, tap, encoder = nodes
    assert set(collect(tap, [0x700 + node for node in NODES]).values()) == {b"\x00"}
    for node in NODES:
        send(bus, 0x600 + node, bytes.fromhex("40 0B 10 00 00 00 00 00"))
    answers = collect(tap, [0x580 + node for node in NODES])
    assert answers == {0x580 + node: bytes.fromhex("43 0B 10 00") + struct.pack("<I", node)
                       for node in NODES}
    send(bus, 0x000, bytes([0x01, 0x00]))
    collect(tap, [0x180 + node for node in NODES] + [0x480 + node for node in NODES])
    for _ in range(10):
        send(bus, 0x080)
        assert set(collect(tap, [0x280 + node for node in NODES]).values()) == {bytes(4)}
    send(bus, 0x000, bytes([0x81, 0x40]))
    assert tap.data(0x740) == b"\x00"
    assert encoder.alive()


# --- whether there is a bus ---

@pytest.fixture
def alone():
    """An encoder on an interface of its own, and its control plane."""
    set_link("up")
    port = free_port()
    encoder = Encoder([MODEL, "--can", OTHER_WIRE, "--quiet", "--control",
                       f"tcp:127.0.0.1:{port}"])
    with Client(port) as control:
        yield encoder, control
    set_link("up")
    assert encoder.clean_up() == []


def set_link(state: str):
    subprocess.run(["ip", "link", "set", OTHER_WIRE, state], check=True, timeout=PATIENCE_S)


def report(*bits: int):
    """An error frame, as a controller reports it: class, then data[1]."""
    error_class, status = bits
    with can.Bus(interface="socketcan", channel=OTHER_WIRE) as bus:
        bus.send(can.Message(arbitration_id=error_class, is_error_frame=True, is_extended_id=False,
                             data=bytes([0, status, 0, 0, 0, 0, 0, 0])), PATIENCE_S)


def test_leds_when_the_interface_is_down(alone):
    encoder, control = alone
    wait_for_leds(control, "bus:blink/err:off")
    set_link("down")
    wait_for_leds(control, "bus:off/err:off")
    assert_one_line(encoder, OTHER_WIRE, "the interface is down")
    control.do("POW CYCL")
    wait_for_leds(control, "bus:off/err:blink")
    set_link("up")
    wait_for_leds(control, "bus:blink/err:off")
    assert_one_line(encoder, OTHER_WIRE, "back")
    with can.Bus(interface="socketcan", channel=OTHER_WIRE,
                 can_filters=[{"can_id": 0x5BF, "can_mask": 0x7FF}]) as bus:
        assert ask(bus, PATIENCE_S)  # it hears what it heard before


ERR_CRTL, ERR_ACK, ERR_BUSOFF, ERR_RESTARTED = 0x04, 0x20, 0x40, 0x100  # linux/can/error.h
TX_WARNING, TX_PASSIVE, ACTIVE = 0x08, 0x20, 0x40


def test_leds_when_nobody_acknowledges(alone):
    """Until a passive controller is one no more, becomes active, or a frame comes."""
    _, control = alone
    wait_for_leds(control, "bus:blink/err:off")
    report(ERR_ACK, 0)
    wait_for_leds(control, "bus:off/err:off")
    report(ERR_ACK | ERR_CRTL, TX_PASSIVE)
    wait_for_leds(control, "bus:off/err:off")
    report(ERR_CRTL, TX_WARNING)
    wait_for_leds(control, "bus:blink/err:off")
    report(ERR_ACK, 0)
    wait_for_leds(control, "bus:off/err:off")
    report(ERR_CRTL, ACTIVE)
    wait_for_leds(control, "bus:blink/err:off")
    report(ERR_ACK, 0)
    wait_for_leds(control, "bus:off/err:off")
    with can.Bus(interface="socketcan", channel=OTHER_WIRE) as bus:
        send(bus, 0x000, bytes([0x02, 0x00]))
    wait_for_leds(control, "bus:slow/err:off")


def test_leds_of_the_worst_that_a_frame_reports(alone):
    """Off the bus is off the bus, whatever the counters of the same report say."""
    _, control = alone
    wait_for_leds(control, "bus:blink/err:off")
    report(ERR_BUSOFF | ERR_CRTL, ACTIVE)
    wait_for_leds(control, "bus:blink/err:on")
    report(ERR_CRTL, TX_PASSIVE)
    report(ERR_RESTARTED, 0)
    wait_for_leds(control, "bus:blink/err:off")


# --- bus load ---

def test_load_of_everybodys_frames(alone, background):
    """Frames that nobody here listens to, as canbusload counts them with worst case stuffing."""
    _, control = alone
    flood = background("cangen", OTHER_WIRE, "-g", "2", "-I", "555", "-L", "8")
    lines = Lines(background("stdbuf", "-oL", "canbusload", f"{OTHER_WIRE}@250000").stdout)
    pairs = []
    while len(pairs) < 5:
        line = lines.wait()
        if line.strip().startswith(OTHER_WIRE):
            percent = int(line.split("%")[0].split()[-1])
            pairs.append((percent, int(state_of(control)["wire_load_permille"]) / 10))
    assert flood.poll() is None
    theirs, ours = (sum(column) / 4 for column in zip(*pairs[1:]))
    assert theirs > 5
    assert abs(theirs - ours) <= 0.25 * theirs + 1, pairs
