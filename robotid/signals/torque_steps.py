"""A held torque whose steps fall between the samples of a regular grid, as those of a clock that jitters do.

The mean torque of an interval gives the impulse; where in the interval the torque changed decides when dry friction
reverses. One step in each interval keeps the impulse and its first moment, and is exact where a single one fell into
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robotid.model.array import Array, Index


@dataclass(frozen=True, slots=True, eq=False)
class TorqueSteps:
    """The torque of interval k is its mean less (1 - share) step until the share (n,) of the interval, and step (n,)
    [Nm] more after it."""

    share: Array
    step: Array = field(metadata={"unit": "Nm"})

    def take(self, where: Index | slice) -> TorqueSteps:
        """Those of these intervals."""
        return TorqueSteps(self.share[where], self.step[where])

    def around(self, mean: Array) -> tuple[Array, Array]:
        """The torque before and after the step of each interval. mean (n,) -> (n,) each."""
        return mean - (1.0 - self.share) * self.step, mean + self.share * self.step


def torque_steps(at: Array, torque: Array, grid: Array) -> TorqueSteps:
    """The steps of a torque (n,) that lasts from its stamp to the next, within the intervals that begin at a grid (m,).

    at : (n,) increasing stamps, in intervals. The largest step gives the instant, the first moment the size.
    """
    inside = (at[1:] > grid[0]) & (at[1:] < grid[-1] + 1.0)
    moments, sizes = at[1:][inside], np.diff(torque)[inside]
    interval = np.clip(np.searchsorted(grid, moments, side="right") - 1, 0, len(grid) - 1)
    shares = np.clip(moments - grid[interval], 0.0, 1.0)
    moment = np.bincount(interval, sizes * shares * (1.0 - shares), len(grid))  # twice the first moment
    order = np.lexsort((np.abs(sizes), interval))
    share = np.full(len(grid), 0.5)
    share[interval[order]] = shares[order]  # of several in an interval the last one written, the largest
    lever = share * (1.0 - share)
    return TorqueSteps(share, np.divide(moment, lever, out=np.zeros(len(grid)), where=lever > 0.0))


def in_a_row(parts: Sequence[tuple[TorqueSteps | None, int]]) -> TorqueSteps | None:
    """Those of several records one after the other, each with its number of samples; None where no record has any."""
    if all(steps is None for steps, _ in parts):
        return None
    whole = [TorqueSteps(np.full(n, 0.5), np.zeros(n)) if steps is None else steps for steps, n in parts]
    return TorqueSteps(*(np.concatenate([getattr(one, name) for one in whole]) for name in ("share", "step")))
