# SPDX-License-Identifier: MIT
"""BiSS and SSI: the device under test clocks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from cocotb.handle import LogicObject
from cocotb.triggers import Event

from .. import _native
from .._native import EncoderError, checked
from ..shaft import TURN, Shaft
from .biss_line import Access, BissLine, Frame, Layout
from .simulation import (
    LEAD_PS, Delay, News, SimulatedEncoder, drive, level_of, now_ps, ps_of, start,
)  # fmt: skip

LIFE_BITS = 6
HINT_US = 100  # a simulation is short
NEVER = (1 << 64) - 1


class Latch(NamedTuple):
    """A position that the encoder has latched."""

    at_ps: int  # when it was, at the encoder
    position: int  # what it tells the master: multiturn and singleturn, right-aligned, binary
    multiturn: int
    singleturn: int
    degrees: float  # of the shaft, whatever it tells


class ClockedEncoder(SimulatedEncoder):
    """What BiSS and SSI have in common: the master's clock, the encoder's line."""

    def __init__(
        self,
        clock: LogicObject,
        data: LogicObject | None,
        model: str,
        clock_to_output_ns: float,
        settings: dict[str, Any],
        **options: Any,
    ) -> None:
        super().__init__(model, settings=settings, **options)
        output_ps = ps_of(clock_to_output_ns) - self._noise.most_ps
        if output_ps <= 0:
            raise EncoderError(
                f"clock_to_output_ns={clock_to_output_ns}: above 0 and above jitter_ns; an encoder that "
                "answers at once finds no fault of a master's"
            )
        self._pin, self._data = clock, data
        self._at, self._counts = self._ffi.new("uint64_t *"), self._ffi.new("uint64_t *")
        self._latches: News[Latch] = News()
        self._latched_ns = 0
        self._followers: list[Callable[[bool], None]] = []
        self._out = Delay(self._arrive, ps_of(clock_to_output_ns) + self._line_ps, self._noise)
        self._near = Delay(self._follow, ps_of(clock_to_output_ns))
        self._in = Delay(self._clocked, self._line_ps)
        self._sent = self._received = level_of(clock, True)
        self._level = False
        self._settle()
        drive(data, self._level)
        self._watch(clock, self._changed)

    def _settle(self) -> None:
        """It knows the level of the clock, and we know that of its line."""
        now = LEAD_PS + now_ps()
        if self.powered:
            self._level = self._lib.dg_host_clock_ps(self._host, now, self._received) == 1

    def power(self, state: bool | Literal["CYCLE"]) -> None:
        """True, False, or "CYCLE": off and on again."""
        super().power(state)
        if state is not False:
            self._edge(self._received)

    # ------------------------------------------------------------ edges

    def _changed(self) -> None:
        level = level_of(self._pin, self._sent)
        if level != self._sent:
            self._sent = level
            self._in.put(level)

    def _clocked(self, level: bool) -> None:
        self._received = level
        self._edge(level)

    def _edge(self, level: bool) -> None:
        clock = self._clock
        with clock.lock:
            self._serve()
            if not self.powered:
                return
            self._lib.dg_host_clock_ps(self._host, LEAD_PS + now_ps(), level)
            self._encoder._run(clock._ns)
        if self._lib.dg_host_latched(self._host, self._at, self._counts) == 0:
            self._look(int(self._at[0]), int(self._counts[0]))

    def _look(self, at: int, position: int) -> None:
        """It may have latched."""
        if at == self._latched_ns:
            return
        self._latched_ns = at
        mt, st = int(self.get("mt")), int(self.get("st"))
        degrees = float(self._lib.dg_host_angle(self._host, at)) * 360 / TURN
        self._latches.tell(
            Latch(now_ps(), position, position >> st & (1 << mt) - 1, position & (1 << st) - 1, degrees)
        )

    def _said(self, event: Any) -> None:
        self._level = event.data[0] != 0
        self._out.put(self._level)
        if self._followers:
            self._near.put(self._level)

    def _arrive(self, level: bool) -> None:
        drive(self._data, level)

    def _follow(self, level: bool) -> None:
        for follower in self._followers:
            follower(level)

    # ------------------------------------------------------------ looks

    @property
    def latch(self) -> Latch | None:
        """What it latched last; None: nothing yet."""
        return self._latches.latest

    async def latched(self) -> Latch:
        """Wait until the master makes it latch, and say what it has to receive."""
        return await self._latches.next()


class SsiEncoder(ClockedEncoder):
    """An SSI encoder on the pins of a master: `SsiEncoder(dut.clk, dut.data, model="ssi-25")`.

    Data follows `clock_to_output_ns` behind the edge of the clock that gets to the encoder, never at once. For the other
    arguments see SimulatedEncoder."""

    PROTOCOL = "ssi"

    def __init__(
        self,
        clk: LogicObject,
        data: LogicObject,
        model: str = "ssi-25",
        *,
        shaft: Shaft | str = "0",
        clock_to_output_ns: float = 150,
        line_delay_ns: float = 0,
        jitter_ns: float = 0,
        seed: int = 1,
        power: bool = True,
        memory: bytes | None = None,
        **settings: str | float,
    ) -> None:
        super().__init__(
            clk, data, model, clock_to_output_ns, settings, shaft=shaft, line_delay_ns=line_delay_ns,
            jitter_ns=jitter_ns, seed=seed, power=power, memory=memory,
        )  # fmt: skip


class BissEncoder(ClockedEncoder):
    """A BiSS encoder on the pins of a master: `BissEncoder(dut.ma, dut.slo, model="s3684-biss", busy_us=5)`.

    SLO follows `clock_to_output_ns` behind the edge of MA that gets to the encoder, never at once. `sli` is
    the next encoder of a chain, made before with `slo` None, or a pin; None: it is the last one. For the
    other arguments see SimulatedEncoder."""

    PROTOCOL = "biss"

    def __init__(
        self,
        ma: LogicObject,
        slo: LogicObject | None,
        model: str = "s3684-biss",
        *,
        sli: BissEncoder | LogicObject | None = None,
        shaft: Shaft | str = "0",
        clock_to_output_ns: float = 10,
        line_delay_ns: float = 0,
        jitter_ns: float = 0,
        seed: int = 1,
        power: bool = True,
        memory: bytes | None = None,
        **settings: str | float,
    ) -> None:
        self._frames: News[Frame] = News()
        self._accesses: News[Access] = News()
        self._wires: BissLine | None = None
        self._behind_level = False
        super().__init__(
            ma, slo, model, clock_to_output_ns, {"hint_us": HINT_US} | settings, shaft=shaft, line_delay_ns=line_delay_ns,
            jitter_ns=jitter_ns, seed=seed, power=power, memory=memory,
        )  # fmt: skip
        self._wires = self._begun()
        if isinstance(sli, BissEncoder):
            sli._followers.append(self._behind)
            self._behind(sli._level)
        elif sli is not None:
            pin = sli
            self._watch(pin, lambda: self._behind(level_of(pin, self._behind_level)))
            self._behind(level_of(pin, False))
        start(self._until_the_end())
        self._after()

    async def _until_the_end(self) -> None:
        """What there is still to tell when the test is over."""
        try:
            await Event().wait()
        finally:
            self._encoder._tell(NEVER)

    def _begun(self) -> BissLine:
        life = LIFE_BITS if self.get("lc") == "1" else 0
        layout = Layout(int(self.get("mt")), int(self.get("st")), life)
        return BissLine(layout, self._frames.tell, self._accesses.tell)

    def power(self, state: bool | Literal["CYCLE"]) -> None:
        """True, False, or "CYCLE": off and on again."""
        self._wires = self._begun()  # what was begun is over, and nobody hears of it
        super().power(state)

    def _behind(self, level: bool) -> None:
        """The line of the next encoder has another level."""
        self._behind_level = level
        with self._clock.lock:
            now = self._serve()
            if self._encoder._made:
                checked(self._lib.dg_host_behind(self._host, now, level), f"{self.model}: SLI")
                self._encoder._run(now)

    def _after(self) -> None:
        super()._after()
        line = self._wires
        if line is not None and line.open and self._lib.dg_host_next(self._host) == NEVER:
            line.end()

    def _edge(self, level: bool) -> None:
        super()._edge(level)
        if self._wires is not None and self.powered:
            self._wires.edge(now_ps(), level, self._level)

    # ------------------------------------------------------------ looks

    @property
    def frame(self) -> Frame | None:
        """The latest frame; None: there was none yet."""
        return self._frames.latest

    async def framed(self) -> Frame:
        """Wait for the end of a frame, which is that of its timeout: what was sent, CRC, CDS and CDM included."""
        return await self._frames.next()

    async def accessed(self) -> Access:
        """Wait until the master has accessed a register, or was refused; as it was seen on the line."""
        return await self._accesses.next()

    def register(self, address: int, count: int = 1) -> bytes:
        """What a master would read from `address` on in the present bank: what yours has to find. Nothing
        happens to the encoder, and no time passes."""
        ffi, lib = self._ffi, self._lib
        keep, place = _native.aligned(lib.dg_host_size_of(self.model.encode()))
        twin = lib.dg_host_make(place, len(keep) - 16, self.model.encode())
        now = ffi.new("uint64_t *", self._serve())
        state = self._encoder.save()
        checked(lib.dg_host_restore(twin, state, len(state)), "the state")
        # Whatever the line is doing ends, and it rests.
        for level in (False, True):
            lib.dg_host_clock(twin, now[0], level)
            while (due := int(lib.dg_host_step(twin, now[0]))) != NEVER:
                now[0] = due
        lib.dg_host_behind(twin, now[0], False)
        to = ffi.new("uint8_t[]", count)
        done = lib.dg_host_registers_read(twin, now, address, to, count)
        return bytes(ffi.buffer(to, checked(done, f"{count} registers from {address:02X}h")))
