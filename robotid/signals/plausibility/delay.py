"""The delay of a recorded torque against the motion that it makes, to a fraction of a sample.

Recorded by another device, a torque may be early or late. What the motion of a rigid axis explains of it,

    tau = J a + Fv v + Fc sgn v + c0 + c1 x,

is then largest where the torque is moved by as much. The residual's energy over whole shifts has a smooth minimum, for
all columns pass the same low-pass filter, and a parabola reads it between them. A torque that is held from sample to
sample acts half a sample later than it is recorded, on average; that is no delay.

What friction does about a reversal imitates a delay: it sticks, it yields before it slips, it falls with the speed. Two
columns beside those of the axis take all of that, a pulse at every reversal and a dry friction that is there at low
speeds only, so that what is left to tell a delay is inertia and what moves on. A delay is the same at every cut-off;
where the cut-offs contradict each other, the deviation is theirs.

A spring and a damper between motor and load move the torque, too. Below the antiresonance at sqrt(k/Ja),

    Ja s^2 v / (1 + Ja s^2 / (k + d s)) = Ja s v - Ja^2/k s^3 v + Ja^2 d/k^2 s^4 v + ...,

whose last term has the phase of a delay. A delay is the same beside columns of both; where it is another one there, the
deviation is the difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from robotid.model.array import Array
from robotid.signals.differentiate import ParallelFilter, low_pass
from robotid.signals.plausibility.regression import Determined, cutoffs
from robotid.signals.plausibility.settings import DELAY
from robotid.signals.record import Record
from robotid.signals.stretches import stretches

UNKNOWN = Determined(0.0, np.inf)


def torque_delay(record: Record, *, rigid: bool = False) -> Determined:
    """By how much the torque of a record is late [s], negative where it is early.

    Of several cut-offs up to the torque's bandwidth, that which tells it best among those below which the motion
    explains the torque; its deviation is as many times larger as the cut-offs differ by more than theirs (Birge 1932).
    Of a long record, the same in each of several stretches. Unknown where there are not two: the record is short, or
    the axis is not rigid there. rigid : the axis is known to be; else the delay must be the same beside columns of a
    flexible joint, too.
    """
    found = _best(record, flexible=False)
    if rigid or not np.isfinite(found.std):
        return found
    beside = _best(record, flexible=True)
    if not np.isfinite(beside.std):
        return found
    apart = max(0.0, (beside.value - found.value) ** 2 - beside.std**2)
    return Determined(found.value, float(np.hypot(found.std, np.sqrt(apart))))


def _best(record: Record, *, flexible: bool) -> Determined:
    """The delay at the cut-off that tells it best."""
    found = (
        _Lag.at(stretch, cutoff, flexible=flexible)
        for stretch in stretches(record, DELAY.max_samples)
        for cutoff in dict.fromkeys(cutoffs(stretch))
    )
    usable = [one for one in found if one is not None and one.explained > DELAY.explained and one.std > 0.0]
    if len(usable) < 2:
        return UNKNOWN
    best = min(usable, key=lambda one: one.std)
    std = best.std * _disagreement(usable)
    return Determined(best.value * record.sampling_time, std * record.sampling_time)


@dataclass(frozen=True, slots=True)
class _Lag:
    """A lag with its standard deviation [samples], and the share of the torque that the motion explains there."""

    value: float
    std: float
    explained: float

    @classmethod
    def at(cls, record: Record, cutoff: float, *, flexible: bool) -> _Lag | None:
        """The lag below a cut-off [Hz], None where the record is short or the best shift is the largest tried.

        flexible : beside columns of a flexible joint.
        """
        n, most = len(record), min(DELAY.max_shift, len(record) // DELAY.samples_a_shift)
        if most < 1:
            return None
        columns, torque = _filtered(record, cutoff, flexible=flexible)
        basis = np.linalg.qr(columns[:, most : n - most].T)[0]
        energy = np.array([_left(basis, torque[most + k : n - most + k]) for k in range(-most, most + 1)])
        best = int(np.argmin(energy))
        curvature = float(energy[best - 1] - 2 * energy[best] + energy[(best + 1) % len(energy)])
        if best in (0, 2 * most) or curvature <= 0.0:
            return None
        lag = best - most + 0.5 * float(energy[best - 1] - energy[best + 1]) / curvature
        explained = 1.0 - float(energy[best]) / (n * float(np.var(torque)))
        return cls(lag, _deviation(basis, torque, lag, most), explained)


def _disagreement(lags: Sequence[_Lag]) -> float:
    """How many times more lags of one record differ than their deviations tell, at least 1."""
    values, weights = np.array([one.value for one in lags]), np.array([one.std for one in lags]) ** -2.0
    mean = float(weights @ values / weights.sum())
    return max(1.0, float(np.sqrt(weights @ (values - mean) ** 2 / (len(lags) - 1))))


def _filtered(record: Record, cutoff: float, *, flexible: bool) -> tuple[Array, Array]:
    """Columns of an axis and of its reversals (7 or 9, n), and the torque as it acts at the samples (n,), through the
    same filter."""
    h, parallel = record.sampling_time, ParallelFilter(cutoff)
    motion = parallel.motion(record.phi_m, h)
    acting = (record.tau_m + np.concatenate([record.tau_m[:1], record.tau_m[:-1]])) / 2
    x = motion.position - motion.position.mean()
    v, dry = motion.speed, np.sign(motion.speed)
    slow = dry * np.exp(-np.abs(v) / max(DELAY.slow * float(np.sqrt(np.mean(v**2))), 1e-300))
    rows = np.stack([motion.acceleration, v, dry, np.ones_like(x), x, np.gradient(dry), slow])
    columns = low_pass(_of_unit_length(rows), h, cutoff)
    return (np.vstack([columns, _of_a_spring(columns[0])]) if flexible else columns), low_pass(acting, h, cutoff)


def _of_a_spring(acceleration: Array) -> Array:
    """What a spring and its damper add to an acceleration (n,) below the antiresonance: its second and third
    derivative, (2, n), of length 1."""
    snap = np.gradient(np.gradient(acceleration))
    return _of_unit_length(np.stack([snap, np.gradient(snap)]))


def _of_unit_length(rows: Array) -> Array:
    """Rows (k, n) that are of length 1 each, or nothing."""
    return np.asarray(rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300))


def _left(basis: Array, torque: Array) -> float:
    """Energy of a torque (n,) that a basis (n, p) leaves."""
    return float(torque @ torque) - float(np.sum((basis.T @ torque) ** 2))


def _deviation(basis: Array, torque: Array, lag: float, most: int) -> float:
    """Standard deviation of a lag [samples], from the scores of blocks."""
    at = np.arange(most, len(torque) - most) + lag
    moved = np.interp(at, np.arange(len(torque)), torque)
    slope = np.interp(at, np.arange(len(torque)), np.gradient(torque))
    left, seen = moved - basis @ (basis.T @ moved), slope - basis @ (basis.T @ slope)
    edges = np.linspace(0, len(left), DELAY.blocks + 1).astype(int).tolist()
    scores = [float(seen[a:b] @ left[a:b]) for a, b in pairwise(edges)]
    information = float(seen @ seen)
    return float(np.linalg.norm(scores)) / information if information > 0.0 else np.inf
