# SPDX-License-Identifier: MIT
"""The judge of the rig of forty, with machines made by hand: spans of a tenth of a second."""
import pytest
from judgement import Span, Stall, complaint, judge

MOST = 5


def spans(*missed: int) -> list:
    return [Span(i / 10, (i + 1) / 10, count) for i, count in enumerate(missed)]


def stalls(*begins) -> list:
    """At these moments, for a moment; or from one to another."""
    return [Stall(*begin) if isinstance(begin, tuple) else Stall(begin, begin) for begin in begins]


# What was missed in the spans, when the machine stood still; spans of kept time, what the judge says.
ROWS = [
    ([0, 0, 0, 0], [], 4, ""),
    ([0, 0, 0, 0], [0.12], 3, ""),
    ([0, 5, 0, 0], [0.12], 3, ""),
    ([0, 0, 2, 0], [0.17], 2, ""),  # the aftermath is in the next one
    ([0, 9, 0, 0], [0.11, 0.13], 3, ""),
    ([1, 1, 0, 3], [0.12], 3, ""),  # slow rounds, and
    ([1, 1, 1, 3], [], 4, "6 deadlines missed while the machine kept time: 1 at 0.00, 1 at 0.10, 1 at 0.20, 3 at 0.30"),
    ([0, 0, 0, 6], [0.12], 3, "6 deadlines missed more than the machine's stalls explain: 6 at 0.30"),
    ([0, 6, 0, 0], [0.12], 3, "6 deadlines missed more than the machine's stalls explain: 6 at 0.10"),
    ([6, 0, 0, 0], [0.12, 0.22, 0.32], 1, "6 deadlines missed more than the machine's stalls explain: 6 at 0.00"),
    ([5, 5, 5, 5], [0.02, 0.12, 0.22, 0.32], 0, ""),
    ([5, 5, 6, 5], [0.02, 0.12, 0.22, 0.32], 0, "6 deadlines missed more than the machine's stalls explain: 6 at 0.20"),
    ([0, 0, 5, 0], [(0.11, 0.15)], 2, ""),  # what is held up by a long one takes long
    ([0, 0, 5, 6], [(0.11, 0.15)], 2, "6 deadlines missed more than the machine's stalls explain: 6 at 0.30"),
    ([0, 0, 0, 5], [(0.01, 0.11), 0.12], 0, ""),  # a short one does not shorten it
    ([6, 0, 0, 0], [-0.06, 0.4], 4, "6 deadlines missed more than the machine's stalls explain: 6 at 0.00"),
]


@pytest.mark.parametrize("missed, begins, kept, said", ROWS)
def test_whose_fault_it_is(missed, begins, kept, said):
    judgement = judge(spans(*missed), stalls(*begins), MOST)
    assert judgement.kept_s == pytest.approx(kept / 10)
    assert complaint(judgement) == said
