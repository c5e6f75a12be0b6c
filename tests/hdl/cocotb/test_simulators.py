# SPDX-License-Identifier: MIT
"""Runs each bench in each simulator that cocotb 2 and Debian 12 have in common. A simulator that is missing fails."""
from pathlib import Path
from xml.etree import ElementTree

import pytest
from bench_biss import MATRIX
from cocotb_tools.runner import get_runner

HERE = Path(__file__).resolve().parent
BAD = ("failure", "error", "skipped")
# simulator  source      arguments of GHDL
SIMULATORS = {
    "icarus": ("pins.v", []),
    "ghdl": ("pins.vhd", ["--std=08"]),
}
# bench            tests at least
BENCHES = {
    "bench_biss": 25,
    "bench_ssi": 15,
    "bench_hiperface": 15,
}


def test_every_pair_of_the_matrix():
    assert len(MATRIX) <= 12
    columns = list(zip(*MATRIX))
    for i, left in enumerate(columns):
        for right in columns[:i]:
            assert {(a, b) for a in left for b in right} == set(zip(left, right))


@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_bench(simulator, bench, tmp_path):
    source, arguments = SIMULATORS[simulator]
    runner = get_runner(simulator)
    runner.build(sources=[HERE / source], hdl_toplevel="pins", build_dir=tmp_path, build_args=arguments)
    results = runner.test(hdl_toplevel="pins", test_module=bench, build_dir=tmp_path, test_args=arguments)
    cases = list(ElementTree.parse(results).getroot().iter("testcase"))
    assert len(cases) >= BENCHES[bench]
    assert not [case.get("name") for case in cases if any(case.find(what) is not None for what in BAD)]
