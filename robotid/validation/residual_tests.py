"""Is there anything left in a residual? Its own correlation, its correlation with the torque, and its noise floor."""

from __future__ import annotations

import numpy as np
from scipy.fft import next_fast_len
from scipy.special import ndtr, ndtri

from robotid.estimate.covariance import autoregression, lagged_products
from robotid.model.array import Array
from robotid.signals.differentiate import transform_length
from robotid.validation.results import CONFIDENCE, ResidualTest

LAGS = 25


def residual_test(residual: Array, torque: Array) -> ResidualTest:
    """Test a residual against itself and against the torque, both (n,); the means are taken off first.

    The largest correlation decides, against the band that all of them keep to together (Sidak 1967: correlations that
    depend on each other keep to it the more).
    """
    e, u = residual - residual.mean(), torque - torque.mean()
    n, lags = len(e), min(LAGS, len(e) // 4)
    auto = lagged_products(e, e, lags) / n
    cross = np.concatenate([lagged_products(u, e, lags)[:0:-1], lagged_products(e, u, lags)]) / n
    scale = float(auto[0]) or 1.0
    r = auto[1:] / scale
    deviation = float(np.sqrt(_cross_variance(e, u) / n))
    both = np.sqrt(scale * float(u @ u) / n) or 1.0
    white = _white_part(e)
    return ResidualTest(
        autocorrelation=r,
        band=float(quantile(lags) / np.sqrt(n)),
        crosscorrelation=cross / both,
        cross_band=float(quantile(lags) * deviation / both),
        whiteness_p=_p_of_largest(r * np.sqrt(n)),
        independence_p=_p_of_largest(cross[lags + 1 :] / (deviation or np.inf)),
        white_part=white,
        coloured_part=float(np.sqrt(max(0.0, auto[0] - white**2))),
    )


def quantile(lags: int) -> float:
    """What so many normal variables all stay below in size, at the confidence of the tests."""
    return float(ndtri(0.5 + CONFIDENCE ** (1 / max(1, lags)) / 2))


def _p_of_largest(normal: Array) -> float:
    """p value of the largest of some variables that are normal with unit variance under the hypothesis."""
    largest = float(np.abs(normal).max(initial=0.0))
    return float(-np.expm1(len(normal) * np.log1p(-2 * ndtr(-largest)))) if largest > 0 else 1.0


def _cross_variance(e: Array, u: Array) -> float:
    """n times the variance of a cross-covariance of two signals that do not depend on each other, sum_j R_e(j) R_u(j).

    Ljung 1999, eq. (16.81), with the residual's spectrum from an autoregressive model of it.
    """
    n = len(e)
    a, variance = autoregression(e)
    length = next_fast_len(n + max(LAGS, len(a) + 1), real=True)
    density = variance / np.abs(np.fft.rfft(np.concatenate([[1.0], -a]), length)) ** 2
    power = np.abs(np.fft.rfft(u, length)) ** 2 / n
    return float(np.fft.irfft(density * power, length)[0])


def _white_part(e: Array) -> float:
    """Standard deviation of a white noise with the mean density of the upper half of the spectrum."""
    n = transform_length(len(e))
    power = np.abs(np.fft.rfft(e[:n])) ** 2 / n
    return float(np.sqrt(power[len(power) // 2 :].mean()))
