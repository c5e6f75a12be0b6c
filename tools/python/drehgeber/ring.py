# SPDX-License-Identifier: MIT
"""INTERBUS of an encoder in this process: its words of a data cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ._native import EncoderError, RangeError, checked, whole

if TYPE_CHECKING:
    from .encoder import Encoder


class Ring:
    """The master of a ring with this encoder in it. A cycle happens now, all at once."""

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder
        self._event = encoder._ffi.new("struct dg_host_event *")
        self._data = encoder._ffi.buffer(self._event.data)

    def _exchange(self, out: int, flags: int) -> bytes:
        encoder, event = self._encoder, self._event
        with encoder.clock.lock:
            now = encoder.clock._sync()
            while encoder._lib.dg_host_receive(encoder._host, event) != 0:
                pass
            event.at, event.id, event.flags, event.length = now, out, flags, 0
            event.kind = encoder._lib.DG_HOST_WORDS
            checked(encoder._lib.dg_host_send(encoder._host, event), "a cycle")
            encoder._run(now)
            if encoder._lib.dg_host_receive(encoder._host, event) != 1:
                raise EncoderError(f"{encoder.model}: nothing comes back", encoder._lib.DG_HOST_ERR_SILENT)
            return bytes(self._data[: event.length])

    def cycle(self, words: Sequence[int] = ()) -> tuple[int, ...]:
        """A data cycle: OUT words of 16 bits, the high one first; without, 0. The IN words."""
        out = 0
        if len(words) > 2:
            raise RangeError(f"{len(words)} words: expected 0..2")
        for word in words:
            out = out << 16 | whole(word, 0, 0xFFFF, "word")
        back = self._exchange(out, 0)
        return tuple(int.from_bytes(back[i : i + 2], "big") for i in range(0, len(back), 2))

    def identify(self) -> int:
        """An ID cycle: the ID word."""
        return int.from_bytes(self._exchange(0, self._encoder._lib.DG_HOST_IDENTIFY), "big")
