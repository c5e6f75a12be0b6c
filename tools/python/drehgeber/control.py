# SPDX-License-Identifier: MIT
"""A client of the control plane: SCPI over a socket."""

from __future__ import annotations

import csv
import socket
import threading

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


class Control:
    """A session at unix:PATH or tcp:HOST:PORT, with ,token=FILE behind it where one is asked for.
    Threads may share one: a line is one exchange."""

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
        else:
            raise ValueError(f"{address}: unix:PATH or tcp:HOST:PORT is right")
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
        with self._lock:
            self._socket.sendall(f"{line}\n{MARK}\n".encode("ascii"))
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
