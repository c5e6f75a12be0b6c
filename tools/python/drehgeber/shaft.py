# SPDX-License-Identifier: MIT
"""Shafts of encoders in this process."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from decimal import Decimal
from pathlib import Path
from typing import Any

from . import _native
from ._native import EncoderError, whole, within
from .clock import NEVER, SECOND_NS, SECONDS_MAX, Clock

TURN = 1 << 32
FORMS = "0, 90DEG, 2.5REV, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S[,HOLD] or FILE.csv"
MRPM = 1000
# What a unit measures, and what the library counts of it.
UNITS = {
    "DEG": ("angle", TURN / 360),
    "REV": ("angle", TURN),
    "RPM": ("speed", MRPM),
    "MS": ("time", SECOND_NS / 1000),
    "S": ("time", SECOND_NS),
}
# Bytes of a line of a CSV file without its end, as the command has it.
LINE_MAX = 198
DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)", re.A)
QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+))\s*(DEG|REV|RPM|MS|S)\s*", re.A | re.I)


# What fits: angles have 64 bits, speeds and gears 32.
DEGREES_MAX = 360 * ((1 << 31) - 1)
RPM_MAX = ((1 << 31) - 1) // MRPM
GEAR_MAX = (1 << 31) - 1
MOST = {"angle": DEGREES_MAX * TURN / 360, "speed": RPM_MAX * MRPM, "time": SECONDS_MAX * SECOND_NS}


def angle_of(degrees: float | Decimal) -> int:
    return round(within(degrees, -DEGREES_MAX, DEGREES_MAX, "degrees") * TURN / 360)


def mrpm_of(rpm: float) -> int:
    return round(within(rpm, -RPM_MAX, RPM_MAX, "rpm") * MRPM)


def _quantity(text: str, *wanted: str) -> tuple[str, int]:
    match = QUANTITY.fullmatch(text)
    if match is None or UNITS[match[2].upper()][0] not in wanted:
        raise EncoderError(f"motion {text!r}: {' or '.join(wanted)} with its unit is right: {FORMS}")
    dimension, factor = UNITS[match[2].upper()]
    most = MOST[dimension] / factor
    value = float(match[1])
    within(value, 0 if dimension == "time" else -most, most, match[2].upper())
    return dimension, round(value * factor)


def _sine(amplitude: str, period: str) -> dict[str, Any]:
    return {
        "kind": "DG_MOTION_SINE",
        "amplitude": _quantity(amplitude, "angle")[1],
        "period": _quantity(period, "time")[1],
    }


def _ramp(speed: str, accel: str, hold: str | None = None) -> dict[str, Any]:
    return {
        "kind": "DG_MOTION_RAMP",
        "mrpm": _quantity(speed, "speed")[1],
        "accel": _quantity(accel, "time")[1],
        "hold": NEVER if hold is None else _quantity(hold, "time")[1],
    }


def _simple(text: str) -> dict[str, Any]:
    if re.fullmatch(r"\s*[+-]?0+(\.0*)?\s*", text, re.A):
        return {"kind": "DG_MOTION_STANDSTILL"}
    dimension, value = _quantity(text, "angle", "speed")
    if dimension == "angle":
        return {"kind": "DG_MOTION_STANDSTILL", "from": value}
    return {"kind": "DG_MOTION_SPEED", "mrpm": value}


FORMS_OF: dict[str, Callable[..., dict[str, Any]]] = {"sine": _sine, "ramp": _ramp}


def parse_motion(text: str) -> dict[str, Any]:
    """Members of struct dg_motion of words as --shaft takes them, but for files."""
    kind, colon, rest = text.partition(":")
    if not colon:
        return _simple(text)
    try:
        return FORMS_OF[kind.lower()](*rest.split(","))
    except (KeyError, TypeError):
        raise EncoderError(f"motion {text!r}: one of these is right: {FORMS}") from None


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
            raise EncoderError(f"{path}:{number}: {line} is right")
        points.append((Decimal(cells[0]), Decimal(cells[1])))
    return points


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
        self._points: list[Any] = []  # the library borrows them
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
            raise TypeError(f"motion {motion!r}: words are right: {FORMS}")
        if motion.lower().endswith(".csv"):
            self.replay(read_points(Path(motion)))
        else:
            self._play(parse_motion(motion), motion)

    def replay(self, points: Iterable[tuple[float | Decimal, float | Decimal]]) -> None:
        """Straight lines between points (seconds from now on, degrees)."""
        rows = [{"at": round(within(at, 0, SECONDS_MAX, "seconds") * SECOND_NS), "angle": angle_of(degrees)} for at, degrees in points]
        self._points.append(self._ffi.new("struct dg_motion_point[]", rows))
        self._play(
            {"kind": "DG_MOTION_REPLAY", "points": self._points[-1], "point_count": len(rows)}, "points"
        )

    def _play(self, members: dict[str, Any], text: str) -> None:
        kind = getattr(self._lib, members["kind"])
        motion = self._ffi.new("struct dg_motion *", {**members, "kind": kind})
        self._command("play", f"motion {text!r}", self.clock._sync(), motion)
