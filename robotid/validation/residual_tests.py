"""Is there anything left in a residual? Its own correlation, its correlation with the torque, and its noise floor."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh, toeplitz
from scipy.special import chdtrc, ndtri

from robotid.estimate.covariance import autoregression
from robotid.model.array import Array
from robotid.validation.results import CONFIDENCE, ResidualTest

LAGS = 25
QUANTILE = float(ndtri(0.5 + CONFIDENCE / 2))
COLLINEAR = 1e-6  # share of the largest variance below which lagged torques say nothing of their own


def residual_test(residual: Array, torque: Array) -> ResidualTest:
    """Test a residual against itself and against the torque, both (n,); the means are taken off first."""
    e, u = residual - residual.mean(), torque - torque.mean()
    n, lags = len(e), min(LAGS, len(e) // 4)
    auto = _covariance(e, e, lags)[lags:]
    cross = _covariance(e, u, lags)
    scale = float(auto[0]) or 1.0
    r = auto[1:] / scale
    spread = _cross_variance(e, u, lags)
    both = np.sqrt(scale * float(u @ u) / n) or 1.0
    white = _white_part(e)
    return ResidualTest(
        autocorrelation=r,
        band=float(QUANTILE / np.sqrt(n)),
        crosscorrelation=cross / both,
        cross_band=float(QUANTILE * np.sqrt(spread[0] / n) / both),
        # Ljung & Box 1978
        whiteness_p=float(chdtrc(lags, n * (n + 2) * np.sum(r**2 / (n - np.arange(1, lags + 1))))),
        independence_p=_independence(cross[lags + 1 :], spread, n),
        white_part=white,
        coloured_part=float(np.sqrt(max(0.0, auto[0] - white**2))),
    )


def _covariance(a: Array, b: Array, lags: int) -> Array:
    """sum over t of a[t] b[t - lag] / n for lags -lags to lags, (2 lags + 1,)."""
    n = len(a)
    spectrum = np.fft.rfft(a, n + lags) * np.fft.rfft(b, n + lags).conj()
    c = np.fft.irfft(spectrum, n + lags) / n
    return np.concatenate([c[len(c) - lags :], c[: lags + 1]])


def _cross_variance(e: Array, u: Array, lags: int) -> Array:
    """n times the covariance of two cross-covariances at lags k apart, sum_j R_e(j) R_u(j + k), (lags,), k from 0.

    Ljung 1999, eq. (16.81), with the residual's spectrum from an autoregressive model of it.
    """
    n = len(e)
    a, variance = autoregression(e)
    length = n + max(lags, len(a) + 1)
    density = variance / np.abs(np.fft.rfft(np.concatenate([[1.0], -a]), length)) ** 2
    power = np.abs(np.fft.rfft(u, length)) ** 2 / n
    return np.asarray(np.fft.irfft(density * power, length)[:lags])


def _independence(cross: Array, spread: Array, n: int) -> float:
    """p value of all cross-covariances at once, their mutual covariance allowed for."""
    values, vectors = eigh(toeplitz(spread))
    kept = values > COLLINEAR * values[-1]
    if values[-1] <= 0:
        return 1.0
    return float(chdtrc(int(kept.sum()), n * np.sum((vectors.T @ cross)[kept] ** 2 / values[kept])))


def _white_part(e: Array) -> float:
    """Standard deviation of a white noise with the mean density of the upper half of the spectrum."""
    power = np.abs(np.fft.rfft(e)) ** 2 / len(e)
    return float(np.sqrt(power[len(power) // 2 :].mean()))
