"""Uncertainty of least-squares estimates: classical, and robust to coloured residuals.

Output errors of a simulation are coloured as soon as the model or the torque is not perfect, and the classical
covariance then promises too much. The robust one is the sandwich H^-1 B H^-1 with B = J^T R J (Ljung 1999, section
9.5). R, the covariance of the residual, is taken as the sum of two parts: a stationary one, an autoregression
(Andrews & Monahan 1992), and the response of the joint itself to a white error of the torque. The second grows along
the record and hides at frequencies that the fit absorbs; its level is read off where it does show (Whittle 1953).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import expm, solve_toeplitz
from scipy.optimize import minimize

from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint

MAX_ORDER = 30  # of an autoregression; residuals of machines need less than ten
ABSORBED = 4  # lowest frequencies of a record, which the fit shapes


def autoregression(residual: Array) -> tuple[Array, float]:
    """Autoregressive model of a residual: e[n] = sum a_k e[n - k] + w[n]. residual (n,) -> a (order,), variance of w.

    Yule-Walker, order by the Bayesian information criterion.
    """
    n = len(residual)
    e = residual - residual.mean()
    orders = min(MAX_ORDER, n // 10)
    c = lagged_products(e, e, orders) / n
    best, best_bic = (np.zeros(0), float(c[0])), n * np.log(max(c[0], 1e-300))
    for order in range(1, orders + 1):
        a = solve_toeplitz(c[:order], c[1 : order + 1]) if c[0] > 0 else np.zeros(order)
        variance = float(c[0] - a @ c[1 : order + 1])
        bic = n * np.log(max(variance, 1e-300)) + order * np.log(n)
        if bic < best_bic and variance > 0:
            best, best_bic = (a, variance), bic
    return best


def lagged_products(a: Array, b: Array, lags: int) -> Array:
    """sum over t of a[t] b[t - lag] for lags 0 to lags, (lags + 1,). a, b (n,)."""
    return np.array([a[lag:] @ b[: len(b) - lag] for lag in range(lags + 1)])


def zero_order_hold_response(joint: Joint, theta: Array, sampling_time: float) -> tuple[Array, Array]:
    """x[n + 1] = A x[n] + b u[n] of a slipping joint with its spring at rest, its torque constant from sample to
    sample: A (nx, nx), b (nx,), which may not be written to, for all pieces of a record have the same."""
    return _zero_order_hold_response(joint, np.asarray(theta, dtype=np.float64).tobytes(), sampling_time)


@lru_cache(maxsize=8)
@np.errstate(over="ignore", invalid="ignore")  # of a joint that runs away
def _zero_order_hold_response(joint: Joint, theta: bytes, sampling_time: float) -> tuple[Array, Array]:
    """The same. theta : as bytes, which can be compared."""
    x = np.zeros((joint.nx, 1))
    s = np.ones((joint.masses, 1))
    at = joint.evaluate(x, np.zeros(1), s, np.zeros(1), np.frombuffer(theta), columns=DerivativeColumns())
    assert at.B is not None
    d = joint.nx
    block = np.zeros((d + 1, d + 1))
    block[:d, :d], block[:d, d] = at.A[:, :, 0], at.B[:, -1, 0]
    discrete = expm(block * sampling_time)
    discrete.flags.writeable = False
    return discrete[:d, :d], discrete[:d, d]


@np.errstate(over="ignore", invalid="ignore")  # of a joint that runs away
def impulse_response(joint: Joint, theta: Array, row: int, sampling_time: float, n: int) -> Array:
    """State `row` after a torque of 1 Nm during one interval, while slipping with the spring at rest, (n,)."""
    A, b = zero_order_hold_response(joint, theta, sampling_time)
    stride = int(np.ceil(np.sqrt(n)))
    # after stride j + k steps, (row of A^k) (A^(stride j) b): no state is kept but every stride samples
    within, starts = np.empty((stride, len(b))), np.empty((len(b), stride))
    power = np.eye(len(b))
    for k in range(stride):
        within[k], power = power[row], power @ A
    for j in range(stride):
        starts[:, j], b = b, power @ b
    return np.concatenate([[0.0], (within @ starts).T.ravel()[: n - 1]])


def coloured_information(jacobian: Array, residual: Array, impulse: Array | None = None) -> Array:
    """B = J^T R J with R the covariance of the residual. jacobian (m, n), residual (n,) -> (m, m).

    impulse : (n,) of the output to the torque; without it R has its stationary part only.
    """
    n = len(residual)
    a, variance = autoregression(residual)
    response = np.fft.rfft(np.concatenate([[1.0], -a]), 2 * n)
    stationary, level = variance / np.abs(response) ** 2, 0.0
    columns = np.fft.rfft(jacobian, 2 * n, axis=1)
    if impulse is not None:
        torque = np.fft.rfft(impulse, 2 * n)
        stationary, level = _compose(residual, stationary, np.abs(torque) ** 2, len(a))
    weight = np.full(n + 1, 2.0)
    weight[[0, -1]] = 1.0
    shaped = columns * np.sqrt(weight * stationary / (2 * n))
    information = (shaped @ shaped.conj().T).real
    if impulse is None or level == 0.0:
        return np.asarray(information)
    back = np.fft.irfft(columns * torque.conj(), 2 * n, axis=1)[:, :n]
    return np.asarray(information + level * back @ back.T)


def _compose(residual: Array, coloured: Array, torque: Array, order: int) -> tuple[Array, float]:
    """The stationary spectrum of a residual and the variance of the torque error in it, spectra (n + 1,).

    White or autoregressive, with or without a torque error: what the Bayesian information criterion prefers.
    """
    n = len(residual)
    seen = slice(ABSORBED, (n + 1) // 2)
    periodogram = np.abs(np.fft.rfft(residual))[seen] ** 2 / n
    if periodogram.size == 0 or not periodogram.any():
        return coloured, 0.0
    best, answer = np.inf, (coloured, 0.0)
    for stationary, parameters in ((np.ones(n + 1), 1), (coloured, order + 1)):
        for bases in ((stationary,), (stationary, torque)):
            fit, levels = _whittle(periodogram, np.stack([b[::2][seen] for b in bases]))
            bic = 2 * len(periodogram) * fit + (parameters + len(bases) - 1) * np.log(n)
            if bic < best:
                best, answer = bic, (levels[0] * stationary, float(levels[1]) if len(bases) == 2 else 0.0)
    return answer


def _whittle(periodogram: Array, bases: Array) -> tuple[float, Array]:
    """Levels of spectra (k, f) that explain a periodogram (f,) best, and half the mean negative log-likelihood."""
    sizes = periodogram.mean() / bases.mean(axis=1)

    def cost(logs: Array) -> float:
        model = np.exp(logs) * sizes @ bases
        return float(np.mean(np.log(model) + periodogram / model))

    found = minimize(cost, np.full(len(bases), -0.7), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-8})
    return float(found.fun), np.exp(found.x) * sizes


def sandwich(outer: Array, middle: Array) -> Array:
    """outer middle outer' of a covariance, as a square: of a motion that runs away rounding would leave variances
    below zero. outer (k, m), middle (m, m) -> (k, k)."""
    length = np.sqrt(np.maximum(np.diag(middle), 0.0))
    length = np.where(length > 0.0, length, 1.0)
    values, vectors = np.linalg.eigh(middle / np.outer(length, length))
    root = (outer * length) @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    return np.asarray(root @ root.T)
