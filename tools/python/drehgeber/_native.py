# SPDX-License-Identifier: MIT
"""The C library, loaded when the first encoder is made: what starts rigs of other processes does without."""

from __future__ import annotations

import enum
import functools
import numbers
import operator
import os
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, SupportsFloat, SupportsIndex, Union

NAME = "libdrehgeber.so"
ERR_ARGUMENT = -1
ERR_WIRE = -10


class Medium(enum.IntEnum):
    """What travels on the wire of an encoder: enum dg_host_medium."""

    CHARACTERS = 0
    FRAMES = 1
    EDGES = 2
    WORDS = 3


WIRES = {Medium.CHARACTERS: "RS485", Medium.FRAMES: "CAN", Medium.EDGES: "clocked line", Medium.WORDS: "ring"}


class EncoderError(Exception):
    """An encoder refuses, or there is no such thing; `code` is enum dg_host_result, 0 without one."""

    def __init__(self, text: str, code: int = 0) -> None:
        super().__init__(text)
        self.code = code


class RangeError(EncoderError, ValueError):
    """A value that cannot be; nothing has happened."""


Number = Union[float, Decimal, Fraction]


def _plain(value: SupportsFloat, what: str) -> Number:
    """A number of Python's own: those of others, e.g. numpy's, may have few bits and overflow."""
    if isinstance(value, (int, float, Decimal, Fraction)):
        return value
    if isinstance(value, numbers.Integral):
        return operator.index(value)
    if isinstance(value, SupportsFloat):
        return float(value)
    raise TypeError(f"{what} {value!r}: expected a number")


def within(value: SupportsFloat, low: float, high: float, what: str) -> Number:
    """A number from `low` to `high`, before it is multiplied or rounded: neither NaN nor a text."""
    number = _plain(value, what)
    undecided = isinstance(number, Decimal) and number.is_nan()  # which does not compare
    if undecided or not low <= number <= high:
        raise RangeError(f"{what} {number}: expected {low:.12g}..{high:.12g}", ERR_ARGUMENT)
    return number


def whole(value: SupportsIndex | SupportsFloat, low: int, high: int, what: str) -> int:
    """A whole number from `low` to `high`; a float is none, whatever its value."""
    if type(value) is int and low <= value <= high:
        return value
    if isinstance(value, SupportsIndex):
        return int(within(operator.index(value), low, high, what))
    within(value, low, high, what)
    raise TypeError(f"{what} {value!r}: expected a whole number")


def encoded(text: str, what: str, encoding: str = "utf-8") -> bytes:
    """A text for the library, which ends at a NUL."""
    return _terminated(text, what, encoding, "strict")


def raw(text: str, what: str) -> bytes:
    """The same of one that came from bytes, whatever they were."""
    return _terminated(text, what, "utf-8", "surrogateescape")


def _terminated(text: str, what: str, encoding: str, errors: str) -> bytes:
    if not isinstance(text, str):
        raise TypeError(f"{what} {text!r}: expected a text")
    try:
        data = text.encode(encoding, errors)
    except UnicodeEncodeError as error:
        raise RangeError(f"{what} {text!r}: expected {encoding.upper()}", ERR_ARGUMENT) from error
    if b"\0" in data:
        raise RangeError(f"{what} {text!r}: expected a text without NUL", ERR_ARGUMENT)
    return data


def text_of(pointer: Any) -> str:
    """A text of the library; what is no UTF-8 becomes the same bytes again by raw()."""
    ffi, _ = load()
    data: bytes = ffi.string(pointer)
    return data.decode("utf-8", "surrogateescape")


def reason_of(wrong: Any) -> str:
    """What a struct dg_plan_error says: what was wrong, what would be right."""
    return "; ".join(filter(None, (text_of(wrong.what), text_of(wrong.right))))


def octets(data: Any, what: str) -> bytes:
    """The bytes of whatever has some."""
    try:
        return memoryview(data).tobytes()
    except TypeError:
        raise TypeError(f"{what} {data!r}: expected bytes") from None


def _candidate() -> str:
    """$DREHGEBER_LIBRARY, else the wheel's own, else the system's of this major version."""
    from . import __version__

    named = os.environ.get("DREHGEBER_LIBRARY")
    if named:
        return named
    own = Path(__file__).with_name(NAME)
    return str(own) if own.exists() else f"{NAME}.{__version__.partition('.')[0]}"


def _check_version(path: str, version: str) -> None:
    """Layouts hold for a major version, and a later minor version has all that an earlier one has. A folder of sources
    has no version: it takes the library that it is told to take."""
    from . import __version__

    theirs, own = ([int(part) for part in text.split(".")[:2]] for text in (version, __version__))
    if own != [0] and (theirs[0] != own[0] or theirs < own):
        needed = f"{own[0]}.{own[1]} or a later {own[0]}.x"
        raise EncoderError(f"{path} is of version {version}, and this package needs {needed}")


@functools.cache
def load() -> tuple[Any, Any]:
    """cffi's view of types, and the library."""
    try:
        from ._abi import ffi
    except ImportError as error:
        raise EncoderError(
            f"encoders in this process need the installed package ({error}): pip install drehgeber, "
            "or ./tools/python of a clone"
        ) from error
    path = _candidate()
    try:
        lib: Any = ffi.dlopen(path)
    except OSError as error:
        raise EncoderError(str(error)) from error
    text: Any = ffi.string(lib.dg_version())
    _check_version(path, text.decode())
    return ffi, lib


def checked(result: int, about: str) -> int:
    """A result that is no error."""
    if result < 0:
        ffi, lib = load()
        kind = RangeError if result == ERR_ARGUMENT else EncoderError
        raise kind(f"{about}: {ffi.string(lib.dg_host_result_text(result)).decode()}", result)
    return result


def aligned(size: int) -> tuple[Any, Any]:
    """Memory for a handle: what keeps it, and where it begins."""
    ffi, _ = load()
    keep = ffi.new("uint8_t[]", size + 16)
    start = int(ffi.cast("uintptr_t", keep))
    return keep, keep + (-start % 16)


def models() -> list[str]:
    """The names of all models."""
    ffi, lib = load()
    found: list[str] = []
    while (name := lib.dg_host_name(len(found))) != ffi.NULL:
        found.append(ffi.string(name).decode())
    return found


def eds(model: str) -> str:
    """The EDS file (CiA 306) of a CANopen model, as `drehgeber eds` prints it."""
    ffi, lib = load()
    sheet = lib.dg_cia406_sheet_of(lib.dg_device_find(encoded(model, "model")))
    if sheet == ffi.NULL:
        raise EncoderError(f"{model} is no CANopen model")
    pieces: list[bytes] = []

    @ffi.callback("void(void *, const char *, size_t)")  # type: ignore[untyped-decorator,unused-ignore]
    def write(_: object, text: object, n: int) -> None:
        pieces.append(ffi.buffer(text, n)[:])

    lib.dg_co_eds(sheet, write, ffi.NULL)
    return b"".join(pieces).decode("ascii")
