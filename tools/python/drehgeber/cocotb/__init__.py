# SPDX-License-Identifier: MIT
"""Encoders in an HDL simulation under cocotb 2: the device under test is the master, the simulator owns time.

    from drehgeber.cocotb import BissEncoder

    @cocotb.test()
    async def reads_the_position(dut):
        encoder = BissEncoder(dut.ma, dut.slo, model="s3684-biss", shaft="60RPM")
        dut.request.value = 1
        latch = await encoder.latched()
        await RisingEdge(dut.valid)
        assert dut.position.value == latch.position

An encoder belongs to the test that it was made in. Moments are picoseconds since the simulation began.
"""

from __future__ import annotations

try:
    import cocotb
except ImportError as error:
    raise ImportError(f"drehgeber.cocotb: {error}; its extra brings it: pip install 'drehgeber[cocotb]'") from error

if int(cocotb.__version__.split(".")[0]) < 2:
    raise ImportError(
        f"drehgeber.cocotb needs cocotb 2, and this is {cocotb.__version__}: pip install 'drehgeber[cocotb]'"
    )

from .biss_line import Access, Frame
from .clocked import BissEncoder, Latch, SsiEncoder
from .hiperface import HiperfaceEncoder, Reply, Request
from .simulation import SimulatedEncoder, SimulationClock

__all__ = [
    "Access",
    "BissEncoder",
    "Frame",
    "HiperfaceEncoder",
    "Latch",
    "Reply",
    "Request",
    "SimulatedEncoder",
    "SimulationClock",
    "SsiEncoder",
]
