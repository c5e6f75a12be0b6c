# SPDX-License-Identifier: MIT
"""Lines of a rig file: sections, and words with the line that each stands in. It takes and refuses lines as the
drehgeber command does; the standard library's configparser knows no lines, and takes others."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from ._native import EncoderError, RangeError

BLANKS = " \t\r\n\v\f"
LINE_MAX = 198  # bytes
SECTIONS = "[rig], [shaft NAME], [bus NAME] and [encoder NAME] are right"
NAME = re.compile(r"[A-Za-z0-9_-]{1,32}")
COMMENT = re.compile(r"[ \t\r\v\f];.*")
# The keys that a kind has of its own; those with True take others, too.
KEYS = {
    "rig": ({"name", "control", "files"}, False),
    "shaft": ({"motion", "driver", "ratio"}, False),
    "bus": ({"wire", "address", "trace"}, True),
    "encoder": ({"model", "shaft", "bus", "wire", "trace", "node", "address", "nvm", "serial"}, True),
}
REPEATED = ("rig", "control")

T = TypeVar("T")


class Word(NamedTuple):
    value: str
    line: int


class Section:
    """What stands below one line in brackets."""

    def __init__(self, source: str, line: int, kind: str, name: str) -> None:
        self.source, self.line, self.kind, self.name = source, line, kind, name
        self.words: dict[str, Word] = {}

    def __contains__(self, key: str) -> bool:
        return key in self.words

    def get(self, key: str) -> str | None:
        word = self.words.get(key)
        return None if word is None else word.value

    def named(self, name: str) -> Section:
        """The same words under another name."""
        copy = Section(self.source, self.line, self.kind, name)
        copy.words = dict(self.words)
        return copy

    def put(self, key: str, value: str) -> None:
        """Another value in the line of the one before."""
        self.words[key] = Word(value, self.words[key].line)

    def wrong(self, text: str, key: str | None = None, code: int = 0) -> EncoderError:
        """What is wrong with a word, or without a key with all of it."""
        line = self.line if key is None or key not in self.words else self.words[key].line
        title = f"{self.kind} {self.name}".rstrip()
        return EncoderError(f"{self.source}:{line}: [{title}]: {text}", code)

    def told(self, key: str | None, make: Callable[[], T]) -> T:
        """What `make` makes of a word; its error says where that stands."""
        try:
            return make()
        except EncoderError as error:
            raise self.wrong(str(error), key, error.code) from None

    def _add(self, key: str, value: str, line: int) -> None:
        if key in self.words and (self.kind, key) != REPEATED:
            before = self.words[key].line
            self.words[key] = Word(value, line)
            raise self.wrong(f"{key} already exists, in line {before}; one of them is right", key)
        self.words[key] = Word(value, line)
        known, others = KEYS[self.kind]
        if key not in known and not others:
            raise self.wrong(f"{key}: right is one of {', '.join(sorted(known))}", key)
        if key in known and not value:
            raise self.wrong(f"{key} is empty; {key} = VALUE is right", key)


def sections(source: str, data: bytes) -> list[Section]:
    """All of a file, in its order."""
    found: list[Section] = []
    for number, raw in enumerate(data.removeprefix(b"\xef\xbb\xbf").split(b"\n"), 1):
        if len(raw) > LINE_MAX or b"\0" in raw:
            raise EncoderError(f"{source}:{number}: more than {LINE_MAX} characters, or no text at all")
        where = f"{source}:{number}"
        try:
            line = raw.decode("utf-8").strip(BLANKS)
        except UnicodeDecodeError as error:
            raise RangeError(f"{where}: byte {error.start + 1} is no UTF-8: expected text in UTF-8") from None
        if line.startswith("["):
            found.append(_begun(source, number, line))
        elif line and line[0] not in ";#":
            _take(where, number, line, found)
    return found


def _begun(source: str, number: int, line: str) -> Section:
    inside, bracket, behind = line[1:].partition("]")
    kind, *names = inside.split() or [""]
    if not bracket or behind.strip(BLANKS)[:1] not in ("", ";", "#"):
        text = "[KIND NAME] on a line of its own is right"
    elif kind not in KEYS:
        text = SECTIONS
    elif kind == "rig" and names:
        text = "[rig] is right"
    elif kind != "rig" and (len(names) != 1 or not NAME.fullmatch(names[0])):
        text = f"a name of 1 to 32 letters, digits, _ and - is right, as in [{kind} a1]"
    else:
        return Section(source, number, kind, "".join(names))
    raise EncoderError(f"{source}:{number}: {line.partition(']')[0]}]: {text}")


def _take(where: str, number: int, line: str, found: list[Section]) -> None:
    key, sign, value = re.fullmatch(r"([^=:]*)([=:]?)(.*)", COMMENT.sub("", line), re.S).groups()  # type: ignore[union-attr]
    if not sign or not key.strip(BLANKS):
        raise EncoderError(f"{where}: {line[:40]!r}: [SECTION] or KEY = VALUE is right")
    if not found:
        raise EncoderError(f"{where}: no section so far; {SECTIONS}")
    found[-1]._add(key.strip(BLANKS), value.strip(BLANKS), number)
