# SPDX-License-Identifier: MIT
"""The rig of pitch.ini: three blades, each with an encoder at the motor and one at the blade."""
from pathlib import Path

import pytest

PITCH = Path(__file__).with_name("pitch.ini")
GEAR = 100


@pytest.fixture
def encoders(drehgeber_rig):
    return drehgeber_rig(PITCH.read_text()).encoders


def test_all_start(encoders):
    assert sorted(encoders) == ["blade1", "blade2", "blade3", "motor1", "motor2", "motor3"]


@pytest.mark.parametrize("blade", [1, 2, 3])
def test_a_blade_follows_its_motor_alone(encoders, blade):
    encoders[f"motor{blade}"].shaft.position = 25 * 360
    for i in (1, 2, 3):
        turned = 25 * 360 if i == blade else 0
        assert encoders[f"motor{i}"].shaft.position == turned
        assert encoders[f"blade{i}"].shaft.position == turned / GEAR
