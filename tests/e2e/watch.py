#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Watch an encoder: its type label, then position, temperature and status twice a second."""
import argparse
import sys
import time

try:
    import serial
except ImportError:
    sys.exit("watch.py: needs pyserial: apt install python3-serial, or pip install pyserial")

from hiperface_master import EncoderError, ExtendedLabel, HiperfaceError, Master, UartSetting

STEPS_PER_PERIOD = 32  # in all encoders of the kind (5.1.2.1)
INTERVAL_S = 0.5


def limits(low, high, unit: str) -> str:
    return f"{'?' if low is None else low} .. {'?' if high is None else high} {unit}"


def print_labels(encoder: Master) -> ExtendedLabel:
    label, who, extended = encoder.type_label(), encoder.identity(), encoder.extended_label()
    uart = UartSetting.decode(label.uart)
    print(f"type label   type {label.type_code:02X}h, {label.memory_bytes} bytes for the user, "
          f"option {label.option_code:02X}h, {uart.baudrate} Bd 8{uart.parity}1")
    print(f"identity     serial number {who.serial_number}, firmware {who.version} of {who.date}")
    print(f"designation  {extended.designation}")
    print(f"resolution   {extended.periods} periods a turn x {STEPS_PER_PERIOD} steps, "
          f"{extended.turns} turn{'' if extended.turns == 1 else 's'}")
    temperature = limits(extended.temperature_min_degc, extended.temperature_max_degc, "degC")
    led = limits(extended.led_min_ma, extended.led_max_ma, "mA")
    print(f"limits       {temperature}, LED {led}, "
          f"speed up to {extended.speed_max_rpm} rpm")
    return extended


def position_text(encoder: Master, label: ExtendedLabel) -> str:
    try:
        counts = encoder.read_position()
    except EncoderError as error:
        return f"position: {error.name} ({error.code:02X}h)"
    turns, rest = divmod(counts, label.periods * STEPS_PER_PERIOD)
    degrees = rest * 360 / (label.periods * STEPS_PER_PERIOD)
    return f"position {counts:>10} = {turns:>4} turns + {degrees:7.3f} deg"


def temperature_text(encoder: Master, label: ExtendedLabel) -> str:
    if label.temperature_channel is None:
        return "no temperature"
    return f"{encoder.read_analog(label.temperature_channel)} degC"


def status_text(encoder: Master) -> str:
    # Only a set warning bit says that something is stored; asking would remove it.
    if not encoder.warning:
        return "ok"
    return ", ".join(f"{name} ({code:02X}h)" for code, name in encoder.read_all_status().items())


def watch(encoder: Master, seconds: float):
    label = print_labels(encoder)
    end = time.monotonic() + seconds
    due = time.monotonic()
    while due < end:
        time.sleep(max(0.0, due - time.monotonic()))
        print(f"{position_text(encoder, label)}   {temperature_text(encoder, label)}   "
              f"{status_text(encoder)}", flush=True)
        due += INTERVAL_S


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("port", metavar="PTY", help="serial port, e.g. /dev/pts/4")
    parser.add_argument("--seconds", type=float, default=10.0, metavar="N",
                        help="how long to watch (default 10)")
    arguments = parser.parse_args()
    try:
        with Master(arguments.port) as encoder:
            watch(encoder, arguments.seconds)
    except (HiperfaceError, OSError, serial.SerialException) as error:
        print(f"watch.py: {arguments.port}: {error}; is an encoder running on it, "
              f"at 9600 8E1 and address 40h?", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
