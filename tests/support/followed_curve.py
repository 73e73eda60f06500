"""A reported curve of missing torque against the true torque, for tests."""

from __future__ import annotations

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.model.array import Array


def followed(curve: Curve, variable: Array, v: Array) -> Array:
    """The torque of a curve along a motion with this variable and speed, (n,) each; a knot that is there twice is one
    on either side of a jump."""
    torque = np.interp(variable, curve.x, curve.missing_torque)
    twice = np.flatnonzero(np.diff(curve.x) == 0.0)
    if twice.size:
        k = int(twice[0]) + 1
        lower, upper = (np.interp(variable, curve.x[at], curve.missing_torque[at]) for at in (slice(k), slice(k, None)))
        torque = np.where(variable < 0, lower, upper)
    counted = curve.along.partition(", ")[2]
    return np.asarray(torque * {"": np.ones_like(v), "by direction": np.sign(v), "by speed": v / curve.at}[counted])


def imitable(v: Array, sampling_time: float) -> Array:
    """What torques of a model of inertia, friction and a constant are made of at this speed, (n, 4)."""
    return np.column_stack([np.gradient(v, sampling_time), v, np.sign(v), np.ones_like(v)])


def correlation_beyond(told: Array, true: Array, known: Array) -> float:
    """Of two torques (n,), but for what of either lies along known (n, k)."""
    left = [signal - known @ np.linalg.lstsq(known, signal, rcond=None)[0] for signal in (told, true)]
    return float(np.corrcoef(*left)[0, 1])
