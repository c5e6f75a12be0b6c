# SPDX-License-Identifier: MIT
"""Rings of encoders in this process: words of data cycles, and ID cycles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ._native import EncoderError, RangeError, checked, whole
from .wire import make_bus

if TYPE_CHECKING:
    from .encoder import Encoder

WORDS = 2  # of an encoder, at most
SILENT = -14  # DG_HOST_ERR_SILENT
# By enum dg_ring_result.
RESULTS = ("", "a transmission error", "a cycle behind a transmission error", "the ring is interrupted",
           "the ring is not identified")  # fmt: skip


class _Bus:
    """The ring itself, as the library has it."""

    def __init__(self, encoders: Sequence[Encoder]) -> None:
        first = encoders[0]
        self._encoders = tuple(encoders)
        self._ffi, self._lib = ffi, lib = first._ffi, first._lib
        self.words = ffi.new("uint16_t[]", WORDS * len(encoders))  # the IN image
        self._wire = ffi.new("struct dg_bus_words_setup *")
        self._wire.size = ffi.sizeof("struct dg_bus_words_setup")
        self._wire[0].words, self._wire.identifies = len(self.words), True
        setattr(self._wire, "in", self.words)
        self._keep, self._bus = make_bus("words", len(encoders), self._wire, ffi.new("struct dg_bus_ops *"), ffi.NULL)
        for encoder in encoders:
            checked(lib.dg_bus_attach(self._bus, encoder._host, ffi.NULL), f"{encoder.model} in a ring")
        self.state: Any = lib.dg_ring_state(self._bus)
        self._event = ffi.new("struct dg_tap_event *")
        self._event.kind = lib.DG_TAP_WORDS

    def run(self, now: int, out: Any) -> None:
        """A cycle; without `out` an ID cycle. What was done to the encoders since is looked at first."""
        ffi, lib, event = self._ffi, self._lib, self._event
        for place, encoder in enumerate(self._encoders):
            encoder._run(now)
            panel = encoder._panel
            lib.dg_bus_control(self._bus, place, ffi.NULL if panel is None else lib.dg_host_panel_encoder(panel))
            lib.dg_bus_changed(self._bus, place, now)
        event.at = now
        event.words.identify = out is None
        event.words.out, event.words.count = ffi.NULL if out is None else out, self.state.words
        lib.dg_bus_rx(self._bus, event)

    def ids(self) -> tuple[int, ...]:
        return tuple(self._lib.dg_ring_id_word(self._bus, place) for place in range(self.state.reached))


class Ring:
    """The master of a ring: `Ring(encoder)`, or `Ring([first, second])` in the order of the ring, on the same clock.
    A cycle happens now, all at once."""

    def __init__(self, encoders: Encoder | Sequence[Encoder]) -> None:
        several = isinstance(encoders, Sequence)
        members: tuple[Encoder, ...] = tuple(encoders) if isinstance(encoders, Sequence) else (encoders,)
        if not members:
            raise RangeError("a ring without encoders: expected 1 to 512")
        if len(set(map(id, members))) < len(members):
            raise EncoderError("an encoder stands in a ring once")
        self._encoder = encoder = members[0]
        self._event = encoder._ffi.new("struct dg_host_event *")
        self._bus: _Bus | None = None
        if not several:
            encoder._listen(lambda event: encoder._back.append(encoder._ffi.buffer(event.data, event.length)[:]))
        if several:
            if any(one.clock is not encoder.clock for one in members):
                raise EncoderError("encoders of a ring go by the same clock")
            with encoder.clock.lock:
                self._bus = _Bus(members)
            for one in members:
                one._ring = self  # whoever holds an encoder holds what listens to it

    # ------------------------------------------------------------ one alone, by its handle

    def _exchange(self, out: int, flags: int) -> bytes:
        encoder, event = self._encoder, self._event
        with encoder.clock.lock:
            now = encoder.clock._sync()
            if not encoder._lib.dg_host_made(encoder._host):
                checked(encoder._lib.DG_HOST_ERR_STATE, "a cycle")
            event.at, event.id, event.flags, event.length = now, out, flags, 0
            event.kind = encoder._lib.DG_HOST_WORDS
            encoder._back.clear()
            encoder._lib.dg_host_feed(encoder._host, event)
            encoder._run(now)
            if not encoder._back:
                raise EncoderError(f"{encoder.model}: nothing comes back", encoder._lib.DG_HOST_ERR_SILENT)
            return encoder._back[0]

    def _cycle_alone(self, words: Sequence[int]) -> tuple[int, ...]:
        out = 0
        if len(words) > WORDS:
            raise RangeError(f"{len(words)} words: expected 0..{WORDS}")
        for word in words:
            out = out << 16 | whole(word, 0, 0xFFFF, "word")
        back = self._exchange(out, 0)
        return tuple(int.from_bytes(back[i : i + 2], "big") for i in range(0, len(back), 2))

    # ------------------------------------------------------------ several, on their bus

    def _cycle_all(self, bus: _Bus, words: Sequence[int]) -> tuple[int, ...]:
        clock, state = self._encoder.clock, bus.state
        if len(words) not in (0, state.words):
            raise RangeError(f"{len(words)} words: expected 0 or {state.words}")
        out = self._encoder._ffi.new("uint16_t[]", max(1, state.words))
        for i, word in enumerate(words):
            out[i] = whole(word, 0, 0xFFFF, "word")
        with clock.lock:
            now = clock._sync()
            bus.run(now, out)
            if state.result == self._encoder._lib.DG_RING_IDENTIFY and not state.dropped:
                bus.run(now, out)  # its ID cycle was run
            if state.dropped or state.result != 0:
                raise EncoderError(RESULTS[state.result] if not state.dropped else "a cycle was lost", SILENT)
            return tuple(bus.words[i] for i in range(state.words))

    # ------------------------------------------------------------ either

    def cycle(self, words: Sequence[int] = ()) -> tuple[int, ...]:
        """A data cycle: OUT words of 16 bits, those of the first encoder first, of each the high one first; without,
        0. The IN words likewise. Raises EncoderError when it brings nothing."""
        return self._cycle_alone(words) if self._bus is None else self._cycle_all(self._bus, words)

    def identify(self) -> int:
        """An ID cycle: the ID word of the first encoder."""
        if self._bus is None:
            return int.from_bytes(self._exchange(0, self._encoder._lib.DG_HOST_IDENTIFY), "big")
        ids = self.identify_all()
        if not ids:
            raise EncoderError(RESULTS[3], SILENT)
        return ids[0]

    def identify_all(self) -> tuple[int, ...]:
        """An ID cycle: the ID words of those that were reached, in ring order."""
        if self._bus is None:
            return (self.identify(),)
        clock = self._encoder.clock
        with clock.lock:
            self._bus.run(clock._sync(), None)
            if self._bus.state.dropped:
                raise EncoderError("a cycle was lost", SILENT)
            return self._bus.ids()
