"""Torques that a recorded and a simulated motion do not have in common, for a reason that is no noise.

Between a reversal as it was measured and as it is simulated dry friction acts in opposite directions, and a motor that
is held takes up any torque. What this leaves is far from the linear response of a joint, and of a few reversals it is
no spectrum. The torque of these samples therefore counts as unknown: what tells of the noise lies between them.
"""

from __future__ import annotations

import numpy as np

from robotid.estimate.noise.response import TorqueResponse
from robotid.model.array import Array, Mask
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory

MOST = 200  # unknown torques of a record: more are taken together, several samples each
AT_ONCE = 8_000_000  # samples of what they leave, in memory


def reversal_columns(record: Record, trajectory: Trajectory, response: TorqueResponse, at: slice) -> Array:
    """What unknown torques at the reversals of a part of a record leave in its output, (k, samples)."""
    part, n = trajectory.part(at), at.stop - at.start
    pulses = _pulses(_apart(part, record.dphi_m[at]), min(MOST, AT_ONCE // n))
    return response.to_torques(pulses)


def _apart(trajectory: Trajectory, measured: Array) -> Mask:
    """Whether a motor with dry friction is held, reverses, or moves in the direction opposite to the measured speed
    (n,) during an interval, (n - 1,)."""
    way = np.sign(trajectory.dphi_m)
    if not trajectory.joint.dry:
        return np.zeros(len(way) - 1, dtype=bool)
    unlike = way * measured <= 0.0
    return np.asarray((way[:-1] != way[1:]) | unlike[:-1] | unlike[1:])


def _pulses(apart: Mask, most: int) -> Array:
    """Torques (k, n) that are one in some of the marked intervals (n - 1,) each and zero elsewhere, k at most `most`:
    none where the runs of intervals are more."""
    n = len(apart) + 1
    edges = np.flatnonzero(np.diff(np.concatenate([[0], apart, [0]]))).reshape(-1, 2)
    spare = most - len(edges)
    if spare < 0 or not len(edges):
        return np.zeros((0, n))
    length = max(1, -(-int(apart.sum()) // max(1, spare)))
    starts = np.concatenate([np.arange(first, stop, length) for first, stop in edges])
    stops = np.concatenate([np.minimum(np.arange(first, stop, length) + length, stop) for first, stop in edges])
    time = np.arange(n)
    return np.asarray((time >= starts[:, None]) & (time < stops[:, None]), dtype=np.float64)
