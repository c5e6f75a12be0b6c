# SPDX-License-Identifier: MIT
"""Shafts of encoders in this process."""

from __future__ import annotations

import re
from collections.abc import Iterable
from decimal import Decimal
from pathlib import Path
from typing import Any

from . import _native
from ._native import EncoderError, RangeError, raw, reason_of, text_of, whole, within
from .clock import SECOND_NS, SECONDS_MAX, Clock

TURN = 1 << 32
MRPM = 1000
# Bytes of a line of a CSV file without its end, as the command has it.
LINE_MAX = 198
DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.A)
# What fits: angles have 64 bits, speeds and gears 32.
DEGREES_MAX = 360 * ((1 << 31) - 1)
RPM_MAX = ((1 << 31) - 1) // MRPM
GEAR_MAX = (1 << 31) - 1


def angle_of(degrees: float | Decimal) -> int:
    return round(within(degrees, -DEGREES_MAX, DEGREES_MAX, "degrees") * TURN / 360)


def mrpm_of(rpm: float) -> int:
    return round(within(rpm, -RPM_MAX, RPM_MAX, "rpm") * MRPM)


def forms() -> str:
    """Words that a motion has."""
    _, lib = _native.load()
    return text_of(lib.dg_motion_forms)


def _lines(path: Path) -> Iterable[tuple[int, str]]:
    """Lines of a file without comments, by number. What has no end within the bound is not read on."""
    with path.open("rb") as file:
        for number, line in enumerate(iter(lambda: file.readline(LINE_MAX + 2), b""), 1):
            if b"\0" in line:
                raise EncoderError(f"{path}:{number}: no text, as it has a NUL; expected lines of text")
            if len(line.removesuffix(b"\n").removesuffix(b"\r")) > LINE_MAX:
                raise EncoderError(f"{path}:{number}: more than {LINE_MAX} characters; expected a shorter line of text")
            text = line.removeprefix(b"\xef\xbb\xbf") if number == 1 else line
            yield number, text.partition(b"#")[0].decode("latin-1")


def read_points(path: Path, line: str = "time_s,angle_deg") -> list[tuple[Decimal, Decimal]]:
    """Points of a file of such lines; a header, empty lines and comments are skipped."""
    points = []
    begun = False
    for number, text in _lines(path):
        cells = [cell.strip(" \t\r\n") for cell in text.split(",")]
        if not "".join(cells):
            continue
        header = not begun and cells[0][:1] not in "+-.0123456789"
        begun = True
        if header:
            continue
        if len(cells) != 2 or not all(DECIMAL.fullmatch(cell) for cell in cells):
            raise EncoderError(f"{path}:{number}: expected {line}")
        points.append((Decimal(cells[0]), Decimal(cells[1])))
    return points


def replay_points(points: Iterable[tuple[float | Decimal, float | Decimal]]) -> tuple[Any, Any]:
    """Straight lines between points (seconds, degrees) as a motion, and what it borrows."""
    ffi, lib = _native.load()
    rows = [{"at": round(within(at, 0, SECONDS_MAX, "seconds") * SECOND_NS), "angle": angle_of(degrees)} for at, degrees in points]
    kept = ffi.new("struct dg_motion_point[]", rows)
    return ffi.new("struct dg_motion *", {"kind": lib.DG_MOTION_REPLAY, "points": kept, "point_count": len(rows)}), kept


class Shaft:
    """A shaft that encoders sit on, or that drives others: `Shaft(clock, "60RPM")`, or geared,
    `Shaft(driver=motor, ratio=(1, 10))`: one turn for ten of the motor. Angles are degrees, speeds rpm,
    positive clockwise."""

    def __init__(
        self,
        clock: Clock | None = None,
        motion: str = "0",
        *,
        driver: Shaft | None = None,
        ratio: tuple[int, int] = (1, 1),
    ) -> None:
        self._ffi, self._lib = _native.load()
        self.clock: Clock = clock or (driver.clock if driver else Clock())
        self._c = self._ffi.new("struct dg_shaft *")
        self._kept: list[Any] = []  # what the library borrows
        self._driver = driver
        self._lib.dg_shaft_init(self._c)
        if driver is not None:
            if driver.clock is not self.clock:
                raise EncoderError("a shaft and what drives it go by the same clock")
            turns, per = (whole(n, -GEAR_MAX, GEAR_MAX, "ratio") for n in ratio)
            sign = -1 if per < 0 else 1
            coupled = self._lib.dg_shaft_couple(self._c, driver._c, sign * turns, sign * per)
            _native.checked(coupled, f"a gear of {turns}:{per}")
        if motion != "0":
            self.play(motion)
            self._c.before = self._c.course  # it was there already: nobody sees a jump

    def _command(self, name: str, what: str, *arguments: Any) -> None:
        with self.clock.lock:
            self.clock._sync()
            result = getattr(self._lib, f"dg_shaft_{name}")(self._c, *arguments)
            if result < 0:
                geared = " (a geared shaft is turned by its driver)" if self._driver else ""
                _native.checked(result, f"{what}{geared}")
            self.clock._touch()

    @property
    def position(self) -> float:
        """Degrees, to six decimals."""
        return round(float(self._lib.dg_shaft_angle(self._c, self.clock._sync())) * 360 / TURN, 6)

    @position.setter
    def position(self, degrees: float) -> None:
        now = self.clock._sync()
        self._command("set_position", f"{degrees} degrees", now, angle_of(degrees))

    @property
    def velocity(self) -> float:
        """rpm; setting it turns at that speed, reached with the acceleration."""
        return float(self._lib.dg_shaft_mrpm(self._c, self.clock._sync())) / MRPM

    @velocity.setter
    def velocity(self, rpm: float) -> None:
        self._command("set_velocity", f"{rpm} rpm", self.clock._sync(), mrpm_of(rpm))

    @property
    def acceleration(self) -> float:
        """rpm per second of commands to come; 0: at once."""
        return float(self._c.mrpm_per_s) / MRPM

    @acceleration.setter
    def acceleration(self, rpm_per_s: float) -> None:
        within(rpm_per_s, 0, RPM_MAX, "rpm/s")
        self._command("set_acceleration", f"{rpm_per_s} rpm/s", mrpm_of(rpm_per_s))

    def move(self, degrees: float, rpm: float = 60, wait: bool = True) -> None:
        """Go to an angle; `wait` until it is there, which lets virtual time pass."""
        now = self.clock._sync()
        self._command("move", f"to {degrees} degrees", now, angle_of(degrees), mrpm_of(rpm))
        if wait:
            with self.clock.lock:
                self.clock._wait_until(self._lib.dg_shaft_settled(self._c))

    def stop(self) -> None:
        """To a standstill, with the acceleration."""
        self.velocity = 0

    def play(self, motion: str) -> None:
        """What --shaft takes: "60RPM", "sine:90DEG,2S", "ramp:3000RPM,1S", "run.csv", ..."""
        if not isinstance(motion, str):
            raise TypeError(f"motion {motion!r}: expected words: {forms()}")
        text, ffi = raw(motion, "motion"), self._ffi
        if self._lib.dg_motion_is_file(text):
            self.replay(read_points(Path(motion)))
            return
        made, wrong = ffi.new("struct dg_motion *"), ffi.new("struct dg_plan_error *")
        if self._lib.dg_motion_read(made, text, wrong) != 0:
            raise RangeError(f"motion {motion!r}: {reason_of(wrong)}", _native.ERR_ARGUMENT)
        self._play(made, motion)

    def replay(self, points: Iterable[tuple[float | Decimal, float | Decimal]]) -> None:
        """Straight lines between points (seconds from now on, degrees)."""
        motion, kept = replay_points(points)
        self._kept.append(kept)
        self._play(motion, "points")

    def _play(self, motion: Any, text: str) -> None:
        self._command("play", f"motion {text!r}", self.clock._sync(), motion)
