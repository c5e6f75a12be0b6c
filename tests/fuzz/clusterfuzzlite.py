# SPDX-License-Identifier: MIT
"""What .clusterfuzzlite/build.sh makes, with the compiler of this machine: every target with its seeds
and its words, and each target takes its seeds.

usage: clusterfuzzlite.py TREE WORK
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import zipfile

SANITIZE = "-O1 -fno-omit-frame-pointer -fsanitize=address -fsanitize=fuzzer-no-link"


def main():
    tree, work = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    out = work / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    settings = {"CC": "clang", "CXX": "clang++", "CFLAGS": SANITIZE, "CXXFLAGS": SANITIZE,
                "LIB_FUZZING_ENGINE": "-fsanitize=fuzzer", "WORK": str(work), "OUT": str(out)}
    subprocess.run([tree / ".clusterfuzzlite/build.sh"], cwd=tree, check=True,
                   env=os.environ | settings)
    targets = sorted(path.stem for path in (tree / "tests/fuzz").glob("fuzz_*.c"))
    for name in targets:
        assert (out / f"{name}.dict").read_bytes() == (tree / f"tests/fuzz/{name}.dict").read_bytes()
        with tempfile.TemporaryDirectory() as seeds:
            with zipfile.ZipFile(out / f"{name}_seed_corpus.zip") as archive:
                archive.extractall(seeds)
            inputs = {path.name for path in pathlib.Path(seeds).iterdir()}
            assert inputs == {path.name for path in (tree / "tests/fuzz/corpus" / name).iterdir()}
            assert inputs, name
            subprocess.run([out / name, "-runs=0", "-close_fd_mask=1", seeds], check=True,
                           stderr=subprocess.DEVNULL, timeout=60)
        print(f"{name}: {len(inputs)} seeds")
    assert targets and {path.name for path in out.iterdir() if path.is_file() and not path.suffix} == set(targets)


main()
