# SPDX-License-Identifier: MIT
"""Models that are texts, as the command takes them: in a file of their own, in a rig file, in a folder."""
import json
import os
import shutil
import subprocess
import zipfile

import pytest

from rig import PATIENCE_S, PROGRAM, Rigs, run, run_refused

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


def test_one_of_a_file(tmp_path):
    path = tmp_path / "trees.ini"
    path.write_text(TREE)
    assert asked("ssi", "tree", "--model", path, "read", "--shaft", "5.25REV") == "MT 5  ST 256  90.000000 deg\n"
    assert "error 0" in asked("ssi", "tree-low", f"--model={path}", "read")
    assert "ready tree-low sim:" in asked("run", "--model", path, "--sim", "--time", "virtual:1S")
    assert "ready tree sim:" in asked("run", "tree", "--model", path, "--sim", "--time", "virtual:1S")
    assert "const struct dg_device model_tree = " in asked("model", "tree", "--model", path, "--c")
    for command in "run", "faults":
        assert "trees.ini has no model ssi-13; expected one of: tree tree-low" in run_refused(2, command, "ssi-13", "--model", path)
    assert "none.ini: cannot open" in run_refused(2, "run", "tree", "--model", tmp_path / "none.ini")
    assert "trees.ini has no model bench.ini" in run_refused(2, "run", "bench.ini", "--model", path)
    assert "list takes no option --model" in run_refused(2, "list", "--model", path)


def test_a_folder_of_models(folder):
    assert "la26                     BiSS-C, linear, 26 bit\n" in asked("list", env=folder)
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
    ("[model a]\nbase = s3674-biss\nst = 33\n", "a.ini:3: st 33: expected a number in 8..32"),
    ("[model ssi-13]\nbase = ssi-25\n", "a.ini:1: [model ssi-13]: ssi-13 is built in; expected another name"),
    ("[model a]\nbase = a\n", "a.ini:2: base: a is unknown; expected one of:"),
    ("[model a]\nbase = ssi-13\n[shaft s]\n", "a.ini: without encoders"),
])
def test_what_is_wrong_and_where(tmp_path, text, right):
    (tmp_path / "a.ini").write_text(text)
    for command in "run", "faults":
        assert right in run_refused(2, command, "a.ini", cwd=tmp_path)
    for command in "run", "faults":
        said = run_refused(2, command, "other", env={**os.environ, "DREHGEBER_MODELS": str(tmp_path)})
        assert f"unknown model other; not read: {right}" in said.replace(f"{tmp_path}/", "")


def test_a_wrong_file_is_not_in_the_way(folder, tmp_path):
    """It is named where it may be the one that was meant, and by whoever lists the folder."""
    (tmp_path / "models" / "a.ini").write_text("[model ok]\nbase = ssi-13\n[model bad]\nbase = ssi-13\nst = 33\n")
    assert "la26: BiSS-C" in asked("run", "la26", "--help", env=folder)
    asked("ssi", "tree", "read", env=folder)
    asked("faults", "rls-la11-26", env=folder)
    wrong = "a.ini:5: st 33: expected a number in 1..32"
    for name in "ok", "bad":
        said = run_refused(2, "ssi", name, "read", env=folder)
        assert wrong in said and "unknown" not in said
    assert wrong in run_refused(2, "run", "other", env=folder)
    ended = run("list", env=folder)
    assert ended.stderr.count("\n") == 1 and wrong in ended.stderr and "\nla26 " in ended.stdout


def test_a_folder_that_is_not_there(tmp_path):
    nowhere = {**os.environ, "DREHGEBER_MODELS": str(tmp_path / "none")}
    said = f"$DREHGEBER_MODELS {tmp_path}/none: No such file or directory"
    assert said in run_refused(2, "run", "la26", env=nowhere)
    assert said in run("list", env=nowhere).stderr
    assert "rls-la11-26: BiSS-C" in asked("run", "rls-la11-26", "--help", env=nowhere)
    asked("faults", "ssi-13", env=nowhere)


def test_two_of_a_name(folder, tmp_path):
    (tmp_path / "models" / "more.ini").write_text(LA26.replace("26 bit", "another"))
    said = f"la26 is in both {tmp_path}/models/la26.ini and {tmp_path}/models/more.ini; expected it in only one file"
    assert said in run_refused(2, "biss", "la26", "read", env=folder)
    ended = run("list", env=folder)
    assert "la26" not in ended.stdout and ended.stderr.count("\n") == 1 and said in ended.stderr


# --- the catalogue ------------------------------------------------------------------------------

SOLD = [row for row in json.loads(run("list", "--json", env={**os.environ, "DREHGEBER_MODELS": ""}).stdout) if "file" in row]


def test_there_is_a_catalogue():
    assert len(SOLD) >= 8 and len({row["model"] for row in SOLD}) == len(SOLD)
    for row in SOLD:
        assert row["file"].endswith(".ini") and row["source"] and row["unmodelled"] and row["base"]
        shown = " ".join(asked("run", row["model"], "--help").split())
        flat = shown.replace(" ", "")
        assert f"Source:{row['source']}".replace(" ", "") in flat
        assert f"Notmodelled:{row['unmodelled']}".replace(" ", "") in flat


@pytest.mark.parametrize("row", [row for row in SOLD if row["stack"] in ("biss", "ssi")], ids=lambda row: row["model"])
def test_the_master_reads_what_is_sold(row):
    """Of a scale whose whole range is a turn a quarter is 90 degrees, too."""
    said = asked(row["stack"], row["model"], "read", "--shaft", "90DEG")
    assert said.startswith("MT 0  ST ") and "  90.000000 deg" in said
    assert row["stack"] == "ssi" or "CRC valid" in said


def test_the_users_own_goes_before_it(tmp_path):
    (tmp_path / "mine.ini").write_text(LA26.replace("la26", "rls-la11-26"))
    own = {**os.environ, "DREHGEBER_MODELS": str(tmp_path)}
    listed = [line for line in asked("list", env=own).splitlines() if line.startswith("rls-la11-26 ")]
    assert listed == ["rls-la11-26              BiSS-C, linear, 26 bit"]
    assert "rls-la11-26: BiSS-C, linear, 26 bit" in asked("run", "rls-la11-26", "--help", env=own)


def test_a_rig_names_what_is_sold(folder, tmp_path):
    """... and what is in the user's folder, as an encoder's model and as a base; its own names go first."""
    path = tmp_path / "bench.ini"
    path.write_text("[model mine]\nbase = rls-la11-26\nst = 24\n[model la26]\nbase = ssi-13\n"
                    "[encoder a]\nmodel = renishaw-resolute-32\nwire = sim\n[encoder b]\nmodel = mine\nwire = sim\n"
                    "[encoder c]\nmodel = tree\nwire = sim\n[encoder d]\nmodel = la26\nwire = sim\n")
    said = asked("run", path, "--time", "virtual:1S", env=folder)
    for name, model in ("a", "renishaw-resolute-32"), ("b", "mine"), ("c", "tree"), ("d", "la26"):
        assert f"ready {model} sim: {name}\n" in said
    path.write_text("[model mine]\nbase = rls-la11-26\nst = 20\n")
    assert asked("biss", path, "read", "--shaft", "90DEG", env=folder).startswith("MT 0  ST 262144 ")
    path.write_text("[encoder a]\nmodel = renishaw-resolute-33\nwire = sim\n")
    assert "bench.ini:2: model: renishaw-resolute-33 is unknown; expected one of:" in run_refused(2, "run", path, env=folder)


def test_it_is_found_where_it_is_installed(tmp_path):
    """bin/drehgeber has its catalogue in share/drehgeber/models; without one there is none."""
    program = tmp_path / "bin" / "drehgeber"
    program.parent.mkdir()
    shutil.copy(PROGRAM, program)
    alone = subprocess.run([program, "list"], capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert "ssi-13" in alone.stdout and "sick" not in alone.stdout and alone.stderr == ""
    models = tmp_path / "share" / "drehgeber" / "models"
    models.mkdir(parents=True)
    shutil.copy(SOLD[0]["file"], models)
    told = subprocess.run([program, "list"], capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert SOLD[0]["model"] in told.stdout


def test_an_fmu_has_its_figures(tmp_path):
    path = tmp_path / "la26.ini"
    path.write_text(LA26)
    assert run("fmu", path, "--output", tmp_path / "a.fmu").stderr == ""
    described = zipfile.ZipFile(tmp_path / "a.fmu").read("modelDescription.xml").decode()
    assert "=la26:s3674-biss;-registers;-eds;st=26" in described


def test_a_wire_does_not_hide_what_is_wrong_in_a_file(tmp_path):
    path = tmp_path / "la26.ini"
    path.write_text(LA26.replace("st = 26", "st = 99"))
    assert "la26.ini:3: st 99: expected a number in 8..32" in run_refused(2, "run", path, "--sim")
    assert "none.ini: cannot open" in run_refused(2, "run", tmp_path / "none.ini", "--shaft", "1RPM")


def test_nobody_waits_for_a_fifo(folder, tmp_path):
    os.mkfifo(tmp_path / "models" / "a.ini")
    os.mkfifo(tmp_path / "acme.eds")
    ended = run("list", env=folder)
    assert "la26                     BiSS-C, linear, 26 bit\n" in ended.stdout
    assert "a.ini: expected a regular file" in ended.stderr
    assert "acme.eds: expected a regular file" in run_refused(1, "check", tmp_path / "acme.eds")
    assert "acme.eds: expected a regular file" in run_refused(2, "run", tmp_path / "acme.eds")


# --- EEPROM files -------------------------------------------------------------------------------

LA25 = LA26.replace("26", "25") + "inherit = registers\n"


def test_an_image_of_other_figures(tmp_path):
    """Refused with the figures; what fits goes on in a new file, and the old one stays."""
    path, old, new = tmp_path / "la.ini", tmp_path / "old.nvm", tmp_path / "new.nvm"
    live = ("--sim", "--time", "virtual:1MS")
    path.write_text(LA25)
    assert run("run", path, *live, "--nvm", old).returncode == 0
    image = old.read_bytes()
    assert b"protocol=biss\nmt=0\nst=25\n" in image
    path.write_text(LA25.replace("25", "26"))
    assert run_refused(2, "run", path, *live, "--nvm", old) == (
        f"drehgeber: {old}: of other figures: st: 25, expected 26; --nvm-convert NEW makes one of what fits")
    assert run("run", path, *live, "--nvm", old, "--nvm-convert", new).returncode == 0
    assert b"protocol=biss\nmt=0\nst=26\n" in new.read_bytes()
    assert run("run", path, *live, "--nvm", new).returncode == 0
    assert old.read_bytes() == image
    assert f"{new}: File exists" in run_refused(2, "run", path, *live, "--nvm", old, "--nvm-convert", new)
    path.write_text(LA25.replace("25", "26") + "busy_us = 12\n")
    assert run("run", path, *live, "--nvm", new).returncode == 0


def test_an_image_of_a_model_that_is_built_in(tmp_path):
    path, old, new = tmp_path / "la.ini", tmp_path / "old.nvm", tmp_path / "new.nvm"
    live = ("--sim", "--time", "virtual:1MS")
    path.write_text(LA25)
    assert run("run", "s3674-biss", *live, "--nvm", old).returncode == 0
    assert f"{old}: of other figures: those of a built-in model" in run_refused(2, "run", path, *live, "--nvm", old)
    (tmp_path / "bench.ini").write_text(LA25 + "[encoder a]\nmodel = la25\nwire = sim\nnvm = old.nvm\n")
    assert "those of a built-in model" in run_refused(2, "run", tmp_path / "bench.ini", *live[1:])
    assert run("run", path, *live, "--nvm", old, "--nvm-convert", new).returncode == 0
    assert "an image of this encoder has" in run_refused(1, "run", "s3674-biss", *live, "--nvm", new)
    old.write_bytes(b"something else")
    assert "nothing that could be converted; expected an image of an encoder of the same protocol" in run_refused(
        2, "run", path, *live, "--nvm", old, "--nvm-convert", tmp_path / "x.nvm")
    assert not (tmp_path / "x.nvm").exists()


def test_what_of_an_image_stays_as_delivered(tmp_path):
    path, old = tmp_path / "sin.ini", tmp_path / "old.nvm"
    live = ("--time", "virtual:1MS", "--nvm", old)
    path.write_text("[model sin]\nbase = s3684-rs485\nperiods = 512\n")
    assert run("run", path, "--pty", *live).returncode == 0
    path.write_text("[model sin]\nbase = s3684-rs485\nperiods = 1024\nmemory = 20\n")
    said = run("run", path, "--pty", *live, "--nvm-convert", tmp_path / "new.nvm")
    assert said.returncode == 0
    assert [line for line in said.stderr.splitlines() if "as delivered" in line] == [
        f"drehgeber: {old}: position offset: as delivered", f"drehgeber: {old}: data fields: as delivered"]
