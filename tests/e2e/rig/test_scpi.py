# SPDX-License-Identifier: MIT
"""The control plane as SCPI (IEEE 488.2, SCPI-99): every command, every way to get it wrong, many
clients, and clients that do not behave."""
import itertools
import os
import random
import socket
import stat
import statistics
import struct
import subprocess
import time
from decimal import Decimal

import pytest

from bench import ERROR, PATIENCE_S, PROGRAM, Master, Session, connect, eventually, fields, run

RIG = """
[rig]
name = panel
control = unix:{socket}
control = tcp:127.0.0.1:0
[shaft main]
[shaft second]
[encoder a]
model = s3684-rs485
shaft = main
wire = pty
[encoder b]
model = s3684-biss
shaft = second
wire = sim
"""

CHARACTER, SYNTAX, DATA_TYPE, SUPERFLUOUS, MISSING = -101, -102, -104, -108, -109
UNDEFINED, SUFFIX, STRING = -113, -131, -151
CONFLICT, RANGE, ILLEGAL, NO_ANSWER, NO_HARDWARE = -221, -222, -224, -240, -241
STORAGE, FILE_NAME, FILE_ERROR, QUEUE, OVERRUN = -250, -256, -257, -350, -363

CLIENTS_MAX = 32
LINE_MAX = 512
QUEUE_LENGTH = 16

# Everything the control plane is said to know, long form.
COMMON = ["*CLS", "*ESE", "*ESE?", "*ESR?", "*IDN?", "*OPC", "*OPC?", "*RST", "*SRE", "*SRE?",
          "*STB?", "*WAI"]
HEADERS = [
    "SYSTem:ERRor", "SYSTem:HELP", "INSTrument:CATalog", "INSTrument:SELect", "INSTrument:MODel",
    "INSTrument:WIRE", "SHAFt:CATalog", "SHAFt:NAME", "SHAFt:POSition", "SHAFt:VELocity",
    "SHAFt:ACCeleration", "SHAFt:STOP", "SHAFt:MOVE", "SHAFt:MOVing", "SHAFt:PROFile",
    "SHAFt:RECord:STARt", "SHAFt:RECord:STOP", "WORLd:TEMPerature", "WORLd:LED:CURRent",
    "WORLd:SUPPly", "WORLd:BATTery", "WORLd:AMPLitude:SIN", "WORLd:AMPLitude:COS",
    "WORLd:OFFSet:SIN", "WORLd:OFFSet:COS", "WORLd:SINGleturn", "WORLd:MULTiturn:AMPLitude",
    "WORLd:MULTiturn:SYNC", "WORLd:MULTiturn:VECTor", "WORLd:EEPRom", "WORLd:WATChdog",
    "WORLd:DEFault", "FAULt:CATalog", "FAULt:SET", "FAULt:CLEar", "FAULt:ACTive",
    "FAULt:HAPPened", "NVM:CATalog", "NVM:CORRupt", "NVM:ERASe", "POWer", "STATe", "TIME", "TIME:ORIGin",
    "TIME:SCALe", "TIME:STEP", "TRACe:STARt", "TRACe:STOP", "TRACe:LAST", "TRACe:LAST:SEVerity", "BISS:FRAMe",
    "BISS:REGister", "WORLd:TEMPerature:PROFile", "WORLd:TEMPerature:PROFile:POINts",
    "WORLd:MULTiturn:SYNC:PROFile:STATe",
]


@pytest.fixture(scope="module")
def bench(start_once, tmp_path_factory):
    path = tmp_path_factory.mktemp("control") / "panel.sock"
    return start_once(RIG.format(socket=path))


@pytest.fixture(params=["unix", "tcp"])
def session(bench, request) -> Session:
    """A new client; afterwards everything is as it was."""
    client = bench.session(address=bench.address(request.param))
    assert client.ask("SYST:VERS?") == "1999.0"  # TCP: who begins with something else is sent away
    yield client
    client.close()
    clean = bench.session()
    for encoder in "ab":
        clean.select(encoder)
        clean.do("SHAF:ACC 0")
        clean.do("SHAF:POS 0")
        clean.do("WORL:DEF")
        clean.do("FAUL:CLE")
        clean.do("POW ON")
    clean.close()
    assert bench.alive()


# --- identity, lists ----------------------------------------------------------------------------

def test_identity(session):
    maker, model, serial, version = session.ask("*IDN?").split(",")
    assert maker and model and serial and version


def test_lists(session):
    assert session.parts("INST:CAT?") == ["a", "b"]
    assert session.name("INST:SEL?") == "a"
    assert session.parts("INST:MOD?") == ["s3684-rs485"]
    assert session.parts("SHAF:CAT?") == ["main", "second"]
    assert session.name("SHAF:NAME?") == "main"
    session.do("INSTRUMENT:SELECT B")
    assert session.name("INST:SEL?") == "b"
    assert session.parts("INST:MOD?") == ["s3684-biss"]
    assert session.name("SHAF:NAME?") == "second"


def test_wire_is_what_the_ready_line_said(session, bench):
    assert session.parts("INST:WIRE?") == [f"pty:{bench.wires['a']}"]
    assert session.select("b").parts("INST:WIRE?") == [f"sim:{bench.wires['b']}"]


def test_help_knows_everything(session):
    text = session.ask("SYST:HELP?")
    for header in COMMON + HEADERS:
        assert header.rstrip("?") in text, header


def test_version(session):
    assert session.ask("SYST:VERS?") == "1999.0"


# --- spelling -----------------------------------------------------------------------------------

@pytest.mark.parametrize("header", [
    "SHAFt:POSition", "shaft:position", "SHAF:POS", "shaf:pos", "sHaFt:PoS", "SHAF:POSITION",
    ":SHAF:POS", ":shaft:position",
])
def test_forms(session, header):
    session.do(f"{header} 12.5")
    assert session.ask(f"{header}?") == "12.500000"


@pytest.mark.parametrize("header", [
    "SHAFTT:POS", "SHA:POS", "SHAFT:POSI", "SHAFT:POSITIO", "SHAF:POSITIONS", "SHAF", "POS",
    "SHAF::POS", "SHAF:POS:NOW", "FOO", "*FOO", "*IDN:X", "SYST:ERR:FOO", "SHAF POS", "1", "_",
])
def test_what_is_no_header(session, header):
    for text in (header, f"{header}?"):
        assert session.codes(text) in ([UNDEFINED], [SYNTAX]), text
    assert session.ask("SHAF:POS?") == "0.000000"


@pytest.mark.parametrize("line", [
    "SHAF:STOP?", "SHAF:MOVE?", "WORL:DEF?", "FAUL:SET?", "FAUL:CLE?", "NVM:CORR?", "NVM:ERAS?",
    "*CLS?", "*WAI?", "*RST?", "INST:CAT", "SHAF:CAT", "SHAF:MOV", "FAUL:CAT", "STAT", "*IDN",
    "*ESR", "*STB", "TIME", "TIME:ORIG", "BISS:FRAM", "SYST:ERR", "SYST:HELP",
])
def test_commands_without_query_and_queries_without_command(session, line):
    assert session.codes(line) == [UNDEFINED]


@pytest.mark.parametrize("line", [
    b"*ESE 7\n*ESE?\n", b"*ESE 7\r\n*ESE?\r\n", b"*ESE 7\r*ESE?\r", b" \t*ESE\t 7 \t\n  *ESE? \n",
    b"\n\n\r\n*ESE 7\n\n*ESE?\n", b"*ESE 7;*ESE?\n", b"*ESE 7 ; *ESE?\n",
])
def test_ends_and_blanks(session, line):
    session.send(line)
    assert session.line() == "7"
    assert session.errors() == []


def test_a_line_in_pieces(session):
    for byte in b"SHAF:POS 33 DEG;POS?\n":
        session.send(bytes([byte]))
    assert session.line() == "33.000000"


# --- compound lines -----------------------------------------------------------------------------

@pytest.mark.parametrize("line, answer", [
    ("SHAF:POS 10;POS?", "10.000000"),
    ("SHAF:POS 10;VEL 0;POS?;VEL?", "10.000000;0.000"),
    ("SHAF:POS 10;:SHAF:POS?", "10.000000"),
    ("SHAF:POS 10;*ESE 0;POS?", "10.000000"),
    ("*ESE 5;SHAF:POS 10;POS?;*ESE?", "10.000000;5"),
    ("WORL:LED:CURR 1234;CURR?", "1234"),
    ("WORL:MULT:SYNC OFF;VECT?;SYNC?", "1;0"),
    ("WORL:MULT:SYNC?;:WORL:SING?", "1;1"),
    ("INST:SEL b;SEL?;:SHAF:NAME?", '"b";"second"'),
    ("SYST:ERR?;ERR?", '0,"No error";0,"No error"'),
    ("SYST:ERR:NEXT?;NEXT?", '0,"No error";0,"No error"'),
    ("TIME:SCAL?;SCAL?;:INST:SEL?", '1.000;1.000;"a"'),
])
def test_paths(session, line, answer):
    assert session.ask(line) == answer
    assert session.errors() == []


@pytest.mark.parametrize("line", [
    "SHAF:POS 10;SHAF:VEL 1",  # SHAF:SHAF:VEL
    "WORL:LED:CURR 1234;TEMP 20",  # WORL:LED:TEMP
    "SHAF:POS 10;NOPE",
])
def test_wrong_paths(session, line):
    assert session.codes(line) == [UNDEFINED]


def test_the_path_ends_with_the_line(session):
    session.do("SHAF:POS 10")
    assert session.codes("POS 20") == [UNDEFINED]


def test_what_follows_an_error_is_not_done(session):
    assert session.codes("SHAF:POS 10;FOO;POS 20;*ESE 3") == [UNDEFINED]
    assert session.ask("SHAF:POS?") == "10.000000"
    assert session.ask("*ESE?") == "0"


def test_answers_before_an_error_come(session):
    session.send("*ESE?;FOO;*ESE?")
    assert session.line() == "0"
    assert session.errors() == [UNDEFINED]


# --- parameters ---------------------------------------------------------------------------------

@pytest.mark.parametrize("text, degrees", [
    ("90", "90.000000"), ("90 DEG", "90.000000"), ("90DEG", "90.000000"), ("90deg", "90.000000"),
    ("1 REV", "360.000000"), ("0.25rev", "90.000000"), ("-1.5REV", "-540.000000"),
    ("9E1", "90.000000"), ("9e+1 DEG", "90.000000"), ("900e-1", "90.000000"), ("+90", "90.000000"),
    (".5", "0.500000"), ("5.", "5.000000"), ("-0.25", "-0.250000"), ("0", "0.000000"),
    ("1500000", "1500000.000000"), ("-1500000", "-1500000.000000"),
])
def test_angles(session, text, degrees):
    session.do(f"SHAF:POS {text}")
    assert session.ask("SHAF:POS?") == degrees


@pytest.mark.parametrize("header, text, answer", [
    ("SHAF:VEL", "60", "60.000"), ("SHAF:VEL", "-0.5 RPM", "-0.500"),
    ("SHAF:ACC", "100 RPM/S", "100.000"), ("SHAF:ACC", "0", "0.000"),
    ("WORL:TEMP", "85", 85), ("WORL:TEMP", "-45.5 DEGC", -45.5), ("WORL:TEMP", "20 CEL", 20),
    ("WORL:LED:CURR", "40000", 40000), ("WORL:LED:CURR", "40 MA", 40000),
    ("WORL:LED:CURR", "40000UA", 40000), ("WORL:SUPP", "4.5 V", 4500), ("WORL:SUPP", "24000", 24000),
    ("WORL:BATT", "2300 MV", 2300), ("WORL:AMPL:SIN", "500", 500), ("WORL:AMPL:COS", "2000", 2000),
    ("WORL:OFFS:SIN", "-1000", -1000), ("WORL:OFFS:COS", "1000", 1000), ("WORL:SING", "OFF", 0),
    ("WORL:SING", "on", 1), ("WORL:MULT:AMPL", "0", 0), ("WORL:MULT:SYNC", "Off", 0),
    ("WORL:MULT:VECT", "1", 1), ("WORL:EEPR", "OFF", 0), ("WORL:WATC", "ON", 1),
    ("POW", "OFF", 0), ("POWER", "on", 1), ("POW", "CYCLE", 1), ("POW", "cycl", 1),
    ("*ESE", "255", 255), ("*ESE", "#HFF", 255), ("*ESE", "#B101", 5), ("*ESE", "#Q17", 15),
    ("*ESE", "1E1", 10), ("*ESE", "MAX", 255), ("*ESE", "min", 0),
    ("*SRE", "32", 32),
])
def test_values(session, header, text, answer):
    session.do(f"{header} {text}")
    told = session.ask(f"{header}?")
    assert told == answer or not isinstance(answer, str) and float(told) == answer
    session.do("POW ON")


def test_quantities_go_back_to_default(session):
    quantities = [header for header in HEADERS
                  if header.startswith("WORLd:") and ":PROFile" not in header and header != "WORLd:DEFault"]
    healthy = [session.ask(f"{header}?") for header in quantities]
    for header, value in zip(quantities, healthy):
        session.do(f"{header} {1 - int(value) if value in '01' else 1}"
                   if "OFFS" not in header else f"{header} 1")
        assert float(session.ask(f"{header}?")) != float(value)
    session.do("WORL:DEF")
    assert [session.ask(f"{header}?") for header in quantities] == healthy


@pytest.mark.parametrize("line, code", [
    # nothing where something is needed
    ("SHAF:POS", MISSING), ("SHAF:VEL", MISSING), ("SHAF:MOVE", MISSING), ("INST:SEL", MISSING),
    ("WORL:TEMP:PROF", MISSING), ("WORL:TEMP:PROF:POIN 0", MISSING), ("WORL:TEMP:PROF a.csv,LOOP,STEP,1", SUPERFLUOUS),
    ("WORL:TEMP:PROF:POIN 0,1E9", RANGE), ("WORL:SUPP:PROF:POIN 0,1DEGC", SUFFIX),
    ("WORL:TEMP:PROF:POIN 1,0,0,0", ILLEGAL), ("WORL:TEMP:PROF words", ILLEGAL),
    ("WORL:TEMP:PROF nowhere.csv", FILE_NAME), ("WORL:TEMP:PROF:STAT ON", CONFLICT),
    ("SHAF:PROF", MISSING), ("SHAF:REC:STAR", MISSING), ("WORL:TEMP", MISSING),
    ("WORL:SING", MISSING), ("FAUL:SET", MISSING), ("FAUL:HAPP?", MISSING), ("NVM:CORR", MISSING),
    ("POW", MISSING), ("TIME:SCAL", MISSING), ("TIME:STEP", MISSING), ("TRAC:STAR", MISSING),
    ("*ESE", MISSING), ("*SRE", MISSING), ("FAUL:SET wire_drop,COUN", MISSING),
    # more than it takes
    ("SHAF:POS 1,2", SUPERFLUOUS), ("SHAF:STOP 1", SUPERFLUOUS), ("SHAF:POS? 1", SUPERFLUOUS),
    ("SHAF:MOVE 1,2,3", SUPERFLUOUS), ("WORL:DEF 1", SUPERFLUOUS), ("WORL:TEMP 1,2", SUPERFLUOUS),
    ("INST:SEL a,b", SUPERFLUOUS), ("*CLS 1", SUPERFLUOUS), ("*IDN? 1", SUPERFLUOUS),
    ("*ESE 1,2", SUPERFLUOUS), ("STAT? 1", SUPERFLUOUS), ("POW ON,OFF", SUPERFLUOUS),
    ("SYST:ERR? 1", SUPERFLUOUS), ("*WAI 1", SUPERFLUOUS), ("*OPC? 1", SUPERFLUOUS),
    # another kind of thing
    ("SHAF:POS abc", DATA_TYPE), ('SHAF:POS "90"', DATA_TYPE), ("SHAF:VEL ON", DATA_TYPE),
    ("*ESE foo", DATA_TYPE), ("WORL:TEMP (1)", DATA_TYPE), ("SHAF:POS #15hello", DATA_TYPE),
    ("SHAF:POS -", DATA_TYPE), ("SHAF:POS .", DATA_TYPE),
    # suffixes
    ("SHAF:POS 1 RPM", SUFFIX), ("SHAF:VEL 1 DEG", SUFFIX), ("WORL:TEMP 1 V", SUFFIX),
    ("WORL:SUPP 1 MA", SUFFIX), ("SHAF:POS 1 FURLONG", SUFFIX), ("*ESE 1 S", SUFFIX),
    # strings
    ('SHAF:PROF "60RPM', STRING), ("SHAF:PROF '60RPM", STRING), ('TRAC:STAR "x', STRING),
    # too much, too little
    ("SHAF:VEL 1E9", RANGE), ("SHAF:VEL -1E9", RANGE), ("SHAF:ACC -1", RANGE),
    ("SHAF:ACC 1E10", RANGE), ("SHAF:MOVE 10,0", RANGE), ("SHAF:MOVE 10,-5", RANGE),
    ("SHAF:POS 1E30", RANGE), ("SHAF:POS -1E300", RANGE), ("SHAF:POS 1E99999", RANGE),
    ("WORL:AMPL:SIN 2001", RANGE), ("WORL:AMPL:COS -1", RANGE), ("WORL:OFFS:SIN 1001", RANGE),
    ("WORL:OFFS:COS -1001", RANGE), ("WORL:BATT -1", RANGE), ("WORL:LED:CURR -1", RANGE),
    ("WORL:TEMP 1E12", RANGE), ("*ESE 256", RANGE), ("*SRE -1", RANGE),
    ("FAUL:SET wire_drop,PROB 1.5", RANGE), ("FAUL:SET wire_drop,PROB -0.1", RANGE),
    ('SHAF:REC:STAR "r.csv",1 NS', RANGE), ('SHAF:REC:STAR "r.csv",2 H', SUFFIX),
    # nothing of that name
    ("INST:SEL nobody", ILLEGAL), ("FAUL:SET nonsense", ILLEGAL), ("FAUL:CLE nonsense", ILLEGAL),
    ("FAUL:HAPP? nonsense", ILLEGAL), ("NVM:CORR nonsense", ILLEGAL), ("POW MAYBE", ILLEGAL),
    ("FAUL:SET wire_drop,FOO 1", ILLEGAL), ('SHAF:PROF "nonsense"', ILLEGAL),
    # not now, not here
    ("NVM:ERAS", CONFLICT), ("TIME:SCAL 2", CONFLICT), ("TIME:SCAL 0", CONFLICT),
    ("TIME:STEP 1 S", CONFLICT), ("BISS:FRAM?", NO_HARDWARE), ("BISS:REG? 120", NO_HARDWARE),
    # files
    ('SHAF:PROF "/nowhere/at/all.csv"', (FILE_NAME, STORAGE)),
    ('SHAF:REC:STAR "/nowhere/at/all.csv"', FILE_ERROR),
    ('TRAC:STAR "/nowhere/at/all.vcd"', FILE_ERROR),
])
def test_refusals(session, line, code):
    (told,) = session.codes(line)
    assert told in (code if isinstance(code, tuple) else (code,))
    assert session.ask("SHAF:POS?") == "0.000000"
    assert session.parts("FAUL:ACT?") == []


@pytest.mark.parametrize("line", ["WORL:SING MAYBE", "WORL:EEPR 2", "WORL:WATC YES"])
def test_states_that_are_none(session, line):
    codes = session.codes(line)
    assert codes in ([DATA_TYPE], [RANGE], [ILLEGAL]), codes
    assert session.ask("WORL:SING?;EEPR?;WATC?") == "1;1;0"


@pytest.mark.parametrize("limits", ["COUN 3", "PROB 0.5"])
def test_only_frames_are_counted(session, limits):
    (code,) = session.codes(f"FAUL:SET temperature_high,{limits}")
    assert -299 <= code <= -200
    assert session.parts("FAUL:ACT?") == []


def test_refused_fault_leaves_nothing_behind(session):
    assert session.codes("FAUL:SET wire_drop,COUN 3,FOO 3") == [ILLEGAL]
    assert session.parts("FAUL:ACT?") == []


@pytest.mark.parametrize("line, code", [
    ("BISS:REG?", MISSING), ("BISS:REG 27", MISSING), ("BISS:REG? 128", RANGE),
    ("BISS:REG? -1", RANGE), ("BISS:REG? 0,65", RANGE), ("BISS:REG 27,256", RANGE),
    ("BISS:REG? foo", DATA_TYPE), ("BISS:FRAM? 1", SUPERFLUOUS),
    ("BISS:REG 120,1", NO_ANSWER),  # read-only
    ("BISS:REG? 72", NO_ANSWER),  # not implemented
])
def test_refusals_of_biss(session, line, code):
    session.select("b")
    eventually(lambda: int(session.ask("BISS:REG? #H60")) & 0x80 != 0)
    assert session.codes(line) == [code]


def test_registers_of_biss(session):
    session.select("b")
    eventually(lambda: int(session.ask("BISS:REG? #H60")) & 0x80 != 0)
    assert session.ask("BISS:REG? #H7E,2") == "75,85"
    assert session.ask("BISS:REG? 0x7E") == "75"
    session.do("BISS:REG 64,7;REG 0,17,34")  # bank 7
    eventually(lambda: session.ask("BISS:REG? 0,3") == "17,34,255")


def test_names_in_any_form(session):
    for name in ("wire_drop", "WIRE-DROP", '"Wire_Drop"', "'wire-drop'"):
        session.do(f"FAUL:SET {name}")
        assert session.parts("FAUL:ACT?") == ["wire_drop"]
        session.do(f"FAUL:CLE {name}")


def test_reset_makes_everything_good(session):
    session.do("FAUL:SET wire_drop;:WORL:TEMP 85;:INST:SEL b;:FAUL:SET wire_break;:POW OFF")
    session.do("SHAF:POS 45")
    session.do("*RST")
    assert session.ask("POW?") == "1" and session.parts("FAUL:ACT?") == []
    assert session.ask("SHAF:POS?") == "45.000000"  # nothing turns by itself
    assert session.name("INST:SEL?") == "b"
    session.select("a")
    assert float(session.ask("WORL:TEMP?")) == 37 and session.parts("FAUL:ACT?") == []


def test_traces(session, bench, tmp_path):
    file = tmp_path / "wire.vcd"
    session.do(f'TRAC:STAR "{file}"')
    assert session.codes(f'TRAC:STAR "{file}"') == [CONFLICT]
    with Master(bench.wires["a"]) as master:
        master.read_position()
    session.do("TRAC:STOP")
    text = file.read_text()
    assert "$enddefinitions" in text and len(text.splitlines()) > 50
    session.parts("TRAC:LAST?")  # the first question begins the listening
    with Master(bench.wires["a"]) as master:
        master.read_position()
    eventually(lambda: " > " in session.name("TRAC:LAST?"))
    request, reply = session.parts("TRAC:LAST? 2")
    assert " < " in request and " > " in reply and "42" in request and "42" in reply


def test_errors_say_what_is_wrong(session):
    session.send("SHAF:VEL 1E9")
    code, text = fields(session.ask("SYST:ERR?"))
    assert code == "-222" and text.startswith("Data out of range;") and len(text) > 20
    session.send("FOO:BAR")
    code, text = fields(session.ask("SYST:ERR?"))
    assert code == "-113" and text.startswith("Undefined header")


# --- status -------------------------------------------------------------------------------------

def test_registers(session):
    assert session.ask("*ESR?") == "128"  # power on
    assert session.ask("*ESR?") == "0"
    session.do("*ESE 32;*SRE 32")
    assert session.ask("*STB?") == "0"
    session.send("FOO")
    assert session.ask("*STB?") == str(4 + 32 + 64)
    assert session.ask("*ESR?") == "32"
    assert session.ask("*STB?") == "4"
    assert session.error() == UNDEFINED
    assert session.ask("*STB?") == "0"


@pytest.mark.parametrize("line, bit", [("FOO", 32), ("SHAF:POS", 32), ("SHAF:VEL 1E9", 16),
                                       ("INST:SEL nobody", 16), ("*OPC", 1)])
def test_event_bits(session, line, bit):
    session.ask("*ESR?")
    session.send(line)
    assert session.ask("*ESR?") == str(bit)


def test_clear(session):
    session.send("FOO")
    session.send("*CLS")
    assert session.ask("SYST:ERR?") == '0,"No error"'
    assert session.ask("*ESR?") == "0"


def test_enables_stay_over_clear_and_reset(session):
    session.do("*ESE 60;*SRE 36")
    session.do("*CLS")
    session.do("*RST")
    assert session.ask("*ESE?;*SRE?") == "60;36"


def test_service_request_bit_cannot_be_enabled(session):
    session.do("*SRE 255")
    assert session.ask("*SRE?") == str(255 - 64)


def test_queue_is_a_queue(session):
    session.send("FOO")
    session.send("SHAF:POS")
    session.send("*ESE 999")
    assert session.errors() == [UNDEFINED, MISSING, RANGE]


def test_queue_overflow(session):
    for _ in range(QUEUE_LENGTH + 5):
        session.send("FOO")
    assert session.errors() == [UNDEFINED] * (QUEUE_LENGTH - 1) + [QUEUE]
    session.send("*ESE 999")
    assert session.errors() == [RANGE]


# --- what takes time ----------------------------------------------------------------------------

def test_opc_query_waits_for_a_move(session):
    took = []
    for degrees in range(180, 13 * 180, 180):
        begin, done, end = session.ask(f"TIME?;:SHAF:MOVE {degrees} DEG,60 RPM;*OPC?;:TIME?").split(";")
        took.append(Decimal(end) - Decimal(begin))
        assert done == "1" and session.ask("SHAF:POS?") == f"{degrees}.000000" and took[-1] >= Decimal("0.5")
        # By the rig's clock half a second, and until a busy machine has woken the rig: two of three were late by
        # 25 and 63 ms.
        if took[-1] <= Decimal("0.505"):
            return
    raise AssertionError(took)


def test_wai_holds_the_line(session):
    assert session.ask("SHAF:MOVE 90,60;*WAI;POS?") == "90.000000"
    session.send("SHAF:MOVE -90,120")
    session.send("*WAI")
    assert session.ask("SHAF:POS?") == "-90.000000"


def test_moves_overlap(session):
    session.do("SHAF:MOVE 3600,60")  # 10 s
    assert session.ask("SHAF:MOV?") == "1"
    assert 0 <= float(session.ask("SHAF:POS?")) < 3600
    session.do("SHAF:STOP")
    assert session.ask("SHAF:MOV?") == "0"
    assert session.ask("*OPC?") == "1"


def test_opc_comes_when_it_is_over(session):
    session.ask("*ESR?")
    session.send("SHAF:MOVE 90,60;*OPC\n*ESR?")  # at once: it takes a quarter of a second only
    assert session.line() == "0"
    eventually(lambda: session.ask("*ESR?") == "1", 5)
    assert session.ask("SHAF:POS?") == "90.000000"


def test_a_waiting_client_stops_nobody(session, bench):
    session.send("SHAF:MOVE 36000,60;*OPC?;POS?")  # 100 s
    other = bench.session()
    assert session.silent()
    begin = time.monotonic()
    assert other.name("INST:SEL?") == "a"
    assert time.monotonic() - begin < 5
    other.do("SHAF:STOP")  # and it can be freed
    assert session.line().startswith("1;")


# --- several clients ----------------------------------------------------------------------------

def test_selections_and_queues_are_each_ones_own(session, bench):
    other = bench.session()
    session.do("INST:SEL b")
    other.send("FOO")
    session.do("*ESE 7")
    assert other.ask("INST:SEL?;*ESE?") == '"a";0'
    assert session.ask("INST:SEL?;*ESE?") == '"b";7'
    assert session.errors() == []
    assert other.errors() == [UNDEFINED]
    session.do("SHAF:POS 77")
    assert other.ask("SHAF:POS?") == "0.000000"
    assert other.select("b").ask("SHAF:POS?") == "77.000000"


def test_forty_clients(bench):
    address = bench.address("tcp")
    eventually(lambda: bench.session().name("INST:SEL?") == "a")  # those of other tests are gone
    bench.closing.close()
    time.sleep(0.1)
    clients = [Session(address) for _ in range(40)]
    late, gone = clients[-CLIENTS_MAX:], clients[:-CLIENTS_MAX]
    for client in late:
        assert client.ask("*ESE 1;*ESE?") == "1"
    for client in gone:  # the longest silent ones had to make room
        assert client.socket.recv(1) == b""
        client.close()
    for client in late[:10]:
        client.close()
    served = late[10:]
    late = [eventually(lambda: try_session(address)) for _ in range(10)]
    for client in late + served:
        assert client.name("INST:SEL?") == "a"
        client.close()


def try_session(address: str):
    """A client that is served, or None."""
    client = Session(address)
    try:
        if client.ask("*ESE?") == "0":
            return client
    except (AssertionError, OSError):
        pass
    client.close()
    return None


# --- clients that do not behave -----------------------------------------------------------------

@pytest.mark.parametrize("size", [LINE_MAX + 1, 600, 100_000])
def test_a_line_too_long(session, size):
    session.do("SHAF:POS 5")
    session.send(b"SHAF:POS 6;" + b"x" * (size - 11) + b"\n")
    assert session.errors() == [OVERRUN]
    assert session.ask("SHAF:POS?") == "5.000000"


def test_the_longest_line(session):
    session.send(b"SHAF:POS 6" + b" " * (LINE_MAX - 10) + b"\n")
    assert session.ask("SHAF:POS?") == "6.000000"
    assert session.errors() == []


def test_garbage(session):
    chance = random.Random(4711)
    for _ in range(60):
        size = chance.randrange(1, 400)
        line = bytes(chance.choice([0, 1, 7, 0x1B, 0x80, 0xA5, 0xFE, 0xFF,
                                    chance.randrange(0x80, 0x100)]) for _ in range(size))
        assert session.codes(line + b"\n") == [UNDEFINED], line.hex(" ")


@pytest.mark.parametrize("line", [
    b"\x00", b"*IDN?\x00", b"\xff\xfb\x01\xff\xfb\x03", b"SHAF:POS\x80 5", b"SHAF:POS 5\xb0",
    "SHAFT:POSITIÖN 5".encode(), b"\x7f", b"*IDN?\x08",
])
def test_one_wrong_byte(session, line):
    assert session.codes(line + b"\n") in ([UNDEFINED], [CHARACTER])
    assert session.ask("SHAF:POS?") == "0.000000"


def test_a_client_dying_in_a_line(session, bench):
    for how, kind in itertools.product(["reset", "close"], ["unix", "tcp"]):
        line = connect(bench.address(kind))
        line.sendall(b"SHAF:POS 12")
        time.sleep(0.02)
        if how == "reset":
            line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        line.close()
    time.sleep(0.05)
    assert session.ask("SHAF:POS?") == "0.000000"


def test_a_client_dying_while_it_waits(session, bench):
    line = connect(bench.address("tcp"))
    line.sendall(b"SHAF:MOVE 180,60;*OPC?\n")
    eventually(lambda: session.ask("SHAF:MOV?;POS?") != "0;0.000000")
    line.close()
    assert session.ask("*OPC?") == "1"
    assert session.ask("SHAF:POS?") == "180.000000"


@pytest.mark.parametrize("kind", ["unix", "tcp"])
def test_half_closed_connections_get_their_answers(bench, kind):
    with connect(bench.address(kind)) as line:
        line.sendall(b"INST:SEL?\nSHAF:MOVE 90,60;*OPC?\nINST:CAT?\nSHAF:POS 0\n")
        line.shutdown(socket.SHUT_WR)
        got = b""
        while chunk := line.recv(4096):
            got += chunk
    assert got.decode() == '"a"\n1\n"a","b"\n'


def test_nc_and_socat(bench):
    path = bench.address("unix").partition(":")[2]
    port = bench.address("tcp").rpartition(":")[2]
    for call in (["nc", "-N", "127.0.0.1", port], ["nc", "-N", "-U", path],
                 ["socat", "-t5", "-", f"UNIX-CONNECT:{path}"]):
        ended = subprocess.run(call, input="INST:SEL?\nSYST:ERR?\n", capture_output=True,
                               text=True, timeout=PATIENCE_S)
        assert ended.stdout == '"a"\n0,"No error"\n', (call, ended.stderr)


def latencies(master: Master, seconds: float) -> list:
    """How long a position takes, one after the other."""
    took = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        master.wait_for_line()
        begin = time.monotonic()
        master.read_position()
        took.append(time.monotonic() - begin)
    return took


def test_a_client_that_never_reads_stops_nobody(bench, session):
    with Master(bench.wires["a"]) as master:
        before = statistics.median(latencies(master, 0.6))
        lazy = connect(bench.address("tcp"))
        lazy.setblocking(False)
        wanted = b"FAUL:CAT?\n" * 10_000
        sent, alive, took = 0, True, []
        for _ in range(40):
            try:
                while sent < len(wanted):
                    sent += lazy.send(wanted[sent:])
            except BlockingIOError:
                pass
            except OSError:  # cut off
                alive = False
            took += latencies(master, 0.03)
            if not alive:
                break
        begin = time.monotonic()
        assert session.name("INST:SEL?") == "a"
        assert time.monotonic() - begin < 5
        lazy.close()
    assert sent >= 10 * 1000
    during = statistics.median(took)
    assert during < before + 0.01, f"{before * 1000:.1f} ms before, {during * 1000:.1f} ms then"


# --- sockets ------------------------------------------------------------------------------------

def mode(path) -> int:
    return stat.S_IMODE(os.stat(path).st_mode)


def test_the_socket_is_private(bench):
    assert mode(bench.address("unix").partition(":")[2]) == 0o600


def test_default_address(start, tmp_path):
    environment = os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)}
    bench = start("[rig]\nname = stand\n[encoder a]\nmodel = s3674-biss\nwire = sim\n",
                  env=environment)
    path = tmp_path / "drehgeber" / "stand.sock"
    assert mode(path) == 0o600 and mode(path.parent) == 0o700
    assert Session(f"unix:{path}").parts("INST:CAT?") == ["a"]
    assert bench.end() == 0
    assert not path.exists()


@pytest.mark.parametrize("others", ["", ":/nowhere"], ids=["one", "several"])
def test_default_address_in_a_service(start, tmp_path, others):
    """RuntimeDirectory= of a systemd unit; its own folder, the first one, before the user's."""
    own = tmp_path / "own"
    environment = os.environ | {"RUNTIME_DIRECTORY": f"{own}{others}", "XDG_RUNTIME_DIR": str(tmp_path / "user")}
    bench = start("[rig]\nname = stand\n[encoder a]\nmodel = s3674-biss\nwire = sim\n", env=environment)
    assert mode(own / "stand.sock") == 0o600 and not (tmp_path / "user").exists()
    ended = subprocess.run([PROGRAM, "ctl", "INST:SEL?"], env=environment, capture_output=True, text=True,
                           timeout=PATIENCE_S)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, '"a"\n', "")
    assert bench.end() == 0
    assert list(own.iterdir()) == []


def test_a_folder_of_a_service_without_a_path_is_none(start, tmp_path):
    environment = os.environ | {"RUNTIME_DIRECTORY": "", "XDG_RUNTIME_DIR": str(tmp_path)}
    start("[rig]\nname = stand\n[encoder a]\nmodel = s3674-biss\nwire = sim\n", env=environment)
    assert (tmp_path / "drehgeber" / "stand.sock").is_socket()


def test_a_dead_socket_is_replaced_and_a_living_one_is_not(start, tmp_path):
    path = tmp_path / "x.sock"
    text = "[encoder a]\nmodel = s3674-biss\nwire = sim\n"
    first = start(text, "--control", f"unix:{path}")
    ended = run("run", first.folder / "bench.ini", "--control", f"unix:{path}")
    assert ended.returncode == 1 and ended.stdout == "" and len(ended.stderr.splitlines()) == 1
    first.process.kill()
    first.process.wait(PATIENCE_S)
    assert path.exists()
    assert start(text, "--control", f"unix:{path}").session().name("INST:SEL?") == "a"


# --- drehgeber ctl ------------------------------------------------------------------------------

def ctl(*arguments, runtime=None, text=None) -> subprocess.CompletedProcess:
    environment = os.environ | ({"XDG_RUNTIME_DIR": str(runtime)} if runtime else {})
    return subprocess.run([PROGRAM, "ctl", *arguments], input=text or "", capture_output=True,
                          text=True, timeout=PATIENCE_S, env=environment)


@pytest.mark.parametrize("kind", ["unix", "tcp"])
def test_ctl(bench, kind):
    address = bench.address(kind)
    ended = ctl("--control", address, "INST:SEL?")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, '"a"\n', "")
    ended = ctl("--control", address, "SHAF:POS 45", "SHAF:POS?", "SHAF:POS 0;*ESE?")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "45.000000\n0\n", "")
    ended = ctl("--control", address, text="INST:SEL b\nINST:SEL?\n")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, '"b"\n', "")


def test_ctl_tells_errors(bench):
    ended = ctl("--control", bench.address("unix"), "INST:SEL?;FOO", "SHAF:VEL 1E9")
    assert ended.returncode == 1 and ended.stdout == '"a"\n'
    assert len(ended.stderr.splitlines()) == 1
    assert "-113" in ended.stderr and "-222" in ended.stderr


def test_ctl_finds_the_only_one(start, tmp_path):
    text = "[encoder a]\nmodel = s3674-biss\nwire = sim\n"
    environment = os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)}
    ended = ctl("*IDN?", runtime=tmp_path)
    assert ended.returncode == 1 and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1 and "drehgeber run" in ended.stderr
    start(f"[rig]\nname = one\n{text}", env=environment)
    ended = ctl("INST:SEL?", runtime=tmp_path)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, '"a"\n', "")
    start(f"[rig]\nname = two\n{text}", env=environment)
    ended = ctl("INST:SEL?", runtime=tmp_path)
    assert ended.returncode == 1 and ended.stdout == ""
    assert len(ended.stderr.splitlines()) == 1
    assert "one.sock" in ended.stderr and "two.sock" in ended.stderr


@pytest.mark.parametrize("arguments", [["--control", "nonsense", "*IDN?"],
                                       ["--control", "udp:1:2", "*IDN?"]])
def test_ctl_with_a_wrong_address(arguments):
    ended = ctl(*arguments)
    assert ended.returncode == 2 and ended.stdout == "" and len(ended.stderr.splitlines()) == 1


def test_ctl_with_nobody_there(tmp_path):
    ended = ctl("--control", f"unix:{tmp_path}/nobody.sock", "*IDN?")
    assert ended.returncode == 1 and ended.stdout == "" and len(ended.stderr.splitlines()) == 1
