"""Whitening: a filter after which a residual of pure noise is white with unit variance, and segments that carry it.

Two white noises make a residual: of the measured output, and of the recorded torque, which the joint integrates. The
filter is the innovations form of the Kalman predictor for both (Ljung 1999, section 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from scipy.linalg import LinAlgError, solve_discrete_are

from robotid.estimate.covariance import zero_order_hold_response
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.record import Record


@dataclass(frozen=True, slots=True, eq=False)
class Whitening:
    """A filter numerator / denominator, in powers of the delay. output : variance of the white output noise, in the
    unit of the output squared; torque : of the white torque noise [Nm2]."""

    numerator: Array
    denominator: Array
    output: float
    torque: float

    def __call__(self, signals: Array) -> Array:
        """Signals (..., n), whitened."""
        return np.asarray(scipy.signal.lfilter(self.numerator, self.denominator, signals, axis=-1))

    def transposed(self, signals: Array) -> Array:
        """The adjoint of the filter: from the last sample to the first."""
        return np.asarray(self(signals[..., ::-1])[..., ::-1])


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A segment of a record, with the filter that whitens what noise leaves in its residual."""

    record: Record
    whitening: Whitening

    def energy(self, residual: Array) -> float:
        """Energy of a residual (n,), in variances of the noise."""
        white = self.whitening(residual)
        return float(white @ white)


UNIT_WHITENING = Whitening(np.ones(1), np.ones(1), 1.0, 0.0)
"""The filter of an output noise of unit variance, which changes nothing: before the noise is known."""


def whitening(joint: Joint, theta: Array, row: int, sampling_time: float, levels: tuple[float, float]) -> Whitening:
    """The filter for white output noise and white torque noise of these variances, at state `row` as the output.

    theta : (p,) of the joint, linearised as it slips with its spring at rest. Without a torque noise, or where the
    Riccati equation has no solution, the filter only scales by the output noise.
    """
    output, torque = levels
    identity = Whitening(np.array([1.0 / np.sqrt(output)]), np.ones(1), output, 0.0)
    if torque <= 0.0:
        return identity
    A, b = zero_order_hold_response(joint, theta, sampling_time)
    kept = [k for k in range(joint.speeds.stop) if k == row or not (joint.keeps_angle and k == joint.motor_angle)]
    A, b, C = A[np.ix_(kept, kept)], b[kept], np.zeros((1, len(kept)))
    C[0, kept.index(row)] = 1.0
    try:
        P = solve_discrete_are(A.T, C.T, torque * np.outer(b, b) + 1e-12 * torque * np.diag(b**2), output * np.eye(1))
    except (LinAlgError, ValueError):
        return identity
    variance = float((C @ P @ C.T)[0, 0] + output)
    K = A @ P @ C.T / variance
    numerator, denominator = (np.asarray(np.poly(m).real, dtype=np.float64) for m in (A, A - K @ C))
    return Whitening(numerator / np.sqrt(variance), denominator, output, torque)
