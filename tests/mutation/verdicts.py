# SPDX-License-Identifier: MIT
"""What is kept of runs: the log of all verdicts, by which rooms are judged, and the list of survivors."""

import datetime
import math
from typing import NamedTuple

import rooms

SURVIVORS_HEAD = """\
# SPDX-License-Identifier: MIT
# Mutants that survived, or whom nobody can kill: path @@ line before @@ line after @@ day @@ reason. What has no
# reason is a test that is missing. `run --list` adds to it, tries some of it again, and strikes what is killed.
"""


def today():
    return datetime.date.today().isoformat()


def plain(text):
    """The lines of a source as they are named: without indentation."""
    return {" ".join(line.split()) for line in text.split("\n")}


class Entry(NamedTuple):
    """A line of the log."""
    day: str
    room: str
    path: str
    line: str
    kind: str
    before: str
    after: str
    result: str
    why: str

    @property
    def key(self):
        return self.path, self.before, self.after

    @property
    def counts(self):
        return self.result in ("killed", "survived")


class Log:
    """Every verdict, a line each; of one run only where there is no file."""

    def __init__(self, path):
        self.path = path
        self.entries = []
        if path and path.exists():
            rows = (line.split("\t") for line in path.read_text(encoding="utf-8").splitlines())
            self.entries = [Entry(*row) for row in rows if len(row) == len(Entry._fields)]

    def add(self, entry):
        self.entries.append(entry)
        if self.path:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with open(self.path, "a", encoding="utf-8") as log:
                log.write("\t".join(entry) + "\n")

    def last(self, room, texts):
        """The last WINDOW verdicts of the room whose lines still stand. Of a mutant that was tried again, the
        last verdict stands at the place of the first."""
        standing = {path: plain(text) for path, text in texts.items() if path.startswith(room.name + "/")}
        verdicts = {}
        for entry in self.entries:
            if entry.room == room.name and entry.counts and entry.before in standing.get(entry.path, ()):
                verdicts[entry.key] = entry
        return list(verdicts.values())[-rooms.WINDOW:]


def upper_bound(killed, count):
    """Percent that are killed of all mutants at the most, given a sample: Wilson's bound of 95 %."""
    z = 1.645
    share, spread = killed / count, z * z / count
    return 100 * (share + spread / 2 + math.sqrt(share * (1 - share) * spread + spread * spread / 4)) / (1 + spread)


def judge(room, verdicts):
    """Prints the score of the room. @return whether it reaches the floor; few verdicts have to be so bad that it is
    no chance"""
    count = len(verdicts)
    killed = sum(entry.result == "killed" for entry in verdicts)
    score = 100 * killed / count if count else 0
    few = f", of {rooms.WINDOW} wanted" if count < rooms.WINDOW else ""
    good = score >= room.floor
    chance = not good and few != "" and count > 0 and upper_bound(killed, count) >= room.floor
    print(f"figure: mutation score of {room.name}: {score:.1f} %, {killed} of the last {count} killed{few}; "
          f"{'floor' if good else 'too few to say that it is below the floor of' if chance else 'BELOW the floor of'} "
          f"{room.floor} %")
    return good or chance


class Survivor(NamedTuple):
    path: str
    before: str
    after: str
    day: str
    reason: str

    @property
    def key(self):
        return self.path, self.before, self.after


def read_survivors(path):
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [Survivor(*map(str.strip, f"{line} ".split(" @@ "))) for line in lines if not line.startswith("#")]


def write_survivors(path, survivors):
    lines = [" @@ ".join(each).rstrip() for each in sorted(set(survivors))]  # without a reason: "... @@ day @@"
    path.write_text(SURVIVORS_HEAD + "".join(line + "\n" for line in lines), encoding="utf-8")
