# SPDX-License-Identifier: MIT
"""python-can: can.Bus(interface="drehgeber", channel=...)"""

from __future__ import annotations

from typing import Any

import can

from ._native import Medium
from .address import encoder_of, is_model
from .canbus import CanBus
from .clock import Clock


class DrehgeberBus(can.BusABC):
    """A master on a bus of this process. `channel` is the name of a drehgeber.CanBus, or a model with
    what --set and --shaft take behind it, "f3668?node=5&shaft=60RPM" or "vendor.eds?node=5", which is made then. `time` is that
    of an encoder made so: "real", or "virtual", which moves by advance(), and in recv() up to an answer
    that the encoder takes its time for, as for "save"."""

    def __init__(
        self,
        channel: Any = "f3668",
        can_filters: can.typechecking.CanFilters | None = None,
        time: str = "virtual",
        **kwargs: Any,
    ) -> None:
        text = str(channel)
        if time not in ("virtual", "real"):
            raise can.CanInitializationError(f"time={time!r}: expected 'virtual' or 'real'")
        bus = CanBus.named(text)
        self.encoder = None
        if bus is None:
            if not is_model(text):
                raise can.CanInitializationError(
                    f"no drehgeber.CanBus({text!r}) in this process, and no model, "
                    "e.g. channel='f3668?node=5&shaft=60RPM'"
                )
            self.encoder = encoder_of(text, Clock(real=time == "real"), Medium.FRAMES)
            bus = self.encoder.bus
        self.bus = bus
        self.channel_info = f"drehgeber {text} in this process"
        self._port = bus.port()
        self._is_over = False
        self._can_protocol = can.CanProtocol.CAN_20
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def advance(self, seconds: float) -> None:
        """Let virtual time pass."""
        self.bus.clock.advance(seconds)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Heard at once. Frames with 29 bits, CAN FD and error frames are not for these encoders."""
        self._check_open()
        if msg.is_extended_id or msg.is_fd or msg.is_error_frame:
            return
        self._port.send(msg.arbitration_id, bytes(msg.data), msg.is_remote_frame, msg.dlc)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self._check_open()
        frame = self._port.recv() if timeout == 0 else self._port.wait(timeout)
        if frame is None:
            return None, False
        return can.Message(
            timestamp=frame.at,
            arbitration_id=frame.id,
            is_extended_id=False,
            is_remote_frame=frame.remote,
            dlc=frame.dlc,
            data=None if frame.remote else frame.data,
            is_rx=True,
            channel=str(self.channel_info),
        ), False

    def _check_open(self) -> None:
        if self._is_over:
            raise can.CanOperationError("the bus has been shut down")

    def shutdown(self) -> None:
        """Leave the bus; what was made for it goes, too."""
        super().shutdown()
        self._is_over = True
        self._port.close()
