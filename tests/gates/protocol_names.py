# SPDX-License-Identifier: MIT
"""Who a protocol is stands in its own places; everybody else goes by the medium of a wire, by what a handle can do, by
rows of models. Refused are

- a string literal that is the name of a protocol, as the stacks have it, outside of OWN and ALLOWED;
- what only one stack can reach behind a comparison with a medium, a `case` of one or a row of a table by media, in C
  outside of OWN: its code names a function or a header of a protocol.

It reads text, a line or a block at a time. It does not see a name that is put together of parts, in a comment or in an
object's key of JavaScript; a branch on a capability; a body that calls a function of the same file which then names the
protocol; what follows a block that has returned; media compared in other languages than C.

usage: protocol_names.py TREE
"""

import re
import sys
from fnmatch import fnmatch
from pathlib import Path

from exported import PREFIX
from sources import blank, files, finish, read

FOLDERS = ("src", "include", "platform", "tools", "tests")
SUFFIXES = (".c", ".h", ".def", ".py", ".js", ".mjs")
NAME = re.compile(r'^    \.name = "(\w+)",$', re.M)
# Folders that stacks are made of beside the one that has stack.c.
BESIDE = {"cia406": ("canopen",)}

# A protocol's own places; PROTOCOL is any of them, FOLDER one of its folders in src/.
OWN = (
    "src/FOLDER/*", "src/devices/*", "src/instruments/*", "include/drehgeber/FOLDER.h",
    "platform/linux/can/*", "platform/linux/clocked/*", "platform/linux/interbus/*",
    "tools/drehgeber/PROTOCOL.c", "tools/drehgeber/verify_FOLDER.c", "tools/sigrok/*/*",
    "tests/e2e/test_PROTOCOL*.py", "tests/e2e/test_sigrok.py", "tests/hdl/*", "tests/hdl/cocotb/bench_PROTOCOL.py",
    "tests/unit/test_PROTOCOL_*.c",
)
# Files in which one may be named all the same, each with its reason.
COMMAND, NAMED, TABLE = "the command `drehgeber biss` or `ssi`", "encoders, wires or files that are called so", "what the test expects of each"
ALLOWED = {
    "platform/web/single.py": "page/biss.js, a BiSS master",
    "tools/drehgeber/help.c": COMMAND,
    "tools/drehgeber/command_rows.c": COMMAND,
    "tools/python/drehgeber/clocked.py": "classes Biss and Ssi, masters of these alone",
    "tools/python/drehgeber/cocotb/clocked.py": "classes BissEncoder and SsiEncoder, of these alone",
    "tools/python/drehgeber/cocotb/hiperface.py": "class HiperfaceEncoder, of this alone",
    "tools/site/made.py": COMMAND,
    "tools/site/overview.py": COMMAND,
    "tests/abi/0.2/*": "a header as it was released",
    "tests/conformance/conformance.c": "suites, each of a protocol's clauses",
    "tests/differential/play_command.py": TABLE,
    "tests/differential/play_hdl.py": NAMED,
    "tests/differential/script.py": TABLE,
    "tests/e2e/gpio/conftest.py": "a word of names of models",
    "tests/e2e/gpio/test_gpio.py": COMMAND,
    "tests/e2e/panel/test_panel.py": COMMAND,
    "tests/e2e/playground/test_playground.py": "the four encoders of the page, by the names of their tabs",
    "tests/e2e/rig/bench.py": "the folder tests/e2e/canopen",
    "tests/e2e/rig40/masters.[cp]*": NAMED,
    "tests/e2e/silkit/soak.py": NAMED,
    "tests/e2e/strangers/test_command.py": COMMAND,
    "tests/e2e/test_access.py": NAMED,
    "tests/e2e/test_cli.py": COMMAND,
    "tests/e2e/test_explain.py": COMMAND,
    "tests/e2e/test_files.py": NAMED,
    "tests/e2e/test_golden.py": COMMAND,
    "tests/e2e/test_models.py": COMMAND,
    "tests/e2e/test_manual.py": COMMAND,
    "tests/e2e/test_trace_tools.py": COMMAND,
    "tests/e2e/verified.py": "lists of clauses that are called so",
    "tests/fmu/test_described.py": NAMED,
    "tests/gates/*.py": "which folders there are",
    "tests/python/test_encoder.py": "properties of Encoder that only one protocol has",
    "tests/python/test_package.py": "the module of python-canopen",
    "tests/rp2040/image.test.mjs": "images that are called so",
    "tests/support/host_rig.c": TABLE,
    "tests/trace/make_traces.c": TABLE,
}
MEDIUM = r"DG_(?:HOST_)?MEDIUM_(?!COUNT\b)\w+"
BRANCH = re.compile(rf"\bcase {MEDIUM}\s*:|[!=]=\s*(?:\(int\))?{MEDIUM}|\b{MEDIUM}\s*[!=]=|\[{MEDIUM}\]\s*=")


def names(tree):
    """Protocols, and the folders of each."""
    found = {}
    for path in files(tree, "src", suffixes=("stack.c",)):
        folder = path.split("/")[1]
        found[NAME.search(read(tree, path)).group(1)] = (folder, *BESIDE.get(folder, ()))
    return found


def own_places(protocols):
    """Patterns of paths, without the words that stand for a protocol."""
    folders = [folder for of in protocols.values() for folder in of]
    places = []
    for row in OWN:
        words = folders if "FOLDER" in row else list(protocols) if "PROTOCOL" in row else [""]
        places += [row.replace("FOLDER", word).replace("PROTOCOL", word) for word in words]
    return places


def body(text, start):
    """What belongs to a branch that begins there: up to the end of its block, the next `case` or the next row."""
    depth = 0
    is_case = text[start - 1] == ":"
    for match in re.finditer(r"[{}();,]|\bcase\b|\bdefault\b", text[start:]):
        token = match.group()
        depth += (token in ("{", "(")) - (token in ("}", ")"))
        over = {"}": depth <= 0 and not (is_case and depth == 0), ";": depth <= 0 and not is_case, ",": depth <= 0 and not is_case}
        if over.get(token, False) or token in ("case", "default") and depth <= 0:
            return text[start:start + match.end()]
        depth = max(depth, 0)
    return text[start:]


def lonely(path, text, theirs):
    """Branches on a medium behind which a protocol stands."""
    code = blank(text)
    for match in BRANCH.finditer(code):
        found = theirs.search(body(code, match.end()))
        if found:
            line = code.count("\n", 0, match.start()) + 1
            yield f"{path}:{line}: only one protocol can get behind {match.group().strip()}: {found.group()}"


def main():
    tree = sys.argv[1]
    protocols = names(tree)
    literal = re.compile(rf"""(["'])({'|'.join(protocols)})\1""")
    prefixes = {PREFIX.get(folder, f"dg_{folder}_") for of in protocols.values() for folder in of}
    theirs = re.compile(rf"\b(?:{'|'.join(sorted(prefixes))})\w+")
    own, allowed, named, checked, complaints = own_places(protocols), set(), 0, 0, []
    for path in files(tree, *FOLDERS, suffixes=SUFFIXES):
        if any(fnmatch(path, place) for place in own):
            continue
        checked += 1
        text = read(tree, path)
        rows = {row for row in ALLOWED if fnmatch(path, row)}
        lines = [number for number, line in enumerate(text.split("\n"), 1) if literal.search(line)]
        named += len(lines)
        allowed |= rows if lines else set()
        complaints += [] if rows else [f"{path}:{number}: a protocol is named" for number in lines]
        complaints += lonely(path, text, theirs) if path.endswith((".c", ".h")) else []
    complaints += [f"{row} is allowed, and names no protocol" for row in sorted(set(ALLOWED) - allowed)
                   if (Path(tree) / row).exists()]
    print(f"{named} lines outside of a protocol's own places name one")
    finish(checked, complaints)


if __name__ == "__main__":
    main()
