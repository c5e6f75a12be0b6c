# SPDX-License-Identifier: MIT
"""Every file of a release does what it is for, with nothing else of ours: the release is in $RELEASE_FOLDER. Programs of
other tests are handed what was unpacked from there in place of the tree. By hand, as root:

RELEASE_FOLDER=build/releases/drehgeber-VERSION /usr/bin/python3 -m pytest tests/release/test_smoke.py
"""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
import yaml

from copies import TREE, VERSION

sys.path.append(str(TREE / "tests/package"))
import debian_root  # noqa: E402

RELEASE = Path(os.environ["RELEASE_FOLDER"]).resolve()
VENV = Path(os.environ.get("DREHGEBER_VENV", TREE / "build/venv"))
BROWSER = Path(os.environ.get("DREHGEBER_BROWSER", TREE / "build/browser"))
HERE = Path(__file__).resolve().parent
# What pip is told about the registry here, it is told in a root as well.
REGISTRY = {name: value for name, value in os.environ.items()
            if re.fullmatch(r"PIP_(INDEX_URL|CERT|DEFAULT_TIMEOUT)|https?_proxy", name)}
# Installing a package writes Debian's list of authorities anew.
CERTIFICATES = "/etc/ssl/registry.crt"
if "PIP_CERT" in REGISTRY:
    REGISTRY["PIP_CERT"] = CERTIFICATES
PYTHON_MAX_S, RUN_MAX_S = 60, 120
# Debian's own programs, whatever stands before them in PATH.
PLAIN = {**os.environ, "PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "PYTHONDONTWRITEBYTECODE": "1"}
READ = 'import drehgeber; print(drehgeber.Encoder("s3684-rs485").request(bytes.fromhex("404202")).hex())'
REPLY = "40420000000002"


def call(*command, cwd=None, **environment) -> str:
    """What it prints; one that fails ends the test with it."""
    ended = subprocess.run([str(word) for word in command], cwd=cwd, text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, env=PLAIN | {key: str(value) for key, value in environment.items()},
                           check=False)
    assert ended.returncode == 0, ended.stdout[-4000:]
    return ended.stdout


def one(pattern: str) -> Path:
    [path] = RELEASE.glob(pattern)
    return path


def unpack(pattern: str, folder: Path) -> Path:
    """An archive's only folder."""
    call("tar", "-xzf", one(pattern), "-C", folder)
    [inside] = folder.iterdir()
    return inside


@pytest.fixture(scope="module", name="sources")
def fixture_sources(tmp_path_factory):
    return unpack("*-sources.tar.gz", tmp_path_factory.mktemp("sources"))


@pytest.fixture(scope="module", name="base")
def fixture_base(tmp_path_factory):
    """A fresh Debian, with the release in /release."""
    root = tmp_path_factory.mktemp("debian") / "base"
    debian_root.make_root(root, "bookworm")
    shutil.copy("/etc/hosts", root / "etc/hosts")
    if "PIP_CERT" in os.environ:
        (root / CERTIFICATES[1:]).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(os.environ["PIP_CERT"], root / CERTIFICATES[1:])
    shutil.copytree(RELEASE, root / "release")
    yield root
    shutil.rmtree(root)


@pytest.fixture(name="root")
def fixture_root(base, tmp_path):
    """A copy of it."""
    debian_root.copy(base, tmp_path / "root")
    yield tmp_path / "root"
    shutil.rmtree(tmp_path / "root")


def make_venv(folder: Path, *wanted) -> Path:
    call("python3", "-m", "venv", folder)
    call(folder / "bin/pip", "install", "-q", *wanted)
    return folder / "bin/python"


def test_sums():
    call("sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS", cwd=RELEASE)
    listed = {line.split()[1] for line in (RELEASE / "SHA256SUMS").read_text(encoding="utf-8").splitlines()}
    assert listed | {"SHA256SUMS"} == {path.name for path in RELEASE.iterdir()}


def test_the_list_is_spdx_and_has_every_file():
    listed = one("*.spdx.json")
    call(VENV / "bin/pyspdxtools", "--infile", listed)
    packages = json.loads(listed.read_text(encoding="utf-8"))["packages"]
    sums = {package.get("packageFileName"): checksum["checksumValue"] for package in packages
            for checksum in package.get("checksums", []) if checksum["algorithm"] == "SHA256"}
    rows = (line.split() for line in (RELEASE / "SHA256SUMS").read_text(encoding="utf-8").splitlines())
    assert {name: value for value, name in rows if name != listed.name} == \
        {name: value for name, value in sums.items() if name is not None}


def test_the_wheel_in_a_fresh_environment(tmp_path):
    """The first page's test of a master."""
    page = (TREE / "README.md").read_text(encoding="utf-8")
    [text] = re.findall(r"^<!-- file: test_master.py -->\n```python\n(.*?)^```$", page, re.M | re.S)
    (tmp_path / "test_master.py").write_text(text, encoding="utf-8")
    python = make_venv(tmp_path / "venv", f"{one('*_x86_64.whl')}[serial]", "pytest")
    assert "1 passed" in call(python, "-m", "pytest", "-q", "test_master.py", cwd=tmp_path)


def test_the_wheel_for_aarch64_has_a_library_for_it(tmp_path):
    with zipfile.ZipFile(one("*_aarch64.whl")) as wheel:
        wheel.extractall(tmp_path)
    libraries = list(tmp_path.rglob("*.so"))
    assert libraries
    for library in libraries:
        assert re.search(r"Machine: +AArch64", call("readelf", "-h", library))


def test_the_python_sources_build(tmp_path):
    python = make_venv(tmp_path / "venv", RELEASE / f"drehgeber-{VERSION}.tar.gz")
    assert call(python, "-c", READ, cwd=tmp_path).strip() == REPLY


def test_the_debian_packages_together(root, capfd):
    """Manual pages, unit, a program with the library, Python; then the service as systemd starts it."""
    shutil.copytree(RELEASE, root / "packages")
    shutil.copy(HERE / "service.py", root / "tmp")
    debian_root.run(root, "apt-get -qq update" + debian_root.INSTALLED + "python3 /tmp/service.py 90DEG")
    said = capfd.readouterr().out
    assert re.search(rf"^{re.escape(VERSION)} {REPLY}$", said, re.M)
    assert re.search(r"^READY=1$", said, re.M)
    assert re.search(r"^90\.000000$", said, re.M)


@pytest.mark.parametrize("how", ["fetchcontent", "bare", "meson"])
def test_consumers_of_the_sources(sources, tmp_path, how):
    """CMake and Meson projects; `bare` is one for a Cortex-M4."""
    call(TREE / "tests/package/consumer", how, sources, tmp_path)


def test_consumers_of_the_package(sources, tmp_path):
    """CMake's find_package() in what the development packages have."""
    for package in (*RELEASE.glob("libdrehgeber[0-9]*.deb"), one("libdrehgeber-dev_*.deb"), one("drehgeber_*.deb")):
        call("dpkg-deb", "-x", package, tmp_path / "root")
    (tmp_path / "prefix").symlink_to(tmp_path / "root/usr")
    call(TREE / "tests/package/consumer", "find-package", sources, tmp_path)


def test_consumers_by_frameworks(sources, tmp_path):
    """What PlatformIO, Arduino, ESP-IDF and Zephyr are told to compile."""
    said = call("python3", "-B", TREE / "tests/package/sources", sources, tmp_path / "built")
    assert len(re.findall(r"^(?:platformio|arduino|esp-idf|zephyr): \d\d+ sources and ", said, re.M)) == 4


def test_the_hdl_archive_with_icarus(tmp_path):
    folder = unpack("*-hdl-*.tar.gz", tmp_path)
    [found] = folder.glob("lib/*/pkgconfig")
    said = call(folder / "examples/icarus/run", tmp_path / "built", PKG_CONFIG_PATH=found)
    assert re.search(r"^ok$", said, re.M), said


# The profile that every CiA 406 encoder names in 1000h, and Kuebler's vendor number in 1018h.
@pytest.mark.parametrize("model", ["f3658", "f3668"])
def test_data_sheets(model):
    said = call(VENV / "bin/python", "-B", "-c", "import sys, canopen; od = canopen.import_od(sys.argv[1]); "
                "print(od[0x1000].default & 0xFFFF, od['Position value'].index, od.device_information.vendor_number)",
                one(f"{model}-{VERSION}.eds"))
    assert said.split() == [str(406), str(0x6004), str(0x13)]


def image_of(file: Path) -> bytes:
    """What a board flashes of an UF2 file: https://github.com/microsoft/uf2."""
    data = file.read_bytes()
    blocks = [data[at:at + 512] for at in range(0, len(data), 512)]
    for i, block in enumerate(blocks):
        assert block[:8] == bytes.fromhex("5546320a 57515d9e") and block[508:] == bytes.fromhex("306fb10a")
        assert int.from_bytes(block[12:16], "little") == 0x10000000 + 256 * i
    return b"".join(block[32:288] for block in blocks)


def test_images(tmp_path):
    """Each is one for flash; that with SLCAN answers in an emulated board, and keeps a value over a reset."""
    images = {path: image_of(path) for path in RELEASE.glob("*.uf2")}
    assert len(images) > 10
    board = tmp_path / "board.bin"
    board.write_bytes(images[one("drehgeber-f3668-slcan-*.uf2")])
    said = call(VENV / "bin/python", "-B", TREE / "tests/rp2040/second.py", board)
    assert "1017h after a reset: 4B17100064000000" in said


def test_the_page_from_a_file(tmp_path):
    """In Chromium, without a server."""
    shutil.copy(one("*-playground.html"), tmp_path / "drehgeber.html")
    said = call(BROWSER / "bin/python", "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", "--noconftest", "-k", "one_file",
                TREE / "tests/e2e/playground/test_playground.py", PLAYGROUND=tmp_path, DREHGEBER="", HANDLE_PYTHON="")
    assert re.search(r"^2 passed", said, re.M), said


def test_the_site(tmp_path):
    site = unpack("*-site.tar.gz", tmp_path)
    for page in ("index.html", "docs/start.html", "playground/index.html"):
        assert (site / page).stat().st_size > 1000


def jobs_of_the_page() -> list:
    """The jobs of docs/install.md for the two forges: GitHub's, GitLab's."""
    blocks = debian_root.blocks_of(TREE / "docs/install.md", "release.smoke", "yaml")
    github, gitlab = (yaml.safe_load(block) for block in blocks)
    return [github["jobs"]["test"], gitlab["test"]]


def test_the_action(root, capfd):
    """The steps of action.yml as docs/install.md calls them, with the release where its address leads to. Then what it
    has for GitLab, in the same root in place of the image."""
    github, gitlab = jobs_of_the_page()
    called, asks, shows = github["steps"]
    assert called["uses"] == f"ADDRESS/drehgeber@v{VERSION}" and called["with"]["version"] == VERSION
    assert shows["run"] == f'echo "the port is ${{{{ steps.{called["id"]}.outputs.wire }}}}"'
    steps = yaml.safe_load((TREE / "action.yml").read_text(encoding="utf-8"))["runs"]["steps"]
    shutil.copytree(TREE / ".ci", root / "action/.ci")
    (root / "releases").mkdir()
    (root / f"releases/v{VERSION}").symlink_to("../release")
    inputs = {name.upper(): value for name, value in called["with"].items()}
    values = {"ACTION": "/action", "RELEASES": "file:///releases", "GITHUB_OUTPUT": "/tmp/output"} | inputs
    assert set(values) >= {name for step in steps for name in step["env"]}
    ask = f"; {asks['run']}; cat /tmp/output"
    debian_root.run(root, "\n".join(step["run"] for step in steps) + ask, environment=values)
    said = capfd.readouterr().out
    assert re.search(rf"^drehgeber {re.escape(VERSION)}$", said, re.M)
    assert re.search(r"^90\.000000$", said, re.M)
    assert re.search(r"^wire=/dev/pts/\d+$", said, re.M)
    assert gitlab["image"]["name"].endswith(f":{VERSION}")
    assert re.search(r"^90\.000000$", debian_root.run(root, "\n".join(gitlab["script"])), re.M)


def type_page(root: Path, ends: str, wanted_s: int, what: str, **environment) -> str:
    """A newcomer's commands as docs/install.md has them, in the release folder; the block that ends with `ends`."""
    blocks = debian_root.blocks_of(TREE / "docs/install.md", "release.smoke")
    [block] = [block for block in blocks if ends in block]
    begin = time.monotonic()
    said = debian_root.run(root, debian_root.TYPED + block, "/release", environment=REGISTRY | environment)
    took = time.monotonic() - begin
    print(f"figure: {what} in a fresh Debian after {took:.0f} s")
    assert took < wanted_s
    return said


def test_a_newcomer_has_a_turning_encoder_in_python(root):
    assert type_page(root, "encoder.position", PYTHON_MAX_S, "a turning encoder in Python").endswith("\n600.25 turns\n")


def test_a_newcomer_runs_the_command(root):
    """`run` goes on until it is ended: here a minute after it was begun, at the latest."""
    said = type_page(root, "drehgeber run", RUN_MAX_S, "drehgeber run")
    assert re.search(r"^ready s3684-rs485 pty:/dev/pts/\d+$", said, re.M), said
