# SPDX-License-Identifier: MIT
"""explain: what recordings may say in other ways than our own do, and what is refused with its place."""
import os
import struct
import zipfile

import pytest

from rig import run

HEARTBEAT = "> heartbeat node 63 pre-operational"
TPDO = "< TPDO1 node 63 requested"


def explain(folder, content, *arguments):
    """What is said of a recording with this content."""
    path = folder / "recording"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return run("explain", path, *arguments)


def told(ended) -> list:
    """The lines without their times and clauses."""
    return [line.split(" ", 1)[1].split("  [")[0] for line in ended.stdout.splitlines()]


def check_refusal(folder, content, refusal, right=""):
    """One line, with the place in the file; what was expected behind it, if the test says what."""
    ended = explain(folder, content)
    assert ended.returncode == 1, ended.stdout
    (line,) = ended.stderr.splitlines()
    told, _, expected = line.partition("; ")
    assert told == f"drehgeber: {folder}/recording:{refusal}" and right in ("", expected), line


# --- candump

CANDUMP = {
    "blanks first": ("\n\r\n  vcan0  73F   [1]  7F\n", [HEARTBEAT]),
    "no end of line": ("(1.0) can0 73F#7F", [HEARTBEAT]),
    "small letters": ("(1.0) can0 73f#7f\n", [HEARTBEAT]),
    "tabs": ("(1.0)\tcan0\t73F#7F\r\n", [HEARTBEAT]),
    "dots": ("(1.0) can0 5BF#43.00.10.00.96.01.02.00\n", ["> SDO node 63 -> upload 1000h:00 = 00020196h"]),
    "many decimals": ("(1.0000000001234) can0 73F#7F\n", [HEARTBEAT]),
    "no decimals": ("(1) can0 73F#7F\n", [HEARTBEAT]),
    "sent": ("  vcan0  TX B E  73F   [1]  7F\n", [HEARTBEAT]),
    "sized remote": ("(1.0) can0 1BF#R8\n", [TPDO]),
    "a long name": ("(1.0) a-wire-with-a-long-name 73F#7F\n(2.0) a-wire-with-a-long-name 73F#7F\n", [HEARTBEAT] * 2),
    "extended on a terminal": ("  vcan0  1234ABCD   [1]  7F\n  vcan0  73F   [1]  7F\n", [HEARTBEAT]),
    "CAN FD on a terminal": ("  vcan0  123  [08]  00 00\n  vcan0  73F   [1]  7F\n", [HEARTBEAT]),
    "a longer name": ("(1.0) can0 73F#7F\n(1.0) can01 73F#05\n", [HEARTBEAT]),
}


@pytest.mark.parametrize("content, said", CANDUMP.values(), ids=CANDUMP)
def test_candump_in_other_ways(tmp_path, content, said):
    ended = explain(tmp_path, content)
    assert ended.returncode == 0, ended.stderr
    assert told(ended) == said


def test_times_go_on_where_a_recording_goes_back(tmp_path):
    ended = explain(tmp_path, "(2.5) can0 73F#7F\n(1.0) can0 73F#7F\n(2.500002) can0 73F#7F\n")
    assert [line.split()[0] for line in ended.stdout.splitlines()] == ["0.000000", "0.000000", "0.000002"]


REFUSED = {
    "a long remote frame": ("(1.0) can0 1BF#R9\n", "16: no frame of candump"),
    "a letter behind R": ("(1.0) can0 1BF#Rx\n", "16: no frame of candump"),
    "half a byte": ("(1.0) can0 73F#7\n", "15: no frame of candump"),
    "no hexadecimal digit": ("(1.0) can0 73F#7G\n", "15: no frame of candump"),
    "a byte too many": ("(1.0) can0 73F#" + "00" * 9 + "\n", "31: no frame of candump"),
    "a time without an end": ("(1.0 can0 73F#7F\n", "0: no frame of candump"),
    "a time of another age": ("(99999999999.0) can0 73F#7F\n", "0: no frame of candump"),
    "digits that fit no number": ("(" + "1" * 19 + ") can0 73F#7F\n", "0: no frame of candump"),
    "a time alone": ("(1.0)\n", "5: the line ends here"),
    "a wire alone": ("(1.0) can0\n", "10: the line ends here"),
    "an ID of many digits": ("(1.0) can0 " + "0" * 17 + "#00\n", "11: no frame of candump"),
    "no length": ("  vcan0  73F\n", "12: the line ends here"),
    "a length of 9": ("  vcan0  73F   [9]  7F\n", "15: no frame of candump"),
    "a length without an end": ("  vcan0  73F   [1)  7F\n", "15: no frame of candump"),
    "a length that is none": ("  vcan0  73F   [x]  7F\n", "15: no frame of candump"),
    "a length too long": ("  vcan0  73F   [123]  7F\n", "15: no frame of candump"),
    "no bytes": ("  vcan0  73F   [1]\n", "18: the line ends here"),
    "a byte of a terminal": ("  vcan0  73F   [1]  7G\n", "20: no frame of candump"),
    "more than the length says": ("  vcan0  73F   [1]  7F 00\n", "23: no frame of candump"),
    "no ID on a terminal": ("  vcan0  73G   [1]  7F\n", "9: no frame of candump"),
    "a CAN-ID too large": ("  vcan0  83F   [1]  7F\n", "9: no frame of candump"),
    # serial logs
    "a rate too high": ("10000001 8E1\n", "0: no data rate of a line"),
    "nine bits": ("9600 9E1\n", "5: no setting of a line"),
    "a strange parity": ("9600 8X1\n", "5: no setting of a line"),
    "two stop bits": ("9600 8E2\n", "5: no setting of a line"),
    "no seconds": ("0,5 < 40\n", "0: no time"),
    "a long direction": ("0.5 << 40\n", "4: no direction"),
    "a time alone in a log": ("0.5\n", "3: no direction"),
    "a byte of one digit": ("0.5 < 40 4\n", "9: no character"),
    "a byte of three digits": ("0.5 < 40 420\n", "9: no character"),
    "a byte with other letters": ("0.5 < 40 4G\n", "9: no character"),
    "no time in the second line": ("0.5 < 40\nlater < 42\n", "9: no time"),
    "an empty file": ("", "0: not a known kind of recording"),
    "blanks alone": (" \n \r\n", "0: not a known kind of recording"),
}
VCD = "$timescale 1 us $end\n$var wire 1 m MA $end\n$var wire 1 s SLO $end\n$enddefinitions $end\n"
BODY = len(VCD)
REFUSED |= {
    "no header": ("$timescale 1 us $end\nmoon\n", "21: no header"),
    "an end in the header": ("$comment no more\n", "17: the file ends here"),
    "a scale of zero": (VCD.replace("1 us", "0 us"), "13: no timescale"),
    "a scale of weeks": (VCD.replace("1 us", "1 weeks"), "13: no timescale"),
    "a scale too large": (VCD.replace("1 us", "1000000 s"), "19: no timescale"),
    "a scale without an end": ("$timescale\n", "11: the file ends here"),
    "a wire of two bits": (VCD.replace("wire 1 s", "wire 2 s"), "86: no wire"),
    "a long ID": (VCD.replace("wire 1 s", "wire 1 " + "s" * 16), "101: no wire"),
    "a variable without an end": ("$var wire 1 m\n", "14: no variable"),
    "one signal": (VCD.replace("$var wire 1 s SLO $end\n", ""), "63: no wire"),
    "two wires": (VCD.replace("SLO", "reply"), "88: no wire"),
    "a time that is none": (VCD + "#x\n", f"{BODY}: no time"),
    "a time without digits": (VCD + "#\n", f"{BODY}: no time"),
    "a time that does not fit": (VCD + "#99999999999999999\n", f"{BODY}: no time"),
    "a change without an ID": (VCD + "#1\n0\n", f"{BODY + 3}: no change of a signal"),
    "a vector without an ID": (VCD + "#1\nb01\n", "94: the file ends here"),
    "a comment without an end": (VCD + "#1\n$comment no more\n", "107: the file ends here"),
}


# What is expected in place of each.
EXPECTED = {
    "R and a length of 0 to 8": ["a long remote frame", "a letter behind R"],
    "bytes of two hexadecimal digits": ["half a byte", "no hexadecimal digit", "a byte of a terminal"],
    "8 bytes at most": ["a byte too many"],
    "a time such as (1436509052.249713)":
        ["a time without an end", "a time of another age", "digits that fit no number"],
    "a wire": ["a time alone"],
    "a CAN-ID of 3 or 8 hexadecimal digits": ["a wire alone", "an ID of many digits", "no ID on a terminal"],
    "a length such as [8]":
        ["no length", "a length of 9", "a length without an end", "a length that is none", "a length too long"],
    "as many bytes as the length says": ["no bytes"],
    "the end of the line": ["more than the length says"],
    "a CAN-ID of 000 to 7FF": ["a CAN-ID too large"],
    "100 to 10000000": ["a rate too high"],
    "8E1, 8O1 or 8N1": ["nine bits", "a strange parity", "two stop bits"],
    "seconds such as 0.012345, or a line such as 9600 8E1": ["no seconds", "no time in the second line"],
    "< to the encoder, > from it": ["a long direction", "a time alone in a log"],
    "two hexadecimal digits such as 0A": ["a byte of one digit", "a byte of three digits", "a byte with other letters"],
    "a candump log, pcapng, pcap, VCD, a session of sigrok or a serial log": ["an empty file", "blanks alone"],
    "$enddefinitions": ["no header"],
    "$end": ["an end in the header", "a scale without an end", "a comment without an end"],
    "1, 10 or 100 s, ms, us, ns or ps": ["a scale of zero", "a scale of weeks", "a scale too large"],
    "signals request and reply, MA and SLO, or CLOCK and DATA":
        ["a wire of two bits", "a long ID", "one signal", "two wires"],
    "$var TYPE WIDTH ID NAME $end": ["a variable without an end"],
    "# and a number that fits the timescale":
        ["a time that is none", "a time without digits", "a time that does not fit"],
    "#TIME, 0ID, 1ID, bBITS ID, rNUMBER ID or sTEXT ID": ["a change without an ID"],
    "the ID of a signal": ["a vector without an ID"],
}
RIGHT = {name: right for right, names in EXPECTED.items() for name in names}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(tmp_path, name):
    content, refusal = REFUSED[name]
    check_refusal(tmp_path, content, refusal, f"expected {RIGHT[name]}")


# --- serial logs

LOG = "0.0 < 40 42 02\n0.01 > 40 42 00 01 E2 40 A1\n"
ASKED, ANSWERED = "< 40h 42h read position", "> 40h -> 42h position 123456"
SERIAL = {
    "comments": ("# one\n\n0.0 < 40 42 02 # asks\n  # two\n0.01 > 40 42 00 01 E2 40 A1", [ASKED, ANSWERED]),
    "two lines of one message": ("0.0 < 40 42\n0.002 < 02\n0.01 > 40 42 00 01 E2 40 A1\n", [ASKED, ANSWERED]),
    "without parity": ("19200 8N1\n" + LOG, [ASKED, ANSWERED]),
    "odd parity": ("38400 8O1\n" + LOG, [ASKED, ANSWERED]),
    "small letters": (LOG.lower(), [ASKED, ANSWERED]),
    "a rate in between": (LOG + "600 8E1\n1.0 < 40 42 02\n", [ASKED, ANSWERED, ASKED]),
}


@pytest.mark.parametrize("content, said", SERIAL.values(), ids=SERIAL)
def test_serial_logs_in_other_ways(tmp_path, content, said):
    ended = explain(tmp_path, content)
    assert ended.returncode == 0, ended.stderr
    assert told(ended) == said


def test_a_message_that_is_longer_than_any(tmp_path):
    ended = explain(tmp_path, "0.0 <" + " 40" * 1300 + "\n")
    assert (ended.returncode, ended.stderr) == (0, "drehgeber: 9 messages\n")
    assert all("160 bytes are too many" in line for line in ended.stdout.splitlines()[:-1])


# --- VCD

def clock_frame(scale: int = 1) -> str:
    """Eight periods of a clock of 1 MHz, in microseconds times `scale`; the data line falls with the fourth."""
    lines = ["#0", "1m", "1s"]
    for at in range(8):
        lines += [f"#{(10 + at) * scale}", "0m", f"#{(10 + at) * scale + scale // 2}", "1m"]
        if at == 3:
            lines.append("0s")
    return "\n".join([*lines, f"#{100 * scale}", "1s", f"#{200 * scale}"]) + "\n"


FRAME = clock_frame(1000)
HEAD = VCD.replace("1 us", "1 ns")
VCDS = {
    "nanoseconds": HEAD + FRAME,
    "no blank": HEAD.replace("1 ns", "1ns") + FRAME,
    "picoseconds": HEAD.replace("1 ns", "1 ps") + clock_frame(1000000),
    "ten picoseconds": HEAD.replace("1 ns", "10 ps") + clock_frame(100000),
    "a hundred picoseconds": HEAD.replace("1 ns", "100ps") + clock_frame(10000),
    "ten nanoseconds": HEAD.replace("1 ns", "10ns") + clock_frame(100),
    "a hundred nanoseconds": HEAD.replace("1 ns", "100\nns") + clock_frame(10),
    "other names": HEAD.replace(" MA ", " clk ").replace("SLO", "sl") + FRAME,
    "a range": HEAD.replace("SLO $end", "SLO [0] $end") + FRAME,
    "other signals": HEAD.replace("$enddef", "$var real 64 r SPEED $end\n$enddef") + "r1.5 r\nsidle r\n" + FRAME,
    "blocks": HEAD + "".join(f"${name}\nxm\nZs\n$end\n" for name in ("dumpvars", "dumpall", "dumpon", "dumpoff"))
        + "$comment so what $end\n" + FRAME,
    "vectors": HEAD + FRAME.replace("0m", "b0 m").replace("1m", "B1 m"),
    "blanks first": "\r\n " + HEAD + FRAME,
    "no scale": HEAD.partition("\n")[2] + FRAME,
}


@pytest.mark.parametrize("content", VCDS.values(), ids=VCDS)
def test_vcd_files_in_other_ways(tmp_path, content):
    """The same frame, whatever the writer."""
    ended = explain(tmp_path, content)
    assert (ended.returncode, ended.stdout) == (0, "0.000000 > frame of 8 bits: F0\n"), ended.stderr


LARGEST = {"1 s": 10**10, "10 s": 10**9, "100 s": 10**8, "1 ms": 10**13, "10 ms": 10**12, "100 ms": 10**11,
           "1 us": 10**16, "10 us": 10**15, "100 us": 10**14, "100 ns": 10**17}


@pytest.mark.parametrize("scale, largest", LARGEST.items(), ids=LARGEST)
def test_times_up_to_ten_thousand_million_seconds(tmp_path, scale, largest):
    head = VCD.replace("1 us", scale)
    ended = explain(tmp_path, f"{head}#{largest}\n")
    assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
    check_refusal(tmp_path, f"{head}#{largest + 1}\n", f"{len(head)}: no time",
                  f"expected {RIGHT['a time that does not fit']}")


# --- pcap

def pcap(*packets, link: int = 227, mark: int = 0xA1B23C4D) -> bytes:
    """A file of packets: (seconds, nanoseconds, bytes)."""
    return struct.pack("<IHHiIII", mark, 2, 4, 0, 0, 65535, link) + b"".join(
        struct.pack("<IIII", seconds, part, len(data), len(data)) + data for seconds, part, data in packets)


def can_frame(can_id: int, data: bytes, length: int | None = None, flags: int = 0) -> bytes:
    return struct.pack(">IBBxx", can_id, len(data) if length is None else length, flags) + data


def test_packets_that_no_encoder_has_are_counted(tmp_path):
    ended = explain(tmp_path, pcap(
        (1, 0, can_frame(0x73F, b"\x7f")),
        (1, 1000, can_frame(0x98FF1234, b"")),
        (1, 2000, can_frame(0x20000004, bytes(8))),
        (1, 3000, can_frame(0x123, bytes(12), flags=4)),
        (1, 4000, can_frame(0x400001BF, b"", length=4))))
    assert ended.returncode == 0, ended.stderr
    assert [line.split("  [")[0] for line in ended.stdout.splitlines()] == [
        "0.000000 > heartbeat node 63 pre-operational", f"0.000004 {TPDO}"]
    assert "3 frames are left out" in ended.stderr


@pytest.mark.parametrize("mark", [0xA1B2C3D4, 0xA1B23C4D])
def test_marks_of_pcap(tmp_path, mark):
    ended = explain(tmp_path, pcap((1, 0, can_frame(0x73F, b"\x7f")), mark=mark))
    assert ended.stdout.startswith("0.000000 > heartbeat node 63")


PACKETS = {
    "a short header": pcap((1, 0, b"\0\0\x07\x3f")),
    "nine bytes": pcap((1, 0, can_frame(0x73F, bytes(9)))),
    "fewer bytes than it says": pcap((1, 0, can_frame(0x73F, b"\x7f", length=8))),
}


@pytest.mark.parametrize("content", PACKETS.values(), ids=PACKETS)
def test_packets_that_are_no_frames(tmp_path, content):
    check_refusal(tmp_path, content, "24: no CAN frame")


def test_a_pcap_without_a_header(tmp_path):
    ended = explain(tmp_path, pcap()[:10])
    assert ended.returncode == 1
    assert ended.stderr.startswith(f"drehgeber: {tmp_path}/recording:10: ") and len(ended.stderr.splitlines()) == 1


# --- sessions of sigrok

METADATA = "[device 1]\ncapturefile=logic-1\nsamplerate=1 MHz\nprobe1=MA\nprobe2=SLO\nunitsize=1\n"


def session(folder, metadata: str, unit: int = 1, member: str = "logic-1-1") -> bytes:
    """The frame of clock_frame(), a sample each half of a microsecond, but the rate is what the metadata say."""
    clock = [3] * 20
    for at in range(8):
        clock += [(0 if at > 3 else 2), (1 if at >= 3 else 3)]
    clock += [1] * 100 + [3] * 100
    path = folder / "samples.sr"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("metadata", metadata)
        archive.writestr(member, b"".join(sample.to_bytes(unit, "little") for sample in clock))
    return path.read_bytes()


SESSIONS = {
    "a part": (METADATA, 1, "logic-1-1"),
    "one member": (METADATA, 1, "logic-1"),
    "two bytes": (METADATA.replace("unitsize=1", "unitsize=2"), 2, "logic-1-1"),
    "no blank": (METADATA.replace("1 MHz", "1MHz"), 1, "logic-1-1"),
    "decimals": (METADATA.replace("1 MHz", "0.5 MHz"), 1, "logic-1-1"),
    "kilohertz": (METADATA.replace("1 MHz", "2000 kHz"), 1, "logic-1-1"),
    "hertz": (METADATA.replace("1 MHz", "1000000 Hz"), 1, "logic-1-1"),
    "no end of line": (METADATA.rstrip(), 1, "logic-1-1"),
}


@pytest.mark.parametrize("metadata, unit, member", SESSIONS.values(), ids=SESSIONS)
def test_sessions_in_other_ways(tmp_path, metadata, unit, member):
    ended = explain(tmp_path, session(tmp_path, metadata, unit, member))
    assert (ended.returncode, ended.stdout) == (0, "0.000000 > frame of 8 bits: F0\n"), ended.stderr


REFUSED_SESSIONS = {
    "a rate of zero": METADATA.replace("1 MHz", "0 MHz"),
    "a rate beyond all": METADATA.replace("1 MHz", "99 GHz"),
    "a rate that fits no number": METADATA.replace("1 MHz", "9999999999 GHz"),
    "a rate without a unit": METADATA.replace("1 MHz", "1000"),
    "no rate": METADATA.replace("1 MHz", ""),
    "no unit": METADATA.replace("unitsize=1", "unitsize=x"),
    "no name": METADATA.replace("=logic-1", "="),
    "a long name": METADATA.replace("=logic-1", "=" + "l" * 64),
    "no probe": METADATA.replace("probe1=", "probe="),
    "a probe 0": METADATA.replace("probe1=", "probe0="),
    "a probe 65": METADATA.replace("probe1=", "probe65="),
    "a probe x": METADATA.replace("probe1=", "probex="),
}


@pytest.mark.parametrize("metadata", REFUSED_SESSIONS.values(), ids=REFUSED_SESSIONS)
def test_sessions_that_are_refused(tmp_path, metadata):
    what = "no wire" if "=MA" in metadata and "probe1=" not in metadata else "no samples"
    check_refusal(tmp_path, session(tmp_path, metadata), f"0: {what}, in sample 0")


def test_a_session_that_is_no_zip_file(tmp_path):
    check_refusal(tmp_path, b"PK\x03\x04" + bytes(40), "0: no zip file of sigrok, in sample 0")
    check_refusal(tmp_path, b"PK\x03\x04", "0: no zip file of sigrok, in sample 0")
    check_refusal(tmp_path, b"PK\x03\x04" + bytes(40) + struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, 1, 1, 40, 4, 0),
                  "0: no zip file, in sample 0")


# --- files that cannot be read

def test_a_folder_is_no_recording(tmp_path):
    ended = run("explain", tmp_path)
    assert (ended.returncode, ended.stdout, len(ended.stderr.splitlines())) == (1, "", 1)
    assert str(tmp_path) in ended.stderr


def test_a_pipe_is_no_recording(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    keep = os.open(path, os.O_RDWR)
    os.write(keep, b"(1.0) can0 73F#7F\n")
    ended = run("explain", path)
    os.close(keep)
    assert (ended.returncode, ended.stdout, len(ended.stderr.splitlines())) == (1, "", 1)


# --- against a model

BOOT = "(0.0) can0 73F#00\n"
ASK = "(1.0) can0 63F#4000100000000000\n"
AGAINST = {
    "no answer": (BOOT + ASK, "came:  nothing\n  model: 43 00 10 00 96 01 02 00"),
    "a PDO that nobody sends": (BOOT + "(1.0) can0 1BF#00000000\n", "came:  00 00 00 00  TPDO1"),
    "a position beyond all": (BOOT + "(1.0) can0 63F#4004600000000000\n(1.001) can0 5BF#43046000FFFFFFFF\n",
                              "came:  43 04 60 00 FF FF FF FF"),
    "another length": (BOOT + "(1.0) can0 63F#4008100000000000\n(1.001) can0 5BF#4108100010000000\n",
                       "came:  41 08 10 00 10 00 00 00"),
}


@pytest.mark.parametrize("content, difference", AGAINST.values(), ids=AGAINST)
def test_differences_of_a_bus(tmp_path, content, difference):
    ended = explain(tmp_path, content, "--against", "f3668", "--node", "63")
    assert ended.returncode == 1 and difference in ended.stdout, ended.stdout


def test_an_answer_that_nobody_has_asked_for(tmp_path):
    ended = explain(tmp_path, "0.0 > 40 42 00 01 E2 40 A1\n", "--against", "s3684-rs485")
    assert ended.returncode == 1 and ended.stdout.endswith("\n  model: nothing\n")


BROKEN = {
    "a bus": (BOOT + ASK + "(1.001) can0 5BF#4300100096010200\nx\n", "f3668", 85),
    "a line": (LOG + "x\n", "s3684-rs485", 43),
    "a clocked line": (HEAD + FRAME + "?\n", "ssi-25", len(HEAD + FRAME)),
}


@pytest.mark.parametrize("against", [False, True], ids=["in words", "against"])
@pytest.mark.parametrize("content, model, offset", BROKEN.values(), ids=BROKEN)
def test_recordings_that_break_off(tmp_path, content, model, offset, against):
    ended = explain(tmp_path, content, *(["--against", model] if against else []))
    assert ended.returncode == 1
    assert ended.stderr.startswith(f"drehgeber: {tmp_path}/recording:{offset}: ") and ended.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments, refusal", [
    (["ssi-25", "--address", "5"], "ssi-25 has no address"),
    (["ssi-25", "--set", "parity=both"], "--set parity=both: out of its range"),
    (["f3668"], "levels of a clocked line, f3668 has CAN frames on its wire"),
    (["ocd-ib-k3"], "levels of a clocked line, ocd-ib-k3 has words of a ring on its wire"),
])
def test_models_that_are_refused(tmp_path, arguments, refusal):
    ended = explain(tmp_path, HEAD + FRAME, "--against", *arguments)
    assert (ended.returncode, ended.stdout) == (2, "") and refusal in ended.stderr
