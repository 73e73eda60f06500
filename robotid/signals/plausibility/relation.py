"""Whether a torque belongs to a motion: that of a rigid axis, or of a joint whose gear is a spring.

Behind a spring hangs a part Ja of the inertia. The torque then obeys, with the angle of the motor, a differential
equation in which the operator P of that part acts on both:

    P(D) tau = P(D) (J a + Fv v + Fc sgn v) + Q(D) a,    P(D) = Ja D^2 + d D + k,    Q of order 2.

Its coefficients are not known. Whether there are any is asked by the largest canonical correlation (Hotelling 1936) of
tau, D tau, D^2 tau with the columns of a rigid axis and the first two derivatives of acceleration and dry friction.
A rigid axis has P = 1. So a joint that rings at its resonance is seen as well as one that does not.

What chance does is what the same search finds for the same torque shifted in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy

from robotid.model.array import Array
from robotid.signals.plausibility.settings import REGRESSION

MASS, DRY = 0, 2
SPRING_COLUMNS = 6  # derivatives of acceleration, dry friction and torque
TINY = float(np.finfo(float).tiny)
INNER = slice(2, -2)  # samples of which a second difference is central
ROUNDING = 1e-8  # singular value, relative to the largest, of a column that repeats others


@dataclass(frozen=True, slots=True)
class Relation:
    """explained : share of the torque's variance, or of that of a combination with its derivatives, that the motion
    explains; by_chance : the same of the torque shifted in time, the largest of several. Corrected for the number of
    columns. is_determined : whether the record has samples enough for them."""

    explained: float
    by_chance: float
    is_determined: bool

    @property
    def above_chance(self) -> float:
        """How many times more the motion explains than of a shifted torque, as odds."""
        return odds(self.explained) / max(odds(self.by_chance), np.finfo(float).eps)


def odds(share: float) -> float:
    """A share over what it leaves: 99 % are eleven times more than 90 %."""
    return share / max(1.0 - share, np.finfo(float).eps)


class Filtered(Protocol):
    """A record below one cut-off: its torque (n,) and the columns of a rigid axis (p, n), without what an orthonormal
    basis (n, k) of the torques of others holds of them."""

    @property
    def torque(self) -> Array: ...

    @property
    def columns(self) -> Array: ...

    @property
    def others(self) -> Array: ...


def relate(tried: Sequence[Filtered]) -> Relation:
    """The relation at the cut-off where it is closest, of those that leave enough samples; a shifted torque alike."""
    found = [one for one in map(_shares, tried) if one is not None]
    if not found:
        return Relation(0.0, 0.0, is_determined=False)
    own, *shifted = np.max(found, axis=0).tolist()
    return Relation(own, max(shifted), is_determined=True)


def _shares(one: Filtered) -> Array | None:
    """Adjusted share of the torque and of each shifted one (1 + shifts,); None where there are too few samples."""
    if len(one.torque) < REGRESSION.samples_a_column:
        return None
    motion = orthonormal(np.vstack([one.columns[:, INNER], *(_derivatives(one.columns[k]) for k in (MASS, DRY))]))
    torques = np.vstack([one.torque[INNER], _derivatives(one.torque)])
    torques -= torques.mean(axis=1, keepdims=True)
    others = orthonormal(one.others[INNER].T)
    n, free = torques.shape[1] - others.shape[1], motion.shape[1] + len(torques) - 1
    if n < REGRESSION.samples_a_column * free:
        return None
    # unequal steps, lest a periodic excitation comes back to where it was
    steps = np.arange(REGRESSION.shifts + 1)
    shifts = (torques.shape[1] * (steps + 0.37 * np.sin(2.4 * steps)) / len(steps)).astype(int)
    moved = (np.roll(torques, shift, axis=1) for shift in shifts)
    closest = np.array([_closest(motion, one - (one @ others) @ others.T) for one in moved])
    adjusted: Array = np.maximum(0.0, 1.0 - (1.0 - closest) * n / (n - free))
    return adjusted


def _closest(motion: Array, torques: Array) -> float:
    """The largest squared canonical correlation of torques (k, n) with the orthonormal basis (n, p) of a motion."""
    if not np.ptp(torques[0]):
        return 0.0
    return min(1.0, float(np.linalg.norm(motion.T @ orthonormal(torques), ord=2)) ** 2)


def _derivatives(signal: Array) -> Array:
    """First and second difference of a signal (n,), by one rule for torque and motion, without its ends."""
    first = np.gradient(signal)
    return np.array([first, np.gradient(first)])[:, INNER]


def orthonormal(columns: Array) -> Array:
    """Orthonormal basis (n, k) of columns (p, n) of whatever size."""
    if not len(columns):
        return np.zeros((columns.shape[1], 0))
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=1, keepdims=True), TINY)
    left, values, _ = scipy.linalg.svd(scaled.T, full_matrices=False)
    return np.asarray(left[:, values > ROUNDING * max(float(values[0]), TINY)])
