"""Uncertainty of least-squares estimates: classical, and robust to coloured residuals.

Output errors of a simulation are coloured as soon as the model or the torque is not perfect, and the classical
covariance then promises too much. The robust one is the sandwich H^-1 B H^-1 with B = J^T R J, R the residual's covariance
from an autoregressive model of it (Ljung 1999, section 9.5; Andrews & Monahan 1992 for the autoregressive estimate).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz

from robotid.model.array import Array

HIGHEST_ORDER = 30


def autoregression(residual: Array, highest: int = HIGHEST_ORDER) -> tuple[Array, float]:
    """Autoregressive model of a residual: e[n] = sum a_k e[n - k] + w[n]. residual (n,) -> a (order,), variance of w.

    Yule-Walker, order by the Bayesian information criterion.
    """
    n = len(residual)
    e = residual - residual.mean()
    spectrum = np.abs(np.fft.rfft(e, 2 * n)) ** 2
    c = np.fft.irfft(spectrum)[: highest + 1] / n
    best, best_bic = (np.zeros(0), float(c[0])), n * np.log(max(c[0], 1e-300))
    for order in range(1, min(highest, n // 10) + 1):
        a = solve_toeplitz(c[:order], c[1 : order + 1]) if c[0] > 0 else np.zeros(order)
        variance = float(c[0] - a @ c[1 : order + 1])
        bic = n * np.log(max(variance, 1e-300)) + order * np.log(n)
        if bic < best_bic and variance > 0:
            best, best_bic = (a, variance), bic
    return best


def coloured_information(jacobian: Array, residual: Array) -> Array:
    """B = J^T R J with R the covariance of the residual as an autoregression. jacobian (m, n), residual (n,) -> (m, m)."""
    a, variance = autoregression(residual)
    length = 2 * jacobian.shape[1]
    response = np.fft.rfft(np.concatenate([[1.0], -a]), length)
    columns = np.fft.rfft(jacobian, length, axis=1)
    weight = np.full(columns.shape[1], 2.0)
    weight[[0, -1]] = 1.0
    shaped = columns * np.sqrt(weight * variance / length) / np.abs(response)
    return np.asarray((shaped @ shaped.conj().T).real)
