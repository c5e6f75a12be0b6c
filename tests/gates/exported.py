# SPDX-License-Identifier: MIT
"""The shared library exports what the public headers declare with DG_API: all of it, nothing else. What
else has external linkage in the folders' libraries starts with dg_ and the folder's own prefix, so that
a program can link libdrehgeber.a beside libraries that have a co_find() or a scpi_write() of their own.

usage: exported.py TREE SHARED ARCHIVE...
"""

import re
import subprocess
import sys

from sources import blank, files, finish, read

# folder: what its internal names start with
PREFIX = {"hiperface": "dg_hf_", "canopen": "dg_co_", "interbus": "dg_ib_", "rig": "dg_plan_"}
# What a second part of a folder has instead.
SECOND = {"rig": "dg_engine_"}
DECLARED = re.compile(r"^DG_API\b([^;{]*);", re.M)
NAME = re.compile(r"\b(\w+)(?=\s*(?:\(|\[|,|$))")
# Where the parameters of a function begin, nothing is declared any more.
PARAMETERS = re.compile(r"\(.*", re.S)


def declared(tree):
    """Names that headers declare with DG_API, and where."""
    names = {}
    for path in files(tree, "include", suffixes=(".h",)):
        for match in DECLARED.finditer(blank(read(tree, path))):
            for name in NAME.findall(PARAMETERS.sub("(", match.group(1))):
                names[name] = path
    return names


def defined(library, *options):
    """Symbols with external linkage that `library` defines."""
    command = ["nm", *options, "--extern-only", "--defined-only", "--format=posix", library]
    lines = subprocess.check_output(command, text=True).splitlines()
    return {line.split()[0] for line in lines if line and not line.endswith(":")}


def foreign(archive, public):
    """Complaints about internal symbols of a folder's library."""
    folder = re.search(r"libdg_(\w+)\.a$", archive).group(1)
    prefix = PREFIX.get(folder, f"dg_{folder}_")
    internal = defined(archive) - set(public)
    known = prefix, SECOND.get(folder, prefix)
    return [f"{folder}: {name} is not {prefix}..." for name in sorted(internal) if not name.startswith(known)]


def main():
    tree, shared, *archives = sys.argv[1:]
    public, exported = declared(tree), defined(shared, "-D")
    complaints = [f"{public[name]}: {name} is not exported" for name in sorted(set(public) - exported)]
    complaints += [f"{shared} exports {name}, which no header declares" for name in sorted(exported - set(public))]
    for archive in archives:
        complaints += foreign(archive, public)
    finish(len(public) + len(exported), complaints)


if __name__ == "__main__":
    main()
