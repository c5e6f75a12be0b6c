# SPDX-License-Identifier: MIT
"""Courses of what an encoder in this process senses: an LED that ages, a housing that warms."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from . import _native
from ._native import EncoderError
from .clock import NEVER, Clock


class Course:
    """Points (nanoseconds from now on, counts) that the library goes along: include/drehgeber/course.h. Without `put` an
    encoder's panel does."""

    def __init__(
        self, clock: Clock, points: Iterable[tuple[int, int]], put: Callable[[int], None] | None, *, loop: bool, steps: bool
    ) -> None:
        ffi, self._lib = _native.load()
        rows = list(points)
        self._points = ffi.new("struct dg_course_point[]", rows)  # the library borrows them
        members = {"points": self._points, "count": len(rows), "loop": loop, "steps": steps}
        self._of_rig: Any = ffi.new("struct dg_rig_course *", {"course": members})
        self._c: Any = ffi.addressof(self._of_rig.course)
        if self._lib.dg_course_check(self._c) != 0:
            raise EncoderError("a course needs points that go on in time; a loop needs one behind 0")
        self._value = ffi.new("int32_t *")
        self._put = put
        self._start = self._due = clock._ns

    def _serve(self, now: int) -> None:
        """At its deadline."""
        since = now - self._start
        if self._put is not None and self._lib.dg_course_at(self._c, since, self._value):
            self._put(int(self._value[0]))
        behind = int(self._lib.dg_course_next(self._c, since))
        self._due = NEVER if behind == NEVER else self._start + behind
