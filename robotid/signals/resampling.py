"""Signals from the time stamps of their samples onto a regular grid.

A torque that a controller sets lasts until it sets it anew, so each interval of the grid gets the mean torque that
acted in it. The motion is interpolated by a spline of degree five through the samples: with stamps that jitter by 10 %
of the interval, its error on a motion of 40 Hz is 4e-7 of the amplitude at 2 ms and 3e-5 at 4 ms, 15 to 60 times below
that of a cubic one, and the steps of an encoder come out as on a regular clock. What the steps of the torque do to the
motion is no polynomial: the integral of the torque, scaled as the samples demand, is taken off before and added after.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import ceil, floor

import numpy as np
import scipy
from numpy.typing import NDArray

from robotid.model.array import Array
from robotid.signals.differentiate import bandwidth, central_difference, low_pass

DEGREE = 5  # of the spline
CLOSEST = 0.25  # intervals between samples of the spline: noise of closer ones would become a steep slope
PASSES = 30  # of the weights that leave out reversals
SIGNIFICANT = 25.0  # F of one more regressor, from which the steps of the torque are seen in a motion
MIN_TO_COMPARE = 20  # samples from which the smoothness of a signal is measured
SMOOTHER = 0.7  # of the roughness over the stamps, below which the regular grid is what was sampled on
MARGIN = 4.0  # cut-off over the band, so that the filter takes noise and not motion
ACCELERATION_SHARE = 0.99  # of the energy of a speed that its acceleration is measured from


def grid_positions(at: Array) -> Array:
    """Regular positions within those of the samples, as near to them as one phase allows. at : (n,) increasing stamps
    in intervals -> (m,)."""
    phase = float(np.angle(np.mean(np.exp(2j * np.pi * at)))) / (2 * np.pi)
    slack = 1e-9 * max(1.0, abs(float(at[-1])))
    return phase + np.arange(ceil(at[0] - phase - slack), floor(at[-1] - phase + slack) + 1, dtype=np.float64)


def resample(at: Array, signals: Mapping[str, Array], held: Collection[str]) -> dict[str, Array]:
    """Signals on the regular grid within their stamps, (m,) each.

    at : (n,) increasing stamps in intervals; signals : (n,) each; held : those that last from sample to sample.
    """
    grid = grid_positions(at)
    driven = _integrals(at, signals["tau_m"], grid) if "tau_m" in signals else {}
    found = {}
    for name, signal in signals.items():
        if name in held:
            found[name] = mean_over_intervals(at, signal, grid)
        elif name in driven:
            before, after = driven[name]
            share = _driven_share(at, signal, before)
            found[name] = interpolate(at, signal - share * before, grid) + share * after
        else:
            found[name] = interpolate(at, signal, grid)
    return found


def interpolate(at: Array, signal: Array, grid: Array) -> Array:
    """A signal that goes on between its samples, at the positions of a grid. at, signal : (n,); grid : (m,) -> (m,)."""
    kept = _apart(at)
    degree = min(DEGREE, len(kept) - 1)
    spline = scipy.interpolate.make_interp_spline(at[kept], signal[kept], k=degree)
    return np.asarray(spline(np.clip(grid, at[0], at[-1])), dtype=np.float64)


def _integrals(at: Array, torque: Array, grid: Array) -> dict[str, tuple[Array, Array]]:
    """What a held torque, less its mean, makes of speed and angle of a mass of one, at its samples (n,) and on the grid
    (m,)."""
    u = torque - torque.mean()
    step = np.diff(at)
    speed = np.concatenate([[0.0], np.cumsum(u[:-1] * step)])
    angle = np.concatenate([[0.0], np.cumsum(speed[:-1] * step + 0.5 * u[:-1] * step**2)])
    k = np.clip(np.searchsorted(at, grid, side="right") - 1, 0, len(at) - 1)
    rest = grid - at[k]
    return {
        "dphi_m": (speed, speed[k] + u[k] * rest),
        "phi_m": (angle, angle[k] + speed[k] * rest + 0.5 * u[k] * rest**2),
    }


def _driven_share(at: Array, signal: Array, driven: Array) -> float:
    """The factor of what the torque drives in a signal, that leaves it smoothest; 0.0 where that is not significant."""
    if len(at) < MIN_TO_COMPARE:
        return 0.0
    y, x = _off_cubic(at, signal), _off_cubic(at, driven)
    share, weights = 0.0, np.ones(len(y))
    for _ in range(PASSES):  # Cauchy's weights: where friction reverses, the samples tell of friction
        share = float((weights * x) @ y) / max(float((weights * x) @ x), 1e-300)
        rest = y - share * x
        weights = 1.0 / (1.0 + np.square(rest / max(2.0 * float(np.median(np.abs(rest))), 1e-300)))
    gain = 1.0 - float(weights @ rest**2) / max(float(weights @ y**2), 1e-300)
    return share if gain * len(y) > SIGNIFICANT else 0.0


def mean_over_intervals(at: Array, signal: Array, grid: Array) -> Array:
    """Mean over each interval of a grid (m,) of a signal that lasts from its sample to the next. at, signal : (n,)."""
    integral = np.concatenate([[0.0], np.cumsum(signal[:-1] * np.diff(at))])
    edges = np.append(grid, grid[-1] + 1.0)
    lasting = np.concatenate([integral, [integral[-1] + signal[-1] * 2.0]])
    return np.asarray(np.diff(np.interp(edges, np.append(at, at[-1] + 2.0), lasting)))


def _apart(at: Array) -> NDArray[np.intp]:
    """Numbers of samples of which none is closer to the one before than CLOSEST."""
    if float(np.diff(at).min()) >= CLOSEST:
        return np.arange(len(at))
    kept = [0]
    for k in range(1, len(at)):
        if at[k] - at[kept[-1]] >= CLOSEST:
            kept.append(k)
    return np.array(kept)


def sampled_regularly(at: Array, numbers: Array, angle: Array) -> bool:
    """Whether an angle is smoother over the numbers of its samples than over their time stamps: then the stamps jitter,
    as those of a logger that writes when it finds the time, and not the sampling. at, numbers, angle : (n,)."""
    return _roughness(numbers, angle) < SMOOTHER * _roughness(at, angle)


def _roughness(x: Array, y: Array) -> float:
    """Median distance of a sample from the cubic through its four neighbours. x, y : (n,)."""
    return float(np.median(np.abs(_off_cubic(x, y))))


def _off_cubic(x: Array, y: Array) -> Array:
    """Distance of each sample from the cubic through its four neighbours, (n - 4,), in units of what white noise of one
    would show. x, y : (n,)."""
    outer = (-2, -1, 1, 2)
    centre = slice(2, len(x) - 2)
    near = [x[2 + k : len(x) - 2 + k] - x[centre] for k in outer]
    weights = []
    for i, xi in enumerate(near):
        others = [xj for j, xj in enumerate(near) if j != i]
        weights.append(np.prod([xj / (xj - xi) for xj in others], axis=0))
    predicted = np.sum([w * y[2 + k : len(y) - 2 + k] for w, k in zip(weights, outer, strict=True)], axis=0)
    return np.asarray((predicted - y[centre]) / np.sqrt(1.0 + np.sum(np.square(weights), axis=0)))


def speed_error(late: Array, speed: Array, sampling_time: float, *, derived: bool) -> float:
    """Root mean square error of the speed [rad/s] had jitter been ignored, on this record.

    late : (n,) [s] of each stamp against a regular clock; speed : (m,) on the grid; derived : it is the derivative of
    the angle, so that a wrong interval scales it; a recorded speed is only taken for that of another time.
    """
    spread = float(np.sqrt(np.mean(np.square(late - late.mean()))))
    band = max(1.0 / (len(speed) * sampling_time), bandwidth(speed, sampling_time, ACCELERATION_SHARE))
    smooth = low_pass(speed, sampling_time, MARGIN * band)
    if derived:
        stretched = central_difference(late, sampling_time)
        return float(np.sqrt(np.mean(np.square(stretched)) * np.mean(np.square(smooth))))
    return spread * float(np.sqrt(np.mean(np.square(central_difference(smooth, sampling_time)))))
