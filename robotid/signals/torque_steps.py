"""A held torque whose steps fall between the samples of a regular grid, as those of a clock that jitters do.

The mean torque of an interval gives the impulse; where in the interval the torque changed decides when dry friction
reverses. One step in each interval keeps the impulse and its first moment, and is exact where a single one fell into
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, log, pi, sqrt

import numpy as np

from robotid.model.array import Array, Index, Mask

PARTS = 16  # of an interval: a step within a part has its instant to a few hundredths of the interval
SCATTERED = 1e-9  # length of the mean of unit vectors that point everywhere
ROUNDING = 1e-9  # of the largest torque: what changes less within an interval is constant


@dataclass(frozen=True, slots=True, eq=False)
class TorqueSteps:
    """The torque of interval k is its mean less (1 - share) step until the share (n,) of the interval, and step (n,)
    [Nm] more after it."""

    share: Array = field(metadata={"shape": ("n",), "finite": True})
    step: Array = field(metadata={"unit": "Nm", "shape": ("n",), "finite": True})

    def take(self, where: Index | slice) -> TorqueSteps:
        """Those of these intervals."""
        return TorqueSteps(self.share[where], self.step[where])

    def around(self, mean: Array) -> tuple[Array, Array]:
        """The torque before and after the step of each interval. mean (n,) -> (n,) each."""
        return mean - (1.0 - self.share) * self.step, mean + self.share * self.step

    def in_parts(self, mean: Array, parts: int) -> Array:
        """Means over so many equal parts of each interval. mean (n,) -> (n parts,)."""
        before, _ = self.around(mean)
        after = np.clip(np.arange(1, parts + 1) - parts * self.share[:, None], 0.0, 1.0)
        return np.asarray((before[:, None] + self.step[:, None] * after).ravel())

    @property
    def spread(self) -> float:
        """How far apart the instants of the steps lie, as a share of the interval: the width of a uniform distribution
        that deviates as they do around the interval, which is a circle; 0 without any."""
        turns = np.exp(2j * np.pi * self.share[self.step != 0.0])
        together = min(1.0, float(np.abs(turns.mean()))) if len(turns) else 1.0
        return min(1.0, sqrt(12.0) * sqrt(-2.0 * log(max(together, SCATTERED))) / (2.0 * pi))

    @classmethod
    def none(cls, n: int) -> TorqueSteps:
        """Those of a torque that is held over each of n intervals."""
        return cls(np.full(n, 0.5), np.zeros(n))

    @classmethod
    def of_parts(cls, torque: Array, parts: int) -> tuple[Array, TorqueSteps | None]:
        """Mean (n,) and step of each interval, of a torque by its means over so many equal parts of each, (n parts,).

        There are no steps where the torque changes within no interval. The instant is the mean one of all changes, each
        weighted by its square, so that a large one has its own; the size keeps the first moment.
        """
        mean, within = torque.reshape(-1, parts).mean(axis=1), _Within.of(torque, parts)
        mean[within.same] = torque[::parts][within.same]
        if within.same.all():
            return mean, None
        return mean, cls(within.share, within.step)

    @staticmethod
    def change_of_parts(torque: Array, column: Array, parts: int) -> TorqueColumn:
        """How mean and step of `of_parts` change as its torque (n parts,) does, by a column (n parts,)."""
        mean, within = column.reshape(-1, parts).mean(axis=1), _Within.of(torque, parts)
        if within.same.all():
            return TorqueColumn(mean)
        share, changing = within.share, np.diff(column.reshape(-1, parts), axis=1)
        changing[within.same] = 0.0
        moved = 2.0 * ((within.changes * changing * (within.at - share[:, None])).sum(axis=1) / within.energy)
        turned = within.moments(changing) - within.step * (1.0 - 2.0 * share) * moved
        return TorqueColumn(mean, turned / (share * (1.0 - share)), moved)


@dataclass(frozen=True, slots=True, eq=False)
class TorqueColumn:
    """Derivatives of a torque to one parameter. mean, step and share (n,) : of those of each interval, the last two
    None where the torque is held."""

    mean: Array
    step: Array | None = None
    share: Array | None = None

    @classmethod
    def in_a_row(cls, columns: Sequence[TorqueColumn]) -> TorqueColumn:
        """Those of several records one after the other."""
        mean = np.concatenate([one.mean for one in columns])
        if all(one.step is None for one in columns):
            return cls(mean)
        held = [np.zeros(len(one.mean)) for one in columns]
        step = [none if one.step is None else one.step for one, none in zip(columns, held, strict=True)]
        share = [none if one.share is None else one.share for one, none in zip(columns, held, strict=True)]
        return cls(mean, np.concatenate(step), np.concatenate(share))


@dataclass(frozen=True, slots=True, eq=False)
class _Within:
    """How a torque changes between so many equal parts of each of n intervals.

    changes : (n, parts - 1); same : (n,) where it does not; at : (parts - 1,) shares of the interval; energy (n,).
    """

    changes: Array
    same: Mask
    at: Array
    energy: Array

    @classmethod
    def of(cls, torque: Array, parts: int) -> _Within:
        within = torque.reshape(-1, parts)
        same = np.ptp(within, axis=1) <= ROUNDING * float(np.abs(torque).max(initial=0.0))
        changes = np.where(same[:, None], 0.0, np.diff(within, axis=1))
        return cls(changes, same, np.arange(1, parts) / parts, np.where(same, 1.0, np.square(changes).sum(axis=1)))

    @property
    def share(self) -> Array:
        """The mean instant of the changes, weighted by their squares, (n,)."""
        return np.where(self.same, 0.5, np.square(self.changes) @ self.at / self.energy)

    @property
    def step(self) -> Array:
        """The one change at that instant that has their first moment, (n,)."""
        share = self.share
        return np.asarray(self.moments(self.changes) / (share * (1.0 - share)))

    def moments(self, changes: Array) -> Array:
        """Twice the first moment that such changes (n, parts - 1) make, (n,)."""
        return np.asarray(changes @ (self.at * (1.0 - self.at)))


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


def moved(mean: Array, steps: TorqueSteps | None, late: float) -> tuple[Array, TorqueSteps | None]:
    """A torque, by mean (n,) and step of each interval, that acts `late` intervals later, earlier where negative.
    Outside of the record it rests at its first and last values."""
    n, steps = len(mean), TorqueSteps.none(len(mean)) if steps is None else steps
    before, after = steps.around(mean)
    knots = (np.arange(n)[:, None] + np.stack([np.zeros(n), steps.share], axis=1)).ravel()
    levels = np.stack([before, after], axis=1).ravel()
    reach = ceil(abs(late)) + 1.0
    times = np.concatenate([[-reach], knots, [n + reach]])
    impulse = np.concatenate([[0.0], np.cumsum(np.diff(times) * np.concatenate([before[:1], levels]))])
    edges = np.arange(n * PARTS + 1) / PARTS - late
    return TorqueSteps.of_parts(np.diff(np.interp(edges, times, impulse)) * PARTS, PARTS)


def in_a_row(parts: Sequence[tuple[TorqueSteps | None, int]]) -> TorqueSteps | None:
    """Those of several records one after the other, each with its number of samples; None where no record has any."""
    if all(steps is None for steps, _ in parts):
        return None
    whole = [TorqueSteps.none(n) if steps is None else steps for steps, n in parts]
    return TorqueSteps(*(np.concatenate([getattr(one, name) for one in whole]) for name in ("share", "step")))
