# SPDX-License-Identifier: MIT
"""What a release is made of: ARTEFACTS has a row for each, and each calls the tool of the tree that builds it."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

# Debian's own Python and compilers, whatever stands before them in PATH.
PATH = "/usr/sbin:/usr/bin:/sbin:/bin"
MACHINE = "debian12-x86_64"


@dataclass
class Work:
    """The tree, and where its release is made."""

    tree: Path
    version: str
    output: Path
    epoch: int
    notes: str

    @property
    def name(self) -> str:
        return f"drehgeber-{self.version}"

    @property
    def folder(self) -> Path:
        """For what is thrown away: new with each release."""
        return self.tree / "build/releasing"

    @property
    def sources(self) -> Path:
        """The source archive, unpacked: everything is built of it."""
        return self.folder / self.name

    @property
    def packages(self) -> Path:
        """The Debian packages, unpacked into one root."""
        return self.folder / "root"

    @property
    def python(self) -> Path:
        """Of the environment of tools/python-environment.txt."""
        return Path(os.environ.get("DREHGEBER_VENV", self.tree / "build/venv")).absolute() / "bin/python"

    @property
    def site_environment(self) -> Path:
        """Of tools/site/requirements.txt."""
        return Path(os.environ.get("DREHGEBER_SITE_ENV", self.tree / "build/site-env")).absolute()

    def run(self, *command: str | Path, **environment: str | Path) -> None:
        """In the sources; what it says is shown when it fails."""
        own = {"PATH": PATH, "CCACHE_DISABLE": "1"} | {key: str(value) for key, value in environment.items()}
        ended = subprocess.run([str(word) for word in command], cwd=self.sources, text=True, check=False,
                               env=os.environ | own, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if ended.returncode != 0:
            sys.exit(f"\n{ended.stdout[-4000:]}\ntools/release: {command[0]} has ended with {ended.returncode}")

    def pack(self, folder: Path, name: str) -> None:
        """A tar.gz of a folder, without what differs from machine to machine."""
        archive = self.output / f"{name}.tar"
        self.run("tar", "--sort=name", "--format=gnu", f"--mtime=@{self.epoch}", "--owner=0", "--group=0", "--numeric-owner",
                 "--mode=u=rwX,go=rX", f"--transform=s,^{folder.name},{name},", "-C", folder.parent, "-cf", archive, folder.name)
        self.run("gzip", "-9n", archive)


def make_sources(work: Work) -> None:
    """The files of the commit; unpacked again for all that follows."""
    shutil.rmtree(work.folder, ignore_errors=True)
    work.sources.mkdir(parents=True)
    archive = work.output / f"{work.name}-sources.tar"
    work.run("git", "-C", work.tree, "-c", "tar.umask=0022", "archive", f"--prefix={work.name}/", "-o", archive, "HEAD")
    work.run("gzip", "-9n", archive)
    work.run("tar", "-xzf", f"{archive}.gz", "-C", work.folder)


def make_python(work: Work) -> None:
    """The sources for pip, and of these a wheel for each processor."""
    work.run(work.tree / "tools/sysroot", "arm64")
    (work.sources / "build").mkdir(exist_ok=True)
    (work.sources / "build/sysroot").symlink_to(work.tree / "build/sysroot")
    for processor in ("x86_64", "aarch64"):
        made = work.folder / f"python-{processor}"
        work.run("tools/python/release", made, PYTHON=work.python, PROCESSOR=processor)
        for file in made.glob("drehgeber*.*"):
            shutil.copy(file, work.output)


def make_debian(work: Work) -> None:
    """Packages for Debian 12, as tests/package/debian builds and looks at them."""
    made = work.folder / "debian"
    work.run("tests/package/debian", ".", made)
    for package in sorted(made.glob("*.deb")):
        if "-dbgsym_" not in package.name:
            shutil.copy(package, work.output)
            work.run("dpkg-deb", "-x", package, work.packages)


def make_images(work: Work) -> None:
    """Images for a Raspberry Pi Pico."""
    work.run("tools/rp2040/build")
    for image in (work.sources / "build/images/platform/rp2040").glob("*.uf2"):
        shutil.copy(image, work.output / f"{image.stem}-{work.version}.uf2")


def make_page(work: Work) -> None:
    """The playground, as one file for a browser."""
    work.run("cmake", "--preset", "web")
    work.run("cmake", "--build", "--preset", "web")
    shutil.copy(work.sources / "build/web/playground/drehgeber.html", work.output / f"{work.name}-playground.html")


def make_site(work: Work) -> None:
    """The pages, with pictures of the packages' program and the playground in them."""
    program = work.folder / "site-program"
    shutil.copytree(work.sources / "build/web/playground", program / "playground")
    shutil.copy(work.packages / "usr/bin/drehgeber", program)
    site = work.folder / "site"
    work.run("tools/site/build", program / "drehgeber", site, DREHGEBER_SITE_ENV=work.site_environment)
    work.pack(site, f"{work.name}-site")


def make_hdl(work: Work) -> None:
    """Models for simulators with the library that they load, laid out as they are installed, so that pkg-config knows them;
    masters and test benches."""
    hdl = work.folder / "hdl"
    for pattern in ("share/drehgeber/hdl/*", "include/drehgeber/hdl*.h", "lib/*/pkgconfig/drehgeber-hdl.pc",
                    "lib/*/drehgeber/libdrehgeber_hdl.so"):
        for file in work.packages.glob(f"usr/{pattern}"):
            target = hdl / file.relative_to(work.packages / "usr")
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, target)
    shutil.copytree(work.sources / "platform/hdl/master", hdl / "master")
    shutil.copytree(work.sources / "tools/examples/hdl", hdl / "examples")
    for file in ("platform/hdl/README.md", "LICENSE"):
        shutil.copy(work.sources / file, hdl)
    work.pack(hdl, f"{work.name}-hdl-{MACHINE}")


def make_eds(work: Work) -> None:
    """Data sheets of CANopen encoders for masters."""
    for sheet in (work.sources / "tools/eds").glob("*.eds"):
        shutil.copy(sheet, work.output / f"{sheet.stem}-{work.version}.eds")


def make_notes(work: Work) -> None:
    """What is new, cut from the changelog; links into the tree lead nowhere from here."""
    notes = re.sub(r"\[([^\]]+)\]\((?![a-z]+:)[^)]*\)", r"\1", work.notes)
    (work.output / "NOTES.md").write_text(f"# drehgeber {work.version}\n\n{notes}\n", encoding="utf-8")


def make_list(work: Work) -> None:
    """SPDX: what is in the sources, what was made of them, and what that needs."""
    work.run(work.python, "tools/releasing/sbom.py", work.version, work.output, work.output / f"{work.name}.spdx.json",
             DREHGEBER_SITE_ENV=work.site_environment)


# In this order: the site wants packages and page, HDL the packages, and the list everything.
ARTEFACTS: dict[str, Callable[[Work], None]] = {
    "sources": make_sources,
    "python": make_python,
    "debian": make_debian,
    "images": make_images,
    "page": make_page,
    "site": make_site,
    "hdl": make_hdl,
    "eds": make_eds,
    "notes": make_notes,
    "sbom": make_list,
}
