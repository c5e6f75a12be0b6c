# SPDX-License-Identifier: MIT
"""The decoders of tools/sigrok, as sigrok-cli runs them: on traces of the program with a master, and on broken
ones that are made here, bit by bit."""
import importlib.util
import os
import random
import re
import subprocess
import sys
import types

import pytest

from hiperface_master import COMMANDS, EncoderError, FieldStatus, NoReply
from rig import REPOSITORY, Rigs, run
from test_trace_tools import frame_of, signals_of, trace

DECODERS = REPOSITORY / "tools/sigrok"
NAMES = ["biss_c", "biss_c_registers", "hiperface", "ssi"]
BISS = "biss_c:ma=MA:slo=SLO"
REGISTERS = "biss_c_registers=register:access:command:warning"
BAUD = 9600


def sigrok_cli(*arguments, **environment) -> str:
    done = subprocess.run(["sigrok-cli", "-l", "1", *map(str, arguments)], capture_output=True, timeout=60,
                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment})
    assert (done.returncode, done.stderr) == (0, b""), done.stderr
    return done.stdout


def decoded(path, stack, shown) -> list:
    """The annotations of these classes."""
    said = sigrok_cli("-i", path, "-I", "vcd", "-P", stack, "-A", shown, SIGROKDECODE_DIR=str(DECODERS))
    return [line.partition(": ")[2] for line in said.decode().splitlines()]


def drehgeber(*arguments) -> str:
    ended = run(*arguments)
    assert (ended.returncode, ended.stderr) == (0, "")
    return ended.stdout


@pytest.fixture
def rigs(tmp_path):
    begun = Rigs(tmp_path)
    yield begun
    assert begun.end() == []


def module(path):
    """A file of a decoder, without the library that runs it."""
    sys.modules.setdefault("sigrokdecode", types.SimpleNamespace(Decoder=object))
    spec = importlib.util.spec_from_file_location("decoder", DECODERS / path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


# --- words ---

def test_words_of_hiperface_are_those_of_the_program():
    """Commands and status messages as the traces have them; lengths and reaction times as the page has them."""
    lists = module("hiperface/lists.py")
    source = (REPOSITORY / "src/hiperface/words.c").read_text(encoding="utf-8")
    words = re.findall(r'^    \{0x(\w\w), \w+,\s*"[^"]*",\s*"([^"]*)",\s*"([^"]*)"\},$', source, re.M)
    assert {int(code, 16): (request, reply) for code, request, reply in words} == \
        {code: row[3:] for code, row in lists.COMMANDS.items()}
    errors = re.findall(r'^    \{0x(\w\w), "([^"]*)"\},$', source, re.M)
    assert {int(code, 16): text for code, text in errors} == lists.ERRORS
    page = (REPOSITORY / "src/hiperface/README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w\w)h \| [^|]+ \| ([\d-]+) \| ([\d-]+) \| (?:(\d+) ms|no reply) \|", page, re.M)
    figures = {int(code, 16): ([int(n) for n in request.split("-")], [int(n) for n in reply.split("-")],
                               int(reaction) if reaction else None) for code, request, reply, reaction in rows}
    assert figures == {code: ([*dict.fromkeys(request)], [*dict.fromkeys(reply)], reaction)
                       for code, (request, reply, reaction, *_) in lists.COMMANDS.items()}
    assert len(words) == len(rows) == len(COMMANDS) == 19 and len(errors) == 23


def test_words_of_biss_are_those_of_the_pages():
    registers = module("biss_c_registers/pd.py")
    page = (REPOSITORY / "src/biss/README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\|  \| (\w\w)h(?:-(\w\w)h)? \| \w+ \| (.*) \|$", page, re.M)
    for first, last, what in registers.REGISTERS:
        places = [content for begin, end, content in rows
                  if int(begin, 16) <= last and first <= int(end or begin, 16)]
        assert places and all(what in content for content in places), what
    clauses = (REPOSITORY / "tests/conformance/biss.clauses").read_text(encoding="utf-8")
    said = dict(re.findall(r"^N-\d+ +\| (broadcast \d\d|addressed \d\d): (.*)$", clauses, re.M))
    # What the manual leaves out has no clause.
    words = {"broadcast 00": 0, "broadcast 01": 1, "broadcast 11": 3}
    assert all(registers.BROADCASTS[place] in said[name] for name, place in words.items())
    words = {"addressed 00": 0, "addressed 01": 1, "addressed 11": 3}
    assert all(registers.COMMANDS[place] in said[name] for name, place in words.items())


# --- BiSS, with the program ---

@pytest.mark.parametrize("model, widths, settings", [
    ("s3684-biss", "", []),
    ("s3674-biss", ":mt=0", ["clock_hz=10000000", "line_delay_ns=200", "busy_us=5"]),
    ("s3684-biss", "", ["clock_hz=50000", "busy_us=0"]),
    ("s3684-biss", ":st=24:lc=no", ["st=24", "lc=0", "clock_hz=10000000", "line_delay_ns=5000", "busy_jitter_us=5"]),
])
def test_biss_positions(tmp_path, model, widths, settings):
    path = tmp_path / "biss.vcd"
    said = drehgeber("biss", model, *["read"] * 20, "--shaft", "3000RPM", "--trace", path,
                     *(f"--set={setting}" for setting in settings))
    wanted = [re.sub(r"  [\d.]+ deg|MT 0(?=  ST)", "", line) if model == "s3674-biss" else
              re.sub(r"  [\d.]+ deg", "", line) for line in said.splitlines()]
    wanted = [" ".join(line.replace("valid", "ok").split()) for line in wanted]
    if ":lc=no" in widths:
        wanted = [line.replace(" LC 0", "") for line in wanted]
    assert len(set(wanted)) >= 15
    assert decoded(path, BISS + widths, "biss_c=position:warning") == wanted


@pytest.mark.parametrize("count", [1, 2, 3])
def test_biss_chain(tmp_path, rigs, count):
    """Each slave's data is what the master has read of it; the last of the line has ID 0."""
    models = ["s3684-biss", "s3674-biss", "s3684-biss"][:count]
    encoders = "".join(f"[encoder e{place}]\nmodel = {model}\nbus = line\n" for place, model in enumerate(models))
    rig = rigs.begin("[rig]\ncontrol = tcp:127.0.0.1:0\n[shaft motor]\nmotion = 100RPM\n[bus line]\nwire = sim\n" + encoders)
    client = rig.client()
    client.do("TIME:SCAL 0")
    client.do("TIME:STEP 1 S")
    path = tmp_path / "line.vcd"
    client.do(f'TRAC:STAR "{path}"')
    wanted = []
    for place in range(count):
        client.do(f"INST:SEL e{place}")
        client.do("TIME:STEP 7 MS")
        wanted.append(tuple(map(int, client.ask("BISS:FRAM?").split(","))))
    for place in range(count):
        client.do(f"INST:SEL e{place}")
        assert client.ask("BISS:REG? #H7E,2") == "75,85"
    client.do("BISS:REG #H1C,1,2")
    client.do("TRAC:STOP")
    stack = f"{BISS}:slaves={count}:mt2=0"
    found = decoded(path, stack, "biss_c=position")
    assert decoded(path, stack, "biss_c=warning") == []
    assert len(found) % count == 0
    for place, (position, n_err, n_warn, life, right) in enumerate(wanted):
        which = f"slave {place + 1}: " if count > 1 else ""
        turns = f"MT {position >> 21} " if models[place] == "s3684-biss" else ""
        steps = position & ((1 << 21) - 1)
        assert f"{which}{turns}ST {steps} nERR {n_err} nWARN {n_warn} LC {life} CRC ok" in found
        assert right == 1
    accesses = decoded(path, f"{stack},biss_c_registers", "biss_c_registers=access:warning")
    assert accesses == [f"ID {count - 1 - place} read 7Eh: 4B 55" for place in range(count)] + ["ID 0 write 1Ch: 01 02"]


def test_biss_registers(tmp_path):
    """Written, read back, busy; refused."""
    path = tmp_path / "registers.vcd"
    drehgeber("biss", "s3684-biss", "write", "7:3", "A55A", "registers", "7:2", "4", "registers", "0x78", "3",
              "--trace", path)
    assert decoded(path, f"{BISS},biss_c_registers", REGISTERS) == [
        "write 40h (bank select) = 07h", "ID 0 write 40h: 07",
        "write 03h = A5h", "write 04h = 5Ah", "ID 0 write 03h: A5 5A",
        "write 40h (bank select) = 07h", "ID 0 write 40h: 07",
        "read 02h = FFh", "read 03h = A5h", "read 04h = 5Ah", "read 05h = FFh", "ID 0 read 02h: FF A5 5A FF",
        "read 78h (device id) = 04h", "read 79h (device id) = 00h", "read 7Ah (device id) = CCh",
        "ID 0 read 78h: 04 00 CC",
    ]
    fields = decoded(path, f"{BISS},biss_c_registers", "biss_c_registers=cds-field")
    assert sum("busy: " in field for field in fields) >= 4  # the EEPROM's
    assert fields.count("IDL: slaves with an ID: 1") == 5
    binary = sigrok_cli("-i", path, "-P", f"{BISS},biss_c_registers", "-B", "biss_c_registers=read",
                        SIGROKDECODE_DIR=str(DECODERS))
    assert binary == bytes.fromhex("FF A5 5A FF 04 00 CC")
    ended = run("biss", "s3684-biss", "registers", "0x50", "1", "--trace", path)
    assert ended.returncode == 1
    assert decoded(path, f"{BISS},biss_c_registers", REGISTERS) == ["ID 0 read 50h: refused"] * 2


# --- BiSS, made by hand ---

CLOCK_NS = 1000
# Position, nERR, nWARN and CRC of a public vector: 22 bits 123456h, 1, 1, 35h.
VECTOR = f"{0x123456:022b}11{0x35:06b}"
BY_HAND = f"{BISS}:mt=0:st=22:lc=no"


class Line:
    """MA and SLO, edge by edge."""

    step_ns = 10

    def __init__(self):
        self.now, self.levels, self.changes = 10_000, {"MA": 1, "SLO": 1}, []

    def set(self, name, level):
        if self.levels[name] != level:
            self.levels[name] = level
            self.changes.append((self.now, name, level))

    def wait(self, ns):
        self.now += ns
        return self

    def clock(self, bits):
        """A bit of SLO behind each rising edge of MA."""
        for bit in bits:
            self.set("MA", 0)
            self.wait(CLOCK_NS // 2)
            self.set("MA", 1)
            self.set("SLO", int(bit))
            self.wait(CLOCK_NS // 2)
        return self

    def end(self, cdm="0"):
        self.set("MA", 1 - int(cdm))
        self.wait(13_000)
        self.set("SLO", 1)
        self.wait(3_000)
        self.set("MA", 1)
        return self.wait(1_000)

    def frame(self, cds="0", cdm="0", data=VECTOR):
        return self.clock("1" + "00" + "1" + cds + data).end(cdm)

    def control(self, cdm, cds):
        for _ in range(14):
            self.frame()
        for bits in zip(cds.replace(" ", ""), cdm.replace(" ", "")):
            self.frame(*bits)
        return self

    def write(self, path):
        signs = dict(zip(self.levels, "cd"))
        with open(path, "w", encoding="ascii") as file:
            file.write(f"$timescale {self.step_ns} ns $end\n")
            file.writelines(f"$var wire 1 {sign} {name} $end\n" for name, sign in signs.items())
            file.write("$enddefinitions $end\n#0\n1c\n1d\n")
            for at, name, level in self.changes:
                file.write(f"#{at // self.step_ns}\n{level}{signs[name]}\n")
            file.write(f"#{self.now // self.step_ns}\n")
        return path


def low_from_the_start(line):
    line.changes.append((0, "SLO", 0))
    line.levels["SLO"] = 0
    return line


FLAGS = "nERR 1 nWARN 1 CRC ok"


@pytest.mark.parametrize("line, wanted", [
    (Line().frame(), [f"ST {0x123456} {FLAGS}"]),
    (low_from_the_start(Line()).frame(), [f"ST {0x123456} {FLAGS}"]),
    (Line().frame(data=VECTOR[:20]), ["cut: 20 of 30 data bits"]),
    (Line().clock("1001").end(), ["cut: no CDS"]),
    (Line().clock("100000").end(), ["no start bit in 6 clocks"]),
    (Line().clock("1").end(), ["1 clock is no frame"]),
    (Line().clock("10").end("1"), []),  # a reduced frame
    (Line().frame(data="0" + VECTOR[1:-1] + "0"), [f"ST {0x123456} nERR 1 nWARN 1 CRC wrong",
                                                    "CRC 34 is wrong, expected 35"]),
    (Line().frame(data="0" * 30), []),  # data channels are off
    (Line().frame(data=VECTOR + "000"), [f"ST {0x123456} {FLAGS}"]),
    (Line().frame(data=VECTOR + "010"), [f"ST {0x123456} {FLAGS}", "1 behind the CRC: more slaves, or wider data?"]),
    (Line().clock("1" * 36).end(), ["no Ack: SLO stays high"]),
    (low_from_the_start(Line()).clock("0" * 36).end(), ["no Ack: SLO stays low"]),
    # The timeout comes in the middle, and the rest is no frame with this Ack.
    (Line().clock("1001" + "0" + VECTOR[:10]).end().clock("1001").end().frame(),
     ["cut: 10 of 30 data bits", "cut: no CDS", f"ST {0x123456} {FLAGS}"]),
    # The return of MA from CDM = 1 begins no frame.
    (Line().frame(cdm="1").frame(cdm="1").frame(), [f"ST {0x123456} {FLAGS}"] * 3),
])
def test_biss_frames_by_hand(tmp_path, line, wanted):
    path = line.write(tmp_path / "line.vcd")
    assert decoded(path, BY_HAND, "biss_c=position:warning") == wanted


def test_biss_with_the_short_timeout(tmp_path):
    line = Line()
    for _ in range(3):
        line.clock("10010" + VECTOR).wait(1300 - CLOCK_NS // 2).set("SLO", 1)
        line.wait(1000)
    path = line.write(tmp_path / "line.vcd")
    assert decoded(path, BY_HAND + ":timeout_ns=1200", "biss_c=position:warning") == [f"ST {0x123456} {FLAGS}"] * 3


def test_biss_fields_by_hand(tmp_path):
    """Nothing but a frame: each field, in its row, where it is; CDM = 1 in the timeout."""
    path = Line().frame(cds="1", cdm="1").write(tmp_path / "line.vcd")
    said = sigrok_cli("-i", path, "-P", BY_HAND, "-A", "biss_c", "--protocol-decoder-samplenum",
                      SIGROKDECODE_DIR=str(DECODERS)).decode()
    rows = re.findall(r"^(\d+)-(\d+) biss_c-1: (.*)$", said, re.M)
    # e1 is 10.5 us behind the beginning, a sample is 10 ns.
    e1 = 1050
    fields = {text: ((int(ss) - e1) // 100, (int(es) - e1) // 100) for ss, es, text in rows}
    assert fields == {
        "Ack": (1, 3), "Start": (3, 4), "CDS 1": (4, 5), f"ST {0x123456}": (5, 27), "nERR 1": (27, 28),
        "nWARN 1": (28, 29), "CRC 35 ok": (29, 35), f"ST {0x123456} {FLAGS}": (5, 35), "Timeout": (34, 46), "CDM 1": (34, 46),
    }


# Complete control frames of a third party's master.
READ_78 = ("1 1 000 1111000 0101 1 0 1 00000000 0000 0 0", "0 1 0000000 0 0000000 1 0 1 01001011 0110 0")
WRITE_1B = ("1 1 000 0011011 1101 0 1 1 10100101 0100 0 0", "0 1 0000000 0 0000000 0 1 1 10100101 0100 0")
ZEROS = "0" * 14


def changed(frames, place, bits):
    """(CDM, CDS) with bits of CDM from `place` on replaced; behind 100 those of CDS."""
    cdm, cds = (text.replace(" ", "") for text in frames)
    if place >= 100:
        place -= 100
        return cdm, cds[:place] + bits + cds[place + len(bits):]
    return cdm[:place] + bits + cdm[place + len(bits):], cds


@pytest.mark.parametrize("frames, wanted", [
    (READ_78, ["read 78h (device id) = 4Bh", "ID 0 read 78h: 4B"]),
    (WRITE_1B, ["write 1Bh = A5h", "ID 0 write 1Bh: A5"]),
    (changed(READ_78, 15, "0"), ["ID 0, register 78h: CRC4 of the address 4 is wrong, expected 5"] * 2),
    (changed(READ_78, 131, "1"), ["read 78h (device id) = 4Bh, CRC4 of the data 7 is wrong, expected 6",
                                  "ID 0 read 78h: CRC4 of the data 7 is wrong, expected 6", "ID 0 read 78h: 4B"]),
    (changed(WRITE_1B, 30, "1"), [
        "write 1Bh = A5h, CRC4 of the data 5 is wrong, expected 4, echo A5 4 of what was sent as A5 5",
                                  "ID 0 write 1Bh: CRC4 of the data 5 is wrong, expected 4",
                                  "ID 0 write 1Bh: echo A5 4 of what was sent as A5 5", "ID 0 write 1Bh: A5"]),
    (changed(WRITE_1B, 31, "1"), ["write 1Bh = A5h, the stop bit of the master is missing: P = 1",
                                  "ID 0 write 1Bh: the stop bit of the master is missing: P = 1", "ID 0 write 1Bh: A5"]),
    (changed(WRITE_1B, 132, "1"), [
        "write 1Bh = A5h, refused: P = 1", "ID 0 write 1Bh: refused: P = 1", "ID 0 write 1Bh: A5"]),
    # Two registers, the first with a wrong CRC.
    (("1 1 000 1111000 0101 1 0 1 00000000 0000 0 1 00000000 0000 0 0",
      "0 1 0000000 0 0000000 1 0 1 01001011 0111 0 1 01001011 0110 0"),
     ["read 78h (device id) = 4Bh, CRC4 of the data 7 is wrong, expected 6",
      "ID 0 read 78h: CRC4 of the data 7 is wrong, expected 6", "read 79h (device id) = 4Bh", "ID 0 read 78h: 4B 4B"]),
    (changed(READ_78, 118, "1"), ["ID 0 read 78h (device id): refused"] * 2),
    (changed(READ_78, 101, "0" * 32), ["ID 0 read 78h (device id): no answer"] * 2),
    (changed(WRITE_1B, 118, "0"), ["ID 0 write 1Bh: refused"] * 2),
    (changed(READ_78, 17, "1"), ["ID 0 write 78h (device id): R = W = 1"] * 2),
    (changed(READ_78, 18, "0"), ["ID 0 read 78h (device id): given up: no S"] * 2),
    (changed(READ_78, 119, "0" * 14), ["ID 0 read 78h: no S from the slave, given up"] * 2),
    # It ends in the middle: 14 frames with CDM = 0.
    (("1 0", "0 0"), ["control frame: aborted"] * 2),
    # S of the slave comes a frame late, that of the master is repeated.
    ((READ_78[0][:-18].replace(" ", "") + "11" + "0" * 13, "01" + "0" * 15 + "100" + "1010010110110" + "0"),
     ["read 78h (device id) = 4Bh", "ID 0 read 78h: 4B"]),
    # Commands: to all; to ID 1, which acknowledges, or does not; not executed.
    (("1 0 00000000 01 1100 1 1", "0 1 00000000 00 0000 0 0"),
     ["all: command 01, register and command communication on"]),
    (("1 0 01000000 01 0011 1 0000000 1", "0 1 10000000 00 0000 0 0100000 0"),
     ["ID 1: command 01, register communication of this slave off"]),
    (("1 0 01000000 01 0011 1 0000000 1", "0 1 10000000 00 0000 0 0000000 0"),
     ["ID 1: command 01, register communication of this slave off",
      "ID 1: command 01, register communication of this slave off: not acknowledged by ID 1"]),
    (("1 0 10000000 00 0010 1 0000000 0", "0 1 00000000 00 0000 0 1000000 0"),
     ["ID 0: command 00, data channel on: not executed: EX = 0"] * 2),
    (("1 0 00000000 00 1110 1 1", "0 1 00000000 00 0000 0 0"),
     ["command 00: CRC4 of the address E is wrong, expected F"] * 2),
])
def test_biss_control_frames_by_hand(tmp_path, frames, wanted):
    path = Line().control(*frames).control(ZEROS, ZEROS).write(tmp_path / "line.vcd")
    assert decoded(path, f"{BY_HAND},biss_c_registers", REGISTERS) == wanted


def test_biss_start_that_comes_too_early(tmp_path):
    """Its control frame has four zeros in its end."""
    line = Line().control(*WRITE_1B)
    for cdm in "00000000" + "1":
        line.frame(cdm=cdm)
    path = line.control(*READ_78).write(tmp_path / "line.vcd")
    assert decoded(path, f"{BY_HAND},biss_c_registers", REGISTERS) == [
        "write 1Bh = A5h", "ID 0 write 1Bh: A5", "CDM = 1 behind 12 frames with CDM = 0 only: 14 are needed",
        "read 78h (device id) = 4Bh", "ID 0 read 78h: 4B"]


def test_biss_access_without_an_answer_in_a_frame(tmp_path):
    """A frame of the data that is cut has no CDS."""
    line = Line()
    for _ in range(14):
        line.frame()
    for place, (cdm, cds) in enumerate(zip(*(text.replace(" ", "") for text in READ_78))):
        line = line.clock("100").end(cdm) if place == 23 else line.frame(cds, cdm)
    path = line.write(tmp_path / "line.vcd")
    said = decoded(path, f"{BY_HAND},biss_c_registers", REGISTERS)
    assert said[0] == "frame without CDS inside a register access"


def test_biss_command_in_reduced_frames(tmp_path):
    """Two clocks carry CDM; there is no CDS, and none is missed."""
    line = Line()
    for cdm in ZEROS + "1 0 00000000 00 1111 1 1".replace(" ", ""):
        line.clock("10").end(cdm)
    path = line.write(tmp_path / "line.vcd")
    assert decoded(path, f"{BY_HAND},biss_c_registers", REGISTERS) == ["all: command 00, data channels off"]


def test_biss_control_frames_of_random_bits(tmp_path):
    """Behind each the next one is understood."""
    drawn = random.Random(1)
    line, wanted = Line(), 0
    for _ in range(30):
        for _ in range(drawn.randrange(1, 50)):
            cdm = drawn.choice("01")
            line = line.clock("10").end(cdm) if drawn.random() < 0.1 else line.frame(drawn.choice("01"), cdm)
        line.control(*READ_78)
        wanted += 1
    path = line.write(tmp_path / "line.vcd")
    said = decoded(path, f"{BY_HAND},biss_c_registers", "biss_c_registers=access")
    assert said.count("ID 0 read 78h: 4B") == wanted


# --- SSI ---

@pytest.mark.parametrize("model, options", [
    ("ssi-13", "mt=0"), ("ssi-25", "mt=12"), ("ssi-28", "st=16:code=binary:error_bit=high:parity=even"),
])
def test_ssi_positions(tmp_path, model, options):
    path = tmp_path / "ssi.vcd"
    said = drehgeber("ssi", model, *["read"] * 20, "--shaft", "3000RPM", "--trace", path)
    wanted = [" ".join(re.sub(r" [\d.]+ deg", "", line).replace("valid", "ok").split()) for line in said.splitlines()]
    wanted = [line.removeprefix("MT 0 ") for line in wanted] if model == "ssi-13" else wanted
    assert len(set(wanted)) >= 15
    stack = f"ssi:clock=CLOCK:data=DATA:{options}"
    assert decoded(path, stack, "ssi=word:warning") == wanted
    assert decoded(path, stack, "ssi=stop:monoflop") == ["0 behind the word", "Monoflop 20.0 us"] * 20


class Ssi(Line):
    """CLOCK and DATA; a bit is there behind a rising edge."""

    def __init__(self):
        super().__init__()
        self.levels = {"CLOCK": 1, "DATA": 1}

    def clock(self, bits):
        for bit in bits:
            self.set("CLOCK", 0)
            self.wait(CLOCK_NS // 2)
            self.set("CLOCK", 1)
            self.set("DATA", int(bit))
            self.wait(CLOCK_NS // 2)
        return self

    def end(self, tm_ns=20_000):
        self.wait(tm_ns - CLOCK_NS)
        self.set("DATA", 1)
        return self.wait(30_000)


def ssi_low_at_rest(line):
    line.changes.append((5_000, "DATA", 0))
    line.levels["DATA"] = 0
    return line


# 1001 is 1110 in binary; a published table of Gray code has 001101 for 9.
NINE = "001101"


@pytest.mark.parametrize("line, options, wanted", [
    (Ssi().clock(NINE + "0").end(), "", ["ST 9"]),
    (Ssi().clock(NINE).end(), "", ["ST 9"]),
    (Ssi().clock(NINE).end(), ":code=binary", ["ST 13"]),
    (Ssi().clock(NINE + "0").end(), ":st=4:mt=2", ["MT 0 ST 9"]),
    (Ssi().clock(NINE + "0" + NINE + "0").end(), "", ["ST 9", "repeated"]),
    (Ssi().clock(NINE + "0" + "001111" + "0").end(), "",
     ["ST 9", "repeated, not the same", "the repeated word is not the same"]),
    (Ssi().clock(NINE + "0" + "0011").end(), "", ["ST 9", "repeated word cut: 4 of 6 bits"]),
    (Ssi().clock(NINE + "0" + "0000000").end(), "", ["ST 9"]),  # an encoder that sends it once
    (Ssi().clock(NINE + "1").end(), "", ["ST 9", "1 behind the word: a wider one, or an error"]),
    (Ssi().clock(NINE[:3]).end().clock(NINE + "0").end(), "", ["cut: 3 of 6 bits", "ST 9"]),
    (ssi_low_at_rest(Ssi()).clock(NINE + "0").end(), "", ["data low at rest: no supply, or not ready", "ST 9"]),
    (Ssi().clock(NINE + "11" + "0").end(), ":error_bit=high:parity=odd", ["ST 9 error 1 parity ok"]),
    (Ssi().clock(NINE + "11" + "0").end(), ":error_bit=low:parity=even", ["ST 9 error 0 parity wrong", "parity wrong"]),
    (Ssi().clock(NINE + "0").end(25_000), "", ["ST 9"]),
])
def test_ssi_words_by_hand(tmp_path, line, options, wanted):
    path = line.write(tmp_path / "line.vcd")
    stack = "ssi:clock=CLOCK:data=DATA:mt=0:st=6" + options
    assert sorted(decoded(path, stack, "ssi=word:repeat:warning")) == sorted(wanted)


def test_ssi_monoflop_time_is_measured(tmp_path):
    for tm_ns, wanted in ((12_000, "12.0"), (20_000, "20.0"), (25_500, "25.5")):
        path = Ssi().clock(NINE + "0").end(tm_ns).write(tmp_path / "line.vcd")
        # From the last falling edge, half a clock before the last rising one.
        assert decoded(path, "ssi:clock=CLOCK:data=DATA:mt=0:st=6", "ssi=monoflop") == [f"Monoflop {wanted} us"]


# --- HIPERFACE ---

UART = f"baudrate={BAUD}:parity=even,hiperface"
LINES = f"uart:rx=request:tx=reply:{UART}"
FRAMES = "hiperface=request:reply:error:warning"


def ask_everything(master):
    """Each of the nineteen commands; what the master has read."""
    got = types.SimpleNamespace(position=master.read_position())
    master.set_position(7)
    got.temperature = master.read_analog(0x48)
    master.increment_counter()
    got.counter = master.read_counter()
    master.erase_counter()
    master.create_field(0, FieldStatus(16))
    master.save_data(0, 0, b"abc")
    got.data = master.read_data(0, 0, 3)
    master.field_status(0)
    got.free, got.fields = master.available_memory()
    master.modify_access_code(1, 0x55, 0x12)
    master.type_label()
    got.identity = master.identity()
    master.configure_uart(0xE4)
    got.synchronised = master.set_position_synchronised(0x11)
    master.assign_address(0x41)
    with pytest.raises(EncoderError, match="0Dh"):
        master.command(0x44, b"\x01")
    got.status = master.read_status()
    master.address = 0x42
    with pytest.raises(NoReply):
        master.read_position()
    master.address = 0xFF
    got.broadcast = master.read_position()
    master.address = 0x41
    master.reset()
    got.last = master.read_position()
    return got


def test_hiperface_commands(tmp_path, start):
    path = tmp_path / "line.vcd"
    encoder = start("--shaft", "90DEG", "--trace", path)
    got = ask_everything(encoder.master())
    assert encoder.end() == 0
    # A machine that stands still answers late: that is its own affair.
    assert [text for text in decoded(path, LINES, FRAMES) if "behind the timeout" not in text] == [
        "40h 42h read position", f"40h -> 42h position {got.position}",
        "40h 43h set position 7, code 55h", "40h -> 43h position set",
        "40h 44h read analog value 48h", f"40h -> 44h analog value 48h: {got.temperature}",
        "40h 47h increment counter", "40h -> 47h counter incremented",
        "40h 46h read counter", f"40h -> 46h counter {got.counter}",
        "40h 49h erase counter, code 55h", "40h -> 49h counter erased",
        "40h 4Dh create data field 00h status C8h, code 55h", "40h -> 4Dh data field 00h created, status C8h",
        "40h 4Bh save data field 00h offset 00h count 3, code 55h: 61 62 63",
        "40h -> 4Bh data field 00h offset 00h count 3 saved",
        "40h 4Ah read data field 00h offset 00h count 3, code 55h",
        f"40h -> 4Ah data field 00h offset 00h count 3: {got.data.hex(' ')}",
        "40h 4Ch determine data field status 00h", "40h -> 4Ch data field 00h status C8h",
        "40h 4Eh determine available memory area", f"40h -> 4Eh memory blocks free {got.free // 16}, data fields {got.fields}",
        "40h 4Fh modify access key 1 from 55h to 12h", "40h -> 4Fh access key 1 modified",
        "40h 52h read type label", "40h -> 52h type label: UART E4h, type 27h, memory blocks 112, option 00h",
        "40h 56h read serial number and version",
        f"40h -> 56h serial number {got.identity.serial_number}, version {got.identity.version}, date {got.identity.date}",
        "40h 57h configure serial interface E4h, code 55h", "40h -> 57h serial interface E4h",
        "40h 6Ah set position with synchronization 17, code 55h", f"40h -> 6Ah position {got.synchronised}",
        "40h 55h assign address 41h, code 55h", "41h -> 55h address assigned",
        "41h 44h read analog value 01h", "41h -> 50h error 0Dh wrong argument",
        "41h 50h read encoder status", "41h -> 50h no error",
        "42h 42h read position", "no reply to 42h read position",
        "all 42h read position", f"41h -> 42h position {got.broadcast}",
        "41h 53h reset encoder",
        "41h 42h read position", f"41h -> 42h position {got.last}",
    ]
    assert got.status == 0
    binary = sigrok_cli("-i", path, "-P", LINES, "-B", "hiperface=requests", SIGROKDECODE_DIR=str(DECODERS))
    assert binary.startswith(frame_of(0x40, 0x42) + frame_of(0x40, 0x43, 0, 0, 0, 7, 0x55))


ASKED = frame_of(0x40, 0x42)
TOLD = frame_of(0x40, 0x42, 0, 0, 0x30, 0x39)
READ, POSITION = "40h 42h read position", "40h -> 42h position 12345"


def line_trace(path, frames):
    """Frames (ms of silence, ours, bytes[, place of a damaged character]), as the program writes them."""
    character_ns = 11 * 10 ** 9 / BAUD
    at, events = 5e6, []
    for silence_ms, ours, frame, *damaged in frames:
        at += silence_ms * 1e6
        for place, byte in enumerate(frame):
            at += character_ns
            events.append(f"c {at:.0f} {ours} {BAUD} E {byte:02X} {int(place in damaged)}")
    events.append(f"n {at + 50e6:.0f} 0 end")
    return trace(path, "rs485", events)


@pytest.mark.parametrize("frames, wanted", [
    ([(0, 0, ASKED), (6, 1, TOLD)], [READ, POSITION]),
    ([(0, 0, ASKED), (6, 1, TOLD), (0, 0, ASKED), (6, 1, TOLD)], [READ, POSITION] * 2),  # no pause behind a reply
    # The timeout comes inside the request.
    ([(0, 0, ASKED[:2]), (5, 0, ASKED[2:]), (20, 0, ASKED), (6, 1, TOLD)], [
        "too short: 40 42, a frame has 3 characters or more", "request: a frame has 3 characters or more",
        "too short: 02, a frame has 3 characters or more", "request: a frame has 3 characters or more", READ, POSITION]),
    ([(0, 0, ASKED[:2] + b"\x03"), (6, 1, frame_of(0x40, 0x50, 0x0A))], [
        READ + ", check sum wrong", "request: check sum wrong", "40h -> 50h error 0Ah check sum error"]),
    ([(0, 0, ASKED), (6, 1, TOLD[:-1] + b"\0"), (20, 0, ASKED)], [
        READ, POSITION + ", check sum wrong", "reply: check sum wrong", READ]),
    ([(0, 0, ASKED, 1), (20, 0, ASKED), (6, 1, TOLD)], [
        READ + ", wrong parity in character 2", "request: wrong parity in character 2", "no reply to " + READ[4:],
        READ, POSITION]),
    ([(0, 0, frame_of(0x40, 0x42, 0)), (6, 1, frame_of(0x40, 0x50, 0x0C))], [
        READ + ", too many: 00, 1 data bytes, right are 0", "request: 1 data bytes, right are 0",
        "40h -> 50h error 0Ch wrong command length"]),
    ([(0, 0, frame_of(0x40, 0x41)), (6, 1, frame_of(0x40, 0xD0, 0x0B))], [
        "40h 41h unknown command, no such command", "request: no such command",
        "40h -> 50h error 0Bh unknown command code, warning"]),
    ([(0, 0, frame_of(0x40, 0x50)), (6, 1, frame_of(0x40, 0x50, 0x1E))], [
        "40h 50h read encoder status", "40h -> 50h error 1Eh temperature"]),
    ([(0, 0, ASKED), (25, 1, TOLD)], [READ, POSITION, "reply 20.4 ms behind the timeout, at most 10 ms"]),
    ([(0, 0, ASKED), (6, 1, frame_of(0x41, 0x42, 0, 0, 0, 1))], [
        READ, "41h -> 42h position 1", "41h answers for 40h"]),
    ([(0, 0, ASKED), (6, 1, frame_of(0x40, 0x46, 0, 0, 1))], [
        READ, "40h -> 46h counter 1", "reply to another command: 42h was asked"]),
    ([(0, 1, TOLD)], [POSITION, "reply without a request"]),
])
def test_hiperface_frames_by_hand(tmp_path, frames, wanted):
    assert decoded(line_trace(tmp_path / "line.vcd", frames), LINES, FRAMES) == wanted


def on_one_line(path, frames, pulses_ns=()):
    """A trace with requests and replies on one signal, and with pulses of 10 us in its silences."""
    signals = signals_of(open(line_trace(path, frames), encoding="ascii").read())
    levels = {"request": 1, "reply": 1}
    changes = [(at, name, level) for name in levels for at, level in signals[name]]
    changes += [(at + after, "pulse", int(after > 0)) for at in pulses_ns for after in (0, 10_000)]
    line = Line()
    line.step_ns, line.levels = 1000, {"LINE": 1}
    for line.now, name, level in sorted(changes):
        levels[name] = level
        line.set("LINE", int(all(levels.values())))
    return line.wait(50_000_000).write(path)


BOTH = f"uart:rx=LINE:{UART}:line=both"


def test_hiperface_with_both_on_one_line(tmp_path):
    """As a logic analyser at the line has it: requests without an answer are no replies."""
    counter = frame_of(0x40, 0x47)
    path = on_one_line(tmp_path / "line.vcd", [
        (0, 0, ASKED), (6, 1, TOLD), (0, 0, ASKED), (30, 0, ASKED), (6, 1, TOLD), (0, 0, counter), (6, 1, counter),
        (0, 0, frame_of(0x40, 0x44, 0)), (6, 1, frame_of(0x40, 0x50, 0x0D)), (20, 0, ASKED)])
    assert decoded(path, BOTH, FRAMES) == [
        READ, POSITION, READ, "no reply to 42h read position", READ, POSITION,
        "40h 47h increment counter", "40h -> 47h counter incremented",
        "40h 44h read analog value 00h", "40h -> 50h error 0Dh wrong argument", READ]


def test_hiperface_takes_a_pulse_for_no_character(tmp_path):
    path = on_one_line(tmp_path / "line.vcd", [(0, 0, ASKED), (6, 1, TOLD)], pulses_ns=(1_000_000, 13_000_000))
    assert decoded(path, BOTH, "uart=rx-warnings") == ["Frame error"] * 2
    assert decoded(path, BOTH, FRAMES) == [READ, POSITION]


# --- noise ---

@pytest.mark.parametrize("channels, stack, shown", [
    (("MA", "SLO"), f"{BISS}:mt=0:st=12:lc=no:slaves=2:st2=4,biss_c_registers", "biss_c,biss_c_registers"),
    (("CLOCK", "DATA"), "ssi:clock=CLOCK:data=DATA:mt=0:st=6:error_bit=low:parity=odd", "ssi"),
    (("request", "reply"), LINES, "hiperface"),
    (("LINE", "X"), BOTH, "hiperface"),
])
def test_noise_is_told_about_and_nothing_else_happens(tmp_path, channels, stack, shown):
    """Bursts of edges, of any length and distance; sigrok ends with an error when a decoder fails."""
    drawn = random.Random(str(channels))
    line = Line()
    line.step_ns, unit = (1000, 100_000) if "hiperface" in stack else (10, 300)
    line.levels = dict.fromkeys(channels, 1)
    for _ in range(300):
        for _ in range(drawn.choice((1, 2, 3, 5, 8, 20, 80))):
            for name in channels:
                line.set(name, drawn.randrange(2))
            line.wait(drawn.randrange(1, 4) * unit)
        line.wait(drawn.choice((5, 40, 60, 100)) * unit)
    path = line.wait(50 * unit).write(tmp_path / "noise.vcd")
    assert len(decoded(path, stack, shown)) > 300


# --- as a user has them ---

def test_they_are_installed_as_the_page_says(tmp_path):
    """sigrok finds them where the page's line puts them."""
    page = (DECODERS / "README.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^<!-- run: elsewhere, e2e\.sigrok -->\n```sh\n(.*?)^```$", page, re.M | re.S)
    assert "/usr/local/share/drehgeber/sigrok" in block
    home = {"HOME": str(tmp_path), "XDG_DATA_HOME": ""}
    subprocess.run(["bash", "-euc", block.replace("/usr/local/share/drehgeber/sigrok", str(DECODERS))], check=True,
                   env={**os.environ, **home})
    listed = sigrok_cli("-L", **home).decode()
    assert all(re.search(rf"^  {name} +", listed, re.M) for name in NAMES)
    path = Line().frame().write(tmp_path / "line.vcd")
    said = sigrok_cli("-i", path, "-P", BY_HAND, "-A", "biss_c=position", **home).decode()
    assert said == f"biss_c-1: ST {0x123456} {FLAGS}\n"


@pytest.mark.parametrize("name", NAMES)
def test_what_the_package_links_and_the_page_lists(name):
    links = (REPOSITORY / "debian/drehgeber.links").read_text(encoding="utf-8")
    assert f"usr/share/drehgeber/sigrok/{name} usr/share/libsigrokdecode/decoders/{name}\n" in links
    assert f"| `{name}` |" in (DECODERS / "README.md").read_text(encoding="utf-8")
