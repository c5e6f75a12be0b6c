# SPDX-License-Identifier: MIT
"""explain: recordings of conversations with encoders in words, and against a model.

Recordings are those of our own encoders, by `--trace`: against the same model there is no difference. With one byte
changed there is one, and the line of it says which.
"""
import os
import re
import select
import struct
import subprocess
import time
import zipfile
from pathlib import Path

import pytest

from hiperface_master import CHARACTER_BITS, EncoderError, Master, open_port
from rig import MULTITURN, PATIENCE_S, PROGRAM, Encoder, run

NODE = 63
POSITION_OBJECT = 0x6004
SAMPLES = 20000
MEMORY_MB = 64


def explain(*arguments):
    return run("explain", *arguments)


def differences(*arguments) -> list:
    """What is different: blocks of lines. The status says whether there is one."""
    ended = explain(*arguments)
    assert ended.returncode in (0, 1), (ended.stdout, ended.stderr)
    blocks = re.split(r"\n(?=\d)", ended.stdout.strip()) if ended.stdout else []
    assert ended.returncode == (1 if blocks else 0), ended.stderr
    return blocks


# --- recordings

def talk_on_line(master):
    """What a drive asks for when it starts, and what it may do wrong."""
    master.type_label()
    master.identity()
    for _ in range(3):
        master.read_position()
    master.set_position(123456)
    master.read_position()
    master.read_analog(0x48)
    master.increment_counter()
    assert master.read_counter() == 1
    with pytest.raises(EncoderError):
        master.field_status(5)
    master.read_all_status()


class WritingMaster(Master):
    """A master that writes a serial log of what goes through its port."""

    def __init__(self, path, log):
        super().__init__(path)
        self.log = log
        self.begin = time.monotonic()

    def write(self, sign, data, at):
        self.log.write(f"{at - self.begin:.6f} {sign} {data.hex(' ').upper()}\n")

    def send(self, request):
        self.wait_for_line()
        self.write("<", request, time.monotonic())
        super().send(request)

    def receive(self, n, timeout_s):
        got = super().receive(n, timeout_s)
        if got:
            self.write(">", got, time.monotonic() - self.bits_s(len(got) * CHARACTER_BITS))
        return got


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    """One conversation, as a VCD file of RS485 and as a serial log."""
    folder = tmp_path_factory.mktemp("line")
    encoder = Encoder([MULTITURN, f"--pty={folder}/tty", "--shaft", "60RPM", "--trace", folder / "line.vcd"])
    try:
        with open(folder / "line.txt", "w") as log, WritingMaster(f"{folder}/tty", log) as master:
            talk_on_line(master)
    finally:
        encoder.clean_up()
    return folder


def session(path) -> Path:
    """What sigrok makes of a VCD file."""
    to = path.with_suffix(".sr")
    subprocess.run(["sigrok-cli", "-i", path, "-I", "vcd", "-o", to], check=True, capture_output=True, timeout=60)
    return to


@pytest.fixture(params=["line.vcd", "line.txt", "line.sr"])
def line(request, lines):
    return session(lines / "line.vcd") if request.param == "line.sr" else lines / request.param


class Adapter:
    """The master of a CAN bus behind an SLCAN adapter."""

    def __init__(self, path):
        self.port = open_port(str(path), 115200, "N")
        self.rest = b""
        self.port.write(b"C\rS5\rO\r")

    def send(self, can_id, *data):
        self.port.write(f"t{can_id:03X}{len(data)}{bytes(data).hex().upper()}\r".encode())

    def wait(self, can_id) -> bytes:
        """The next frame with this identifier."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            select.select([self.port], [], [], 0.1)
            self.rest += self.port.read(self.port.in_waiting or 1)
            while b"\r" in self.rest:
                text, _, self.rest = self.rest.partition(b"\r")
                found = re.search(rb"t([0-9A-F]{3})\d([0-9A-F]*)$", text)
                if found and int(found[1], 16) == can_id:
                    return bytes.fromhex(found[2].decode())
        raise AssertionError(f"no frame {can_id:03X}")

    def upload(self, index, sub=0) -> bytes:
        self.send(0x600 + NODE, 0x40, *struct.pack("<HB", index, sub), 0, 0, 0, 0)
        return self.wait(0x580 + NODE)

    def download(self, index, sub, data) -> bytes:
        self.send(0x600 + NODE, 0x23 | (4 - len(data)) << 2, *struct.pack("<HB", index, sub), *data.ljust(4, b"\0"))
        return self.wait(0x580 + NODE)


def talk_on_bus(master):
    master.upload(0x1000)
    master.upload(0x1018, 4)
    master.upload(POSITION_OBJECT)
    master.upload(0x1234)  # refused
    master.download(0x1017, 0, struct.pack("<H", 100))
    master.download(0x1801, 2, b"\x01")  # TPDO2 with every SYNC
    master.send(0x000, 0x01, NODE)
    for _ in range(5):
        master.send(0x080)
        master.wait(0x280 + NODE)
    master.wait(0x700 + NODE)
    master.send(0x000, 0x81, NODE)
    while master.wait(0x700 + NODE) != b"\0":  # boot-up: a heartbeat from before may come first
        pass
    master.upload(0x1000)


@pytest.fixture(scope="module", params=["log", "pcapng"])
def bus(request, tmp_path_factory):
    """A candump log and a pcapng file of CAN."""
    folder = tmp_path_factory.mktemp("bus")
    path = folder / f"bus.{request.param}"
    encoder = Encoder(["f3668", f"--slcan={folder}/can", "--node", NODE, "--shaft", "60RPM", "--trace", path])
    try:
        talk_on_bus(Adapter(folder / "can"))
    finally:
        encoder.clean_up()
    return path


def clocked(folder, command, model, *words) -> Path:
    path = folder / f"{model}.vcd"
    ended = run(command, model, *words, "--shaft", "123DEG", "--trace", path, *SETTINGS[model])
    assert ended.returncode == 0, ended.stderr
    return path


# A word of SSI that is nothing but a position has nothing to compare.
SETTINGS = {"s3684-biss": [], "ssi-25": ["--set", "parity=even"]}


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    """VCD files of BiSS and SSI, with their models."""
    folder = tmp_path_factory.mktemp("frames")
    return {
        "s3684-biss": clocked(folder, "biss", "s3684-biss", *["read"] * 5, "registers", "0x78", "8"),
        "ssi-25": clocked(folder, "ssi", "ssi-25", *["read"] * 5),
    }


# --- in words

def test_a_line_in_words(line):
    ended = explain(line)
    assert ended.returncode == 0, ended.stderr
    said = ended.stdout.splitlines()
    assert re.fullmatch(r"0\.000000 < 40h 52h read type label  \[5\.1\.2\.14\]", said[0])
    assert any(re.fullmatch(r"\d\.\d{6} > 40h -> 42h position \d+  \[5\.1\.2\.1\]", text) for text in said)
    assert any(re.search(r"> 40h -> \S+ error 12h wrong data field number  \[5\.1\.3\]$", text) for text in said)


def test_a_bus_in_words(bus):
    ended = explain(bus)
    assert ended.returncode == 0, ended.stderr
    for text in (r"< SDO node 63 upload 1000h:00  \[CiA 301 7\.2\.4\]", r"< NMT start node 63  \[CiA 301 7\.2\.8\]",
                 r"> heartbeat node 63 boot-up", r"abort 1234h:00: .*  \[CiA 301 7\.2\.4\.3\.17\]"):
        assert re.search(text, ended.stdout), text


def test_frames_of_clocked_lines(frames):
    for model, path in frames.items():
        ended = explain(path)
        assert ended.returncode == 0, ended.stderr
        assert len(ended.stdout.splitlines()) >= 5, model
        assert all(re.fullmatch(r"\d+\.\d{6} > frame of \d+ bits:( [0-9A-F]{2})+", text)
                   for text in ended.stdout.splitlines())


# --- against the model

def test_no_difference_on_a_line(line):
    assert differences(line, "--against", MULTITURN) == []


def test_no_difference_on_a_bus(bus):
    assert differences(bus, "--against", "f3668", "--node", NODE) == []


def test_no_difference_on_clocked_lines(frames):
    for model, path in frames.items():
        assert differences(path, "--against", model, *SETTINGS[model]) == [], model


def test_sessions_of_sigrok_say_what_their_vcd_files_do(frames, lines):
    for path in (*frames.values(), lines / "line.vcd"):
        assert explain(session(path)).stdout == explain(path).stdout


def test_another_model_is_different(line, bus):
    assert differences(line, "--against", "s3674-rs485")
    assert differences(bus, "--against", "f3658", "--node", NODE)


def test_an_encoder_with_another_address_is_not_asked(bus):
    """Whoever asks for node 5 sees that it is not there: what all nodes are told has no answer."""
    found = differences(bus, "--against", "f3668", "--node", "5")
    assert all("node 63" not in block for block in found)


@pytest.mark.parametrize("bus", ["log"], indirect=True)
def test_a_changed_byte_on_a_bus(bus, tmp_path):
    text = bus.read_text()
    changed = tmp_path / "changed.log"
    changed.write_text(re.sub(r"(5BF#43001000)(..)", lambda at: f"{at[1]}{int(at[2], 16) ^ 1:02X}", text, count=1))
    (found,) = differences(changed, "--against", "f3668", "--node", NODE)
    asked, came, model = found.splitlines()
    assert re.fullmatch(r"0\.\d{6} < SDO node 63 upload 1000h:00  \[CiA 301 7\.2\.4\]", asked)
    assert re.match(r"  came:  43 00 10 00 97 ", came) and re.match(r"  model: 43 00 10 00 96 ", model)


@pytest.mark.parametrize("bus", ["log"], indirect=True)
def test_an_answer_that_is_missing_and_one_that_nobody_gives(bus, tmp_path):
    lines = bus.read_text().splitlines(keepends=True)
    changed = tmp_path / "changed.log"
    (where,) = [place for place, text in enumerate(lines) if "5BF#43181004" in text]
    changed.write_text("".join(lines[:where] + lines[where + 1:]))
    (found,) = differences(changed, "--against", "f3668", "--node", NODE)
    assert re.search(r"upload 1018h:04 .*\n  came:  nothing\n  model: 43 18 10 04 ", found)
    changed.write_text("".join(lines[:where + 1] + lines[where:]))
    (found,) = differences(changed, "--against", "f3668", "--node", NODE)
    assert re.search(r"\n  came:  43 18 10 04 .*\n  model: nothing$", found)


def changes(text, answer, places):
    """The recording with one bit of a byte of an answer changed, for each; `places` are bytes that are left out."""
    for found in re.finditer(answer, text, re.M):
        for at in range(0, len(found[2]), 2 + found[2].count(" ", 0, 3)):
            if at // 2 not in places(found[1]):
                byte = int(found[2][at:at + 2], 16) ^ 0x10
                begin = found.start(2) + at
                yield found[0], text[:begin] + f"{byte:02X}" + text[begin + 2:]


@pytest.mark.parametrize("bus", ["log"], indirect=True)
def test_each_changed_byte_on_a_bus(bus, tmp_path):
    """But for positions, speeds, and raw positions with their check sum."""
    changed = tmp_path / "changed.log"
    turning = {"1BF": range(4), "2BF": range(4), "3BF": range(2), "4BF": range(6)}
    count = 0
    for what, text in changes(bus.read_text(), r"\b(?=.*$)(1BF|2BF|3BF|4BF|5BF|73F)#([0-9A-F]+)$",
                              lambda can_id: turning.get(can_id, ())):
        if "#43046000" in what:
            continue
        changed.write_text(text)
        assert len(differences(changed, "--against", "f3668", "--node", NODE)) == 1, (what, text)
        count += 1
    assert count > 50


def test_each_changed_byte_on_a_line(lines, tmp_path):
    """Of a position, too: then its check sum is wrong."""
    changed = tmp_path / "changed.txt"
    count = 0
    for what, text in changes((lines / "line.txt").read_text(), r"^\S+ (>) ([0-9A-F ]+)$", lambda _: ()):
        changed.write_text(text)
        assert differences(changed, "--against", MULTITURN), (what, text)
        count += 1
    assert count > 50


REQUEST, REPLY = "40 42 02", "40 42 00 01 E2 40 A1"
SERIAL = f"""# a drive asks for the position
9600 8E1
0.000000 < {REQUEST}
0.008000 > {REPLY}
0.100000 < {REQUEST}
0.108000 > {REPLY}
"""


def test_a_serial_log(tmp_path):
    log = tmp_path / "line.txt"
    log.write_text(SERIAL)
    ended = explain(log)
    assert (ended.returncode, ended.stderr) == (0, "drehgeber: 4 messages\n")
    assert ended.stdout.splitlines()[1] == "0.008000 > 40h -> 42h position 123456  [5.1.2.1]"
    assert differences(log, "--against", MULTITURN) == []


def test_a_changed_byte_on_a_line(tmp_path):
    """The check sum is wrong, so that it is no position any more: the model tells the same with a right one."""
    log = tmp_path / "line.txt"
    log.write_text(SERIAL.replace(REPLY, REPLY[:-2] + "A0", 1))
    (found,) = differences(log, "--against", MULTITURN)
    assert found.splitlines() == [
        "0.000000 < 40h 42h read position  [5.1.2.1]",
        "  came:  40 42 00 01 E2 40 A0  40h -> 42h position 123456, check sum wrong",
        "  model: 40 42 00 01 E2 40 A1  40h -> 42h position 123456",
    ]


def test_a_position_that_the_model_cannot_have(tmp_path):
    log = tmp_path / "line.txt"
    log.write_text(SERIAL.replace(REPLY, "40 42 FF 01 E2 40 5E"))
    found = differences(log, "--against", MULTITURN)
    assert len(found) == 2 and all("came:  40 42 FF" in block for block in found)


def test_another_address_on_a_line(tmp_path):
    log = tmp_path / "line.txt"
    log.write_text(SERIAL)
    assert differences(log, "--against", MULTITURN, "--address", "0x41") == []
    log.write_text(SERIAL.replace(REQUEST, "41 42 03").replace(REPLY, "41 42 00 01 E2 40 A0"))
    assert differences(log, "--against", MULTITURN, "--address", "0x41") == []
    log.write_text(log.read_text().replace("A0", "A1", 1))
    assert len(differences(log, "--against", MULTITURN, "--address", "0x41")) == 1


@pytest.mark.parametrize("model", SETTINGS)
def test_a_changed_bit_on_a_clocked_line(frames, tmp_path, model):
    """Pulses of the data line are left out, one after the other, until some were more than another position."""
    lines = frames[model].read_text().splitlines(keepends=True)
    data = signal(lines, "SLO|DATA")
    found = []
    for first, second in zip(places := [at for at, text in enumerate(lines) if text[1:] == data + "\n"], places[1:]):
        changed = tmp_path / "changed.vcd"
        changed.write_text("".join(text for at, text in enumerate(lines) if at not in (first, second)))
        found += differences(changed, "--against", model, *SETTINGS[model])
        if len(found) > 2:
            break
    assert found and all(re.search(r"\n  came: ( [0-9A-F]{2})+\n  model:( [0-9A-F]{2})+$", block) for block in found)


def test_a_frame_that_was_not_recorded_is_one_difference(frames, tmp_path):
    """The life counter is another one from then on."""
    text = frames["s3684-biss"].read_text()
    at = [found.start() for found in re.finditer(r"^#\d+$", text, re.M)]
    times = [int(found[1]) for found in re.finditer(r"^#(\d+)$", text, re.M)]
    begins = [i for i in range(2, len(at)) if times[i] - times[i - 1] > 1000]  # 10 us of silence
    cut = tmp_path / "cut.vcd"
    cut.write_text(text[:at[begins[3]]] + text[at[begins[4]]:])
    assert len(differences(cut, "--against", "s3684-biss")) == 1


def signal(lines, names) -> str:
    """What a VCD file calls a signal."""
    (name,) = re.findall(rf"^\$var wire 1 (\S) (?:{names}) \$end$", "".join(lines), re.M)
    return name


# --- forms of recordings

COMPACT = "(1436509052.249713) vcan0 0BF#00100000\n(1436509053.249713) vcan0 73F#7F\n"
TERMINAL = {
    "plain": "  vcan0  73F   [1]  7F\n",
    "time": " (1436509052.249713)  vcan0  73F   [1]  7F\n",
    "direction": "  vcan0  RX - -  73F   [1]  7F\n",
    "characters": "  vcan0  73F   [1]  7F                          '.'\n",
    "compact": "(1436509052.249713) vcan0 73F#7F R\n",
}


@pytest.mark.parametrize("form", TERMINAL)
def test_forms_of_candump(tmp_path, form):
    log = tmp_path / "can.log"
    log.write_text(TERMINAL[form])
    assert explain(log).stdout == "0.000000 > heartbeat node 63 pre-operational  [CiA 301 7.2.8]\n"


def test_frames_that_no_encoder_has_are_counted(tmp_path):
    log = tmp_path / "can.log"
    log.write_text("(1.0) can0 18FF1234#00\n(1.0) can0 123##100\n(1.0) can1 73F#7F\n" + COMPACT.replace("vcan0", "can0"))
    ended = explain(log)
    assert ended.returncode == 0
    assert ended.stderr.splitlines()[1] == ("drehgeber: 3 frames are left out: extended, of errors, CAN FD or of "
                                            "another wire")
    assert len(ended.stdout.splitlines()) == 2


def test_remote_frames(tmp_path):
    log = tmp_path / "can.log"
    log.write_text("(1.0) can0 1BF#R\n  can0  1BF   [4]  remote request\n")
    assert explain(log).stdout.count("< TPDO1 node 63 requested") == 2


FORGED = [
    ("no recording", "?\n", 0, "not a known kind of recording"),
    ("no frame", "(1.0) can0 123#0\n", 15, "expected bytes of two hexadecimal digits"),
    ("too long", "(1.0) can0 123#" + "00" * 9 + "\n", 31, "expected 8 bytes at most"),
    ("no id", COMPACT + "(1.0) can0 12#00\n", len(COMPACT) + 11, "expected a CAN-ID"),
    ("a high id", "(1.0) can0 900#00\n", 11, "expected a CAN-ID of 000 to 7FF"),
    ("no time", "(x) can0 123#00\n", 0, "expected a time"),
    ("zero", "(1.0) can0 123#0\0\n", 16, "expected text"),
    ("no end", "(1.0) can0 " + "1" * 9000, 0, "expected lines of less than 4096 characters"),
    ("fewer bytes", "  can0  123   [2]  00\n", 21, "expected as many bytes as the length says"),
    ("no direction", "0.0 = 40\n", 4, "expected < to the encoder, > from it"),
    ("no byte", "0.0 < 4\n", 6, "expected two hexadecimal digits"),
    ("no line", "9600 7E1\n", 5, "expected 8E1, 8O1 or 8N1"),
    ("no rate", "96 8E1\n", 0, "expected 100 to 10000000"),
    ("no wire", "$enddefinitions $end\n", 20, "expected signals request and reply"),
    ("no header", "$var wire 1\n", 12, "expected $var TYPE WIDTH ID NAME $end"),
]
VCD = "$timescale 1 us $end\n$var wire 1 m MA $end\n$var wire 1 s SLO $end\n$enddefinitions $end\n"
FORGED += [
    ("time goes back", VCD + "#5\n0m\n#4\n", len(VCD) + 6, "expected a later time"),
    ("no change", VCD + "#5\n?m\n", len(VCD) + 3, "expected #TIME, 0ID, 1ID"),
    ("a short change", VCD + "#5\nb01", len(VCD) + 6, "expected the ID of a signal"),
]


@pytest.mark.parametrize("text, offset, right", [row[1:] for row in FORGED], ids=[row[0] for row in FORGED])
def test_a_forged_file_is_told_with_its_place(tmp_path, text, offset, right):
    path = tmp_path / "forged"
    path.write_bytes(text.encode())
    ended = explain(path)
    assert ended.returncode == 1
    (told,) = ended.stderr.splitlines()
    assert told.startswith(f"drehgeber: {path}:{offset}: ") and right in told, told


@pytest.mark.parametrize("bus", ["pcapng"], indirect=True)
def test_a_pcapng_that_is_cut_off(bus, tmp_path):
    whole = bus.read_bytes()
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(whole[:-10])
    ended = explain(cut)
    assert ended.returncode == 1
    assert re.fullmatch(rf"drehgeber: {re.escape(str(cut))}:\d+: .*; expected a whole packet\n", ended.stderr)


def test_a_pcap_of_another_link(tmp_path):
    path = tmp_path / "lan.pcap"
    path.write_bytes(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
    ended = explain(path)
    assert (ended.returncode, ended.stderr) == (
        1, f"drehgeber: {path}:0: packets of link type 1; expected 227, SocketCAN\n")


METADATA = "[device 1]\ncapturefile=logic-1\nsamplerate=1 MHz\nprobe1=MA\nprobe2=SLO\nunitsize=1\n"
SESSIONS = {
    "no metadata": ({"version": "2"}, "expected a member 'metadata'"),
    "no wire": ({"metadata": METADATA.replace("SLO", "D7")}, "expected signals request and reply"),
    "no rate": ({"metadata": METADATA.replace("1 MHz", "1 Mhz")}, "expected capturefile, samplerate"),
    "no unit": ({"metadata": METADATA.replace("unitsize=1", "unitsize=9")}, "unitsize of 1 to 8"),
    "a high probe": ({"metadata": METADATA.replace("probe2", "probe9")}, "expected probes that fit the unitsize"),
    "long metadata": ({"metadata": METADATA + "#" * 16384}, "expected less than 16384 characters"),
}


def write_session(path, members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


@pytest.mark.parametrize("members, right", SESSIONS.values(), ids=SESSIONS)
def test_a_forged_session_is_told(tmp_path, members, right):
    path = write_session(tmp_path / "forged.sr", members)
    ended = explain(path)
    assert ended.returncode == 1
    assert re.fullmatch(rf"drehgeber: {re.escape(str(path))}:0: .*; .*{right}.*\n", ended.stderr), ended.stderr


def test_a_session_whose_samples_are_damaged(tmp_path):
    samples = bytes(at // 7 % 4 for at in range(4096))
    path = write_session(tmp_path / "damaged.sr", {"metadata": METADATA, "logic-1-1": samples, "logic-1-2": samples})
    assert explain(path).returncode == 0
    text = path.read_bytes()
    middle = text.index(b"logic-1-2") + 9
    path.write_bytes(text[:middle] + bytes(byte ^ 0xFF for byte in text[middle:middle + 8]) + text[middle + 8:])
    ended = explain(path)
    assert ended.returncode == 1
    assert re.fullmatch(r"drehgeber: \S+:0: samples that cannot be unpacked, in sample \d+; expected a whole member\n",
                        ended.stderr)


def test_a_session_whose_metadata_is_damaged(tmp_path):
    path = write_session(tmp_path / "damaged.sr", {"metadata": METADATA})
    text = path.read_bytes()
    begin = text.index(b"metadata") + len("metadata")
    path.write_bytes(text[:begin] + b"\xFF" * 8 + text[begin + 8:])  # no kind of block of deflate
    ended = explain(path)
    assert (ended.returncode, ended.stderr) == (
        1, f"drehgeber: {path}:0: metadata that cannot be read, in sample 0; expected less than 16384 characters\n")


def test_a_zip_file_with_a_large_directory_is_not_read(tmp_path):
    path = write_session(tmp_path / "large.sr", {"metadata": METADATA})
    path.write_bytes(path.read_bytes()[:-10] + struct.pack("<IIH", 2 << 20, 0, 0))
    ended = explain(path)
    assert ended.returncode == 1 and "expected a directory of up to a megabyte" in ended.stderr


# --- the command line

@pytest.mark.parametrize("arguments, told", [
    ([], "explain needs a recording"),
    (["{log}", "--against", "f36"], "--against f36: no such model; valid:"),
    (["{log}", "--against", MULTITURN], "has CAN frames, s3684-rs485 has characters on its wire"),
    (["{log}", "--against", "f3668", "--node", "200"], "--node 200: no node of f3668"),
    (["{log}", "--against", "f3668", "--set", "baud=1"], "--set baud=1: no setting of this model"),
    (["{log}", "--shaft", "1RPM"], "explain takes no option --shaft"),
])
def test_refusals(tmp_path, arguments, told):
    log = tmp_path / "can.log"
    log.write_text(COMPACT)
    ended = explain(*[argument.format(log=log) for argument in arguments])
    assert (ended.returncode, ended.stdout) == (2, "")
    assert told in ended.stderr and len(ended.stderr.splitlines()) == 1, ended.stderr


def test_a_file_that_is_not_there(tmp_path):
    ended = explain(tmp_path / "none.log")
    assert (ended.returncode, len(ended.stderr.splitlines())) == (1, 1)


# --- memory

def peak_kb(path) -> int:
    """The most memory that explain has had for a file."""
    with subprocess.Popen([PROGRAM, "explain", path, "--against", "f3668", "--node", str(NODE)],
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        _, _, used = os.wait4(process.pid, 0)
        process.returncode = 0
    return used.ru_maxrss


def test_a_long_recording_needs_no_more_memory_than_a_short_one(tmp_path):
    """Nothing but a second of messages is kept, and lines are bounded: a hundred times the file, the same memory."""
    text = "".join(f"({1 + at / 100:.6f}) can0 {0x73F if at % 100 == 0 else 0x080:03X}#{'7F' if at % 100 == 0 else ''}\n"
                   for at in range(SAMPLES))
    short, long = tmp_path / "short.log", tmp_path / "long.log"
    short.write_text(text[:len(text) // 100].rpartition("\n")[0] + "\n")
    long.write_text(text)
    small, large = peak_kb(short), peak_kb(long)
    assert large - small < 4096, (small, large)
    sanitized = b"__asan_init" in Path(PROGRAM).read_bytes()
    assert sanitized or large < MEMORY_MB * 1024, large
