# SPDX-License-Identifier: MIT
"""The BiSS encoder behind its simulated wire: what `drehgeber biss` and `run --sim` show, and the trace."""
import re

import pytest

from rig import run, run_refused

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


def test_user_bank_survives(nvm):
    biss(S3684, "write", "7:3", "A55A", "--nvm", nvm)
    assert biss(S3684, "registers", "7:2", "4", "--nvm", nvm) == "FF A5 5A FF\n"


def test_refusals():
    assert "--sim" in run_refused(2, "run", S3674, "--pty")
    assert run_refused(2, "biss", "f3668", "read")


def crc6(bits: str) -> int:
    value = 0
    for bit in bits:
        value = (value << 1 & 0x3F) ^ (0x03 if (value >> 5 & 1) != int(bit) else 0)
    return value


def frames(trace: str):
    """The levels of SLO after each rising edge of MA, frame by frame; the timeout raises SLO."""
    mapped = {"m": "1", "s": "1"}
    now, edge, bits = 0, 0, ""
    for line in trace.splitlines():
        if line.startswith("#"):
            now = int(line[1:])
        if not re.fullmatch(r"[01][ms]", line) or line[0] == mapped[line[1]]:
            continue
        over = now - edge > 10000
        if over and bits:
            yield bits + mapped["s"]
            bits = ""
        elif line[1] == "m" and line[0] == "0":
            bits += mapped["s"]
        if line[1] == "m":
            edge = now
        mapped[line[1]] = line[0]


def test_trace_is_refused(tmp_path):
    assert ".vcd" in run_refused(1, "biss", S3674, "read", "--trace", tmp_path / "biss.log")
    assert run_refused(1, "biss", S3674, "read", "--trace", tmp_path / "none" / "biss.vcd")


def test_trace_can_be_read_back(tmp_path):
    trace = tmp_path / "biss.vcd"
    biss(S3674, "read", "registers", "0x78", "2", "--shaft", "90DEG", "--trace", trace)
    text = trace.read_text()
    assert "$timescale" in text and "$enddefinitions" in text
    assert f"sposition_0:{1 << 19}_" in text and "sregister_78h_=_04_00 " in text
    # The level in front of e1 is low before the first frame.
    decoded = [bits[1:] for bits in frames(text) if "01" in bits[1:]]
    assert decoded
    for bits in decoded:
        data = bits[bits.index("01") + 3:]  # behind Ack, start bit and CDS
        position, rest, crc = data[:21], data[21:29], data[29:35]
        assert int(position, 2) == 1 << 19
        assert int(crc, 2) == crc6(position + rest) ^ 0x3F
