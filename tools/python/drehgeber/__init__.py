# SPDX-License-Identifier: MIT
"""Virtual absolute encoders in Python programs and tests.

In this process, without a wire, in virtual time:

    import drehgeber

    encoder = drehgeber.Encoder("s3684-rs485", shaft="60RPM")
    encoder.clock.advance(1.5)
    reply = encoder.request(bytes.fromhex("40 42 02"))

On a wire, by the drehgeber command: start it, steer its shafts, break its physics:

    with drehgeber.run("s3684-rs485", "--shaft", "60RPM") as rig:
        encoder = rig.encoders["s3684-rs485"]
        port = serial.Serial(encoder.address, 9600, parity="E")  # what a master would do
        encoder.shaft.move(90)                                   # degrees
        with encoder.fault("led_current_high"):
            ...                                                  # 1Dh on the error stack
        print(encoder.state()["position"])

    with drehgeber.run("bench.ini") as rig: ...
    with drehgeber.rig("[encoder a]\\nmodel = f3668\\nwire = slcan\\n") as rig: ...

python-can knows can.Bus(interface="drehgeber", channel="f3668"), pyserial
serial.serial_for_url("drehgeber://s3684-rs485"), pytest the fixture `drehgeber_rig`.
"""

from __future__ import annotations

import contextlib
import importlib.metadata

try:
    __version__ = importlib.metadata.version("drehgeber")
except importlib.metadata.PackageNotFoundError:  # a folder of sources
    __version__ = "0"

from ._native import EncoderError, Medium, RangeError, eds, models
from .canbus import CanBus, CanFrame, CanPort
from .clock import Clock
from .control import Control, ScpiError
from .encoder import Encoder, HintWarning, Setting, SinCos
from .rigfile import Rig
from .rs485 import Line, Uart
from .running import RigError, RunningEncoder, RunningRig, RunningShaft, program, rig, run
from .shaft import Shaft

with contextlib.suppress(ImportError):
    import serial

    if __name__ not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(__name__)

__all__ = [
    "CanBus",
    "CanFrame",
    "CanPort",
    "Clock",
    "Control",
    "Encoder",
    "EncoderError",
    "HintWarning",
    "Line",
    "Medium",
    "RangeError",
    "Rig",
    "RigError",
    "RunningEncoder",
    "RunningRig",
    "RunningShaft",
    "ScpiError",
    "Setting",
    "Shaft",
    "SinCos",
    "Uart",
    "__version__",
    "eds",
    "models",
    "program",
    "rig",
    "run",
]
