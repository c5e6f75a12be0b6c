# SPDX-License-Identifier: MIT
"""The Python package with two protocols that nobody has heard of (tests/strangers), beside an S36."""
import os
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(os.environ["STRANGERS"])
QUARTER = bytes.fromhex("02 00 00 40 00 00 00 00 00 00 42")


@pytest.fixture(scope="module")
def drehgeber():
    """The package from the sources of that tree, on its library."""
    package = TREE / "tools/python"
    subprocess.run([sys.executable, "-B", package / "make_abi.py", TREE / "include/drehgeber", package / "drehgeber/_abi.py"],
                   check=True, timeout=60)
    os.environ["DREHGEBER_LIBRARY"] = str(TREE / "build/release/libdrehgeber.so")
    sys.path.insert(0, str(package))
    import drehgeber as module

    yield module
    sys.path.remove(str(package))


def test_python_has_them(drehgeber):
    encoder = drehgeber.Encoder("eleven-24", shaft="90DEG", slot=0)
    assert encoder.request(b"\x02") == QUARTER
    assert encoder.position == 1 << 22
    assert {setting.name for setting in encoder.settings()} >= {"slot", "reaction_us"}
    with encoder.fault("wire_drop"):
        assert encoder.request(b"\x02") == b""
    with encoder.fault("singleturn_lost"):
        assert encoder.request(b"\x02")[4] == 1
    assert "frames=" in encoder.ask("STAT?")


def test_python_clocks_them(drehgeber):
    encoder = drehgeber.Encoder("tenbit-low", shaft="90DEG")
    bits = []
    for _ in range(10):
        encoder.clocked.clock(False)
        encoder.clock.advance(5e-7)
        bits.append(encoder.clocked.clock(True))
        encoder.clock.advance(5e-7)
    assert sum(bit << 9 - i for i, bit in enumerate(bits)) == 256
    with pytest.raises(drehgeber.EncoderError, match="tenbit-low"):
        encoder.clocked.frame()


def test_python_refuses_by_name(drehgeber):
    eleven, tenbit = drehgeber.Encoder("eleven-24"), drehgeber.Encoder("tenbit-low")
    for call, told in ((lambda: tenbit.ssi, "tenbit-low speaks tenbit, not ssi"),
                       (lambda: tenbit.biss, "tenbit-low speaks tenbit, not biss"),
                       (lambda: tenbit.request(b"\x02"), "tenbit-low speaks tenbit: it has no RS485"),
                       (lambda: eleven.can, "eleven-24 speaks eleven: it has no CAN"),
                       (lambda: eleven.ring, "eleven-24 speaks eleven: it has no ring"),
                       (lambda: eleven.sincos(), "eleven-24: sine and cosine"),
                       (lambda: drehgeber.Encoder("tenbit-low", line=eleven.rs485), "tenbit-low has no RS485")):
        with pytest.raises(drehgeber.EncoderError) as error:
            call()
        assert told in str(error.value)


def test_python_has_them_on_one_line_with_an_s36(drehgeber):
    serial = pytest.importorskip("serial")
    line = drehgeber.Line()
    s36 = drehgeber.Encoder("s3684-rs485", line=line, shaft="90DEG", name="s36")
    others = [drehgeber.Encoder("eleven-24", line=line, shaft="90DEG", slot=slot) for slot in (0, 3)]
    with serial.serial_for_url("drehgeber://s36", 2_500_000, timeout=0.01) as port:
        for request in (b"\x02", b"\x1a"):
            port.write(request)
            assert port.read(12) == request + QUARTER[1:10] + bytes([request[0] ^ 0x40])
        s36.clock.advance(0.02)
        port.baudrate, port.parity, port.timeout = 9600, "E", 0.1
        port.write(bytes.fromhex("40 42 02"))
        assert port.read(8) == bytes.fromhex("40 42 00 00 40 00 42")
    assert all("frames=1" in other.ask("STAT?") for other in others)


def test_python_reads_rigs_with_them(drehgeber, tmp_path):
    (tmp_path / "rig.ini").write_text(
        "[shaft main]\nmotion = 90DEG\n[bus line]\nwire = pty\n[encoder s36]\nmodel = s3684-rs485\nbus = line\n"
        "[encoder one]\nmodel = eleven-24\nbus = line\nslot = 3\n[encoder ten]\nmodel = tenbit-low\nwire = sim\n")
    with drehgeber.Rig(tmp_path / "rig.ini") as rig:
        assert rig.encoders["one"].position == 1 << 22
        assert rig.encoders["one"].get("slot") == "3"
        assert rig.encoders["ten"].position == 256
