# SPDX-License-Identifier: MIT
"""The BiSS encoder behind its simulated wire: what `drehgeber biss` and `run --sim` show, and the trace."""
import re
import time

import pytest

from rig import Encoder, run, run_refused

S3674 = "s3674-biss"
S3684 = "s3684-biss"


def biss(*arguments) -> str:
    ended = run("biss", *arguments)
    assert ended.returncode == 0 and ended.stderr == "", ended.stderr
    return ended.stdout


def test_device_id():
    assert biss(S3674, "registers", "0x78", "8") == "04 00 C0 15 00 00 4B 55\n"


def test_position_follows_the_shaft():
    line = biss(S3684, "read", "--shaft", "2.5REV")
    assert re.search(r"\bMT 2\b.*\bST 1048576\b", line) and "CRC valid" in line


@pytest.mark.parametrize("model", [S3674, S3684])
def test_eds_banks_have_valid_check_sums(model):
    for bank in (3, 4):
        values = bytes.fromhex(biss(model, "registers", f"{bank}:0", "64"))
        assert len(values) == 64 and sum(values[:63]) % 256 == values[63]
    assert biss(model, "eds").count("valid") >= 2


@pytest.mark.parametrize("model", [S3674, S3684])
def test_eds_shows_what_the_banks_hold(model):
    """Every field of 5.2.1.3.1 and 5.2.1.3.2 with its bytes."""
    common, profile = biss(model, "eds").split("\n\n")
    fields = re.compile(r"^0x([0-9A-F]{2})  (\w+) +([0-9A-F]+) +(\d+)", re.MULTILINE)
    for bank, text, count in (3, common, 23), (4, profile, 32):
        values = bytes.fromhex(biss(model, "registers", f"{bank}:0", "64"))
        shown = fields.findall(text)
        assert len(shown) == count
        for address, _, digits, _ in shown:
            first = int(address, 16)
            assert values[first:first + len(digits) // 2].hex().upper() == digits
    assert re.search(r"^0x0E  PON_DLY +0064 +100 ms ", common, re.MULTILINE)
    assert re.search(r"^0x02  BP_ID1 +62 +98 ", profile, re.MULTILINE)
    turns = {S3674: r"00000000 +0", S3684: r"00001000 +4096"}[model]
    assert re.search(rf"^0x10  MT_CNT +{turns} turns", profile, re.MULTILINE)


# Address, symbol, bytes, unit: 5.2.1.3.1 and 5.2.1.3.2. "250 ns" is a step of a value.
COMMON = """
00 EDS_VER 1; 01 EDS_LEN 1 banks; 02 USR_STA 1; 03 USR_END 1; 04 TMA 1 ns; 05 TO_MIN 1 250 ns;
06 TO_MAX 1 250 ns; 07 TOS_MIN 1 25 ns; 08 TOS_MAX 1 25 ns; 09 TCLK_MIN 1 25 ns; 0A TCLK_MAX 1 25 ns;
0B TCYC 1 250 ns; 0C TBUSY_S 1 250 ns; 0D BUSY_S 1 TMA; 0E PON_DLY 2 ms; 10 DC_NUM 1; 11 SL_NUM 1;
12 SL_OFF 1; 14 BANK1 1; 15 DLEN1 1 bit; 16 FORMAT1 1; 17 CPOLY1 1; 3F CHKSUM 1
"""
PROFILE = """
00 BP_VER 1; 01 BP_LEN 1 banks; 02 BP_ID1 1; 03 BP_ID2 1 bit; 04 FB1 1; 05 FB2 1; 06 PON_PDL 1 100 ms;
08 EN_TYP 1; 09 POS_NUM 1; 0A MT_LEN 1 bit; 0B MT_FMT 1; 0C CO_LEN 1 bit; 0D CO_FMT 1; 0E FI_LEN 1 bit;
0F FI_FMT 1; 10 MT_CNT 4 turns; 14 SIP_CNT 4; 18 SIP_RES 4 LSB; 1C CPOLY 4; 20 CSTART 4; 24 ABS_ACU 2;
26 REL_ACU 2; 28 SPD_ACU 2; 2A HYST 2; 2C SPD_MAX 2; 2E ACC_MAX 2; 30 TMP_MIN 2; 32 TMP_MAX 2; 34 VLT_MIN 2;
36 VLT_MAX 2; 38 CUR_MAX 2; 3F CHKSUM 1
"""


def test_eds_has_the_manuals_steps_and_units():
    """In columns, whose last one says what a field is."""
    for text, fields in zip(biss(S3684, "eds").split("\n\n"), (COMMON, PROFILE)):
        lines = [line for line in text.splitlines() if line.startswith("0x")]
        for line, field in zip(lines, fields.split(";"), strict=True):
            address, symbol, size, *unit = field.split()
            step = int(unit.pop(0)) if len(unit) == 2 else 1
            digits = line[16:24].strip()
            assert line[:6] == f"0x{address}  "
            assert (line[6:14].strip(), len(digits), line[37:42].split()) == (symbol, 2 * int(size), unit)
            assert int(line[26:36]) == int(digits, 16) * step
            assert re.fullmatch("  [0-9A-Za-z].*", line[42:])


def test_user_bank_survives(nvm):
    biss(S3684, "write", "7:3", "A55A", "--nvm", nvm)
    assert biss(S3684, "registers", "7:2", "4", "--nvm", nvm) == "FF A5 5A FF\n"


def test_refusals():
    assert "--sim" in run_refused(2, "run", S3674, "--pty")
    assert run_refused(2, "biss", "f3668", "read")


@pytest.mark.parametrize("action, said", [
    ("registers", "no address"),
    ("registers x:0 4", "no bank: x"),
    ("registers 256:0 4", "no bank: 256"),
    ("registers 0x80 1", "no address of 0x00..0x7F: 0x80"),
    ("write 7:3", "write needs 1..64 BYTES"),
    ("command", "command needs a number of 0..255"),
    ("command 256", "command needs a number of 0..255"),
    ("fly", "unknown action fly"),
])
def test_an_action_says_what_it_needs(action, said):
    line = run_refused(2, "biss", S3684, *action.split())
    assert said in line and "expected read, registers [BANK:]ADDR N, eds, write [BANK:]ADDR BYTES or command N" in line


def test_a_register_that_is_refused_is_a_failure():
    """Banks end at 31, see the table of the registers."""
    assert "refused" in run_refused(1, "biss", S3684, "registers", "32:0", "4")


@pytest.mark.parametrize("stored, after", [([], "00"), (["command", "1"], "5A")])
def test_commands_store_and_start_anew(stored, after):
    """WMASK, 00h as delivered, is what was stored when command 03 has started the encoder anew; command 01 stores it."""
    reading = ["registers", "0:0x23", "1"]
    said = biss(S3684, "write", "0:0x23", "5A", *reading, *stored, "command", "3", *reading)
    assert said == f"5A\n{after}\n"


def crc6(bits: str) -> int:
    value = 0
    for bit in bits:
        value = (value << 1 & 0x3F) ^ (0x03 if (value >> 5 & 1) != int(bit) else 0)
    return value


def changes(trace: str, signal: str) -> list:
    """(ns, level) of a signal; high in front of the first."""
    now, found = 0, []
    for line in trace.splitlines():
        if line.startswith("#"):
            now = int(line[1:]) * 10
        elif re.fullmatch(rf"[01]{signal}", line) and line[0] != (found[-1][1] if found else "1"):
            found.append((now, line[0]))
    return found


def frames(trace: str, delay_ns: int = 0):
    """The levels of SLO half a period behind each rising edge of MA and the delay there and back,
    frame by frame; those of CDM are left out."""
    ma, slo = changes(trace, "m"), changes(trace, "s")
    half = ma[1][0] - ma[0][0]
    bits, at, level = "", 0, "1"
    for number, (moment, to) in enumerate(ma):
        if number > 0 and moment - ma[number - 1][0] > 10000:
            yield bits
            bits = ""
        elif to == "1":
            while at < len(slo) and slo[at][0] <= moment + delay_ns + half:
                level = slo[at][1]
                at += 1
            bits += level
    yield bits


def test_trace_is_refused(tmp_path):
    assert ".vcd" in run_refused(2, "biss", S3674, "read", "--trace", tmp_path / "biss.log")
    assert run_refused(1, "biss", S3674, "read", "--trace", tmp_path / "none" / "biss.vcd")


def test_trace_can_be_read_back(tmp_path):
    trace = tmp_path / "biss.vcd"
    biss(S3674, "read", "registers", "0x78", "2", "--shaft", "90DEG", "--trace", trace)
    text = trace.read_text()
    assert "$timescale 10 ns $end" in text and "$enddefinitions" in text
    assert f"sposition_0:{1 << 19}_" in text and "sregister_78h_=_04_00 " in text
    assert_positions(text, 1 << 19)


def assert_positions(trace: str, wanted: int, delay_ns: int = 0, width: int = 21) -> int:
    """Each frame has this position, and the check sum that is worked out here."""
    decoded = [bits for bits in frames(trace, delay_ns) if "01" in bits]
    assert decoded
    for bits in decoded:
        data = bits[bits.index("01") + 3:]  # behind Ack, start bit and CDS
        position, rest, crc = data[:width], data[width:width + 8], data[width + 8:width + 14]
        assert int(position, 2) == wanted
        assert int(crc, 2) == crc6(position + rest) ^ 0x3F
    return len(decoded)


CABLE = ["--set", "clock_hz=10000000", "--set", "line_delay_ns=200"]


@pytest.mark.parametrize("timing", [CABLE, ["--set", "clock_hz=50000"],
                                    ["--set", "clock_hz=10000000", "--set", "line_delay_ns=5000"],
                                    ["--set", "line_delay_ns=1000"]])
def test_clock_and_cable(timing):
    """Every position is right, and so are registers."""
    for eighth in range(8):
        said = biss(S3684, "read", "read", "registers", "0x78", "8", "--shaft",
                    f"{360 + 45 * eighth}DEG", *timing)
        lines = said.splitlines()
        assert [line.split()[:4] for line in lines[:2]] == [
            ["MT", "1", "ST", str(eighth << 18)]] * 2
        assert all("CRC valid" in line for line in lines[:2])
        assert lines[2] == "04 00 CC 15 00 00 4B 55"


def test_clock_in_the_trace(tmp_path):
    """Periods of 100 ns, and SLO 400 ns late: what an analyser at the master's end would see."""
    trace = tmp_path / "cable.vcd"
    biss(S3674, *["read"] * 3, "--shaft", "90DEG", "--trace", trace, *CABLE)
    text = trace.read_text()
    assert "_CRC_ok,_line_delay_400_ns" in text
    rising = [at for at, level in changes(text, "m") if level == "1"]
    falls = [at for at, level in changes(text, "s") if level == "0" and at > rising[0]]
    assert rising[1] - rising[0] == 100
    assert falls[0] - rising[1] == 400
    # Low until the first clock, from the first moment of the trace.
    assert changes(text, "s")[:2] == [(0, "0"), (rising[0] + 400, "1")]
    assert assert_positions(text, 1 << 19, delay_ns=400) == 3


def test_trace_begins_with_the_first_edge(tmp_path):
    """Not with the initialisation of 100 ms."""
    trace = tmp_path / "biss.vcd"
    biss(S3674, "read", "--trace", trace)
    assert 0 < changes(trace.read_text(), "m")[0][0] < 5000


def test_cable_of_a_rig(tmp_path):
    rig_file = tmp_path / "rig.ini"
    trace = tmp_path / "rig.vcd"
    rig_file.write_text(f"""
[shaft main]
motion = 90DEG
[bus line]
wire = sim
clock_hz = 10000000
line_delay_ns = 200
trace = {trace}
[encoder a]
model = {S3674}
bus = line
""", encoding="ascii")
    encoder = Encoder([rig_file, "--quiet"])
    time.sleep(1)
    assert encoder.end() == 0
    assert assert_positions(trace.read_text(), 1 << 19, delay_ns=400) > 5


@pytest.mark.parametrize("clock_hz, says", [(384000, "no answer"), (386000, "")])
def test_clock_too_slow_for_the_short_timeout(clock_hz, says):
    """Silence of 1.3 us, as chosen with 7Ch, ends a frame at its first clock."""
    ended = run("biss", S3674, "write", "0x7C", "01", "read", "--set", f"clock_hz={clock_hz}")
    assert ended.returncode == (1 if says else 0)
    assert says in ended.stderr if says else "CRC valid" in ended.stdout


@pytest.mark.parametrize("setting, right", [
    ("clock_hz=49999", "50000..10000000 Hz"), ("clock_hz=10000001", "50000..10000000 Hz"),
    ("line_delay_ns=5001", "0..5000 ns"), ("line_delay_ns=-1", "0..5000 ns"), ("clock_hz", ""),
])
def test_clock_and_cable_out_of_range(setting, right, tmp_path):
    """One text on the command line, in `run`, and in a rig file."""
    text = f"--set {setting}: expected a number in {right}" if right else "clock_hz"
    assert text in run_refused(2, "biss", S3674, "read", "--set", setting)
    assert text in run_refused(2, "run", S3674, "--sim", "--set", setting)
    if right:
        rig_file = tmp_path / "rig.ini"
        rig_file.write_text(f"[encoder a]\nmodel = {S3674}\nwire = sim\n{setting}\n",
                            encoding="ascii")
        assert f"rig.ini:4: {text[len('--set '):]}" in run_refused(2, "run", rig_file)


def test_clock_and_cable_are_of_the_simulated_wire():
    for setting in ("clock_hz=1000000", "line_delay_ns=0"):
        said = run_refused(2, "run", S3674, "--gpio", "gpiochip9:4,5", "--set", setting)
        assert "only a sim wire has it; leave it out" in said
    said = run("--help").stdout
    assert "clock_hz" in said and "line_delay_ns" in said
