# SPDX-License-Identifier: MIT
"""pyserial: serial.serial_for_url("drehgeber://MODEL?shaft=60RPM"), known once drehgeber is imported."""

from __future__ import annotations

from typing import Any

import serial

from ._native import Medium
from .address import encoder_of, is_model
from .clock import Clock
from .encoder import Encoder

SCHEME = "drehgeber://"
FORMS = f"expected {SCHEME}s3684-rs485?shaft=60RPM&time=virtual, or {SCHEME}NAME of a drehgeber.Encoder"


class Serial(serial.SerialBase):
    """The line of an RS485 encoder in this process, made here or before: `encoder` is it. `time=real` goes by the machine's
    clock; virtual time, as usual, moves by what is written, in the timeout of read(), and by
    `encoder.clock.advance()`. Another data rate or parity than the encoder's is a damaged line."""

    encoder: Encoder
    # Of the base class, as pyserial's own handlers use them.
    _port: str | None
    _timeout: float | None
    _baudrate: int
    _parity: str
    _break_state: bool

    def open(self) -> None:
        """Make the encoder; a port that is opened again has the same one."""
        if self._port is None:
            raise serial.SerialException(f"no address: {FORMS}")
        if self.is_open:
            raise serial.SerialException("it is open already")
        if not hasattr(self, "encoder"):
            self.encoder = self._make(str(self._port))
        self._line = self.encoder.rs485
        self.is_open = True

    @staticmethod
    def _make(url: str) -> Encoder:
        text = url[len(SCHEME) :] if url.lower().startswith(SCHEME) else url
        named = Encoder.named(text)
        if named is not None:
            return named
        model, _, query = text.partition("?")
        words = query.split("&") if query else []
        time = [word.partition("=")[2] for word in words if word.startswith("time=")]
        if time not in ([], ["real"], ["virtual"]) or not is_model(text):
            raise serial.SerialException(f"{url}: {FORMS}")
        rest = "&".join(word for word in words if not word.startswith("time="))
        return encoder_of(f"{model}?{rest}", Clock(real=time == ["real"]), Medium.CHARACTERS)

    def close(self) -> None:
        """Nobody listens."""
        self.is_open = False

    def _reconfigure_port(self) -> None:
        """The setting counts when something is written."""

    def _update_rts_state(self) -> None:
        """The line goes its own way."""

    def _update_dtr_state(self) -> None:
        """Nobody looks."""

    def _update_break_state(self) -> None:
        """A damaged 00h, however long it lasts."""
        self._check_open()
        if self._break_state:
            with self.encoder.clock.lock:
                self.encoder.clock._wait_until(self._line._send(b"\0", self._baudrate, self._parity, damaged=True))

    @property
    def cts(self) -> bool:
        """As all lines of a modem, always on."""
        self._check_open()
        return True

    @property
    def dsr(self) -> bool:
        """Always on."""
        self._check_open()
        return True

    @property
    def cd(self) -> bool:
        """Always on."""
        self._check_open()
        return True

    @property
    def ri(self) -> bool:
        """Nobody calls."""
        self._check_open()
        return False

    def _check_open(self) -> None:
        if not self.is_open:
            raise serial.PortNotOpenError()

    @property
    def in_waiting(self) -> int:
        """Characters that have arrived by now."""
        self._check_open()
        with self.encoder.clock.lock:
            self.encoder.clock._sync()
            return len(self._line._arrived)

    def read(self, size: int = 1) -> bytes:
        """As many characters, or fewer when the timeout is over; time goes on to the last one."""
        self._check_open()
        clock = self.encoder.clock
        with clock.lock:
            start = clock._sync()
            limit = 1 << 62 if self._timeout is None else clock._ahead(start, self._timeout, "timeout")
            got = self._line._heard(size)
            while len(got) < size and clock._ns < limit and self._line._until_said(limit):
                got += self._line._heard(size - len(got))
            return got

    def write(self, b: Any, /) -> int | None:
        """Characters one behind the other; time goes on to the end of them."""
        self._check_open()
        data = bytes(b)
        with self.encoder.clock.lock:
            end = self._line._send(data, self._baudrate, self._parity)
            self.encoder.clock._wait_until(end)
        return len(data)

    def flush(self) -> None:
        """What was written is on the line already."""
        self._check_open()

    def reset_input_buffer(self) -> None:
        """Forget what has arrived by now."""
        self._check_open()
        with self.encoder.clock.lock:
            self.encoder.clock._sync()
            self._line._arrived.clear()

    def reset_output_buffer(self) -> None:
        """Nothing waits."""
        self._check_open()

    @property
    def out_waiting(self) -> int:
        """Characters that are not on the line yet."""
        return 0
