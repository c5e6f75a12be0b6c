# SPDX-License-Identifier: MIT
"""FMUs of two protocols that nobody has heard of (tests/strangers), by a command that has them."""

import math
import struct
from collections.abc import Callable

import pytest
from conftest import Fmu, Slave
from fmpy.validation import validate_fmu  # type: ignore[import-untyped]

Make = Callable[..., Fmu]
QUARTER = bytes.fromhex("02 00 00 40 00 00 00 00 00 00 42")


@pytest.mark.parametrize("version", ["3", "2"])
@pytest.mark.parametrize("model", ["eleven-24", "tenbit-low"])
def test_it_is_valid(make: Make, model: str, version: str) -> None:
    assert validate_fmu(make(model, "--fmi", version).path) == []


def test_characters_are_asked(make: Make) -> None:
    slave = Slave(make("eleven-24"), shaft__angle=math.pi / 2)
    assert not {"sin_plus", "nERR", "MA", "CanChannel.Rx_Data"} & set(slave.fmu.names)
    slave.step(0.2)
    slave.send("RS485", struct.pack("<QIHH", 0, 0, 1, 0) + b"\x02")
    slave.step(1e-3)
    data = slave.fetch("RS485")
    assert struct.unpack_from("<QIHH", data)[1:3] == (4000, 11) and data[16:] == QUARTER
    slave.set("fault.singleturn_lost", True)
    slave.send("RS485", struct.pack("<QIHH", 0, 0, 1, 0) + b"\x02")
    slave.step(1e-3)
    assert slave.fetch("RS485")[16:][4] == 1
    slave.close()


def test_a_clocked_one_without_a_master_has_a_position(make: Make) -> None:
    slave = Slave(make("tenbit-low"), shaft__angle=math.pi / 2)
    assert not {"frame", "MA", "nERR", "RS485.Rx_Data"} & set(slave.fmu.names)
    slave.step(0.2)
    assert slave.get("position") == 256
    slave.close()
