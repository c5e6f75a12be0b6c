# SPDX-License-Identifier: MIT
"""Rig files as every host reads them: the library's reader, include/drehgeber/rig.h."""

from __future__ import annotations

import errno
import functools
import os
import re
import stat
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple, TypeVar

from ._native import EncoderError, aligned, load, raw, reason_of, text_of

MEMORY_MIN, MEMORY_EACH = 16384, 16  # bytes to begin with, and behind each byte of a file
LINKS = (errno.ELOOP, errno.ENOTDIR)
FILES_MAX = 4096  # characters of the names of files that include each other

# Words that name other files.
FILES = re.compile(rb"include|\.eds|\.dcf", re.I)

T = TypeVar("T")


class Word(NamedTuple):
    key: str
    value: str
    line: int


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
        if result != 0:
            raise EncoderError(self._refusal(wrong))
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

    def each(self, list: str, count: str) -> Iterator[Any]:
        """All rows of a list."""
        rows = getattr(self.rows, list)
        return (rows[index] for index in range(getattr(self.rows, count)))

    def words(self, settings: Any) -> list[Word]:
        """Settings of an encoder, or of a wire."""
        rows = (settings.list[index] for index in range(settings.count))
        return [Word(text_of(row.key), text_of(row.value), row.line) for row in rows]

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

    def told(self, section: str, line: int, make: Callable[[], T]) -> T:
        """What `make` makes of a word; its error says where that stands."""
        try:
            return make()
        except EncoderError as error:
            raise EncoderError(f"{self._place(line)}: [{section}]: {error}", error.code) from None

    def check_wire(self, section: str, wire: Any) -> None:
        """What a wire's own settings can be, also where nobody makes the wire."""
        for word in self.words(wire.settings):
            self.told(section, word.line, functools.partial(self._check, wire.kind.keys, word))

    def _check(self, keys: Any, word: Word) -> None:
        ffi, lib = self._ffi, self._lib
        row = lib.dg_keys_find(keys, word.key.encode())
        to = ffi.new("uint64_t[]", row.offset // 8 + 1)
        if lib.dg_key_set(row, to, raw(word.value, word.key)) != 0:
            right = f"a number in {row.min}..{row.max} {text_of(row.unit)}".rstrip()
            if row.words != ffi.NULL:
                right = " or ".join(text_of(row.words[index]) for index in range(row.max + 1))
            raise EncoderError(f"{word.key}={word.value}: expected {right}")

    def _refusal(self, wrong: Any) -> str:
        """FILE:LINE: KEY: what; right"""
        key, value = text_of(wrong.key), text_of(wrong.value)
        file = text_of(wrong.included) or self.word(wrong.file)
        place = f"{file}:{wrong.line}: " if file and wrong.line else ""
        about = f"{key}{f' {value}' if wrong.valued else ''}: " if key else ""
        return f"{place}{about}{reason_of(wrong)}"
