# SPDX-License-Identifier: MIT
"""What an FMU says of itself, whole, and which tokens it takes.

tests/golden/fmu has the descriptions, which somebody has read; `DREHGEBER_UPDATE=1 pytest test_described.py`
writes them anew, and the difference is to be read."""

import ctypes
import os
import pathlib
import re
from collections.abc import Callable

import pytest
from conftest import DREHGEBER, Fmu
from fmpy.fmi2 import FMU2Slave  # type: ignore[import-untyped]
from fmpy.fmi3 import FMU3Slave  # type: ignore[import-untyped]
from test_fmu import RIG

Make = Callable[..., Fmu]
RECORDS = pathlib.Path(__file__).parents[1] / "golden/fmu"
TEXTS = ["modelDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml",
         "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml"]
CASES = {"can": ["f3668", "--node", "5"], "can-2": ["f3668", "--fmi", "2"], "biss": ["s3684-biss"],
         "ring-2": ["ocd-ib-k3", "--fmi", "2"],
         "rs485": ["s3674-rs485", "--serial", "12", "--set", "version=a<\"&b>"], "rig": [], "rig-2": ["--fmi", "2"]}


@pytest.mark.parametrize("name", CASES)
def test_an_fmu_describes_itself(make: Make, tmp_path: pathlib.Path, name: str) -> None:
    words = CASES[name]
    if name.startswith("rig"):
        (tmp_path / "axis.ini").write_text("[rig]\nname = axis\n" + RIG)
        words = [str(tmp_path / "axis.ini"), *words]
    folder = pathlib.Path(make(*words).folder)
    said = "".join(f"--- {text}\n{(folder / text).read_text()}" for text in TEXTS if (folder / text).exists())
    version = re.search(r'generationTool="drehgeber ([^"]*)"', said)
    assert version
    for ours in ("drehgeber {}", ' version="{}"'):  # there are versions of others, such as that of FMI-LS-BUS
        said = said.replace(ours.format(version[1]), ours.format("{version}"))
    said = re.sub(r" *<File name=.*\n", "", said)
    record = RECORDS / f"{name}.record"
    if "DREHGEBER_UPDATE" in os.environ:
        record.write_text(said)
    assert said == record.read_text()


@pytest.mark.parametrize("version", ["3", "2"])
def test_its_sources_are_those_that_are_listed(make: Make, version: str) -> None:
    """All of sources.list but what is compiled for the other version; each .c of them is named, in its order."""
    fmu = make("f3668", "--fmi", version)
    listed = (pathlib.Path(DREHGEBER).parent / "fmu-parts/sources.list").read_text().split()
    mine = [name for name in listed if not name.endswith(f"/fmi{5 - int(version)}.c")]
    sources = pathlib.Path(fmu.folder) / "sources"
    there = {str(path.relative_to(sources)) for path in sources.rglob("*") if path.is_file()}
    assert there - {"buildDescription.xml"} == set(mine) and len(mine) == len(listed) - 1
    told = (sources / "buildDescription.xml" if version == "3" else sources.parent / "modelDescription.xml").read_text()
    assert re.findall(r'File name="([^"]*)"', told) == [name for name in mine if name.endswith(".c")]


TAKEN = [" =f3668", " =s3684-rs485,version=v1%2E0%2E8", " =f3668,node=%31%32"]
REFUSED = ["", " ", " =", " f3668", " =f36", "  =f3668", " =f3668 ", " =f3668,node", " =f3668,node=128", " =f3668,none=1",
           " =f3668,", " =f3668@0", " a=f3668", " =f3668 b=f3668", " 00000000.rig", " 00000000.eds", " =f3668,node=%3",
           " =f3668,node=%3G", " =f3668,node=%3b", " =f3668,node=%G3", " " + "a" * 300 + "=f3668", " =" + "f" * 300, " =f3668;"]


@pytest.mark.parametrize("version", ["3", "2"])
def test_tokens(make: Make, version: str) -> None:
    """FMI: an instance is made of the token of its description only."""
    fmu = make("f3668", "--fmi", version)
    kind = FMU3Slave if version == "3" else FMU2Slave
    dll = kind(guid=fmu.description.guid, unzipDirectory=fmu.folder, modelIdentifier="drehgeber", instanceName="it").dll
    head = fmu.description.guid.partition(" =")[0]

    def taken(token: str) -> bool:
        make_it = getattr(dll, "fmi3InstantiateCoSimulation" if version == "3" else "fmi2Instantiate")
        make_it.argtypes, make_it.restype = None, ctypes.c_void_p
        off, text = ctypes.c_bool(False), token.encode()
        if version == "3":
            instance = make_it(b"it", text, None, off, off, off, off, None, ctypes.c_size_t(0), None, None, None)
        else:
            instance = make_it(b"it", 1, text, None, None, 0, 0)
        if instance is not None:
            getattr(dll, f"fmi{version}FreeInstance")(ctypes.c_void_p(instance))
        return instance is not None

    assert [end for end in TAKEN if not taken(head + end)] == []
    assert [end for end in REFUSED if taken(head + end)] == []
    assert not any(taken(other + " =f3668") for other in ("", "drehgeber", "drehgeber 9.9.9", head + "1", head[:-1]))
