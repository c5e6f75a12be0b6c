# SPDX-License-Identifier: MIT
"""The masters of a rig, one process for each wire, and what they say; what a process costs."""
import os
import re
import subprocess
import threading
from pathlib import Path

from judgement import Stall

MASTERS = os.environ.get("RIG_MASTERS", "")
PATIENCE_S = 20.0  # for what should happen at once on a busy, emulated machine

# Steps in a turn, turns.
FIGURES = {
    "f3658": (65536, 1),
    "f3668": (65536, 4096),
    "s3674-rs485": (65536, 1),
    "s3684-rs485": (65536, 4096),
    "s3684-biss": (2097152, 4096),
    "ocd-ib-k1": (4096, 1),
    "ocd-ib-k2": (4096, 4096),
    "ocd-ib-k3": (4096, 4096),
}
# The wire of a ready line: the master's wire, and the least it has to ask in a second, so that one that asks nothing is
# not taken for one that finds nothing. A tenth of what it would without defects on a machine that never stands still:
# 550 on CAN with forty.ini, 45 on RS485, 600 in the ring, 50 over BiSS, 1000 looks at the clock. How fast the guest
# is, is not for these to say, nor that none is lost: a master tells each one that is not answered.
WIRES = {"can": ("can", 55), "slcan": ("can", 55), "pty": ("rs485", 5), "modbus": ("ring", 60),
         "sim": ("biss", 5), "clock": ("clock", 100)}


class Heard:
    """What all masters say, in order."""

    def __init__(self):
        self.lines = []
        self.stalls = []
        self._more = threading.Condition()

    def add(self, line: str):
        with self._more:
            self.lines.append(line)
            self._more.notify_all()

    def wait_for(self, wanted: list, begin: int = 0):
        """Until all of this has been said since `begin`."""
        with self._more:
            if not self._more.wait_for(lambda: set(wanted) <= set(self.lines[begin:]), PATIENCE_S):
                raise AssertionError(f"{wanted} expected, heard {self.lines[begin:]}")


class Master:
    """The master of a wire, in a process of its own. It ends when it has asked `most` times, or never."""

    def __init__(self, wire: str, where: str, control: str, devices: list, heard: Heard, most: int = 0):
        self.wire = wire
        self.where = where
        self.heard = heard
        self.figures = {}
        limit = ["-n", str(most)] if most else []
        self.process = subprocess.Popen([MASTERS, *limit, WIRES[wire][0], where, control, *devices],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            words = line.split()
            if words[0] == "figures":
                self.figures = {key: int(value) for key, value in
                                (word.split("=") for word in words[2:])}
            elif words[0] == "clock":
                at, late = (int(word) / 1e9 for word in words[1:])
                self.heard.stalls.append(Stall(at, at + late))
            else:
                self.heard.add(line.strip())

    def end(self) -> int:
        self.process.terminate()
        return self.wait(PATIENCE_S)

    def wait(self, patience_s: float) -> int:
        """Until it has asked often enough."""
        status = self.process.wait(patience_s)
        self.reader.join(PATIENCE_S)
        self.process.stdout.close()
        return status


def devices_of(encoders: list) -> list:
    """The masters' words for the encoders of a wire, in the order of the file."""
    words = []
    register = 0
    for index, encoder in enumerate(encoders):
        steps, turns = FIGURES[encoder.model]
        address = {"can": encoder.place, "slcan": encoder.place, "pty": 0x40 + index, "modbus": register, "sim": 0}
        register += 1 if turns == 1 else 2
        words.append(f"{encoder.name},{address[encoder.wire]},{steps},{turns}")
    return words


def start_masters(rig, heard: Heard) -> list:
    wires = {}
    for encoder in rig.encoders.values():
        where = encoder.address.rpartition(":")[2] or "-"
        wires.setdefault((encoder.wire, where), []).append(encoder)
    return [Master("clock", "-", rig.socket, [], heard),
            *(Master(wire, where, rig.socket, devices_of(encoders), heard)
              for (wire, where), encoders in wires.items())]


def ticks(pid: int) -> int:
    """User and system time so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return int(fields[11]) + int(fields[12])


def memory_kib(pid: int, what: str) -> int:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(rf"^{what}:\s+(\d+) kB", status, re.M)[1])


def percent(before: int, after: int, seconds: float) -> float:
    return 100 * (after - before) / os.sysconf("SC_CLK_TCK") / seconds
