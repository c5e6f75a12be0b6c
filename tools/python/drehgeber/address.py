# SPDX-License-Identifier: MIT
"""Encoders as text: MODEL?KEY=VALUE&..., in channels and URLs. MODEL may be a file."""

from __future__ import annotations

from urllib.parse import parse_qsl

from ._native import Medium, models
from .clock import Clock
from .encoder import Encoder
from .model import is_file


def is_model(text: str) -> bool:
    """Whether a model is named, or a file that is one, whatever is behind it."""
    name = text.partition("?")[0]
    return name in models() or is_file(name)


def encoder_of(text: str, clock: Clock, medium: Medium) -> Encoder:
    """Make one with such a wire: `shaft` is a motion, everything else a setting."""
    model, _, query = text.partition("?")
    settings = dict(parse_qsl(query, keep_blank_values=True))
    encoder = Encoder(model, clock=clock, shaft=settings.pop("shaft", "0"), power=False)
    encoder._wire(medium)
    for key, value in settings.items():
        encoder.set(key, value)
    encoder._start()
    return encoder
