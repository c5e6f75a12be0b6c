# SPDX-License-Identifier: MIT
"""The package as it is installed: files, types, documentation, entry points."""
import ast
import importlib.metadata
import inspect
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import drehgeber
import drehgeber.cocotb
import pytest
from drehgeber import _native

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
DIST = Path(os.environ["DREHGEBER_DIST"])  # what tools/python/release has made
CACHE = DIST.parent / "mypy"
DEBIAN_12 = (2, 36)  # its glibc

USER = HERE / "user.py"


def run(*arguments, **options) -> subprocess.CompletedProcess:
    """This Python, somewhere else."""
    return subprocess.run([sys.executable, *map(str, arguments)], text=True, capture_output=True, timeout=120, **options)


def mypy(*arguments, **options) -> str:
    return run("-m", "mypy", "--strict", "--cache-dir", CACHE, *arguments, **options).stdout


@pytest.fixture(scope="session")
def wheel() -> Path:
    (found,) = DIST.glob("*.whl")
    return found


def test_the_wheel_is_for_debian_12_and_any_python(wheel):
    match = re.fullmatch(r"drehgeber-([\d.]+)-py3-none-manylinux_(\d+)_(\d+)_\w+\.whl", wheel.name)
    assert match and (int(match[2]), int(match[3])) <= DEBIAN_12
    shown = " ".join(run("-m", "auditwheel", "show", wheel).stdout.split())
    assert f'is consistent with the following platform tag: "{wheel.stem.rpartition("-")[2]}"' in shown
    assert "system-provided shared libraries: libc.so.6 with versions" in shown


def test_what_is_in_the_wheel(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {"drehgeber/py.typed", "drehgeber/libdrehgeber.so", "drehgeber/_abi.py"} <= set(names)
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert all(name.startswith("drehgeber") for name in names)


def test_the_version_is_the_projects():
    text = (TREE / "tools/python/core/include/drehgeber/version.h").read_text()
    assert f'#define DG_VERSION "{drehgeber.__version__}"' in text
    assert importlib.metadata.version("drehgeber") == drehgeber.__version__


def test_it_is_the_installed_one():
    assert TREE not in Path(drehgeber.__file__).parents or "env" in Path(drehgeber.__file__).parts


def test_types_of_the_package(tmp_path):
    assert "Success" in mypy("-p", "drehgeber", cwd=tmp_path)


def test_types_of_a_users_file(tmp_path):
    assert mypy(USER, cwd=tmp_path).startswith("Success")
    assert run(USER, cwd=tmp_path).returncode == 0
    user = tmp_path / "user.py"
    user.write_text(USER.read_text() + 'shaft.mvoe(90)\nblade.world.temperatur = 3\nmotor.request("text")\n')
    said = mypy(user, cwd=tmp_path)
    assert '"Shaft" has no attribute "mvoe"' in said and '"temperatur"' in said and '"str"; expected "bytes"' in said


def public(thing, name=""):
    """Names of what is public and its own, with what it is."""
    yield name, thing
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_") and (callable(value) or isinstance(value, (property, staticmethod))):
                yield f"{name}.{member}", value


@pytest.mark.parametrize("package", [drehgeber, drehgeber.cocotb])
def test_everything_public_is_documented(package):
    for name in set(package.__all__) - {"__version__"}:
        for path, thing in public(getattr(package, name), name):
            assert (thing.__doc__ or "").strip(), path
    assert package.__doc__


@pytest.mark.parametrize(
    "without, said",
    [
        ("sys.modules['cocotb'] = None", "No module named"),
        ("import cocotb; cocotb.__version__ = '1.9.2'", "needs cocotb 2, and this is 1.9.2"),
    ],
)
def test_without_cocotb_the_extra_is_named(tmp_path, without, said):
    done = run("-c", f"import sys; {without}; import drehgeber.cocotb", cwd=tmp_path)
    assert "ImportError: drehgeber.cocotb" in done.stderr and "pip install 'drehgeber[cocotb]'" in done.stderr
    assert said in done.stderr or "import of cocotb halted" in done.stderr


def test_extras_bring_what_examples_import():
    brought = {re.match(r"[\w-]+", row)[0] for row in importlib.metadata.requires("drehgeber")}
    sources = [ast.parse(path.read_text(encoding="utf-8")) for path in (TREE / "tools/examples").glob("test_*.py")]
    nodes = [node for source in sources for node in ast.walk(source)]
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in nodes if isinstance(node, ast.ImportFrom)]
    modules = {name.partition(".")[0] for name in names} - set(sys.stdlib_module_names) - {"drehgeber", "pytest"}
    assert "canopen" in modules
    assert {importlib.metadata.packages_distributions()[module][0] for module in modules} <= brought


def test_fixtures_are_there_by_themselves(tmp_path):
    (tmp_path / "test_user.py").write_text((HERE / "test_user.py").read_text())
    done = run("-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=tmp_path)
    assert "2 passed" in done.stdout, done.stdout


def test_without_the_command_it_is_said_where_it_comes_from(tmp_path):
    environment = {key: value for key, value in os.environ.items() if key != "DREHGEBER"}
    done = run("-c", "import drehgeber; drehgeber.run('f3668')", cwd=tmp_path, env={**environment, "PATH": "/nonexistent"})
    assert "RigError: " in done.stderr and "put it on PATH" in done.stderr and "cmake --install" in done.stderr


def test_encoders_need_the_package(tmp_path):
    """From the folder of sources, rigs of the command work, and encoders say what is missing."""
    script = "import drehgeber; print(drehgeber.run); drehgeber.Encoder('f3668')"
    done = run("-S", "-c", script, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(TREE / "tools/python")})
    assert "<function run" in done.stdout
    assert "EncoderError" in done.stderr and "pip install drehgeber" in done.stderr


def test_another_library_by_its_path(tmp_path):
    script = "import drehgeber; drehgeber.Encoder('f3668')"
    done = run("-c", script, cwd=tmp_path, env={**os.environ, "DREHGEBER_LIBRARY": "/nonexistent/lib.so"})
    assert "EncoderError" in done.stderr and "/nonexistent/lib.so" in done.stderr


def test_a_library_of_another_version(tmp_path):
    script = "import drehgeber; drehgeber.__version__ = '0.0.9'; drehgeber.Encoder('f3668')"
    done = run("-c", script, cwd=tmp_path)
    assert f"is of version {drehgeber.__version__}, and this package needs 0.0 or a later 0.x" in done.stderr


@pytest.mark.parametrize("version, fits", [("1.2.0", True), ("1.2.7", True), ("1.10.0", True), ("1.1.9", False), ("2.3.0", False)])
def test_a_later_minor_version_has_what_the_package_needs(monkeypatch, version, fits):
    monkeypatch.setattr(drehgeber, "__version__", "1.2.3")
    if fits:
        _native._check_version("lib.so", version)
    else:
        with pytest.raises(drehgeber.EncoderError, match="needs 1.2 or a later 1.x"):
            _native._check_version("lib.so", version)


def test_a_folder_of_sources_takes_any_library(monkeypatch):
    monkeypatch.setattr(drehgeber, "__version__", "0")
    _native._check_version("lib.so", "1.2.0")
