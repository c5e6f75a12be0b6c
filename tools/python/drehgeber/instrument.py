# SPDX-License-Identifier: MIT
"""What encoders of this process and of a running rig have in common: SCPI, faults, state."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TypeVar

from .control import split

Self = TypeVar("Self", bound="Instrument")


class Instrument:
    """An encoder that understands lines of SCPI."""

    def ask(self, line: str) -> str | None:
        """An SCPI line to this encoder; its answer, None when it has none. Raises ScpiError."""
        raise NotImplementedError

    def parts(self, line: str) -> list[str]:
        """The parts of the answer to a query."""
        return split(self.ask(line))

    def state(self) -> dict[str, str]:
        """STATe? as a dictionary of strings."""
        found = {}
        for part in self.parts("STAT?"):
            key, _, value = part.partition("=")
            found[key] = value
        return found

    def faults(self) -> list[dict[str, str]]:
        """The catalogue: dictionaries with name, kind, cause, effect and chapter."""
        keys = ("name", "kind", "cause", "effect", "chapter")
        parts = self.parts("FAUL:CAT?")
        return [dict(zip(keys, parts[i : i + 5])) for i in range(0, len(parts), 5)]

    def active_faults(self) -> list[str]:
        """Names of those that last."""
        return [name for name in self.parts("FAUL:ACT?") if name]

    def set_fault(
        self,
        name: str,
        count: int | None = None,
        probability: float | None = None,
        duration_ms: float | None = None,
    ) -> None:
        """Let a fault happen: until it is cleared, `count` times, or as long as it says."""
        line = f"FAUL:SET {name}"
        for word, value, unit in (
            ("COUN", count, ""),
            ("PROB", probability, ""),
            ("DUR", duration_ms, " MS"),
        ):
            if value is not None:
                line += f",{word} {value}{unit}"
        self.ask(line)

    def clear_fault(self, name: str = "") -> None:
        """Clear one fault, or all."""
        self.ask(f"FAUL:CLE {name}".rstrip())

    @contextlib.contextmanager
    def fault(
        self: Self,
        name: str,
        count: int | None = None,
        probability: float | None = None,
        duration_ms: float | None = None,
    ) -> Iterator[Self]:
        """A fault for as long as the block lasts."""
        self.set_fault(name, count, probability, duration_ms)
        try:
            yield self
        finally:
            self.clear_fault(name)
