# SPDX-License-Identifier: MIT
"""Writes the list of what a release has, as SPDX 2.3 in JSON: the files of the source archive, what was made of it, what
that needs to run, and what of others is inside. gate.reuse holds every file to the licence that stands here.

usage: sbom.py VERSION RELEASE OUTPUT
"""

import hashlib
import importlib.metadata
import os
import re
import subprocess
import sys
import tarfile
from datetime import datetime, timezone
from pathlib import Path

from spdx_tools.common.spdx_licensing import spdx_licensing
from spdx_tools.spdx.model import (
    Actor, ActorType, Checksum, ChecksumAlgorithm, CreationInfo, Document, ExternalPackageRef, ExternalPackageRefCategory, File,
    Package, Relationship, RelationshipType, SpdxNoAssertion)
from spdx_tools.spdx.spdx_element_utils import calculate_package_verification_code
from spdx_tools.spdx.writer.write_anything import write_file

AUTHORS = "The drehgeber authors"
TERMS = spdx_licensing.parse("MIT")
COPYRIGHT = f"2026 {AUTHORS}"
SOURCES = "SPDXRef-sources"
# What an artefact needs of others (pyproject.toml), beside what Debian packages say themselves: ending, kind, name
NEEDED = ((".whl", "pypi", "cffi"),)
# What of others is inside: ending, kind, name. Who builds has it installed.
INSIDE = ((".uf2", "deb", "libnewlib-arm-none-eabi"), (".uf2", "deb", "gcc-arm-none-eabi"),
          ("-site.tar.gz", "pypi", "mkdocs-material"))


def identify(*words: str) -> str:
    return "SPDXRef-" + "-".join(re.sub(r"[^A-Za-z0-9.]", "-", word) for word in words)


def checksum(data: bytes, algorithm: str) -> Checksum:
    return Checksum(ChecksumAlgorithm[algorithm.upper()], hashlib.new(algorithm, data).hexdigest())


def list_files(archive: Path) -> list[File]:
    """Regular files of the source archive."""
    files = []
    with tarfile.open(archive) as packed:
        for member in packed:
            stream = packed.extractfile(member) if member.isfile() else None
            if stream:
                data = stream.read()
                name = "./" + member.name.partition("/")[2]
                files.append(File(name, identify("file", name[2:], hashlib.sha1(name.encode()).hexdigest()[:8]),
                                  [checksum(data, "sha1"), checksum(data, "sha256")], license_concluded=TERMS,
                                  license_info_in_file=[TERMS], copyright_text=COPYRIGHT))
    return sorted(files, key=lambda file: file.name)


def describe_own(path: Path, name: str, version: str) -> Package:
    """A file of the release."""
    return Package(name, path.name, SpdxNoAssertion(), version=version, file_name=path.name, files_analyzed=False,
                   supplier=Actor(ActorType.ORGANIZATION, AUTHORS), checksums=[checksum(path.read_bytes(), "sha256")],
                   license_concluded=TERMS, license_declared=TERMS, copyright_text=COPYRIGHT)


def describe_other(kind: str, name: str, version: str | None = None) -> Package:
    """Somebody else's package."""
    address = f"pkg:{kind}/{'debian/' if kind == 'deb' else ''}{name}{f'@{version}' if version else ''}"
    return Package(identify(kind, name), name, SpdxNoAssertion(), version=version, files_analyzed=False,
                   external_references=[ExternalPackageRef(ExternalPackageRefCategory.PACKAGE_MANAGER, "purl", address)])


def needed_by(path: Path) -> list[tuple[str, str]]:
    """Kind and name of what an artefact is installed with."""
    rows = [(kind, name) for ending, kind, name in NEEDED if path.name.endswith(ending)]
    if path.suffix == ".deb":
        said = subprocess.check_output(["dpkg-deb", "-f", path, "Depends"], text=True)
        rows += [("deb", name) for name in re.findall(r"(?:^|, )([a-z0-9.+-]+)", said)]
    return rows


def version_inside(kind: str, name: str) -> str:
    """Of what was put in, as it is installed here."""
    if kind == "deb":
        return subprocess.check_output(["dpkg-query", "-W", "-f", "${Version}", name], text=True)
    folders = [str(path) for path in Path(os.environ["DREHGEBER_SITE_ENV"]).glob("lib/python3*/site-packages")]
    [found] = importlib.metadata.distributions(name=name, path=folders)
    return found.version


def relate(document: Document, path: Path, version: str) -> None:
    """An artefact: of the sources, with what it needs and what is inside."""
    artefact = describe_own(path, identify("artefact", path.name), version)
    document.packages.append(artefact)
    rows = [(RelationshipType.GENERATED_FROM, SOURCES)]
    others = [(RelationshipType.DEPENDS_ON, describe_other(*row)) for row in needed_by(path)]
    others += [(RelationshipType.CONTAINS, describe_other(kind, name, version_inside(kind, name)))
               for ending, kind, name in INSIDE if path.name.endswith(ending)]
    for how, other in others:
        if all(known.spdx_id != other.spdx_id for known in document.packages):
            document.packages.append(other)
        rows.append((how, other.spdx_id))
    document.relationships += [Relationship(artefact.spdx_id, how, other) for how, other in rows]


def main() -> None:
    """Describe, relate, write; what is no SPDX is not written."""
    version, release, output = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    archive = release / f"drehgeber-{version}-sources.tar.gz"
    files = list_files(archive)
    sources = describe_own(archive, SOURCES, version)
    sources.files_analyzed, sources.license_info_from_files = True, [TERMS]
    sources.verification_code = calculate_package_verification_code(files)
    created = datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), timezone.utc).replace(tzinfo=None)
    creation = CreationInfo("SPDX-2.3", "SPDXRef-DOCUMENT", f"drehgeber-{version}",
                            f"https://spdx.org/spdxdocs/drehgeber-{version}-{sources.checksums[0].value}",
                            [Actor(ActorType.ORGANIZATION, AUTHORS), Actor(ActorType.TOOL, "tools/release")], created)
    document = Document(creation, packages=[sources], files=files)
    document.relationships = [Relationship("SPDXRef-DOCUMENT", RelationshipType.DESCRIBES, SOURCES)]
    document.relationships += [Relationship(SOURCES, RelationshipType.CONTAINS, file.spdx_id) for file in files]
    for path in sorted(release.iterdir()):
        if path not in (archive, output):
            relate(document, path, version)
    write_file(document, str(output))


main()
