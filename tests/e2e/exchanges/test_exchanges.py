# SPDX-License-Identifier: MIT
"""Twenty thousand requests on RS485 lines and as many on a CAN bus: each is answered, and rightly.

A busy machine makes answers late; it makes none wrong, and loses none. So a single one that is lost or wrong
fails, whatever the machine does.
"""
import os
import shutil
import sys
import time
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
sys.path += [str(HERE.parents[2] / "tools/python"), str(HERE.parent), str(HERE.parent / "rig40")]
import drehgeber  # noqa: E402
from hiperface_master import UartSetting  # noqa: E402
from masters import MASTERS, Heard, Master, devices_of  # noqa: E402
from rig import MULTITURN, Encoder  # noqa: E402

EXCHANGES = 20_000
LINES = 16  # side by side: a request and its reply take 5 ms on a line at 38400 Bd
NODES = 8
PATIENCE_S = 120.0  # for all of them
FASTEST = UartSetting(38400, "E", 11, False)
LINE = """
[encoder h{number}]
model = s3684-rs485
wire = pty:line{number}
nvm = h{number}.nvm
"""
NODE = """
[encoder n{number}]
model = f3668
bus = can
node = {number}
"""
SHAFT = "[shaft main]\nmotion = 60RPM\n"
BUS = "[bus can]\nwire = slcan\naddress = can\n"


@pytest.fixture(scope="module")
def fast_memory(tmp_path_factory):
    """The EEPROM of an encoder that was set to 38400 Bd, as 57h does it."""
    folder = tmp_path_factory.mktemp("fast")
    encoder = Encoder([MULTITURN, f"--pty={folder}/tty", "--nvm", folder / "fast.nvm"])
    try:
        encoder.master().configure_uart(FASTEST.encode())
        assert encoder.end() == 0
    finally:
        assert encoder.clean_up() == []
    return folder / "fast.nvm"


def ask(rig, count: int, wires: dict) -> tuple[list, dict]:
    """`count` times on all of `wires` together: how a master finds one, its kind, its encoders. What the masters
    heard, and the sums of their figures."""
    heard = Heard()
    masters = [Master(wire, where, rig.socket, devices_of(encoders), heard, -(-count // len(wires)))
               for where, (wire, encoders) in wires.items()]
    try:
        assert [master.wait(PATIENCE_S) for master in masters] == [0] * len(masters)
    finally:
        for master in masters:
            master.process.kill()
    figures = {name: sum(master.figures[name] for master in masters) for name in masters[0].figures}
    figures["longest_us"] = max(master.figures["longest_us"] for master in masters)
    late = [encoder.state()["wire_late"] for encoder in rig.encoders.values()]
    print(f"{figures}; deadlines missed by the machine: {late}")
    return heard.lines, figures


def ask_on_lines(folder, fault, count, memory):
    for number in range(LINES):
        shutil.copy(memory, folder / f"h{number}.nvm")
    (folder / "rig.ini").write_text(SHAFT + "".join(LINE.format(number=number) for number in range(LINES)))
    with drehgeber.run(folder / "rig.ini", "--files", folder, folder=folder) as rig:
        if fault:
            rig.encoders["h3"].ask(f"FAUL:SET {fault}")
        return ask(rig, count, {f"{folder}/line{number}@38400": ("pty", [rig.encoders[f"h{number}"]])
                                for number in range(LINES)})


def ask_on_can(folder, fault, count, _):
    numbers = range(1, NODES + 1)
    (folder / "rig.ini").write_text(SHAFT + BUS + "".join(NODE.format(number=number) for number in numbers))
    with drehgeber.run(folder / "rig.ini", "--files", folder, folder=folder) as rig:
        while any(encoder.state()["sent"] == 0 for encoder in rig.encoders.values()):  # the boot-up
            time.sleep(0.01)
        if fault:
            rig.encoders["n3"].ask(f"FAUL:SET {fault}")
        return ask(rig, count, {f"{folder}/can": ("slcan", list(rig.encoders.values()))})


ON_LINES = (ask_on_lines, {f"h{number}" for number in range(LINES)})
ON_CAN = (ask_on_can, {f"n{number}" for number in range(1, NODES + 1)})


@pytest.mark.parametrize("medium, fault, count, lost", [
    (ON_LINES, "", EXCHANGES, 0),
    (ON_CAN, "", EXCHANGES, 0),
    # One lost on purpose is seen. A node that is started first sends TPDO1, 3 and 4, which nobody waits for.
    (ON_LINES, "wire_drop,COUN 1", EXCHANGES // 10, 1),
    (ON_CAN, "wire_drop,COUN 4", EXCHANGES // 10, 1),
], ids=["lines", "can", "one lost on a line", "one lost on can"])
def test_none_is_lost_and_none_is_wrong(tmp_path, fast_memory, medium, fault, count, lost):
    assert os.access(MASTERS, os.X_OK), f"no program at '{MASTERS}': build rig_masters"
    ask_all, names = medium
    heard, figures = ask_all(tmp_path, fault, count, fast_memory)
    assert figures["exchanges"] + figures["lost"] >= count
    assert (figures["wrong"], figures["lost"], figures["garbled"]) == (0, lost, 0)
    assert {line.split()[0] for line in heard} == names
    assert sum(not line.endswith(" ok") for line in heard) == lost
