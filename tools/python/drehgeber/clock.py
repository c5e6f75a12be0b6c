# SPDX-License-Identifier: MIT
"""Time of encoders in this process."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Protocol

from ._native import within

if TYPE_CHECKING:
    from .course import Course

SECOND_NS = 1_000_000_000
# The library's time at 0 of ours: encoders that are made with power have had it for that long.
LEAD_NS = SECOND_NS
NEVER = (1 << 64) - 1
# Seconds that a clock may go: 285 years.
SECONDS_MAX = 9_000_000_000


class Member(Protocol):
    """What a clock moves on."""

    def _run(self, until_ns: int) -> None: ...

    def _next(self) -> int: ...

    def _touch(self) -> None: ...


class Clock:
    """Virtual time: it stands still until it is moved on, by advance() or by an exchange that takes
    its time on the wire. With `real` it is the machine's, and nobody moves it.

    Several encoders, shafts and buses may share one; threads may, too."""

    def __init__(self, *, real: bool = False) -> None:
        self.real = real
        self.lock = threading.RLock()
        self.changed = threading.Condition(self.lock)  # somebody was sent something
        self._ns = LEAD_NS
        self._origin = time.monotonic_ns() - LEAD_NS
        self._members: list[Member] = []
        self._courses: list[Course] = []

    @property
    def now(self) -> float:
        """Seconds since the clock was made."""
        return (self._sync() - LEAD_NS) / SECOND_NS

    def advance(self, seconds: float) -> None:
        """Let virtual time pass: whatever is due happens at its own moment."""
        if self.real:
            raise ValueError("real time passes by itself")
        with self.lock:
            self._go(self._ahead(self._ns, seconds, "seconds"))

    def _sync(self) -> int:
        """The present in the library's nanoseconds; everything that was due has happened."""
        if self.real:
            with self.lock:
                self._go(max(self._ns, time.monotonic_ns() - self._origin))
        return self._ns

    @staticmethod
    def _ahead(from_ns: int, seconds: float, what: str) -> int:
        """So long after a moment, as long as the clock goes."""
        left = SECONDS_MAX - from_ns // SECOND_NS
        return from_ns + round(within(seconds, 0, max(0, left), what) * SECOND_NS)

    def _go(self, until_ns: int) -> None:
        while self._courses and (due := min(course._due for course in self._courses)) <= until_ns:
            self._move(max(due, self._ns))
            for course in [course for course in self._courses if course._due <= due]:
                course._serve(self._ns)
            self._courses = [course for course in self._courses if course._due != NEVER]
        self._move(until_ns)

    def _move(self, until_ns: int) -> None:
        for member in self._members:
            member._run(until_ns)
        self._ns = until_ns

    def _has_only(self, member: Member) -> bool:
        """Whether virtual time moves this one and nothing else."""
        return not self.real and not self._courses and len(self._members) == 1 and self._members[0] is member

    def _wait_until(self, at_ns: int) -> None:
        """The lock is held. Virtual time jumps there, real time passes; others may go on."""
        if not self.real:
            self._go(max(at_ns, self._ns))
            return
        while (now := self._sync()) < at_ns:
            self._sleep((at_ns - now) / SECOND_NS, min(member._next() for member in self._members))

    def _sleep(self, seconds: float | None, due_ns: int) -> None:
        """The lock is held. Let others go on for that long, or until somebody was sent something, or,
        in real time, until something is due at `due_ns`."""
        if self.real and due_ns != NEVER:
            left = max(0, due_ns - self._ns) / SECOND_NS
            seconds = left if seconds is None else min(seconds, left)
        self.changed.wait(seconds)

    @staticmethod
    def _monotonic() -> float:
        return time.monotonic()

    def _touch(self) -> None:
        """Physics have changed: who sits on it looks at once."""
        for member in self._members:
            member._touch()

    def _ns_of(self, seconds: float) -> int:
        return LEAD_NS + round(within(seconds, -LEAD_NS // SECOND_NS, SECONDS_MAX, "a moment") * SECOND_NS)


def seconds_of(at_ns: int) -> float:
    """A moment of the library as Clock.now has it."""
    return (at_ns - LEAD_NS) / SECOND_NS
