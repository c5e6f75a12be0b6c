# SPDX-License-Identifier: MIT
"""A client of the control plane: SCPI over a socket, or over the serial line of a board."""

from __future__ import annotations

import csv
import os
import socket
import threading
from typing import Literal, TextIO

from ._native import encoded

# Asked behind each line: whether the line has an answer depends on its success, so this says where
# its answer ends, and brings the errors.
MARK = "SYSTem:VERSion?;VERSion?;VERSion?;ERRor:ALL?"
MARKED = "1999.0;1999.0;1999.0;"


class ScpiError(Exception):
    """What the instrument has put into its error queue: `code` and `text` of the first entry."""

    def __init__(self, code: int, text: str, command: str) -> None:
        super().__init__(f"{command!r}: {code}, {text}")
        self.code = code
        self.text = text


def split(answer: str | None) -> list[str]:
    """The parts of an answer; strings without their quotes."""
    return next(csv.reader([answer])) if answer else []


class _Serial:
    """A serial line at 115200 Bd 8N1, with what of a socket is used here."""

    def __init__(self, path: str, timeout: float) -> None:
        import termios  # not everywhere
        import tty

        self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
        try:
            tty.setraw(self._fd)
            line = termios.tcgetattr(self._fd)
            line[2] = line[2] & ~(termios.CSTOPB | termios.CRTSCTS) | termios.CLOCAL | termios.CREAD
            line[4] = line[5] = termios.B115200
            line[6][termios.VMIN] = 0
            line[6][termios.VTIME] = min(max(round(timeout * 10), 1), 255)
            termios.tcsetattr(self._fd, termios.TCSAFLUSH, line)
        except BaseException:
            os.close(self._fd)
            raise

    def sendall(self, data: bytes) -> None:
        """All of it."""
        while data:
            data = data[os.write(self._fd, data):]

    def makefile(self, mode: Literal["r"], encoding: str, newline: str) -> TextIO:
        """What comes in, as a file."""
        return open(self._fd, mode, encoding=encoding, newline=newline, closefd=False)

    def close(self) -> None:
        """Give it back."""
        os.close(self._fd)


class Control:
    """A session at unix:PATH or tcp:HOST:PORT, with ,token=FILE behind it where one is asked for, or at
    tty:PATH, the console of a board. Threads may share one: a line is one exchange."""

    _socket: socket.socket | _Serial
    _lines: TextIO

    def __init__(self, address: str, timeout: float = 10.0) -> None:
        address, _, token = address.partition(",token=")
        kind, _, where = address.partition(":")
        if kind == "unix":
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._socket.settimeout(timeout)
            self._socket.connect(where)
        elif kind == "tcp":
            host, _, port = where.rpartition(":")
            self._socket = socket.create_connection((host.strip("[]"), int(port)), timeout)
        elif kind == "tty":
            self._socket = _Serial(where, timeout)
        else:
            raise ValueError(f"{address}: expected unix:PATH, tcp:HOST:PORT or tty:PATH")
        if token:
            with open(token, encoding="ascii") as file:
                secret = file.read().strip()
            self._socket.sendall(f'SYST:TOK "{secret}"\n'.encode("ascii"))
        self._lines = self._socket.makefile("r", encoding="ascii", newline="\n")
        self._lock = threading.Lock()

    def close(self) -> None:
        """End the session."""
        self._lines.close()
        self._socket.close()

    def _read_line(self) -> str:
        line = self._lines.readline()
        if not line.endswith("\n"):
            raise ConnectionError("the control connection was closed")
        return line.rstrip("\r\n")

    def ask(self, line: str) -> str | None:
        """Send a line; its answer as text, None when it has none. Raises ScpiError."""
        data = encoded(line, "a line", "ascii") + f"\n{MARK}\n".encode("ascii")
        with self._lock:
            self._socket.sendall(data)
            lines = [self._read_line()]
            while not lines[-1].startswith(MARKED):
                lines.append(self._read_line())
        code, text, *_ = split(lines.pop()[len(MARKED):])
        if int(code) != 0:
            raise ScpiError(int(code), text, line)
        return lines[0] if lines else None

    def parts(self, line: str) -> list[str]:
        """The parts of the answer to a query."""
        return split(self.ask(line))
