"""One joint beside several recordings, so that their steps are linearised at once.

Beside each recording a joint whose effects read companions, or follow the recorded angle, is another one. But its
equations differ in what the companions are at a time only: with the recordings one after the other in time they are
those of one joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from math import ceil, log2

from robotid.model.companion import in_turns
from robotid.model.joint import Joint


@dataclass(frozen=True, slots=True, eq=False)
class InTurns:
    """A joint beside several recordings, number k of them from k turn [s] on."""

    joint: Joint
    turn: float = 0.0

    def begin(self, k: int, begin: float) -> float:
        """When what begins at a time [s] in recording k begins for the joint."""
        return k * self.turn + begin


def beside_all(joints: Sequence[Joint]) -> InTurns | None:
    """One joint in place of several, each beside its recording; None where they are not of the same effects, or
    companions are not sampled alike."""
    first = joints[0]
    if any(joint.placed is not first.placed for joint in joints):
        return None
    read = first.courses_read
    if not read or all(joint is first for joint in joints):
        return InTurns(first)
    every = [joint.companions[name] for joint in joints for name in read]
    longest = max(one.begin + (one.samples.shape[1] + 1) * one.sampling_time for one in every)
    turn = 2.0 ** ceil(log2(longest))  # a power of two keeps as many digits of the times as there can be
    courses = {name: in_turns([joint.companions[name] for joint in joints], turn) for name in sorted(read)}
    together = copy(first)
    together.companions = {name: course for name, course in courses.items() if course is not None}
    return InTurns(together, turn) if len(together.companions) == len(courses) else None
