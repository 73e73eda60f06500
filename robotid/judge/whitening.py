"""Whitening: a filter after which a residual of pure noise is white with unit variance.

Two white noises make a residual: of the measured output, and of the recorded torque, which the joint integrates. Their
levels come from the spectrum (Whittle 1953), the filter is the innovations form of the Kalman predictor for both
(Ljung 1999, section 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are
from scipy.optimize import minimize
from scipy.signal import lfilter

from robotid.estimate.covariance import held_response, impulse_response
from robotid.model.array import Array
from robotid.model.joint import Joint

OUTLIER = 8.0  # periodogram over spectrum: noise alone exceeds it once in three thousand
SWEEPS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Whitening:
    """A filter numerator / denominator. output : variance of the white output noise; torque : of the torque's [Nm2]."""

    numerator: Array
    denominator: Array
    output: float
    torque: float

    def __call__(self, signals: Array) -> Array:
        """Signals (..., n), whitened."""
        return np.asarray(lfilter(self.numerator, self.denominator, signals, axis=-1))


def noise_levels(residual: Array, impulse: Array, absorbed: int) -> tuple[float, float]:
    """Variances of output noise and torque noise in a residual (n,). impulse (n,) of the output to the torque.

    absorbed : lowest frequency bins, which a fit has shaped. Bins that stick out of the spectrum count as misfit.
    """
    n = len(residual)
    seen = slice(min(absorbed, n // 4), n // 2)
    periodogram = np.abs(np.fft.rfft(residual))[seen] ** 2 / n
    torque = np.abs(np.fft.rfft(impulse, 2 * n))[::2][seen] ** 2
    kept = np.ones(len(periodogram), dtype=bool)
    levels = np.array([float(np.median(periodogram)) / np.log(2.0), 0.1 * periodogram.mean() / torque.mean()])
    for _ in range(SWEEPS):
        levels = _whittle(periodogram[kept], torque[kept], levels)
        kept = periodogram <= OUTLIER * (levels[0] + levels[1] * torque)
    return float(levels[0]), float(levels[1])


def _whittle(periodogram: Array, torque: Array, start: Array) -> Array:
    size = np.array([periodogram.mean(), periodogram.mean() / torque.mean()])

    def cost(logs: Array) -> float:
        share = np.exp(logs)
        model = share[0] * size[0] + share[1] * size[1] * torque
        return float(np.mean(np.log(model) + periodogram / model))

    first = np.log(np.maximum(start / size, 1e-3))
    found = minimize(cost, first, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-9})
    levels = np.exp(found.x) * size
    return np.asarray(levels)


def whitening(joint: Joint, theta: Array, row: int, sampling_time: float, levels: tuple[float, float]) -> Whitening:
    """The filter for output noise and torque noise of these variances, at state `row` as the output."""
    output, torque = levels
    identity = Whitening(np.array([1.0 / np.sqrt(output)]), np.ones(1), output, 0.0)
    if torque <= 0.0:
        return identity
    A, b = held_response(joint, theta, sampling_time)
    kept = [k for k in range(joint.speeds.stop) if k == row or k != joint.speeds.start - joint.keeps_angle]
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


def fit_whitening(
    joint: Joint, theta: Array, row: int, sampling_time: float, residual: Array, absorbed: int
) -> Whitening:
    """The whitening of a residual (n,) that holds little but noise."""
    impulse = impulse_response(joint, theta, row, sampling_time, len(residual))
    return whitening(joint, theta, row, sampling_time, noise_levels(residual, impulse, absorbed))
