# SPDX-License-Identifier: MIT
"""Models that are texts, as the command takes them: in a file of their own, in a rig file, in a folder."""
import json
import os

import pytest

from rig import Rigs, run, run_refused

LA26 = """[model la26]
base = s3674-biss
st = 26
lc = 0
title = linear, 26 bit
"""
TREE = """[model tree]
base = ssi-25
mt = 8
st = 10
frame = 0000 P 000
[model tree-low]
base = tree
error_bit = low
frame = E 000 P 000
title = tree, error bit in front
"""


@pytest.fixture
def folder(tmp_path):
    """A folder of models, and the environment that names it."""
    models = tmp_path / "models"
    models.mkdir()
    (models / "la26.ini").write_text(LA26)
    (models / "trees.ini").write_text(TREE)
    (models / "notes.txt").write_text("no models\n")
    return {**os.environ, "DREHGEBER_MODELS": str(models)}


def asked(*arguments, **options) -> str:
    ended = run(*arguments, **options)
    assert ended.returncode == 0 and ended.stderr == "", ended.stderr
    return ended.stdout


def test_a_file_is_a_model(tmp_path):
    path = tmp_path / "la26.ini"
    path.write_text(LA26)
    assert asked("biss", path, "read", "--shaft", "90DEG") == (
        "MT 0  ST 16777216  90.000000 deg  nERR 1  nWARN 1  LC 0  CRC valid\n")
    assert "singleturn bits (8..32, default 26)" in asked("biss", path, "--help")
    assert "la26: BiSS-C, linear, 26 bit" in asked("run", path, "--help")
    assert "wire_break" in asked("faults", path)


def test_the_last_one_of_a_file(tmp_path):
    path = tmp_path / "trees.ini"
    path.write_text(TREE)
    trace = tmp_path / "tree.vcd"
    assert asked("ssi", path, "read", "--shaft", "5.25REV", "--trace", trace) == (
        "MT 5  ST 256  90.000000 deg  error 0\n")
    assert "ready tree-low sim:" in run("run", path, "--sim", "--time", "virtual:1S").stdout


def test_a_folder_of_models(folder):
    assert "la26         BiSS-C, linear, 26 bit\n" in asked("list", env=folder)
    listed = {row["model"]: row for row in json.loads(asked("list", "--json", env=folder))}
    assert listed["tree-low"]["resolution"] == "tree, error bit in front"
    assert listed["tree"]["stack"] == "ssi" and "ssi-25" in listed
    assert asked("ssi", "tree", "read", "--shaft", "5.25REV", env=folder) == (
        "MT 5  ST 256  90.000000 deg\n")
    assert "unknown model la26" in run_refused(2, "run", "la26")
    assert "la26" not in asked("list")


def test_a_rig_with_models(tmp_path):
    (tmp_path / "la26.ini").write_text(LA26)
    rigs = Rigs(tmp_path)
    try:
        rig = rigs.begin(f"[rig]\ninclude = la26.ini\ncontrol = unix:{tmp_path}/s\n[shaft s]\nmotion = 90DEG\n"
                         "[encoder slide]\nmodel = la26\nwire = sim\ninit_ms = 0\n")
        assert "ready la26 sim: slide" in rig.lines
        assert rig.client().ask("BISS:FRAM?").startswith("16777216,1,1")
    finally:
        assert rigs.end() == []


@pytest.mark.parametrize("text, right", [
    ("[model a]\nbase = s3674-biss\nst = 33\n", "a.ini:3: st 33: a number in 8..32 is right"),
    ("[model ssi-13]\nbase = ssi-25\n", "a.ini:1: [model ssi-13]: ssi-13 is built in; another name is right"),
    ("[model a]\nbase = a\n", "a.ini:2: base: a is none; right is one of:"),
    ("[model a]\nbase = ssi-13\n[shaft s]\n", "a.ini: without encoders"),
])
def test_what_is_wrong_and_where(tmp_path, text, right):
    (tmp_path / "a.ini").write_text(text)
    for command in "run", "faults":
        assert right in run_refused(2, command, "a.ini", cwd=tmp_path)
    said = run_refused(2, "run", "other", env={**os.environ, "DREHGEBER_MODELS": str(tmp_path)})
    assert right in said.replace(f"{tmp_path}/", "")


def test_an_fmu_has_no_files(tmp_path):
    path = tmp_path / "la26.ini"
    path.write_text(LA26)
    assert "la26 is the model of a file, which an FMU does not have" in run_refused(
        2, "fmu", path, "--output", tmp_path / "a.fmu")


def test_a_wire_does_not_hide_what_is_wrong_in_a_file(tmp_path):
    path = tmp_path / "la26.ini"
    path.write_text(LA26.replace("st = 26", "st = 99"))
    assert "la26.ini:3: st 99: a number in 8..32 is right" in run_refused(2, "run", path, "--sim")
    assert "none.ini: cannot open" in run_refused(2, "run", tmp_path / "none.ini", "--shaft", "1RPM")


def test_nobody_waits_for_a_fifo(folder, tmp_path):
    os.mkfifo(tmp_path / "models" / "a.ini")
    os.mkfifo(tmp_path / "acme.eds")
    ended = run("list", env=folder)
    assert "la26         BiSS-C, linear, 26 bit\n" in ended.stdout
    assert "a.ini: not a regular file; one is right" in ended.stderr
    assert "acme.eds: not a regular file; one is right" in run_refused(1, "check", tmp_path / "acme.eds")
    assert "acme.eds: not a regular file; one is right" in run_refused(2, "run", tmp_path / "acme.eds")
