# SPDX-License-Identifier: MIT
"""FMUs built again from the sources inside them: a minute of a compiler."""

import math
import os
import pathlib
import subprocess
from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import Fmu
from fmpy import simulate_fmu  # type: ignore[import-untyped]

Make = Callable[..., Fmu]


@pytest.mark.parametrize("version", ["3", "2"])
def test_builds_from_its_sources(make: Make, tmp_path: pathlib.Path, version: str) -> None:
    """In a folder with nothing of ours, as a tool does that takes sources only."""
    fmu = make("s3684-rs485", "--fmi", version)
    sources = pathlib.Path(fmu.folder) / "sources"
    list_of, row = {"3": (sources / "buildDescription.xml", "SourceFile"),
                    "2": (pathlib.Path(fmu.folder) / "modelDescription.xml", "File")}[version]
    listed = [file.attrib["name"] for file in ElementTree.parse(list_of).iter(row)]
    library = tmp_path / "drehgeber.so"
    subprocess.run(["gcc", "-std=c11", "-O0", "-fPIC", "-shared", "-Wl,--no-undefined", "-I.", *listed,
                    "-o", str(library)], cwd=sources, check=True, env={"PATH": os.environ["PATH"]})
    platform = {"3": "x86_64-linux", "2": "linux64"}[version]
    binary = pathlib.Path(fmu.folder) / "binaries" / platform / "drehgeber.so"
    binary.write_bytes(library.read_bytes())
    speed = 50 * 2 * math.pi
    turns = np.array([(0.0, 0.0, speed), (1.0, speed, speed)],
                     dtype=[("time", float), ("shaft.angle", float), ("shaft.speed", float)])
    result = simulate_fmu(fmu.folder, stop_time=1.0, output_interval=0.1, input=turns, output=["position"])
    assert abs(int(result[-1]["position"]) - 50 * 65536) <= 1
