# SPDX-License-Identifier: MIT
"""Rig files in this process: all that is in one, on one clock, without its wires."""

from __future__ import annotations

import configparser
from pathlib import Path
from types import TracebackType

from ._native import EncoderError
from .canbus import CanBus
from .clock import Clock
from .course import is_file, split_words
from .encoder import Encoder
from .rs485 import Line
from .shaft import Shaft
from .world import World

# What is about wires that there are none of here, and what the encoder's own line has taken.
OF_WIRES = {"wire", "address", "trace", "pace", "cycle", "tear", "break_at", "clock_hz", "line_delay_ns"}
TAKEN = {"model", "shaft", "bus", "wire", "trace", "nvm"}
KEYS = {"rig": {"name", "control", "files"}, "shaft": {"motion", "driver", "ratio"}, "bus": OF_WIRES}

Section = configparser.SectionProxy


class Rig:
    """A rig file as `drehgeber run` takes it, in virtual time: Rig("bench.ini").advance(1.5).

    Its wires are not made. CANopen encoders of a [bus] share a CanBus, those with RS485 a Line; every other
    encoder has its master for itself. `nvm` files are read, and written by close(). Use it as a context to have that done."""

    def __init__(self, file: str | Path, *, clock: Clock | None = None) -> None:
        path = Path(file)
        self._begin(path.read_text(encoding="utf-8"), path.name, path.parent, clock)

    @classmethod
    def of_text(cls, text: str, folder: str | Path = ".", *, clock: Clock | None = None) -> Rig:
        """A rig of the text of a file in `folder`."""
        rig = cls.__new__(cls)
        rig._begin(text, "text", Path(folder), clock)
        return rig

    def _begin(self, text: str, source: str, folder: Path, clock: Clock | None) -> None:
        self._source, self._folder = source, folder
        self.clock = clock or Clock()
        self.name = Path(source).stem
        self.shafts: dict[str, Shaft] = {}
        self.buses: dict[str, CanBus] = {}
        self.lines: dict[str, Line] = {}
        self.encoders: dict[str, Encoder] = {}
        self._files: dict[str, Path] = {}
        self._wires: set[str] = set()
        parser = configparser.ConfigParser(
            interpolation=None, delimiters=("=",), inline_comment_prefixes=(";",), default_section=""
        )
        try:
            parser.read_string(text, source)
        except configparser.Error as error:
            raise EncoderError(str(error).replace("\n", " ")) from None
        for title in parser.sections():
            self._take(parser[title])
        if not self.encoders:
            raise EncoderError(f"{source}: no encoder; [encoder NAME] with model = MODEL is right")

    def _take(self, section: Section) -> None:
        kind, _, name = section.name.partition(" ")
        name = name.strip().lower()
        take = {"rig": self._rig, "shaft": self._shaft, "bus": self._bus, "encoder": self._encoder}.get(kind)
        if take is None or bool(name) != (kind != "rig"):
            raise EncoderError(
                f"{self._source}: [{section.name}]: [rig], [shaft NAME], [bus NAME] or [encoder NAME] is right"
            )
        known = KEYS.get(kind)
        for key in section if known is not None else ():
            if known is not None and key not in known:
                raise EncoderError(f"{self._where(section)}: {key}: right is one of {', '.join(sorted(known))}")
        try:
            take(name, section)
        except EncoderError as error:
            where = self._where(section)
            text = str(error)
            raise EncoderError(text if text.startswith(where) else f"{where}: {text}", error.code) from None

    def _where(self, section: Section) -> str:
        return f"{self._source}: [{section.name}]"

    def _rig(self, _: str, section: Section) -> None:
        self.name = section.get("name", self.name)

    def _shaft(self, name: str, section: Section) -> None:
        driver, ratio, motion = section.get("driver"), section.get("ratio", "1:1"), section.get("motion")
        if driver is None:
            if motion is not None and motion.lower().endswith(".csv"):
                motion = str(self._folder / motion)
            self.shafts[name] = Shaft(self.clock, motion or "0")
            return
        turns, colon, per = ratio.partition(":")
        if not colon or not all(part.strip().lstrip("+-").isdigit() for part in (turns, per)):
            raise EncoderError(f"ratio = {ratio}: TURNS:TURNS with whole numbers is right")
        self.shafts[name] = Shaft(driver=self._shaft_named(driver), ratio=(int(turns), int(per)))

    def _shaft_named(self, name: str) -> Shaft:
        if name.lower() not in self.shafts:
            raise EncoderError(f"no shaft {name} so far; the NAME of a [shaft] above is right")
        return self.shafts[name.lower()]

    def _bus(self, name: str, section: Section) -> None:
        """Of CAN or RS485; the encoders of others have their masters for themselves."""
        self._wires.add(name)
        kind = section.get("wire", "").partition(":")[0]
        if kind in ("can", "slcan", "socketcand"):
            self.buses[name] = CanBus(clock=self.clock)
        elif kind in ("pty", "tty", "rs485"):
            self.lines[name] = Line(self.clock)

    def _encoder(self, name: str, section: Section) -> None:
        model, bus = section.get("model"), section.get("bus")
        if model is None:
            raise EncoderError("model = MODEL is right")
        if bus is not None and bus.lower() not in self._wires:
            raise EncoderError(f"no bus {bus} so far; the NAME of a [bus] above is right")
        if not self.shafts:
            self.shafts["main"] = Shaft(self.clock)
        shaft = section.get("shaft")
        encoder = Encoder(
            model,
            shaft=next(iter(self.shafts.values())) if shaft is None else self._shaft_named(shaft),
            bus=self.buses.get(bus.lower()) if bus is not None else None,
            line=self.lines.get(bus.lower()) if bus is not None else None,
            power=False,
        )
        courses = {
            key: split_words(section[key]) for key in section if World.senses(key) and is_file(section[key])
        }
        for key in section:
            if key not in TAKEN and key not in courses and (key not in OF_WIRES or self._has(encoder, key)):
                encoder.set(key, section[key])
        if "nvm" in section:
            self._files[name] = self._folder / section["nvm"]
            if self._files[name].exists() and self._files[name].stat().st_size:
                encoder.memory = self._files[name].read_bytes()
        for key, (file, *_) in courses.items():
            encoder.world.begin(key, self._folder / file)
        encoder._start()
        for key, (file, loop, steps) in courses.items():
            encoder.world.play(key, self._folder / file, loop=loop, steps=steps)
        self.encoders[name] = encoder

    @staticmethod
    def _has(encoder: Encoder, key: str) -> bool:
        return key in (setting.name for setting in encoder.settings())

    def advance(self, seconds: float) -> None:
        """Let virtual time pass for the whole rig."""
        self.clock.advance(seconds)

    def close(self) -> None:
        """Write the `nvm` files."""
        for name, path in self._files.items():
            path.write_bytes(self.encoders[name].memory)

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
