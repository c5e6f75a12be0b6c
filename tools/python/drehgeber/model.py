# SPDX-License-Identifier: MIT
"""Models: those of the library, and those of files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple, Union

from ._native import EncoderError, aligned, encoded, load, models, raw, text_of
from .plan import MEMORY_EACH, MEMORY_MIN, Plan

ENDING = ".ini"  # of files with [model NAME]
Word = Union[str, "os.PathLike[str]"]


class Model(NamedTuple):
    """A struct dg_device, and what it lies in, which lasts as long as encoders have it. It may have a handle already."""

    device: Any
    keep: Any
    handle: Any = None

    @property
    def name(self) -> str:
        return text_of(self.device.name)


def is_file(name: str) -> bool:
    """Whether a name is that of a file, as no built-in model's is."""
    ffi, lib = load()
    return name.lower().endswith(ENDING) or bool(lib.dg_model_file_of(raw(name, "model")) != ffi.NULL)


def find_model(word: Word) -> Model:
    """What a name stands for: a built-in model, an EDS or DCF file, or a file with [model NAME], of which the last one counts."""
    name = os.fspath(word) if isinstance(word, (str, os.PathLike)) else None
    if not isinstance(name, str):
        raise TypeError(f"model {word!r}: expected a text, or the path of a file")
    ffi, lib = load()
    device = lib.dg_device_find(encoded(name, "model"))
    if device != ffi.NULL:
        return Model(device, None)
    if lib.dg_model_file_of(encoded(name, "model")) != ffi.NULL:
        return _made_of(Path(name))
    if name.lower().endswith(ENDING):
        return _last_of(Path(name))
    raise EncoderError(f"no model {name!r}; there are {', '.join(models())}, or FILE.eds, FILE.dcf, MODELS.ini")


def _read(path: Path, most: int) -> bytes:
    """Of a file that is too long, so much that its reader says so."""
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise EncoderError(f"{path}: {error.strerror}") from None


def _last_of(path: Path) -> Model:
    """A file of nothing but models stands for the last one of them; one with encoders is a rig."""
    plan = Plan(str(path), _read(path, -1), path.parent)
    if plan.rows.encoder_count > 0:
        raise EncoderError(f"{path}: a rig file is no model; expected Rig({str(path)!r})")
    return Model(plan.rows.models[plan.rows.model_count - 1].device, plan)


def _made_of(path: Path) -> Model:
    """A file that is a model: what is made of its text."""
    ffi, lib = load()
    file = lib.dg_model_file_of(raw(str(path), "model"))
    data = _read(path, lib.DG_PLAN_INCLUDED_MAX + 1)
    source, made, flaw = (ffi.new(f"struct dg_model_{name} *") for name in ("source", "made", "flaw"))
    text = ffi.from_buffer("char[]", data)
    source.text, source.n = text, len(data)
    size, result = MEMORY_MIN + MEMORY_EACH * len(data), lib.DG_ERR_SPACE
    while result == lib.DG_ERR_SPACE:
        keep, source.memory = aligned(size)
        source.memory_size = size
        result = file.read(source, made, flaw)
        size *= 2
    if result != 0:
        what, right = text_of(flaw.what), text_of(flaw.right)
        place = f"{path}:{flaw.line}" if flaw.line else str(path)
        raise EncoderError(f"{place}: {what}{f'; expected {right}' if right else ''}")
    return Model(made.device, keep)
