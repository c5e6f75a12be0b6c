# SPDX-License-Identifier: MIT
"""pyserial's URL of an encoder in this process."""
import time

import drehgeber
import pytest
import serial
from drehgeber import EncoderError

ASK = bytes.fromhex("40 42 02")
URL = "drehgeber://s3684-rs485?shaft=90DEG"
AT_90 = bytes.fromhex("40 42 00 00 40 00 42")


def open_port(url=URL, **options):
    return serial.serial_for_url(url, **{"baudrate": 9600, "parity": "E", "timeout": 0.5, **options})


def test_it_answers_as_on_the_line():
    with open_port() as port:
        assert port.write(ASK) == 3
        assert port.encoder.clock.now == pytest.approx(3 * 11 / 9600, abs=1e-6)
        assert port.in_waiting == 0
        assert port.read(7) == AT_90
        assert port.encoder.clock.now == pytest.approx((3 + 4 + 7) * 11 / 9600 + 0.001, abs=3e-6)


def test_a_reply_arrives_character_by_character():
    with open_port() as port:
        port.write(ASK)
        assert port.read(1) == AT_90[:1]
        assert port.in_waiting == 0
        port.encoder.clock.advance(2.5 * 11 / 9600)
        assert port.in_waiting == 2
        assert port.read(port.in_waiting) == AT_90[1:3]
        port.reset_input_buffer()
        assert port.read(100) == AT_90[3:]


def test_what_has_arrived_is_forgotten():
    """... and what comes later is read."""
    with open_port() as port:
        port.write(ASK)
        port.encoder.clock.advance(1)
        assert port.in_waiting == 7
        port.reset_input_buffer()
        assert port.in_waiting == 0 and port.read(1) == b""
        port.write(ASK)
        assert port.read(7) == AT_90


def test_a_timeout_is_virtual():
    with open_port(timeout=20) as port:
        begin, now = time.monotonic(), port.encoder.clock.now
        assert port.read(1) == b""
        assert port.encoder.clock.now - now == 20 and time.monotonic() - begin < 10
        port.timeout = 0
        assert port.read(1) == b"" and port.encoder.clock.now - now == 20


def test_without_a_timeout_it_waits_for_what_is_there():
    with open_port(timeout=None) as port:
        port.write(ASK)
        assert port.read(7) == AT_90


@pytest.mark.parametrize("options", [{"parity": "N"}, {"parity": "O"}, {"baudrate": 19200}])
def test_another_setting_is_not_understood(options):
    with open_port(**options) as port:
        port.write(ASK)
        assert port.read(7) == b""
        port.parity, port.baudrate = "E", 9600
        port.write(ASK)
        assert port.read(7) == AT_90


def test_in_real_time_a_reply_arrives_by_itself():
    """... whether or not somebody reads."""
    with open_port(URL + "&time=real") as port:
        port.write(ASK)
        end = time.monotonic() + 5
        while port.in_waiting < 7 and time.monotonic() < end:
            time.sleep(0.001)
        assert port.in_waiting == 7 and port.read(7) == AT_90


def test_real_time_takes_its_time():
    with open_port(URL + "&time=real", timeout=5) as port:
        begin = time.monotonic()
        port.write(ASK)
        assert port.read(7) == AT_90
        assert 0.016 < time.monotonic() - begin < 5


def test_a_port_is_opened_again():
    port = open_port(do_not_open=True)
    assert not port.is_open
    port.open()
    port.encoder.shaft.position = 180
    port.close()
    for act in (lambda: port.write(ASK), lambda: port.read(1), lambda: port.in_waiting):
        with pytest.raises(serial.PortNotOpenError):
            act()
    port.open()
    port.write(ASK)
    assert port.read(7)[3:5] == b"\0\x80"
    with pytest.raises(serial.SerialException, match="already"):
        port.open()


@pytest.mark.parametrize("url", ["drehgeber://", "drehgeber://s9", URL + "&time=slow"])
def test_addresses_that_are_none(url):
    with pytest.raises(serial.SerialException, match="expected .*time=virtual, or "):
        open_port(url)


@pytest.mark.parametrize("url, why", [("f3668", "f3668 speaks .*: it has no "), ("s3684-rs485?adress=1", "adress")])
def test_encoders_that_are_none(url, why):
    with pytest.raises(EncoderError, match=why):
        open_port(f"drehgeber://{url}")


def test_an_encoder_that_is_there_already():
    clock = drehgeber.Clock()
    shaft = drehgeber.Shaft(clock, "90DEG")
    motor = drehgeber.Encoder("s3684-rs485", shaft=shaft, name="motor")
    other = drehgeber.Encoder("f3668", shaft=shaft)
    with open_port("drehgeber://motor") as port:
        assert port.encoder is motor
        port.write(ASK)
        assert port.read(7) == AT_90
        assert other.position == 16384 and clock.now > 0.016
    for name in ("motor", "f3668"):
        with pytest.raises(EncoderError, match=f"'{name}' already"):
            drehgeber.Encoder("s3684-rs485", name=name)
    held = drehgeber.Encoder("f3668", name="held")
    with pytest.raises(EncoderError, match="speaks canopen"):
        open_port("drehgeber://held")
    assert held.name == "held"


def test_long_requests():
    """More than an event has room for; the encoder refuses it, and hears the next one."""
    with open_port() as port:
        port.write(bytes(40))
        port.read(100)
        port.write(ASK)
        assert port.read(7) == AT_90


@pytest.mark.parametrize("line", ["cts", "dsr", "cd", "ri"])
def test_a_closed_port_has_no_lines(line):
    with open_port() as port:
        pass
    with pytest.raises(serial.PortNotOpenError):
        getattr(port, line)


def test_lines_of_a_modem_and_a_break():
    with open_port() as port:
        port.rts = port.dtr = False
        assert (port.cts, port.dsr, port.cd, port.ri) == (True, True, True, False)
        port.break_condition = True
        port.break_condition = False
        port.encoder.clock.advance(0.1)  # what the break was part of is over
        port.write(ASK)
        assert port.read(7) == AT_90


def test_much_is_written_piece_by_piece():
    """Each piece in its time; what comes behind is understood."""
    with open_port() as port:
        began = port.encoder.clock.now
        assert port.write(bytes(100_000)) == 100_000
        assert port.encoder.clock.now - began == pytest.approx(100_000 * 11 / 9600, rel=1e-5)
        port.encoder.clock.advance(0.1)
        port.reset_input_buffer()
        port.write(ASK)
        assert port.read(7) == AT_90
        assert len(port.encoder.request(ASK * 1000)) > 0
        port.encoder.clock.advance(0.1)
        assert port.encoder.request(ASK) == AT_90
