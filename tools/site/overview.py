# SPDX-License-Identifier: MIT
"""The picture of README.md: a shaft, and what encoders on it say over their wires. Everything in it was said by the
program: one rig with the shaft at rest, asked as masters ask; BiSS and SSI are levels of a trace."""

import math
import os
import re
import socket
import subprocess
import tempfile
import time
import tty
from pathlib import Path

import waveform

PATIENCE_S = 20
DEGREES = 90
RIG = f"""[shaft motor]
motion = {DEGREES}DEG
[encoder rs485]
model = s3684-rs485
wire = pty
[encoder can]
model = f3668
wire = slcan
[encoder ring]
model = ocd-ib-k3
wire = modbus:127.0.0.1:0
"""
WIDTH, HEIGHT, ROW, TOP, LEFT, BOX = 1000, 408, 78, 12, 432, 200
DIAL_X, DIAL_Y, DIAL_R = 88, HEIGHT / 2, 60
STYLE = ("text{font:14px sans-serif;fill:#1f2328}.s{fill:#59636e;font-size:12px}.w{font:15px monospace;white-space:pre}"
         ".b{fill:#f6f8fa;stroke:#d1d9e0}.e{fill:#fff;stroke:#d1d9e0}.h{fill:none;stroke:#e8710a;stroke-width:2}"
         ".d{fill:#fff;stroke:#59636e;stroke-width:2}path{fill:none;stroke:#1f2328;stroke-width:1.3}.n{font-weight:bold}"
         "@media(prefers-color-scheme:dark){text{fill:#e6edf3}.s{fill:#9198a1}.b{fill:#0d1117;stroke:#3d444d}"
         ".e{fill:#151b23;stroke:#3d444d}.d{fill:#151b23;stroke:#9198a1}path{stroke:#e6edf3}.h{stroke:#f0883e}}")


def _read(descriptor: int, enough) -> bytes:
    """What comes, until it is enough."""
    deadline, got = time.monotonic() + PATIENCE_S, b""
    os.set_blocking(descriptor, False)
    while not enough(got):
        if time.monotonic() > deadline:
            raise RuntimeError(f"no answer, but {got!r}")
        try:
            got += os.read(descriptor, 256)
        except BlockingIOError:
            time.sleep(0.01)
    return got


def _asked(path: str, request: bytes, enough) -> bytes:
    """The answer on a pty."""
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        tty.setraw(port)
        os.write(port, request)
        return _read(port, enough)
    finally:
        os.close(port)


def _rs485(path: str) -> list:
    """Position, 42h."""
    request = bytes.fromhex("404202")
    reply = _asked(path, request, lambda got: len(got) >= 7)
    steps = int.from_bytes(reply[2:6], "big")
    return [f"&gt; {request.hex(' ').upper()}", f"&lt; {reply.hex(' ').upper()}", f"{steps} of 65536 steps"]


def _can(path: str) -> list:
    """Position, 6004h, by SDO."""
    asked = "t63F84004600000000000"
    got = _asked(path, f"O\r{asked}\r".encode(), lambda text: re.search(rb"t5BF8\w{16}", text)).decode()
    answer = re.search(r"t5BF8\w{16}", got)[0]
    frames = [f"{sign} {frame[1:4]}  {' '.join(re.findall('..', frame[5:]))}"
              for sign, frame in (("&gt;", asked), ("&lt;", answer))]
    return [*frames, f"{int.from_bytes(bytes.fromhex(answer[13:]), 'little')} of 65536 steps"]


def _ring(address: str) -> list:
    """Both input registers of the coupler, once the encoder has started: until then it says A000h."""
    host, port = address.rsplit(":", 1)
    deadline = time.monotonic() + PATIENCE_S
    with socket.create_connection((host, int(port)), PATIENCE_S) as client, client.makefile("rb") as replies:
        while True:
            client.sendall(bytes.fromhex("0001 0000 0006 FF 04 0000 0002"))
            reply = replies.read(13)
            words = reply[9:11].hex().upper(), reply[11:].hex().upper()
            if words[0] == "0000":
                return [f"&lt; IN {words[0]} {words[1]}", "", f"{int(words[1], 16)} of 4096 steps"]
            if time.monotonic() > deadline:
                raise RuntimeError(f"the ring says {words}")
            time.sleep(0.02)


def _wires(program: str) -> dict:
    """What the encoders of the rig say."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "rig.ini").write_text(RIG, encoding="utf-8")
        with subprocess.Popen([program, "run", "./rig.ini", "--control", "unix:control"], cwd=folder, text=True,
                              stdout=subprocess.PIPE) as rig:
            try:
                ready = {}
                for line in rig.stdout:
                    if line == "ready rig\n":
                        break
                    _, _, address, name = (line.split() + ["", ""])[:4]
                    ready[name] = address.partition(":")[2]
                return {"rs485": _rs485(ready["rs485"]), "can": _can(ready["can"].rsplit("/", 1)[0]),
                        "ring": _ring(ready["ring"].partition("/")[0])}
            finally:
                rig.terminate()


def _levels(program: str, command: str, model: str, names: tuple) -> tuple:
    """What the command says of a frame, and the lines."""
    with tempfile.TemporaryDirectory() as folder:
        said = subprocess.run([program, command, model, "read", "--shaft", f"{DEGREES}DEG", "--trace", "x.vcd"], cwd=folder,
                              check=True, text=True, capture_output=True, timeout=PATIENCE_S).stdout
        return " ".join(said.split()[:4]), waveform.read((Path(folder) / "x.vcd").read_text(encoding="utf-8"), names)


def _wave(lines: dict, y: int) -> str:
    """Both lines, one above the other, from the begin of the trace to the last edge."""
    end = max(line[-1][0] for line in lines.values()) + 1000
    scale = (WIDTH - LEFT - 62) / end
    out = []
    for row, (name, line) in enumerate(lines.items()):
        at = [(0, waveform.level(line, 0)), *(edge for edge in line if edge[0] > 0), (end, line[-1][1])]
        bottom = y + 28 + 30 * row
        out += [f'<text class="s" x="{LEFT}" y="{bottom - 3}">{name}</text>',
                waveform.steps([(LEFT + 50 + moment * scale, value) for moment, value in at], bottom, 16)]
    return "".join(out)


def _words(lines: list, y: int) -> str:
    """What goes over the wire, and what it says."""
    *frames, meaning = lines
    wire = "".join(f'<text class="w" x="{LEFT}" y="{y + 29 + 23 * k}">{line}</text>' for k, line in enumerate(frames))
    return wire + f'<text class="s" x="{WIDTH - 12}" y="{y + 52}" text-anchor="end">{meaning}</text>'


def picture(program: str) -> str:
    wires = _wires(program)
    biss, biss_lines = _levels(program, "biss", "s3684-biss", ("MA", "SLO"))
    ssi, ssi_lines = _levels(program, "ssi", "ssi-25", ("CLOCK", "DATA"))
    rows = [("RS485 + SinCos", "s3684-rs485: 42h, position", lambda y: _words(wires["rs485"], y)),
            ("BiSS-C", f"s3684-biss: {biss}", lambda y: _wave(biss_lines, y)),
            ("CANopen", "f3668: SDO upload of 6004h", lambda y: _words(wires["can"], y)),
            ("SSI", f"ssi-25, Gray code: {ssi}", lambda y: _wave(ssi_lines, y)),
            ("INTERBUS", "ocd-ib-k3: words of a cycle", lambda y: _words(wires["ring"], y))]
    radians, box = math.radians(DEGREES), LEFT - BOX - 14
    parts = [f'<rect class="b" x="1" y="1" width="{WIDTH - 2}" height="{HEIGHT - 2}" rx="10"/>']
    for number, (name, what, draw) in enumerate(rows):
        y = TOP + number * ROW
        parts += [f'<path class="h" d="M{DIAL_X + DIAL_R} {DIAL_Y}C{DIAL_X + DIAL_R + 44} {DIAL_Y} {box - 44} {y + 35} '
                  f'{box} {y + 35}"/>',
                  f'<rect class="e" x="{box}" y="{y + 4}" width="{BOX}" height="62" rx="6"/>',
                  f'<text class="n" x="{box + 12}" y="{y + 30}">{name}</text>',
                  f'<text class="s" x="{box + 12}" y="{y + 50}">{what}</text>', draw(y)]
    ticks = "".join(f"M{DIAL_X + r0 * math.sin(a):.1f} {DIAL_Y - r0 * math.cos(a):.1f}l{8 * math.sin(a):.1f} {-8 * math.cos(a):.1f}"
                    for r0, a in ((DIAL_R - 8, math.pi * k / 6) for k in range(12)))
    parts += [f'<circle class="d" cx="{DIAL_X}" cy="{DIAL_Y}" r="{DIAL_R}"/><path d="{ticks}"/>',
              f'<path class="h" d="M{DIAL_X} {DIAL_Y}l{DIAL_R * math.sin(radians):.1f} {-DIAL_R * math.cos(radians):.1f}"/>',
              f'<text x="{DIAL_X}" y="{DIAL_Y + DIAL_R + 26}" text-anchor="middle">one shaft at {DEGREES}°</text>']
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" role="img">'
            f'<title>One shaft at {DEGREES} degrees, and what encoders on it say</title><style>{STYLE}</style>'
            f'{"".join(parts)}</svg>\n')
