# SPDX-License-Identifier: MIT
"""Courses of what an encoder in this process senses: an LED that ages, a housing that warms."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterable

from ._native import EncoderError
from .clock import NEVER, SECOND_NS, Clock

# Between two points the value is set anew this often.
TICK_NS = SECOND_NS // 100


class Course:
    """Straight lines between points (seconds from now on, value); a step is two points at one moment.
    Before the first one the value is what it was, behind the last one it stays."""

    def __init__(self, clock: Clock, points: Iterable[tuple[float, float]], put: Callable[[float], None]) -> None:
        rows = [(clock._ns + round(at * SECOND_NS), float(value)) for at, value in points]
        if not rows or rows != sorted(rows, key=lambda row: row[0]) or rows[0][0] < clock._ns:
            raise EncoderError("points of a course begin at 0 or later, and go on in time")
        self._at = [at for at, _ in rows]
        self._values = [value for _, value in rows]
        self._put = put
        self._due = self._at[0]

    def _value(self, now: int) -> float:
        """The last point of a moment counts."""
        behind = bisect.bisect_right(self._at, now)
        if behind == len(self._at):
            return self._values[-1]
        begin, end = self._at[behind - 1], self._at[behind]
        share = (now - begin) / (end - begin)
        return self._values[behind - 1] + share * (self._values[behind] - self._values[behind - 1])

    def _serve(self, now: int) -> None:
        """At its deadline. Where the value is the same at both points, nothing happens between them."""
        self._put(self._value(now))
        behind = bisect.bisect_right(self._at, now)
        if behind == len(self._at):
            self._due = NEVER
        elif self._values[behind] == self._values[behind - 1]:
            self._due = self._at[behind]
        else:
            self._due = min(now + TICK_NS, self._at[behind])
