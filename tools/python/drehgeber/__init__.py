# SPDX-License-Identifier: MIT
"""Virtual absolute encoders in Python programs and tests: start them, steer their shafts, break
their physics, see what they think of it. Standard library only.

    import drehgeber

    with drehgeber.run("s3684-rs485", "--shaft", "60RPM") as rig:
        encoder = rig.encoders["s3684-rs485"]
        port = serial.Serial(encoder.address, 9600, parity="E")  # what a master would do
        encoder.shaft.move(90)                                   # degrees
        with encoder.fault("led_current_high"):
            ...                                                  # 1Dh on the error stack
        print(encoder.state()["position"])

    with drehgeber.run("bench.ini") as rig: ...
    with drehgeber.rig("[encoder a]\nmodel = f3668\nwire = slcan\n") as rig: ...

With pytest, `pytest_plugins = ["drehgeber.fixture"]` gives the fixture `drehgeber_rig`.
"""

from .control import Control, ScpiError
from .rig import Encoder, Rig, RigError, Shaft, program, rig, run

__all__ = ["Control", "Encoder", "Rig", "RigError", "ScpiError", "Shaft", "program", "rig", "run"]
