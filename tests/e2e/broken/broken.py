# SPDX-License-Identifier: MIT
"""Proof that the proof works: encoders that are broken on purpose, one clause each, and what `drehgeber verify` says of them.

`marked` has the clauses that verify can see with OPTIONS: a good encoder agrees with them. Each of them has a ticket, the
SHA-256 of SEED and its name; the DRAWN lowest tickets are drawn. `breaks` has a change of src/ for each, made from the
words of the clause and not from its rows. This program makes the changes one at a time in a copy of the tree, builds the
command, runs the broken encoder on its wire, and has the good command verify it: that has to say `differs` for this clause.

usage: broken.py [--jobs N] [CLAUSE...]  build, ask, print a table; exit status 1 when fewer than ENOUGH were named.
                                         With clauses only these are tried, and all of them have to be named
       broken.py --check                 the breaks are those of the draw, and each fits the sources; nothing is built
       broken.py --marked [--jobs N]     ask a good encoder everything; fails when one of `marked` is not seen any more
       broken.py --mark [--jobs N]       the same, and write `marked` anew: then another 40 may be drawn
"""
import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from rig import PROGRAM, REPOSITORY, Encoder  # noqa: E402
from verified import SERIAL, SUITES, clauses  # noqa: E402

SEED = 20261129
DRAWN, ENOUGH = 40, 38
OPTIONS = ["--alone", "--write"]  # and --power, with the relay of each encoder: nothing else is asked for
LIMIT_S = 400.0
PARTS = 12  # into which the clauses of a model are cut when all of them are asked
# model: its wire, where FOLDER is a folder of its own; its shaft; what else it is run with
RUN = {
    "s3684-rs485": ("--pty=FOLDER/link", "12.3DEG", ["--set", "pace=0", "--serial", SERIAL]),
    "f3668": ("--slcan=FOLDER/link", "12.3DEG", ["--serial", SERIAL]),
    "ocd-ib-k3": ("--modbus=127.0.0.1:0", "2000.3DEG", []),
}
LEFT_OUT = shutil.ignore_patterns(".git", "build", "__pycache__", ".*_cache")


class Clause(NamedTuple):
    suite: str
    name: str

    def __str__(self):
        return f"{self.suite} {self.name}"

    @property
    def ticket(self) -> str:
        return hashlib.sha256(f"{SEED} {self}".encode()).hexdigest()


class Break(NamedTuple):
    clause: Clause
    what: str
    path: str
    hunks: list  # (old text, new text)

    def changed(self, tree: Path) -> str:
        """The file with the change in it."""
        text = (tree / self.path).read_text("utf-8")
        for old, new in self.hunks:
            if text.count(old) != 1:
                sys.exit(f"{self.clause}: {self.path} has not once, but {text.count(old)} times:\n{old}")
            text = text.replace(old, new)
        return text


# --- files

def lines_of(name: str) -> list:
    lines = (HERE / name).read_text("utf-8").splitlines()
    return [line for line in lines if not line.startswith("#")]


def read_marked() -> dict:
    """clause: its model"""
    rows = [line.split() for line in lines_of("marked") if line]
    return {Clause(suite, name): model for model, suite, name in rows}


def read_hunk(lines: list) -> tuple:
    """The old text, and the new one; lines that begin with a blank are in both."""
    return tuple("".join(f"{line[1:]}\n" for line in lines if line[0] in (" ", sign)) for sign in "-+")


def read_breaks() -> tuple:
    """The breaks, and {clause: why there is none} of those that were replaced by the next of the draw."""
    breaks, replaced = [], {}
    for block in "\n".join(lines_of("breaks")).strip("\n").split("\n\n"):
        head, *lines = block.split("\n")
        name, _, what = head.partition("] ")
        clause = Clause(*name.removeprefix("[").split())
        if not lines:
            replaced[clause] = what
            continue
        hunks = "\n".join(lines[1:]).split("\n@@\n")
        breaks.append(Break(clause, what, lines[0], [read_hunk(hunk.split("\n")) for hunk in hunks]))
    return breaks, replaced


def draw(marked: dict, replaced: dict) -> list:
    tickets = [clause for clause in sorted(marked, key=lambda clause: clause.ticket) if clause not in replaced]
    return tickets[:DRAWN]


def check(marked: dict, breaks: list, replaced: dict):
    """Whether the breaks are those that were drawn, and fit."""
    drawn = draw(marked, replaced)
    if [each.clause for each in breaks] != drawn:
        sys.exit("`breaks` does not have the clauses of the draw in its order:\n" + "\n".join(map(str, drawn)))
    latest = drawn[-1].ticket
    for clause in replaced:
        if clause not in marked or clause.ticket > latest:
            sys.exit(f"{clause} is replaced and was not drawn")
    for each in breaks:
        each.changed(REPOSITORY)


# --- encoders

class Verified:
    """An encoder of this program in a folder of its own, whose supply verify cuts by its control plane."""

    def __init__(self, folder: Path, model: str, program):
        folder.mkdir(parents=True)
        wire, shaft, words = RUN[model]
        control = f"unix:{folder}/ctl"
        self.folder, self.model = folder, model
        self.relay = folder / "relay"
        self.relay.write_text(f"#!/bin/sh\nexec {PROGRAM} ctl --control {control} \"POWer $1\" >/dev/null\n")
        self.relay.chmod(0o755)
        self.encoder = Encoder([model, wire.replace("FOLDER", str(folder)), *words, "--nvm", folder / "image", "--shaft", shaft,
                                "--control", control], executable=str(program))
        ready = self.encoder.ready_line.rpartition(":")[2]
        self.wire = wire.replace("FOLDER", str(folder)).replace("127.0.0.1:0", f"127.0.0.1:{ready}")

    def ask(self, names: list) -> tuple:
        """({clause: (result, why)}, what was said when there is nothing of that)"""
        command = [PROGRAM, "verify", self.model, self.wire, *OPTIONS, "--json", "--power", self.relay,
                   "--journal", self.folder / "journal", *names]
        try:
            ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            return {}, f"verify did not end within {LIMIT_S:.0f} s"
        if not ended.stdout.startswith("["):
            return {}, (ended.stderr.splitlines() or [f"exit status {ended.returncode}"])[-1]
        rows = json.loads(ended.stdout)
        return {Clause(row["suite"], row["clause"]): (row["result"], row["why"]) for row in rows}, ""


def ask_encoder(folder: Path, model: str, program, names: list) -> tuple:
    """As Verified.ask(), by an encoder that is run for it."""
    try:
        one = Verified(folder, model, program)
    except AssertionError as error:
        return {}, f"it does not run: {error}"
    try:
        return one.ask(names)
    finally:
        one.encoder.clean_up()


def ask_all(pool, folder: Path, model: str, program) -> dict:
    """{clause: (result, why)} of all clauses, by several encoders."""
    every = clauses(model)
    parts = [every[len(every) * part // PARTS:len(every) * (part + 1) // PARTS] for part in range(PARTS)]
    asked = [pool.submit(ask_encoder, folder / f"{model}.{part}", model, program, names) for part, names in enumerate(parts)]
    found = {}
    for one, names in zip(asked, parts):
        became, said = one.result()
        found.update({clause: row for clause, row in became.items() if clause.name in names})
        if said:
            print(f"{model}, clauses {names[0]} to {names[-1]}: {said}")
    return found


# --- the marks

def ask_again(pool, folder: Path, model: str, wanted: list) -> dict:
    """Each alone, of a good encoder: a busy machine may have hindered it. {clause: (result, why)}"""
    asked = {clause: pool.submit(ask_encoder, folder / f"again.{clause.suite}.{clause.name}", model, PROGRAM, [clause.name])
             for clause in wanted}
    answers = {clause: one.result() for clause, one in asked.items()}
    return {clause: found.get(clause, ("", said)) for clause, (found, said) in answers.items()}


def find_marks(pool, folder: Path, marked: dict) -> dict:
    """What a good encoder agrees with: {clause: its model}. What differs, and what was marked and is not seen, is asked again."""
    marks = {}
    for model in RUN:
        found = ask_all(pool, folder, model, PROGRAM)
        doubtful = [clause for clause, (result, _) in found.items() if result == "differs"]
        doubtful += [clause for clause, of in marked.items() if of == model and found.get(clause, ("", ""))[0] == "not seen"]
        found.update(ask_again(pool, folder, model, doubtful))
        differs = [f"{clause}: {why}" for clause, (result, why) in found.items() if result == "differs"]
        if differs or not found:
            sys.exit(f"a good {model} differs:\n" + "\n".join(differs))
        marks.update({clause: model for clause, (result, _) in found.items() if result == "agrees"})
    return marks


def compare_marks(pool, folder: Path, marked: dict) -> int:
    now = find_marks(pool, folder, marked)
    lost = marked.keys() - now.keys()
    for clause in sorted(lost):
        print(f"marked, and not seen any more: {clause}")
    print(f"{len(marked)} marked, {len(lost)} not seen any more, {len(now.keys() - marked.keys())} more are seen")
    return 1 if lost else 0


def write_marks(marks: dict):
    head = [line for line in (HERE / "marked").read_text("utf-8").splitlines() if line.startswith("#")]
    rows = [f"{model} {clause}" for clause, model in marks.items()]
    (HERE / "marked").write_text("\n".join([*head, *rows]) + "\n", "utf-8")
    print(f"{len(rows)} marked")


# --- the broken ones

def run_quietly(*command):
    ended = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if ended.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{ended.stdout[-3000:]}{ended.stderr[-3000:]}")


def build_programs(breaks: list, folder: Path) -> list:
    """A command for each, out of one copy of the tree, in which one file at a time is changed."""
    tree, build = folder / "tree", folder / "tree/build/broken"
    shutil.copytree(REPOSITORY, tree, ignore=LEFT_OUT, symlinks=True)
    launcher = ["-DCMAKE_C_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    os.environ.update(CCACHE_BASEDIR=str(tree), CCACHE_NOHASHDIR="1")
    run_quietly("cmake", "-S", tree, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_FLAGS_RELEASE=-O1 -DNDEBUG",
                "-DCMAKE_COMPILE_WARNING_AS_ERROR=OFF", "-DDREHGEBER_TESTS=OFF", "-DDREHGEBER_HDL=OFF", *launcher)
    programs = []
    for number, each in enumerate(breaks):
        file = tree / each.path
        sound = file.read_text("utf-8")
        file.write_text(each.changed(tree), "utf-8")
        run_quietly("cmake", "--build", build, "--target", "drehgeber", "-j", "2")
        file.write_text(sound, "utf-8")
        programs.append(shutil.copy2(build / "drehgeber", folder / f"drehgeber{number}"))
    return programs


def judge(each: Break, found: dict, said: str) -> tuple:
    """("named"; "other": under another clause; "refused": there was nothing to ask; or "missed"; and what verify said)"""
    result, why = found.get(each.clause, ("", said))
    if result == "differs":
        return "named", why
    others = [str(clause) for clause, (became, _) in found.items() if became == "differs"]
    if others:
        return "other", "under " + ", ".join(others)
    return ("refused", said) if not found else ("missed", f"{result} {why}")


def try_break(pool, folder: Path, each: Break, model: str, program) -> tuple:
    """The clause alone is asked for first; if that does not find it, all are, to see whether another one does."""
    verdict = judge(each, *ask_encoder(folder / "named", model, program, [each.clause.name]))
    if verdict[0] == "missed":
        verdict = judge(each, ask_all(pool, folder, model, program), verdict[1])
    return verdict


def check_sound(pool, folder: Path, marked: dict, breaks: list):
    """A good encoder agrees with all of these clauses."""
    wanted = {model: [each.clause for each in breaks if marked[each.clause] == model] for model in RUN}
    asked = {model: pool.submit(ask_encoder, folder / f"sound.{model}", model, PROGRAM, [clause.name for clause in of])
             for model, of in wanted.items() if of}
    for model, one in asked.items():
        found = one.result()[0]
        doubtful = [clause for clause in wanted[model] if found.get(clause, ("", ""))[0] != "agrees"]
        bad = [f"{clause}: {became}" for clause, became in ask_again(pool, folder, model, doubtful).items() if became[0] != "agrees"]
        if bad:
            sys.exit(f"a good {model} does not agree:\n" + "\n".join(bad))


def try_breaks(pool, jobs: int, folder: Path, marked: dict, breaks: list) -> int:
    """How many were named."""
    programs = build_programs(breaks, folder)
    check_sound(pool, folder, marked, breaks)
    with ThreadPoolExecutor(jobs) as tries:
        asked = [tries.submit(try_break, pool, folder / f"broken{number}", each, marked[each.clause], program)
                 for number, (each, program) in enumerate(zip(breaks, programs))]
        counts = []
        for each, one in zip(breaks, asked):
            verdict, why = one.result()
            counts.append(verdict)
            print(f"{verdict:8} {each.clause}: {each.what}\n         {why}", flush=True)
    named = counts.count("named")
    print(f"found {len(counts) - counts.count('missed')} of {len(counts)}, named {named}")
    return named


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=2)
    for option in ("--check", "--marked", "--mark"):
        parser.add_argument(option, action="store_true")
    parser.add_argument("clauses", nargs="*")
    options = parser.parse_args()
    marked, (breaks, replaced) = read_marked(), read_breaks()
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="drehgeber-broken-", dir=memory) as place, ThreadPoolExecutor(options.jobs) as pool:
        if options.mark:
            write_marks(find_marks(pool, Path(place), {}))
            return 0
        check(marked, breaks, replaced)
        if options.marked:
            return compare_marks(pool, Path(place), marked)
        if options.check:
            print(f"{len(marked)} marked, {len(breaks)} drawn, {len(replaced)} replaced")
            return 0
        chosen = [each for each in breaks if not options.clauses or each.clause.name in options.clauses]
        named = try_breaks(pool, options.jobs, Path(place), marked, chosen)
        return 0 if named >= (ENOUGH if not options.clauses else len(chosen)) and chosen else 1


if __name__ == "__main__":
    sys.exit(main())
