# SPDX-License-Identifier: MIT
"""BissEncoder, in whatever simulator runs this."""

import logging
import math
import random

import cocotb
from cocotb.simtime import get_sim_time
from cocotb.triggers import Timer, with_timeout
from cocotb.types import Logic
from drehgeber import EncoderError
from drehgeber.cocotb import BissEncoder, SimulationClock
from drehgeber.shaft import Shaft
from masters import BissMaster, crc, now_ps, number

limited = cocotb.test(timeout_time=1, timeout_unit="sec")  # simulated
# Each value of a column with each of every other one, in twelve rows. Delays: clock to output, line each way.
MODELS = {"s3684": {}, "s3674": {"model": "s3674-biss"}, "bare": {"mt": 24, "st": 12, "lc": 0}}
MATRIX = [
    # model  hertz       ns          busy us chain
    ("s3684", 500_000,    (10, 0),    0,      1),
    ("s3674", 1_000_000,  (30, 20),   0,      2),
    ("bare",  10_000_000, (50, 50),   0,      3),
    ("s3684", 500_000,    (30, 20),   3,      3),
    ("s3674", 1_000_000,  (50, 50),   3,      1),
    ("bare",  10_000_000, (10, 0),    3,      2),
    ("s3684", 1_000_000,  (10, 0),    5,      3),
    ("s3674", 10_000_000, (30, 20),   5,      1),
    ("bare",  500_000,    (50, 50),   5,      2),
    ("s3684", 10_000_000, (50, 50),   20,     2),
    ("s3674", 500_000,    (10, 0),    20,     3),
    ("bare",  1_000_000,  (30, 20),   20,     1),
]  # fmt: skip
JITTER_NS = 2
SERIAL = (0x44, 4)
FRAMES = 8
START = 6  # clocks: e1, Ack, one that comes too early, start bit, CDS, one to spare


def widths(encoder):
    """Multiturn and singleturn together; all behind CDS."""
    bits = int(encoder.get("mt")) + int(encoder.get("st"))
    return bits, bits + 2 + (6 if encoder.get("lc") == "1" else 0) + 6


def check_data(encoder, bits, latch):
    """What a master makes of one slave's bits."""
    position, width = widths(encoder)
    word = number(bits[:width])
    assert crc(word >> 6, width - 6, 0x3, 6) == word & 63
    counts = math.floor(latch.degrees / 360 * (1 << int(encoder.get("st")))) & (1 << position) - 1
    assert word >> width - position == latch.position == counts, latch
    assert word >> width - position - 2 & 3 == 3
    return bits[width:]


def chain_of(dut, count, **settings):
    """Encoders, the master's first, each on a shaft of its own."""
    encoders, behind = [], None
    for place in reversed(range(count)):
        slo = dut.slo if place == 0 else None
        behind = BissEncoder(dut.ma, slo, sli=behind, serial=1000 + place, **settings)
        encoders.insert(0, behind)
    return encoders


async def ready(dut):
    dut.ma.value = 1
    await Timer(1, "us")


@limited
@cocotb.parametrize(row=range(len(MATRIX)))
async def matrix(dut, row):
    model, hertz, (output_ns, line_ns), busy, count = MATRIX[row]
    await ready(dut)
    encoders = chain_of(
        dut, count, clock_to_output_ns=output_ns, line_delay_ns=line_ns, jitter_ns=JITTER_NS, seed=row + 1,
        busy_us=busy, **MODELS[model],
    )  # fmt: skip
    period_ps = 1_000_000_000_000 // hertz
    late_ps = (output_ns + 2 * line_ns) * 1000 + period_ps // 4
    data = sum(widths(encoder)[1] for encoder in encoders)
    master = BissMaster(dut, hertz, late_ps, START + busy * hertz // 1_000_000, data)
    turns = random.Random(row)
    for _ in range(FRAMES):
        for encoder in encoders:
            encoder.shaft.position = turns.uniform(-2_000_000, 2_000_000)
        _, bits = await master.frame()
        for encoder in encoders:
            bits = check_data(encoder, bits, encoder.latch)
            assert encoder.frame.good and encoder.frame.position == encoder.latch.position
    slave = row % count  # IDs count from the last one
    asked = encoders[count - 1 - slave]
    address = SERIAL[0] + row % SERIAL[1]
    value = await master.register(address, slave=slave)
    assert value == asked.register(address)[0]
    assert int.from_bytes(asked.register(*SERIAL), "big") == 1000 + count - 1 - slave


TOLD = []  # of what the log has, the hints


class Hints(logging.Handler):
    def emit(self, record):
        if "hangs here" in record.getMessage():
            TOLD.append((record.levelname, record.getMessage(), int(get_sim_time("us"))))


def listen():
    TOLD.clear()
    if not any(isinstance(handler, Hints) for handler in cocotb.log.handlers):
        cocotb.log.addHandler(Hints())


@limited
async def what_may_keep_a_master_waiting_is_told_once(dut):
    """100 us behind power-on, and of a chain by the last one."""
    listen()
    await ready(dut)
    begin = int(get_sim_time("us"))
    chain_of(dut, 3)
    await Timer(300, "us")
    assert [(level, at - begin) for level, _, at in TOLD] == [("WARNING", 100)]
    assert TOLD[0][1] == (
        "s3684-biss: SLO is low until the first MA pulse (BiSS C6, Bus reset); a master that waits for SLO = 1 "
        "hangs here: send a pulse, or set sl_low_at_start=0"
    )
    listen()
    BissEncoder(dut.ma, None, hint_us=0)
    BissEncoder(dut.ma, None, sl_low_at_start=0)
    encoder = BissEncoder(dut.ma, dut.slo)
    await BissMaster(dut, 1_000_000, 250_000, START, widths(encoder)[1]).frame()
    await Timer(300, "us")
    assert not TOLD


@limited
async def a_test_that_ends_early(dut):
    """What it is told is looked at in the next one."""
    listen()
    await ready(dut)
    BissEncoder(dut.ma, dut.slo)
    await Timer(1, "us")
    assert not TOLD


@limited
async def has_the_hint_at_its_end(dut):
    assert len(TOLD) == 1
    await ready(dut)


@limited
async def slo_is_low_before_the_first_clock(dut):
    await ready(dut)
    BissEncoder(dut.ma, dut.slo)
    await Timer(1, "us")
    assert dut.slo.value == 0
    BissEncoder(dut.ma, dut.slo, sl_low_at_start=0)
    await Timer(1, "us")
    assert dut.slo.value == 1


@limited
async def edges_come_after_their_time(dut):
    """Never at once, never out of jitter, and the same for the same seed."""
    await ready(dut)
    seen = {}
    for seed in (1, 2, 1):
        encoder = BissEncoder(dut.ma, dut.slo, clock_to_output_ns=20, jitter_ns=5, seed=seed)
        again, late = seen.get(seed), []
        for _ in range(2):
            for clock in range(24):
                dut.ma.value = 0
                await Timer(500, "ns")
                dut.ma.value = 1
                before = dut.slo.value
                for step in range(30):
                    await Timer(1, "ns")
                    if dut.slo.value != before:
                        assert 14 <= step <= 25, step
                        late.append(step)
                        before = dut.slo.value
                await Timer(470, "ns")
            await Timer(20, "us")
        encoder.power(False)
        assert len(set(late)) > 2
        assert again is None or again == late
        seen[seed] = late
    assert seen[1] != seen[2]


@limited
async def what_makes_no_sense_is_refused(dut):
    for options in (
        {"clock_to_output_ns": 0}, {"clock_to_output_ns": 5, "jitter_ns": 5}, {"jitter_ns": -1},
        {"line_delay_ns": -1}, {"model": "ssi-25"}, {"colour": "red"}, {"shaft": Shaft(motion="60RPM")},
    ):  # fmt: skip
        try:
            BissEncoder(dut.ma, dut.slo, **options)
        except EncoderError as error:
            assert str(error)
            continue
        raise AssertionError(options)


@limited
async def time_is_the_simulators(dut):
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo)
    for move in (lambda: encoder.shaft.clock.advance(1), lambda: encoder.shaft.move(90)):
        try:
            move()
        except EncoderError as error:
            assert "the simulator owns time" in str(error)
            continue
        raise AssertionError(move)
    encoder.shaft.position = 0
    await encoder.move(3.6, rpm=60_000)  # 360 degrees a ms
    assert abs(encoder.angle() - 3.6) < 0.01
    encoder.world.play("temperature", [(0, 20), (20e-6, 60)])
    await Timer(10, "us")
    assert encoder.world.temperature == 20
    await Timer(11, "us")
    assert encoder.world.temperature == 60


def own_master(dut, encoder):
    return BissMaster(dut, 1_000_000, 500_000, START + round(float(encoder.get("busy_us"))), widths(encoder)[1])


@limited
async def registers_are_seen_on_the_line(dut):
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo, eeprom_read_us=0, eeprom_write_us=0, init_ms=0)
    master = own_master(dut, encoder)
    for address, data, value, refused in (
        (0x1C, 0xA5, 0xA5, False),
        (0x1C, None, 0xA5, False),
        (0x78, None, 0x04, False),
        (0x44, 0x01, None, True),
    ):
        awaited = cocotb.start_soon(encoder.accessed())
        back = await master.register(address, data)
        access = await with_timeout(awaited, 1, "us")
        assert back == value
        assert (access.address, access.write, access.value) == (address, data is not None, value)
        assert access.refused == refused and access.good and access.slave == 0
    assert encoder.register(0x1C) == b"\xA5"
    encoder.power("CYCLE")
    assert encoder.register(0x78, 8) == bytes.fromhex("04 00 CC 15 00 00 4B 55")


@limited
async def faults_and_power_reach_the_master(dut):
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo, shaft="90DEG")
    master = own_master(dut, encoder)
    assert not (await master.frame())[1][33] == 0
    with encoder.fault("led_current_high"):
        _, bits = await master.frame()
        assert bits[33] == 0 and encoder.frame.error
        assert encoder.register(0x69) == b"\x01"
    _, bits = await master.frame()
    assert bits[33] == 1 and not encoder.frame.error
    encoder.power(False)
    assert not encoder.powered
    await Timer(1, "us")
    before = encoder.latch
    for _ in range(10):
        dut.ma.value = 0
        await Timer(1, "us")
        dut.ma.value = 1
        await Timer(1, "us")
        assert dut.slo.value == 1
    assert encoder.latch == before
    encoder.power(True)
    await Timer(1, "us")
    assert dut.slo.value == 0
    _, bits = await master.frame()  # initialising
    latch = encoder.latch
    assert number(bits[:33]) == latch.position == 0
    assert (latch.multiturn, latch.singleturn, latch.degrees) == (0, 0, 90)
    assert encoder.scpi("STAT?") and encoder.state()["mode"] == "initialising"


@limited
async def power_ends_what_was_begun(dut):
    """Off in the middle of a frame, in the middle of an access: the line is as new."""
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo, shaft="90DEG", init_ms=0)
    master = own_master(dut, encoder)
    for _ in range(14):
        await master.frame()
    await master.frame(1)
    before = encoder.frame
    for _ in range(20):
        dut.ma.value = 0
        await Timer(500, "ns")
        dut.ma.value = 1
        await Timer(500, "ns")
    encoder.power("CYCLE")
    await Timer(20, "us")
    assert encoder.frame == before and before.cdm
    check_data(encoder, (await master.frame())[1], encoder.latch)
    assert encoder.frame.good and encoder.frame.life == 0


@limited
async def unknown_levels_are_no_edges(dut):
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo, shaft="90DEG")
    for level in "XZXZ":
        dut.ma.value = Logic(level)
        await Timer(100, "ns")
    dut.ma.value = 1
    await Timer(1, "us")
    assert encoder.latch is None and dut.slo.value == 0
    check_data(encoder, (await own_master(dut, encoder).frame())[1], encoder.latch)


@limited
async def a_chain_through_pins_and_one_shaft(dut):
    await ready(dut)
    clock = SimulationClock()
    shaft = Shaft(clock, "600RPM")
    last = BissEncoder(dut.ma, dut.sli, shaft=shaft)
    first = BissEncoder(dut.ma, dut.slo, sli=dut.sli, shaft=last.shaft)
    master = BissMaster(dut, 1_000_000, 500_000, START + 3, 94)
    for _ in range(3):
        _, bits = await master.frame()
        behind = check_data(first, bits, first.latch)
        check_data(last, behind, last.latch)
        assert first.latch.at_ps == last.latch.at_ps and first.latch.position == last.latch.position > 0


@limited
async def the_latch_is_awaited(dut):
    await ready(dut)
    encoder = BissEncoder(dut.ma, dut.slo, shaft="6000RPM", line_delay_ns=25)
    awaited = cocotb.start_soon(encoder.latched())
    framed = cocotb.start_soon(encoder.framed())
    begin = now_ps()
    await own_master(dut, encoder).frame(1)
    latch, frame = await awaited, await framed
    assert latch.at_ps == begin + 500_000 + 25_000 == frame.at_ps
    assert latch.position == int(latch.degrees / 360 * (1 << 21)) == encoder.position(latch.at_ps)
    assert frame.cdm and not frame.cds and frame.life == 0
