# SPDX-License-Identifier: MIT
"""The rig's clock where all wires are simulated, and motion recorded and played again."""
import csv
import time
from decimal import Decimal

import pytest

from bench import BissMaster, eventually

BAD_SUFFIX, CONFLICT, OUT_OF_RANGE = -131, -221, -222
STEPS = 1 << 21
FRAME_S = 0.0001  # a frame at 1 MHz, amply
TOP_REV_S = 2
SIMULATED = """
[rig]
control = tcp:127.0.0.1:0
[shaft main]
motion = {motion}
[encoder a]
model = s3684-biss
wire = sim
[encoder b]
model = s3674-biss
wire = sim
"""
REAL = """
[rig]
control = tcp:127.0.0.1:0
[encoder a]
model = s3684-biss
wire = sim
[encoder b]
model = s3684-rs485
wire = pty
"""


@pytest.fixture
def stopped(start):
    """Start simulated rigs whose clock is stopped."""
    def begin(motion="0DEG"):
        bench = start(SIMULATED.format(motion=motion))
        session = bench.session("a")
        eventually(lambda: BissMaster(session).ready(), 5)
        session.do("TIME:SCAL 0")
        session.do("TIME:STEP 1 S")  # the wire is free
        return session
    return begin


def now(session) -> Decimal:
    text = session.ask("TIME?")
    assert len(text.partition(".")[2]) == 9
    return Decimal(text)


def test_a_stopped_clock(stopped):
    session = stopped("60RPM")
    before = now(session), session.ask("SHAF:POS?")
    time.sleep(0.1)
    assert (now(session), session.ask("SHAF:POS?")) == before
    assert float(session.ask("TIME:SCAL?")) == 0


@pytest.mark.parametrize("span, seconds", [("1 S", "1"), ("250 MS", "0.25"), ("1 US", "0.000001"),
                                           ("1 NS", "0.000000001"), ("36000 S", "36000")])
def test_steps(stopped, span, seconds):
    session = stopped()
    before = now(session)
    session.do(f"TIME:STEP {span}")
    assert now(session) - before == Decimal(seconds)


def test_a_step_turns_the_shaft_and_the_encoders(stopped):
    session = stopped()
    session.do("SHAF:POS 0;VEL 60")
    master = BissMaster(session)
    for quarter in range(1, 10):
        session.do("TIME:STEP 250 MS")
        assert session.ask("SHAF:POS?") == f"{quarter * 90}.000000"
        # Now, or behind the frame that the rig's own master reads at the same time.
        assert 0 <= master.frame()[0] - quarter * STEPS // 4 <= STEPS * FRAME_S


def test_opc_waits_for_the_rigs_time(start):
    bench = start(SIMULATED.format(motion="0DEG"))
    session, other = bench.session("a"), bench.session("a")
    session.do("TIME:SCAL 0;:SHAF:MOVE 360,60")
    session.send("*OPC?")
    assert session.silent()
    other.do("TIME:STEP 999 MS")
    assert session.silent()
    other.do("TIME:STEP 1 MS")
    assert session.line() == "1"
    assert session.ask("SHAF:POS?") == "360.000000"


def test_durations_are_in_the_rigs_time(stopped):
    session = stopped()
    session.do("FAUL:SET led_current_high,DUR 10 S")
    master = BissMaster(session)
    session.do("TIME:STEP 9.999 S")
    assert session.parts("FAUL:ACT?") == ["led_current_high"] and master.errors() == 1
    session.do("TIME:STEP 1 MS")
    assert session.parts("FAUL:ACT?") == [] and master.errors() == 0


@pytest.mark.parametrize("factor", [10, 0.1])
def test_another_pace(start, factor):
    session = start(SIMULATED.format(motion="60RPM")).session("a")
    session.do(f"TIME:SCAL {factor}")
    assert float(session.ask("TIME:SCAL?")) == factor
    begin, first, angle = time.monotonic(), now(session), float(session.ask("SHAF:POS?"))
    time.sleep(0.5)
    last, end = now(session), time.monotonic()
    further = float(session.ask("SHAF:POS?"))
    assert 0.5 * factor <= float(last - first) <= (end - begin) * factor + 0.01 * factor
    assert further - angle >= 0.5 * factor * 360 * 0.99
    session.do("TIME:SCAL 1")
    begin, first = time.monotonic(), now(session)
    time.sleep(0.1)
    assert 0.1 <= float(now(session) - first) <= time.monotonic() - begin + 0.001


def test_a_running_clock_takes_no_steps(start):
    session = start(SIMULATED.format(motion="0DEG")).session()
    assert session.codes("TIME:STEP 1 S") == [CONFLICT]


def test_paces_that_are_none(stopped):
    session = stopped()
    for line in ("TIME:SCAL -1", "TIME:SCAL 1E9", "TIME:STEP -1 S"):
        assert session.codes(line) == [OUT_OF_RANGE]
    assert session.codes("TIME:STEP 1 DEG") == [BAD_SUFFIX]
    assert float(session.ask("TIME:SCAL?")) == 0


def test_real_wires_have_real_time(start):
    session = start(REAL).session()
    for line in ("TIME:SCAL 0", "TIME:SCAL 10", "TIME:STEP 1 S"):
        assert session.codes(line) == [CONFLICT]
    assert float(session.ask("TIME:SCAL?")) == 1
    first = now(session)
    time.sleep(0.05)
    assert now(session) - first >= Decimal("0.05")


def rows(path) -> list:
    with open(path, newline="", encoding="ascii") as file:
        header, *lines = csv.reader(line for line in file if not line.startswith("#"))
    assert header == ["time_s", "angle_deg"]
    return [(Decimal(seconds), Decimal(degrees)) for seconds, degrees in lines]


def walk(session, count: int):
    """Every 10 ms where the shaft is, and what the wire tells of it."""
    master = BissMaster(session)
    shaft, wire = [], []
    for _ in range(count):
        shaft.append(session.ask("SHAF:POS?"))
        wire.append(master.frame()[0])
        session.do("TIME:STEP 10 MS")
    return shaft, wire


def same(one, other) -> bool:
    """The same angles; the wire may be a frame late, see above."""
    return one[0] == other[0] and all(abs(a - b) <= STEPS * TOP_REV_S * FRAME_S
                                      for a, b in zip(one[1], other[1]))


def test_record_and_replay(stopped, tmp_path):
    file = tmp_path / "run.csv"
    session = stopped()
    session.do("SHAF:ACC 600;POS -450")
    session.do(f'SHAF:MOVE 500,120;REC:STAR "{file}",10 MS')
    live = walk(session, 200)
    session.do("SHAF:REC:STOP")
    recorded = rows(file)
    assert [when for when, _ in recorded][:200] == [Decimal(n) / 100 for n in range(200)]
    assert recorded[0][1] == -450
    session.do("SHAF:POS 0")
    session.do(f'SHAF:PROF "{file}"')
    assert session.ask("SHAF:MOV?") == "1"
    assert same(walk(session, 200), live)


def test_replay_by_another_rig(stopped, start, tmp_path):
    file = tmp_path / "run.csv"
    session = stopped("sine:90DEG,2S")
    session.do(f'SHAF:REC:STAR "{file}",10 MS')
    live = walk(session, 100)
    session.do("SHAF:REC:STOP")
    again = stopped()
    again.do(f'SHAF:PROF "{file}"')
    assert same(walk(again, 100), live)


def test_profiles(stopped):
    session = stopped()
    session.do('SHAF:PROF "60RPM"')
    session.do("TIME:STEP 2 S")
    assert session.ask("SHAF:POS?") == "720.000000"
    session.do("SHAF:PROF '2.5REV'")
    assert session.ask("SHAF:POS?") == "900.000000"
    assert session.ask("SHAF:PROF?")


def test_recording_in_real_time(start, tmp_path):
    file = tmp_path / "real.csv"
    session = start(REAL).session("b")
    session.do("SHAF:VEL 60")
    session.do(f'SHAF:REC:STAR "{file}"')
    time.sleep(0.2)
    session.do("SHAF:REC:STOP")
    recorded = rows(file)
    assert len(recorded) >= 200
    assert [when for when, _ in recorded] == [Decimal(n) / 1000 for n in range(len(recorded))]
    speeds = {round(float(after - before), 6) for (_, before), (_, after)
              in zip(recorded, recorded[1:])}
    assert speeds <= {0.36, 0.359999, 0.360001}
