# SPDX-License-Identifier: MIT
"""Prints the figures of tools/python/README.md, each in processor time of this machine.

usage: bench.py [SCALE]    so many times the usual count
"""
import sys
import time

import can
import canopen
import drehgeber
import serial
from drehgeber import Encoder

SCALE = float(sys.argv[1]) if len(sys.argv) > 1 else 1
UPLOAD = bytes.fromhex("40 04 60 00 00 00 00 00")
ASK = bytes.fromhex("40 42 02")


def times(name: str, count: int, act, clock=None):
    """How often a second, and virtual seconds per second where time passes."""
    count = max(1, int(count * SCALE))
    virtual = clock.now if clock else 0.0
    begin = time.process_time()
    for _ in range(count):
        act()
    seconds = time.process_time() - begin
    line = f"{name:44} {count / seconds:>10,.0f} /s"
    if clock and clock.now > virtual:
        line += f" {(clock.now - virtual) / seconds:>10,.0f} virtual s per s"
    print(line, flush=True)


def canopen_encoder():
    encoder = Encoder("f3668", shaft="60RPM")
    port = encoder.can

    def upload():
        port.send(0x63F, UPLOAD)
        assert port.recv() is not None

    def sync():
        encoder.clock.advance(0.001)
        port.send(0x80)
        while port.recv() is not None:
            pass

    times("SDO upload, Encoder.can", 20000, upload)
    port.send(0, b"\1\0")
    times("SYNC each virtual ms, one node operational", 10000, sync, encoder.clock)


def python_can():
    message = can.Message(arbitration_id=0x63F, data=UPLOAD, is_extended_id=False)
    with can.Bus(interface="drehgeber", channel="f3668?shaft=60RPM") as bus:

        def upload():
            bus.send(message)
            assert bus.recv(0) is not None

        times("SDO upload, python-can", 20000, upload)
    network = canopen.Network()
    network.connect(interface="drehgeber", channel="f3668")
    try:
        position = network.add_node(63, canopen.import_od(eds())).sdo["Position value"]
        times("SDO upload, canopen with its thread", 2000, lambda: position.raw)
    finally:
        network.disconnect()


def eds():
    import io

    file = io.StringIO(drehgeber.eds("f3668"))
    file.name = "f3668.eds"
    return file


def lines():
    encoder = Encoder("s3684-rs485", shaft="60RPM")
    times("42h, Encoder.request", 10000, lambda: encoder.request(ASK), encoder.clock)
    port = serial.serial_for_url("drehgeber://s3684-rs485?shaft=60RPM", 9600, parity="E", timeout=0.5)

    def exchange():
        port.write(ASK)
        assert len(port.read(7)) == 7

    times("42h, pyserial", 5000, exchange, port.encoder.clock)
    biss = Encoder("s3684-biss", shaft="60RPM")
    times("BiSS frame, Encoder.biss", 20000, biss.biss.frame, biss.clock)
    ssi = Encoder("ssi-25", shaft="60RPM")
    times("SSI frame, Encoder.ssi", 20000, ssi.ssi.frame, ssi.clock)
    ring = Encoder("ocd-ib-k3", shaft="60RPM").ring
    times("INTERBUS cycle, Encoder.ring", 20000, ring.cycle)


def rows():
    encoder = Encoder("s3684-biss", shaft="sine:90DEG,2S")
    count = int(4000 * 60 * 5 * SCALE)
    begin = time.process_time()
    encoder.positions(0, 1 / 4000, count)
    seconds = time.process_time() - begin
    print(f"{'Encoder.positions, a sine':44} {count / seconds:>10,.0f} /s    an hour of 4 kHz in {seconds * 14.4e6 / count:.1f} s")


for part in (canopen_encoder, python_can, lines, rows):
    part()
