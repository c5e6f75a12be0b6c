# SPDX-License-Identifier: MIT
"""A BiSS register access as a picture: what MA and SLO were, from the VCD file of `drehgeber biss ... --trace`. Takes
frames apart by themselves, from the levels only; the program's own words in the trace are not looked at."""

import re
from typing import NamedTuple

STEP_NS = 10
TIMEOUT_NS = 10_000  # longer than any half period of the master
LEFT, ROW, WIDTH = 46, 40, 1000
# A frame of an S3684 behind CDS, and a register access behind the zeros: what it is, and how many bits.
FRAME = (("MT", 12), ("ST", 21), ("nE", 1), ("nW", 1), ("LC", 6), ("~CRC", 6))
HEAD = (("S", 1), ("C", 1), ("ID", 3), ("ADR", 7), ("CRC", 4), ("R", 1), ("W", 1))
BYTE = (("S", 1), ("DATA", 8), ("CRC", 4), ("P", 1))
# In a page it has the colour of text around it, and must not reach beyond itself; by itself it has two.
STYLE = (".wave path{fill:none;stroke:currentColor;stroke-width:1.3}.wave .m{stroke:#e8710a}"
         ".wave text{font:11px sans-serif;fill:currentColor;text-anchor:middle}.wave .l{text-anchor:start}")
COLOURS = ".wave{color:#1f2328}@media(prefers-color-scheme:dark){.wave{color:#e6edf3}}"


class Frame(NamedTuple):
    edges: list  # rising edges of MA, in ns
    bits: list   # SLO in front of each following edge
    cdm: int


def read(text: str, wanted=("MA", "SLO")) -> dict:
    """Changes of these lines, as (ns, level)."""
    now, lines = 0, {name: [] for name in wanted}
    names = {sign: name for sign, name in re.findall(r"\$var wire 1 (\S+) (\w+) \$end", text)}
    for row in text.split("$enddefinitions $end", 1)[1].split():
        if row[0] == "#":
            now = int(row[1:]) * STEP_NS
        elif row[0] in "01" and row[1:] in names:
            line = lines[names[row[1:]]]
            if not line or line[-1][1] != int(row[0]):
                line.append((now, int(row[0])))
    return lines


def level(line: list, at: int) -> int:
    return [value for moment, value in line if moment <= at][-1]


def frames(lines: dict) -> list:
    found, edges = [], []
    for (at, value), (after, _) in zip(lines["MA"], lines["MA"][1:] + [(lines["MA"][-1][0] + 2 * TIMEOUT_NS, 0)]):
        if value and at > 0:
            edges.append(at)
        if after - at > TIMEOUT_NS and edges:
            ends = edges[1:] + [edges[-1] + edges[-1] - edges[-2]]
            found.append((edges, ends, 1 - value))
            edges = []
    moments = iter(lines["SLO"])
    found_frames, current, following = [], 0, next(moments)
    for edges, ends, cdm in found:
        bits = []
        for end in ends:
            while following and following[0] < end:
                current, following = following[1], next(moments, None)
            bits.append(current)
        found_frames.append(Frame(edges, bits, cdm))
    return found_frames


def start_of(frame: Frame) -> int:
    """Which edge the start bit comes with: the first 1 behind Ack."""
    return frame.bits.index(1, frame.bits.index(0))


def number(bits: list) -> int:
    return int("".join(map(str, bits)), 2)


def fields(bits: list, parts) -> list:
    """(name, first bit, bits) of each part."""
    at, out = 0, []
    for name, count in parts:
        out.append((name, at, bits[at:at + count]))
        at += count
    return out


def access_of(all_frames: list, count: int) -> tuple:
    """Where the access begins, and its fields on CDM and CDS. CDS answers a frame later."""
    cdm = [frame.cdm for frame in all_frames]
    cds = [frame.bits[start_of(frame) + 1] for frame in all_frames]
    begin = cdm.index(1)
    answer = cds[begin + 1:] + [0]
    return begin, fields(cdm[begin:], HEAD + BYTE * count), fields(answer, HEAD + BYTE * count)


def steps(points: list, y: int, high: int = 22) -> str:
    """A path through (x, level)."""
    out, before = [], None
    for x, value in points:
        height = y - high * value
        out.append(f"{'M' if before is None else 'H'}{x:.1f}" + (f" {height}" if before is None else f"V{height}"))
        before = value
    return f'<path d="{"".join(out)}"/>'


def _mark(x: float, width: float, y: int, text: str) -> str:
    return (f'<path class="m" d="M{x:.1f} {y}v4H{x + width:.1f}v-4"/>'
            f'<text x="{x + width / 2:.1f}" y="{y + 15}">{text}</text>')


def _svg(height: int, title: str, parts: list) -> str:
    return (f'<svg xmlns="http://www.w3.org/2000/svg" class="wave" viewBox="0 0 {WIDTH} {height}" role="img" '
            f'width="100%"><title>{title}</title><style>{STYLE}</style>{"".join(parts)}</svg>')


def alone(picture: str) -> str:
    """A picture as a file."""
    return picture.replace("<style>", f"<style>{COLOURS}").replace('width="100%"', f'width="{WIDTH}"') + "\n"


def frame_picture(lines: dict) -> str:
    """The first frame, edge for edge."""
    frame = frames(lines)[0]
    begin, period = frame.edges[0] - 1500, frame.edges[1] - frame.edges[0]
    end = frame.edges[-1] + period + 16_000
    scale = (WIDTH - LEFT - 10) / (end - begin)

    def x_of(at):
        return LEFT + (at - begin) * scale

    parts = []
    for row, name in enumerate(("MA", "SLO")):
        y = 34 + row * ROW
        line = lines[name]
        points = [(x_of(begin), level(line, begin))]
        points += [(x_of(at), value) for at, value in line if begin < at < end]
        points.append((x_of(end), points[-1][1]))
        parts += [f'<text class="l" x="0" y="{y - 6}">{name}</text>', steps(points, y)]
    start = start_of(frame)
    y = 84
    parts.append(_mark(x_of(frame.edges[1]), (start - 1) * period * scale, y, "Ack"))
    names = (("S", 1), ("CDS", 1), *FRAME)
    for name, first, bits in fields(frame.bits[start:], names):
        wide = name in ("MT", "ST")
        text = f"{name} {number(bits)}" if wide else name
        parts.append(_mark(x_of(frame.edges[start + first]) + 1, len(bits) * period * scale - 2, y, text))
    parts.append(_mark(x_of(frame.edges[-1]), 14_000 * scale, y, "timeout"))
    return _svg(108, "a BiSS-C frame: MA and SLO", parts)


def access_picture(lines: dict, count: int) -> str:
    """All frames of the access, a bit each."""
    all_frames = frames(lines)
    begin, asked, answered = access_of(all_frames, count)
    first, total = begin - 4, sum(n for _, n in HEAD + BYTE * count)
    scale = (WIDTH - LEFT - 10) / (total + 6)
    parts = []
    values = {"CDM": [frame.cdm for frame in all_frames],
              "CDS": [frame.bits[start_of(frame) + 1] for frame in all_frames]}
    for row, (name, bits) in enumerate(values.items()):
        y = 34 + row * 66
        shown = bits[first:first + total + 6]
        points = [(LEFT + k * scale, bit) for k, bit in enumerate(shown)] + [(LEFT + len(shown) * scale, shown[-1])]
        parts += [f'<text class="l" x="0" y="{y - 6}">{name}</text>', steps(points, y)]
        late = row  # CDS answers in the next frame
        for part, at, part_bits in (asked, answered)[row]:
            is_word = part == "DATA" if row else part == "ADR"
            text = f"{number(part_bits):02X}h" if is_word else part
            if row == 0 and at >= 18 or row == 1 and at < 16:
                continue
            x = LEFT + (begin - first + at + late) * scale
            parts.append(_mark(x + 1, len(part_bits) * scale - 2, y + 6, text))
    return _svg(124, f"{len(all_frames)} BiSS-C frames read {count} registers: CDM and CDS, a bit a frame", parts)
