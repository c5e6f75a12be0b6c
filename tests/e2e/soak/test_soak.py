# SPDX-License-Identifier: MIT
"""Ten encoders of all kinds, for a minute or as long as DREHGEBER_SOAK_SECONDS says: masters on every
wire, values stored all the time, defects, power cycles, traces, recordings and clients that come and
go. What the process has, memory and descriptors, is at the end what it was after the first rounds."""
import contextlib
import itertools
import os
import re
import statistics
import struct
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

import serial

HERE = Path(__file__).resolve().parent
sys.path += [str(HERE.parents[2] / "tools/python"), str(HERE.parent / "rig40"), str(HERE.parent)]
import drehgeber  # noqa: E402
from hiperface_master import FieldStatus, HiperfaceError  # noqa: E402
from hiperface_master import Master as Hiperface  # noqa: E402
from masters import MASTERS, PATIENCE_S, Heard, Master, devices_of, percent, ticks  # noqa: E402
from rig import Client  # noqa: E402

RUN_S = float(os.environ.get("DREHGEBER_SOAK_SECONDS", "60"))
WARM_S = min(RUN_S / 3, 60.0)  # until every kind of thing has happened a few times
# From the first fifth of what follows to the last. Its own memory: four pages, as the heap may be cut another way;
# what leaks in every round is more. VmRSS has pages of files, too, which the kernel takes and gives back. (Not Pss:
# a page of a library counts for more in it whenever another process ends.)
GROWS_KIB = {"RssAnon": 16, "VmRSS": 256}
ROUND_S = 0.4
STARTS_S = 0.3  # an encoder whose power is back: 0.1 s on RS485, and a busy machine
SILENT_S = 1.0  # longer than a machine stands still
NOTICED_S = 5.0  # that a client has gone, on a busy machine
STEP_S = 0.05  # between the requests of a master in here: 20 a second
RIG = """
[shaft main]
motion = 60RPM
[bus line]
wire = pty
address = line
[bus can]
wire = slcan
address = can
[bus ring]
wire = modbus
address = 127.0.0.1:0
[encoder a1]
model = s3684-rs485
bus = line
nvm = a1.nvm
[encoder a2]
model = s3674-rs485
bus = line
address = 0x41
[encoder w]
model = s3684-rs485
wire = pty:w
pace = 0
nvm = w.nvm
[encoder n1]
model = f3668
bus = can
node = 1
nvm = n1.nvm
[encoder n2]
model = f3658
bus = can
node = 2
[encoder k1]
model = ocd-ib-k1
bus = ring
[encoder k2]
model = ocd-ib-k2
bus = ring
[encoder k3]
model = ocd-ib-k3
bus = ring
nvm = k3.nvm
[encoder e1]
model = s3684-biss
wire = sim
[encoder e2]
model = s3684-biss
wire = sim
nvm = e2.nvm
"""
THREADED = ("w", "n1", "n2", "e2")  # their masters are in here
POWER = "power"
DEFECTS = [
    ("a1", "led_current_high"), ("n1", "led_current_high"), ("k3", "singleturn_lost"), ("e1", "led_current_high"),
    ("a2", "wire_drop"), ("n2", "bus_off"), ("k2", "wire_break"), ("e2", "wire_break"), ("w", "wire_damage"),
    ("n1", POWER), ("a1", POWER), ("k3", POWER), ("e1", POWER), ("n2", "temperature_high"), ("a2", "singleturn_lost"),
    ("n1", "wire_delay"), ("k1", "singleturn_lost"), ("w", POWER), ("e2", "wire_damage"), ("n2", "wire_duplicate"),
]
TRACES = [("a1", "vcd"), ("n1", "log"), ("n1", "pcapng"), ("k1", "csv"), ("e1", "vcd")]


class Span(NamedTuple):
    begin: float
    end: float


class Storing:
    """A master in a thread of its own that reads, and stores now and then. A defect keeps it from
    that, and nothing else does."""

    def __init__(self, *encoders):
        self.encoders = encoders  # those it asks
        self.figures = {"exchanges": 0, "stored": 0, "failed": 0}
        self.failures = []  # Span
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def start(self):
        self._thread.start()
        return self

    def _run(self):
        for count in itertools.count():
            if self._end.wait(STEP_S):
                return
            begin = time.monotonic()
            try:
                self.read()
                self.figures["exchanges"] += 1
                if count % 4 == 0:
                    self.store(count)
                    self.figures["stored"] += 1
            except (HiperfaceError, TimeoutError):
                self.figures["failed"] += 1
                self.failures.append(Span(begin, time.monotonic()))

    def unexplained(self, bent: list) -> list:
        """Failures while no encoder of its own was bent, nor starting again."""
        spans = [span for name, span in bent if name in self.encoders]
        return [one for one in self.failures
                if not any(one.begin <= span.end + STARTS_S and one.end >= span.begin for span in spans)]

    def end(self):
        self._end.set()
        self._thread.join(PATIENCE_S)
        self.close()


class OnLine(Storing):
    """42h and 4Bh."""

    def __init__(self, where):
        super().__init__("w")
        self.master = Hiperface(where, grace_s=PATIENCE_S)
        self.master.create_field(0, FieldStatus(16))
        self.master.grace_s = SILENT_S

    def read(self):
        self.master.read_position()

    def store(self, count):
        self.master.save_data(0, 0, struct.pack("<Q", count))

    def close(self):
        self.master.close()


class OnCan(Storing):
    """SDO uploads of two nodes, and 1010h."""

    def __init__(self, where):
        super().__init__("n1", "n2")
        self.port = serial.Serial(where, timeout=0.02)
        self.port.write(b"C\rS5\rO\r")
        self.rest = b""

    def sdo(self, node, request):
        self.port.write(b"t%03X8%s\r" % (0x600 + node, request.hex().encode()))
        wanted = b"t%03X8" % (0x580 + node)
        end = time.monotonic() + SILENT_S
        while time.monotonic() < end:
            *lines, self.rest = (self.rest + self.port.read(max(1, self.port.in_waiting))).split(b"\r")
            if any(wanted in line for line in lines):
                return
        raise TimeoutError

    def read(self):
        for node in (1, 2):
            self.sdo(node, struct.pack("<BHBI", 0x40, 0x6004, 0, 0))

    def store(self, count):
        self.sdo(1, struct.pack("<BHBI", 0x2B, 0x100C, 0, count % 1000))
        self.sdo(1, struct.pack("<BHB4s", 0x23, 0x1010, 1, b"save"))

    def close(self):
        self.port.close()


class Sample(NamedTuple):
    at: float
    memory: dict  # KiB
    descriptors: int


def descriptors_of(pid: int) -> int:
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))


def sample(pid: int) -> Sample:
    process = Path(f"/proc/{pid}")
    text = (process / "status").read_text()
    memory = {name: int(re.search(rf"^{name}:\s+(\d+) kB", text, re.M)[1]) for name in GROWS_KIB}
    return Sample(time.monotonic(), memory, descriptors_of(pid))


def one_round(rig, folder: Path, number: int) -> tuple[str, Span]:
    """A defect comes and goes while something is traced and recorded and a client comes and goes. Whose, and
    how long it was there."""
    name, fault = DEFECTS[number % len(DEFECTS)]
    traced, ending = TRACES[number % len(TRACES)]
    encoder = rig.encoders[name]
    had = descriptors_of(rig.pid)
    rig.encoders[traced].ask(f'TRAC:STAR "{folder}/trace{number}.{ending}"')
    encoder.ask(f'SHAF:REC:STAR "{folder}/recording.csv"')
    begin = time.monotonic()
    with contextlib.closing(Client(f"unix:{rig.socket}")) as client:
        if fault == POWER:
            encoder.power(False)
        else:
            encoder.set_fault(fault)
        if name != "e2":
            client.do(f"INST:SEL e2;:BISS:REG 64,7;:BISS:REG 3,{number % 256}")
        client.error("NONSense:COMMand?")
        time.sleep(ROUND_S)
        if fault == POWER:
            encoder.power(True)
        else:
            encoder.clear_fault(fault)
    bent = Span(begin, time.monotonic())
    encoder.ask("SHAF:REC:STOP")
    rig.encoders[traced].ask("TRAC:STOP")
    (folder / f"trace{number}.{ending}").unlink()
    time.sleep(ROUND_S / 2)
    end = time.monotonic() + NOTICED_S
    while descriptors_of(rig.pid) != had and time.monotonic() < end:  # until it is noticed who has gone
        time.sleep(0.01)
    return name, bent


def soak(rig, folder: Path) -> tuple[list, list]:
    """Samples behind the time to warm up, and who was bent when."""
    begin = time.monotonic()
    samples, bent = [], []
    for number in itertools.count():
        bent.append(one_round(rig, folder, number))
        samples.append(sample(rig.pid))
        if time.monotonic() - begin >= RUN_S:
            return [one for one in samples if one.at - begin >= WARM_S], bent


def growth(samples: list) -> dict:
    """Of each figure, from the first fifth to the last; in the middle, as a page comes and goes."""
    part = max(3, len(samples) // 5)

    def level(some, name):
        return statistics.median(one.memory[name] for one in some)

    return {name: level(samples[-part:], name) - level(samples[:part], name) for name in GROWS_KIB}


def start_masters(rig, heard: Heard) -> list:
    """Those of the rig of forty, but for CAN, where values are stored. An access to the
    registers of e2 lets its simulated wire run ahead of the clock by which they look at positions."""
    wires = {}
    for encoder in rig.encoders.values():
        if encoder.name not in THREADED:
            where = encoder.address.rpartition(":")[2] or "-"
            wires.setdefault((encoder.wire, where), []).append(encoder)
    return [Master(wire, where, rig.socket, devices_of(encoders), heard)
            for (wire, where), encoders in wires.items()]


def report(took_s, samples, cpu, figures):
    first, last = samples[0], samples[-1]
    print(f"{took_s:.0f} s, {len(samples)} rounds after {WARM_S:.0f} s to warm up, {cpu:.1f} % CPU")
    for name, value in growth(samples).items():
        print(f"{name} {first.memory[name]} -> {last.memory[name]} KiB, grows by {value:+.0f}, "
              f"at most {GROWS_KIB[name]}")
    print(f"descriptors {min(one.descriptors for one in samples)} to {max(one.descriptors for one in samples)}")
    for name, value in figures.items():
        print(name, value)


def judge(masters, storing, took_s, bent):
    """Everybody had answers all the time, and right ones; each one missed is explained."""
    for one in masters:
        assert one.figures["wrong"] == 0 and one.figures["exchanges"] >= 5 * took_s, one.figures
    for one in storing:
        assert one.figures["stored"] >= took_s, one.figures
        assert one.unexplained(bent) == []


def test_what_it_has_stays_what_it_was(tmp_path, monkeypatch):
    assert os.access(MASTERS, os.X_OK), f"no program at '{MASTERS}': build rig_masters"
    # What is given back is seen to be: the C library would keep half a MiB of a trace for the next one.
    monkeypatch.setenv("MALLOC_MMAP_THRESHOLD_", "65536")
    heard = Heard()
    (tmp_path / "rig.ini").write_text(RIG)
    with drehgeber.run(tmp_path / "rig.ini", "--files", tmp_path, folder=tmp_path) as rig:
        assert len(rig.encoders) == 10
        masters = start_masters(rig, heard)
        storing = [OnLine(str(tmp_path / "w")).start(), OnCan(str(tmp_path / "can")).start()]
        try:
            heard.wait_for([f"{name} ok" for name in rig.encoders if name not in THREADED])
            before, begin = ticks(rig.pid), time.monotonic()
            samples, bent = soak(rig, tmp_path)
            took_s = time.monotonic() - begin
            cpu = percent(before, ticks(rig.pid), took_s)
            time.sleep(1.0)
            states = {name: encoder.state() for name, encoder in rig.encoders.items()}
        finally:
            statuses = [master.end() for master in masters]
            for one in storing:
                one.end()
    report(took_s, samples, cpu, {f"{one.wire} {one.where}": one.figures for one in masters}
           | {type(one).__name__: one.figures for one in storing})

    assert statuses == [0] * len(masters)
    assert [name for name, state in states.items() if state["wire_up"] != 1] == []
    judge(masters, storing, took_s, bent)
    assert len({one.descriptors for one in samples}) == 1
    assert [name for name, value in growth(samples).items() if value > GROWS_KIB[name]] == []
