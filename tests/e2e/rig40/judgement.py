# SPDX-License-Identifier: MIT
"""Whose fault missed deadlines are: the machine's, which stood still, or the program's.

A referee with nothing but a clock says when the machine stood still. A short span of time without such
a stall is kept time, and nothing may be missed in it but in a few slow rounds, however little of it there is. What is
missed in a span with a stall is the machine's, as far as a stall goes."""
import bisect
from itertools import accumulate
from typing import NamedTuple

AFTERMATH_S = 0.05
# In an emulated machine a round of a rig's loop may take more than the 10 ms behind which the rig counts it on each
# wire, without any stall: STATe? of a K3 took 6 ms of the processor's own time there, switching on forty encoders 10.
# So many spans of kept time may have such a round.
SLOW_ROUNDS = 3


class Stall(NamedTuple):
    """The machine stood still."""
    begin: float
    end: float

    @property
    def over(self) -> float:
        """When what it held up is done: a rig that takes two thirds of a processor needs twice as long as the stall."""
        return self.end + 2 * (self.end - self.begin) + AFTERMATH_S


class Span(NamedTuple):
    """A short time, and the deadlines missed in it."""
    begin: float
    end: float
    missed: int


class Judgement(NamedTuple):
    kept_s: float  # without a stall
    by_itself: list  # spans of it in which something was missed all the same, no more than in one slow round
    beyond: list  # spans in which more was missed than that, or than their stalls explain


def judge(spans: list, stalls: list, most: int) -> Judgement:
    """Both in the order of time; `most` is what a stall can make a program miss."""
    begins = [stall.begin for stall in stalls]
    ends = list(accumulate((stall.over for stall in stalls), max))
    kept_s, by_itself, beyond = 0.0, [], []
    for span in spans:
        count = bisect.bisect_left(begins, span.end) - bisect.bisect_right(ends, span.begin)
        if count == 0:
            kept_s += span.end - span.begin
            by_itself += [span] if 0 < span.missed <= most else []
        if span.missed > max(count, 1) * most:
            beyond.append(span)
    return Judgement(kept_s, by_itself, beyond)


def complaint(judgement: Judgement) -> str:
    """Empty: all that was missed is the machine's."""
    lines = []
    for spans, most, what in (judgement.by_itself, SLOW_ROUNDS, "while the machine kept time"), \
                             (judgement.beyond, 0, "more than the machine's stalls explain"):
        if len(spans) > most:
            lines.append(f"{sum(span.missed for span in spans)} deadlines missed {what}: " +
                         ", ".join(f"{span.missed} at {span.begin:.2f}" for span in spans[:20]))
    return "; ".join(lines)
