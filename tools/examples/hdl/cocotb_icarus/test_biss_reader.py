# SPDX-License-Identifier: MIT
"""A BiSS master in Verilog against an encoder, in Icarus Verilog: pytest test_biss_reader.py."""
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from cocotb_tools.runner import get_runner
from drehgeber.cocotb import BissEncoder


async def read(dut) -> int:
    dut.start.value = 1
    await RisingEdge(dut.done)
    dut.start.value = 0
    assert dut.crc_ok.value == 1
    return dut.position.value


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def positions(dut):
    dut.start.value = 0
    Clock(dut.clk, 20, "ns", impl="gpi").start()
    encoder = BissEncoder(dut.ma, dut.slo, model="s3684-biss", shaft="600RPM", busy_us=5, busy_jitter_us=2)
    for _ in range(20):
        assert await read(dut) == encoder.latch.position


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def an_error(dut):
    dut.start.value = 0
    Clock(dut.clk, 20, "ns", impl="gpi").start()
    encoder = BissEncoder(dut.ma, dut.slo, model="s3684-biss", shaft="90DEG")
    with encoder.fault("led_current_high"):
        assert await read(dut) == 1 << 19
        assert dut.n_error.value == 0
    await read(dut)
    assert dut.n_error.value == 1


def test_biss_reader(tmp_path):
    runner = get_runner("icarus")
    sources = [Path(__file__).with_name("biss_reader.v")]
    runner.build(sources=sources, hdl_toplevel="biss_reader", build_dir=tmp_path)
    runner.test(hdl_toplevel="biss_reader", test_module=Path(__file__).stem, build_dir=tmp_path)
