# SPDX-License-Identifier: MIT
"""The C library, loaded when the first encoder is made: what starts rigs of other processes does without."""

from __future__ import annotations

import functools
import os
from pathlib import Path
from typing import Any

NAME = "libdrehgeber.so"


class EncoderError(Exception):
    """An encoder refuses, or there is no such thing; `code` is enum dg_host_result, 0 without one."""

    def __init__(self, text: str, code: int = 0) -> None:
        super().__init__(text)
        self.code = code


def _candidate() -> str:
    """$DREHGEBER_LIBRARY, else the wheel's own, else the system's of this minor version: it is what
    the layouts were taken from."""
    named = os.environ.get("DREHGEBER_LIBRARY")
    if named:
        return named
    own = Path(__file__).with_name(NAME)
    return str(own) if own.exists() else f"{NAME}.{_minor()}"


def _minor() -> str:
    """Of this package: layouts hold for a minor version."""
    from . import __version__

    return ".".join(__version__.split(".")[:2])


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
    version = text.decode()
    if not f"{version}.".startswith(f"{_minor()}."):
        raise EncoderError(f"{path} is of version {version}, and this package needs {_minor()}")
    return ffi, lib


def checked(result: int, about: str) -> int:
    """A result that is no error."""
    if result < 0:
        ffi, lib = load()
        raise EncoderError(f"{about}: {ffi.string(lib.dg_host_result_text(result)).decode()}", result)
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
    sheet = lib.dg_cia406_sheet_of(lib.dg_device_find(model.encode()))
    if sheet == ffi.NULL:
        raise EncoderError(f"{model} is no CANopen model")
    pieces: list[bytes] = []

    @ffi.callback("void(void *, const char *, size_t)")  # type: ignore[untyped-decorator,unused-ignore]
    def write(_: object, text: object, n: int) -> None:
        pieces.append(ffi.buffer(text, n)[:])

    lib.dg_co_eds(sheet, write, ffi.NULL)
    return b"".join(pieces).decode("ascii")
