# SPDX-License-Identifier: MIT
"""What encoders of this process and of a running rig have in common: SCPI, faults, state."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any, Literal, TypeVar, overload

from ._native import whole, within
from .clock import SECONDS_MAX
from .control import split

Self = TypeVar("Self", bound="Instrument")
# Values of STATe? in hexadecimal, and lists, whose items are codes.
HEXADECIMAL = frozenset({"address", "causes", "last_command", "locks", "word"})
LISTS = frozenset({"courses", "errors", "leds", "shared_ids"})
COUNT_MAX = (1 << 32) - 1  # frames that a fault may last


def value_of(key: str, text: str) -> int | str | None:
    """A value of STATe?."""
    if text == "-":
        return None
    if key in LISTS:
        return text
    try:
        return int(text, 16 if key in HEXADECIMAL else 10)
    except ValueError:
        return text


def power_word(state: object) -> str:
    """What POWer is told."""
    if state == "CYCLE":
        return "CYCLE"
    if not isinstance(state, int):
        raise TypeError(f'power {state!r}: expected True, False or "CYCLE"')
    return "ON" if whole(state, 0, 1, "power") else "OFF"


class Instrument:
    """An encoder that understands lines of SCPI."""

    def ask(self, line: str) -> str | None:
        """An SCPI line to this encoder; its answer, None when it has none. Raises ScpiError."""
        raise NotImplementedError

    def parts(self, line: str) -> list[str]:
        """The parts of the answer to a query."""
        return split(self.ask(line))

    @overload
    def state(self, raw: Literal[False] = False) -> dict[str, Any]: ...
    @overload
    def state(self, raw: Literal[True]) -> dict[str, str]: ...
    def state(self, raw: bool = False) -> dict[str, Any]:
        """STATe? as a dictionary: numbers as int, what there is not at the moment as None, words and lists of
        codes (`errors`, `leds`, `courses`, `shared_ids`) as str. With `raw` all of it as str."""
        found: dict[str, Any] = {}
        for part in self.parts("STAT?"):
            key, _, value = part.partition("=")
            found[key] = value if raw else value_of(key, value)
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
        if count is not None:
            line += f",COUN {whole(count, 1, COUNT_MAX, 'count')}"
        if probability is not None:
            line += f",PROB {float(within(probability, 0, 1, 'probability')):.15g}"
        if duration_ms is not None:
            line += f",DUR {float(within(duration_ms, 1e-6, SECONDS_MAX * 1000, 'duration_ms')):.15g} MS"
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
