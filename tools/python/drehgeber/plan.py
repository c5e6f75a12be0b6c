# SPDX-License-Identifier: MIT
"""Rig files as every host reads them: the library's reader, include/drehgeber/rig.h."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from ._native import EncoderError, aligned, load, raw, reason_of, text_of

MEMORY_MIN, MEMORY_EACH = 16384, 16  # bytes to begin with, and behind each byte of a file
LINKS = (errno.ELOOP, errno.ENOTDIR)
FILES_MAX = 4096  # characters of the names of files that include each other

# Words that name other files.
FILES = re.compile(rb"include|\.eds|\.dcf", re.I)


def read_below(folder: Path, name: str, most: int) -> bytes:
    """A regular file below the folder, with no link on the way there: of more than `most` bytes the rest is left."""
    at = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        for part in PurePosixPath(os.path.normpath(name)).parts:
            below = os.open(part, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=at)
            os.close(at)
            at = below
        if not stat.S_ISREG(os.fstat(at).st_mode):
            raise OSError(errno.EINVAL, "expected a regular file")
        with open(at, "rb", closefd=False) as file:
            return file.read(most)
    finally:
        os.close(at)


class Plan:
    """What is in a rig file. Its rows are those of struct dg_plan, at `rows`."""

    def __init__(self, source: str, data: bytes, folder: Path) -> None:
        self._ffi, self._lib = ffi, lib = load()
        self.folder = folder
        self._keep: list[Any] = []  # what the reader was given, and may be asked for later
        self.rows: Any = ffi.new("struct dg_plan *")
        setup, wrong = ffi.new("struct dg_plan_setup *"), ffi.new("struct dg_plan_error *")
        setup.size, setup.file = ffi.sizeof("struct dg_plan_setup"), self._kept(os.fsencode(source))
        setup.text.text, setup.text.n = self._kept(data), len(data)
        if FILES.search(data):  # a call back needs memory that may be written and executed
            include = ffi.callback("const char *(void *, const char *, struct dg_plan_text *)", self._include)
            setup.include = include
        size, result = MEMORY_MIN + MEMORY_EACH * len(data), lib.DG_ERR_SPACE
        while result == lib.DG_ERR_SPACE:
            self._memory, setup.memory = aligned(size)
            setup.memory_size = size
            result = lib.dg_plan_read(self.rows, setup, wrong)
            size *= 2
        self.require(result == 0, wrong)
        self.name = text_of(self.rows.name)

    def _kept(self, data: bytes) -> Any:
        self._keep.append(self._ffi.new("char[]", data))
        return self._keep[-1]

    def _include(self, _: Any, path: Any, to: Any) -> Any:
        """Of a file that is too long, so much that the reader says so."""
        name = text_of(path)
        try:
            data = read_below(self.folder, name, self._lib.DG_PLAN_INCLUDED_MAX + 1)
        except OSError as error:
            linked = error.errno in LINKS
            why = "not in the folder for files; expected a name below it" if linked else error.strerror
            return self._kept(raw(f"{name}: {why}", "a name"))
        to.text, to.n = self._kept(data), len(data)
        return self._ffi.NULL

    def word(self, pointer: Any) -> str | None:
        """None: it is not there."""
        return None if pointer == self._ffi.NULL else text_of(pointer)

    def each(self, kind: str) -> Iterator[Any]:
        """All rows of shafts, wires or encoders."""
        rows = getattr(self.rows, f"{kind}s")
        return (rows[index] for index in range(getattr(self.rows, f"{kind}_count")))

    # ------------------------------------------------------------ where things stand

    def file(self, name: str, line: int) -> Path:
        """One that a word in this line names."""
        place = self._lib.dg_plan_place(self.rows, line)
        folder: bytes = self._ffi.string(place.file, place.folder)
        return self.folder / folder.decode("utf-8", "surrogateescape") / name

    def _place(self, line: int) -> str:
        to = self._ffi.new("char[]", FILES_MAX)
        text = self._ffi.new("struct dg_text *", {"to": to, "size": FILES_MAX})
        self._lib.dg_plan_say_files(self.rows, line, text)
        return f"{text_of(to)}:{self._lib.dg_plan_place(self.rows, line).line}"

    @contextlib.contextmanager
    def told(self, section: str, line: int) -> Iterator[None]:
        """What is wrong in the block is told with the place of a word."""
        try:
            yield
        except EncoderError as error:
            raise EncoderError(f"{self._place(line)}: [{section}]: {error}", error.code) from None

    def require(self, right: bool, wrong: Any) -> None:
        """Else FILE:LINE: KEY: what; right"""
        if right:
            return
        key, value = text_of(wrong.key), text_of(wrong.value)
        file = text_of(wrong.included) or self.word(wrong.file)
        place = f"{file}:{wrong.line}: " if file and wrong.line else ""
        between = "=" if wrong.valued == self._lib.DG_PLAN_SETTING else " "
        about = f"{key}{f'{between}{value}' if wrong.valued else ''}: " if key else ""
        raise EncoderError(f"{place}{about}{reason_of(wrong)}")
