# SPDX-License-Identifier: MIT
"""Courses of what an encoder in this process senses: an LED that ages, a housing that warms."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from . import _native
from ._native import EncoderError, raw, reason_of
from .clock import NEVER, Clock


def is_file(text: str) -> bool:
    """Whether a setting is meant for a course."""
    _, lib = _native.load()
    return bool(lib.dg_course_is(raw(text, "a course")))


def split_words(text: str) -> tuple[str, bool, bool]:
    """The file that a setting names, whether it loops, whether it goes in steps."""
    ffi, lib = _native.load()
    said, wrong, data = ffi.new("struct dg_course_words *"), ffi.new("struct dg_plan_error *"), raw(text, "a course")
    if lib.dg_course_read(data, said, wrong) != 0:
        raise EncoderError(reason_of(wrong))
    return data[: said.name].decode("utf-8", "surrogateescape"), said.loop, said.steps


class Course:
    """Points (nanoseconds from now on, counts) that the library goes along: include/drehgeber/course.h."""

    def __init__(
        self, clock: Clock, points: Iterable[tuple[int, int]], put: Callable[[int], None], *, loop: bool, steps: bool
    ) -> None:
        ffi, self._lib = _native.load()
        rows = list(points)
        self._points = ffi.new("struct dg_course_point[]", rows)  # the library borrows them
        members = {"points": self._points, "count": len(rows), "loop": loop, "steps": steps}
        self._c: Any = ffi.new("struct dg_course *", members)
        if self._lib.dg_course_check(self._c) != 0:
            raise EncoderError("a course needs points that go on in time; a loop needs one behind 0")
        self._value = ffi.new("int32_t *")
        self._put = put
        self._start = self._due = clock._ns

    def _serve(self, now: int) -> None:
        """At its deadline."""
        since = now - self._start
        if self._lib.dg_course_at(self._c, since, self._value):
            self._put(int(self._value[0]))
        behind = int(self._lib.dg_course_next(self._c, since))
        self._due = NEVER if behind == NEVER else self._start + behind
