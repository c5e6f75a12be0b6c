# SPDX-License-Identifier: MIT
"""Every entry of every catalogue: injected over the control socket, seen by a master on the wire,
cleared, gone. What a master has to see is in look_*.py: from the manuals, and what the device pages
choose where those are silent."""
import contextlib
import time
from decimal import Decimal

import pytest

from bench import (Bench, BissMaster, CanMaster, Coupler, Master, Session, can_wire, eventually,
                   free_port)
from look_biss import BISS, biss_fine, fresh_biss
from look_canopen import (CAN, POSITION_90DEG as CAN_90DEG, PRE_OPERATIONAL, can_fine,
                          fresh_can, heard, with_heartbeats)
from look_hiperface import (HIPERFACE, POSITION_90DEG as HIPERFACE_90DEG, answers, code_of,
                            fresh_hiperface, hiperface_restart, silent)
from look_interbus import K1, K2, K3, fresh_interbus, ring_fine
from looks import HARDWARE_ERROR, Target, inject, seconds

CYCLE_US = 5000
RIG = """
[rig]
control = tcp:127.0.0.1:0
[bus ring]
wire = modbus
address = 127.0.0.1:{port}
cycle = {cycle}
[encoder h]
model = s3684-rs485
wire = pty
nvm = h.nvm
[encoder c]
model = f3668
wire = {can}
nvm = c.nvm
[encoder b]
model = s3684-biss
wire = sim
nvm = b.nvm
[encoder k1]
model = ocd-ib-k1
bus = ring
[encoder k2]
model = ocd-ib-k2
bus = ring
[encoder k3]
model = ocd-ib-k3
bus = ring
"""


@pytest.fixture(scope="module")
def bench(start_once, tmp_path_factory) -> Bench:
    wire = can_wire(tmp_path_factory.mktemp("can"))
    return start_once(RIG.format(port=free_port(), cycle=CYCLE_US, can=wire), "--quiet")


@pytest.fixture(scope="module")
def masters(bench) -> dict:
    """One for each wire."""
    with contextlib.ExitStack() as stack:
        opened = {
            "h": Master(bench.wires["h"], grace_s=0.4),
            "c": CanMaster(bench.wires["c"]),
            "k": Coupler(bench.wires["k1"]),
        }
        for name in "hck":
            stack.callback(opened[name].close)
        yield opened


@pytest.fixture
def targets(bench, masters) -> dict:
    """With sessions of their own, whatever other tests did to theirs."""
    sessions = {name: bench.session(name) for name in LOOKS}
    ring = masters["k"]
    yield {
        "h": Target(sessions["h"], masters["h"]),
        "c": Target(sessions["c"], masters["c"]),
        "b": Target(sessions["b"], BissMaster(sessions["b"])),
        "k1": Target(sessions["k1"], ring, 0, 0, 1),
        "k2": Target(sessions["k2"], ring, 1, 1),
        "k3": Target(sessions["k3"], ring, 2, 3),
    }
    for session in sessions.values():
        session.close()


def healthy(target: Target):
    target.scpi.do("FAUL:CLE;:WORL:DEF;:POW ON")
    target.scpi.do("SHAF:POS 90")


@pytest.fixture
def target(bench, targets, request) -> Target:
    """The encoder that the test is about; all are healthy before and after."""
    for one in targets.values():
        healthy(one)
    FRESH[request.param[0]](targets[request.param])
    yield targets[request.param]
    for name in targets:
        session = bench.session(name)
        healthy(Target(session, None))
        session.close()


# --- all of it ------------------------------------------------------------------------------------

LOOKS = {"h": HIPERFACE, "b": BISS, "c": CAN, "k1": K1, "k2": K2, "k3": K3}
FRESH = {"h": fresh_hiperface, "b": fresh_biss, "c": fresh_can, "k": fresh_interbus}


def catalogue(session: Session) -> list:
    parts = session.parts("FAUL:CAT?")
    assert len(parts) % 5 == 0
    return [parts[n:n + 5] for n in range(0, len(parts), 5)]


@pytest.mark.parametrize("encoder", LOOKS)
def test_every_entry_has_its_look(bench, encoder):
    """A new entry without a look below, or a look without an entry, fails here."""
    entries = catalogue(bench.session(encoder))
    names = [entry[0].lower() for entry in entries]
    assert len(names) == len(set(names))
    assert set(names) == set(LOOKS[encoder])
    assert all(all(entry) for entry in entries)


@pytest.mark.parametrize("target, name", [(encoder, name) for encoder, looks in LOOKS.items()
                                          for name in looks], indirect=["target"])
def test_seen_and_gone(target, name, request):
    encoder = request.node.callspec.params["target"]
    inject(target, name, LOOKS[encoder][name])


# --- how long a fault lasts -----------------------------------------------------------------------

def happened(target: Target, name: str) -> int:
    return int(target.scpi.ask(f"FAUL:HAPP? {name}"))


def lose_replies(target: Target, count: int):
    """Each request is heard before the next one is sent: two at once are none."""
    for n in range(1, count + 1):
        assert silent(target.master)
        eventually(lambda: happened(target, "wire_drop") == n)


@pytest.mark.parametrize("target", ["h"], indirect=True)
@pytest.mark.parametrize("count", [1, 3])
def test_count_on_rs485(target, count):
    target.scpi.do(f"FAUL:SET wire_drop,COUN {count}")
    lose_replies(target, count)
    assert answers(target.master) and answers(target.master)
    assert target.scpi.parts("FAUL:ACT?") == [] and happened(target, "wire_drop") == count


@pytest.mark.parametrize("target", ["b"], indirect=True)
def test_count_on_biss(target):
    target.scpi.do("FAUL:SET wire_drop,COUNT 3")
    lost = sum(target.master.lost() for _ in range(6))
    assert 2 <= lost <= 3  # the rig's own master may have had one
    assert biss_fine(target.master)
    assert target.scpi.parts("FAUL:ACT?") == [] and happened(target, "wire_drop") == 3


@pytest.mark.parametrize("target", ["c"], indirect=True)
def test_count_on_can(target):
    with_heartbeats(target.master)
    target.master.tap.forget()
    target.scpi.do("FAUL:SET wire_damage,COUN 3")
    eventually(lambda: target.scpi.parts("FAUL:ACT?") == [])
    assert happened(target, "wire_damage") == 3
    seen = []

    def damaged() -> int:
        return sum(state != PRE_OPERATIONAL for state in seen)

    def over() -> bool:
        """All three have come, and some more."""
        seen.extend(heard(target.master))
        return damaged() >= 3 and set(seen[-5:]) == {PRE_OPERATIONAL}

    eventually(over)
    assert damaged() == 3


@pytest.mark.parametrize("target", ["k3"], indirect=True)
def test_count_on_the_ring(target):
    before = target.master.crc_errors(target.place)
    target.scpi.do("FAUL:SET wire_damage,COUN 2")
    eventually(lambda: target.scpi.parts("FAUL:ACT?") == [])
    eventually(lambda: ring_fine(target))
    assert target.master.crc_errors(target.place) == before + 2
    assert happened(target, "wire_damage") == 2


@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_probability(target):
    target.scpi.do("FAUL:SET wire_drop,PROB 0")
    assert all(answers(target.master) for _ in range(5))
    assert happened(target, "wire_drop") == 0
    target.scpi.do("FAUL:SET wire_drop,PROBABILITY 1")
    lose_replies(target, 5)


@pytest.mark.parametrize("target", ["b"], indirect=True)
def test_probability_in_between(target):
    target.scpi.do("FAUL:SET wire_drop,PROB 0.5")
    begin = time.monotonic()
    lost = sum(target.master.lost() for _ in range(4000))
    # Half of them, within five standard deviations of 31.6: one run in a million is outside, and 0.46 would be.
    assert abs(lost - 2000) <= 5 * 31.6
    # The rig's own master reads ten times a second.
    assert lost <= happened(target, "wire_drop") <= lost + 10 * (time.monotonic() - begin) + 2


@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_duration(target):
    end = Decimal(target.scpi.ask("FAUL:SET wire_drop,DUR 1 S;:TIME?")) + 1
    assert silent(target.master)
    active = True
    while active:  # by the rig's clock: it is there up to the nanosecond, and gone then
        *active, now = target.scpi.ask("FAUL:ACT?;:TIME?").split(";")
        active = active != ['""']
        assert active == (Decimal(now) < end), (now, end)
    assert answers(target.master)


@pytest.mark.parametrize("target", ["c"], indirect=True)
def test_duration_of_a_cause(target):
    target.scpi.do("FAUL:SET temperature_high,DUR 0.3 S")
    target.master.emergency(0x4200)
    target.master.emergency(0x0000)
    assert target.scpi.parts("FAUL:ACT?") == [] and can_fine(target.master)
    assert float(target.scpi.ask("WORL:TEMP?")) == 37


@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_count_and_duration(target):
    target.scpi.do("FAUL:SET wire_drop,COUN 100,DUR 0.8 S,PROB 1")
    assert silent(target.master)
    eventually(lambda: target.scpi.parts("FAUL:ACT?") == [])
    assert answers(target.master)


@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_several_at_once(target):
    for name in ("singleturn_lost", "temperature_high", "wire_delay"):
        target.scpi.do(f"FAUL:SET {name}")
    assert set(target.scpi.parts("FAUL:ACT?")) == {"singleturn_lost", "temperature_high",
                                                   "wire_delay"}
    assert seconds(lambda: code_of(target.master.read_position)) >= 0.3
    target.scpi.do("FAUL:CLE wire_delay")
    assert code_of(target.master.read_position) == 0x20
    target.scpi.do("FAUL:CLE")
    assert target.scpi.parts("FAUL:ACT?") == []
    assert target.master.read_position() == HIPERFACE_90DEG


@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_a_fault_is_of_one_encoder_only(target, targets):
    target.scpi.do("FAUL:SET singleturn_lost")
    assert code_of(target.master.read_position) == 0x20
    assert biss_fine(targets["b"].master)
    assert can_fine(targets["c"].master)
    assert ring_fine(targets["k3"])


# --- memory, power --------------------------------------------------------------------------------

@pytest.mark.parametrize("target", ["h"], indirect=True)
def test_corrupt_and_erase(target):
    regions = target.scpi.parts("NVM:CAT?")
    assert {"counter", "user", "field-sums"} <= set(regions)
    target.master.increment_counter()
    assert target.master.read_counter() > 0
    target.scpi.do("NVM:CORR counter")
    hiperface_restart(target)
    assert code_of(target.master.read_counter) == 0x06
    assert target.scpi.codes("NVM:ERAS") == [-221]  # under power
    target.scpi.do("POW OFF;:NVM:ERAS;:POW ON")
    time.sleep(0.12)
    assert target.master.read_counter() == 0 and target.master.read_all_status() == {}


@pytest.mark.parametrize("target", ["k1"], indirect=True)
def test_no_memory_to_corrupt(target):
    assert target.scpi.parts("NVM:CAT?") == []
    (code,) = target.scpi.codes("NVM:CORR steps")
    assert -299 <= code <= -200


@pytest.mark.parametrize("target", ["h", "b", "c", "k3"], indirect=True)
def test_power(target, request):
    encoder = request.node.callspec.params["target"]
    target.scpi.do("POW OFF")
    assert target.scpi.ask("POW?") == "0"
    state = target.scpi.state()
    assert state["power"] == "0" and state["position"] == "-"
    {"h": lambda: silent(target.master) or pytest.fail(),
     "b": lambda: target.scpi.codes("BISS:FRAM?") == [HARDWARE_ERROR] or pytest.fail(),
     "c": lambda: not target.master.answers() or pytest.fail(),
     "k3": lambda: eventually(lambda: target.master.status() != Coupler.RUN)}[encoder]()
    target.scpi.do("POW ON")
    assert target.scpi.ask("POW?") == "1"
    time.sleep(0.12)
    FRESH[encoder[0]](target)
    state = target.scpi.state()
    assert state["power"] == "1"
    assert {"mode", "position", "leds", "errors", "frames", "wire_late", "wire_up"} <= set(state)


@pytest.mark.parametrize("target", ["c"], indirect=True)
def test_state_tells_what_the_encoder_thinks(target):
    before = target.scpi.state()
    assert before["errors"] == "-" and before["position"] == str(CAN_90DEG)
    target.scpi.do("FAUL:SET singleturn_lost")
    target.master.emergency(0x1000)
    state = target.scpi.state()
    assert "1000" in state["errors"] and state["leds"] != before["leds"]
    assert int(state["frames"]) >= int(before["frames"])
