"""Signals from the time stamps of their samples onto a regular grid.

A torque that a controller sets lasts until it sets it anew, so each interval of the grid gets the mean torque that
acted in it. The motion is interpolated by a spline of degree five through the samples: with stamps that jitter by 10 %
of the interval, its error on a motion of 40 Hz is 4e-7 of the amplitude at 2 ms and 3e-5 at 4 ms, 15 to 60 times below
that of a cubic one, and the steps of an encoder come out as on a regular clock. What the steps of the torque do to the
motion is no polynomial, nor is what dry friction does to a speed that reverses: the integrals of the torque and of the
direction of motion, scaled as the samples demand, are taken off before and added after.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from math import ceil, floor

import numpy as np
import scipy
from numpy.typing import NDArray

from robotid.model.array import Array
from robotid.signals.differentiate import bandwidth, central_difference, low_pass

DEGREE = 5  # of the spline
CLOSEST = 0.25  # intervals between samples of the spline: noise of closer ones would become a steep slope
PASSES = 30  # of the weights that leave out what neither torque nor friction makes
NOTHING = 1e-6  # of the largest distance of a corner from a smooth curve, that counts as rounding
LATE = 0.3  # of a corner, by which a stamp that is late may spoil it: no sign of a disturbance
REVERSAL_PASSES = 3  # of the instants of reversals
SIGNIFICANT = 25.0  # F of one more regressor, from which the steps of the torque are seen in a motion
LATEST, LATE_STEP = 3.0, 0.25  # intervals by which a torque may act late, and the steps in which that is sought
SAMPLES_TO_COMPARE = 20_000  # from which the lateness is found: more would cost seconds
MIN_TO_COMPARE = 20  # samples from which the smoothness of a signal is measured
UNEVEN = 1.5  # ratio of the intervals around a sample, from which it tells stamps from numbers
SMOOTHER = 0.7  # of the roughness over the stamps, below which the regular grid is what was sampled on
MARGIN = 4.0  # cut-off over the band, so that the filter takes noise and not motion
ACCELERATION_SHARE = 0.99  # of the energy of a speed that its acceleration is measured from


def grid_positions(at: Array) -> Array:
    """Regular positions within those of the samples, as near to them as one phase allows. at : (n,) increasing stamps
    in intervals -> (m,)."""
    phase = float(np.angle(np.mean(np.exp(2j * np.pi * at)))) / (2 * np.pi)
    slack = 1e-9 * max(1.0, abs(float(at[-1])))
    return phase + np.arange(ceil(at[0] - phase - slack), floor(at[-1] - phase + slack) + 1, dtype=np.float64)


def resample(
    at: Array, signals: Mapping[str, Array], held: Collection[str], stamps: Array | None = None
) -> dict[str, Array]:
    """Signals on the regular grid within their stamps, (m,) each.

    at : (n,) increasing stamps in intervals; signals : (n,) each; held : those that last from sample to sample, which
    are interpolated at stamps (k,) that were lost before.
    """
    grid, stamps = grid_positions(at), at if stamps is None else stamps
    found = {}
    for name, signal in signals.items():
        if name in held:
            found[name] = mean_over_intervals(stamps, np.interp(stamps, at, signal), grid)
        elif name in ("phi_m", "dphi_m") and "tau_m" in signals and len(at) >= MIN_TO_COMPARE:
            torque = np.interp(stamps, at, signals["tau_m"])
            driven = _Driven(stamps, torque - torque.mean(), speed=name == "dphi_m")
            found[name] = _with_corners(at, signal, driven).at(grid)
        else:
            found[name] = interpolate(at, signal, grid)
    return found


def interpolate(at: Array, signal: Array, grid: Array) -> Array:
    """A signal that goes on between its samples, at the positions of a grid. at, signal : (n,); grid : (m,) -> (m,)."""
    kept = _apart(at)
    degree = min(DEGREE, len(kept) - 1)
    spline = scipy.interpolate.make_interp_spline(at[kept], signal[kept], k=degree)
    return np.asarray(spline(np.clip(grid, at[0], at[-1])), dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class _Driven:
    """What a torque (n,) from its stamp (n,) to the next makes of the speed, or else the angle, of a mass of one, where
    it acts late by so many intervals."""

    stamps: Array
    torque: Array
    speed: bool
    late: float = 0.0

    def at(self, x: Array) -> Array:
        """(m,) -> (m,)."""
        step, u, x = np.diff(self.stamps), self.torque, x - self.late
        speed = np.concatenate([[0.0], np.cumsum(u[:-1] * step)])
        k = np.clip(np.searchsorted(self.stamps, x, side="right") - 1, 0, len(u) - 1)
        rest = x - self.stamps[k]
        if self.speed:
            return np.asarray(speed[k] + u[k] * rest)
        angle = np.concatenate([[0.0], np.cumsum(speed[:-1] * step + 0.5 * u[:-1] * step**2)])
        return np.asarray(angle[k] + speed[k] * rest + 0.5 * u[k] * rest**2)


@dataclass(frozen=True, slots=True, eq=False)
class _Reversing:
    """What a friction of one makes of the speed of a mass of one that reverses at instants (k,). first : direction
    before these."""

    first: float
    instants: Array

    @classmethod
    def of(cls, at: Array, speed: Array) -> _Reversing:
        """Reversals of a speed that is straight between its samples."""
        moving = np.flatnonzero(speed)
        if not len(moving):
            return cls(1.0, np.zeros(0))
        last = np.searchsorted(moving, np.arange(len(speed)), side="right") - 1
        direction = np.sign(speed[moving[np.maximum(last, 0)]])
        k = np.flatnonzero(direction[:-1] * direction[1:] < 0.0)
        return cls(float(direction[0]), at[k] + speed[k] / (speed[k] - speed[k + 1]) * (at[k + 1] - at[k]))

    def at(self, x: Array) -> Array:
        """(m,) -> (m,)."""
        edges = np.concatenate([[min(0.0, float(x[0]))], self.instants])
        direction = self.first * (1.0 - 2.0 * (np.arange(len(edges)) % 2))
        integral = np.concatenate([[0.0], np.cumsum(direction[:-1] * np.diff(edges))])
        k = np.searchsorted(edges, x, side="right") - 1
        return np.asarray(integral[k] + direction[k] * (x - edges[k]))


@dataclass(frozen=True, slots=True, eq=False)
class _Cornered:
    """A signal (n,) at its stamps (n,), smooth but for what corners, each with its factor, make of it."""

    stamps: Array
    signal: Array
    corners: tuple[tuple[float, _Driven | _Reversing], ...] = ()

    @property
    def smooth(self) -> Array:
        """The signal without its corners, (n,)."""
        return np.asarray(self.signal - self._corners(self.stamps))

    def at(self, x: Array) -> Array:
        """(m,) -> (m,)."""
        return np.asarray(interpolate(self.stamps, self.smooth, x) + self._corners(x))

    def with_corner(self, corner: _Driven | _Reversing) -> _Cornered:
        """With a further corner, the factor 0.0 where it is not significant."""
        factor, significance = self._of(corner)
        return replace(self, corners=(*self.corners, (factor if significance > SIGNIFICANT else 0.0, corner)))

    def when_driven(self, driven: _Driven) -> _Driven:
        """With the lateness of the torque that its corners show best, none where that shows them hardly better."""
        n = min(len(self.stamps), SAMPLES_TO_COMPARE)
        first = _Cornered(self.stamps[:n], self.signal[:n])

        def shown(late: float) -> float:
            return first._of(replace(driven, late=late))[1]

        prompt, coarse = shown(0.0), np.arange(0.0, LATEST + LATE_STEP, LATE_STEP)
        best = float(coarse[np.argmax([shown(late) for late in coarse])])
        around = max(0.0, best - LATE_STEP), best + LATE_STEP
        found = scipy.optimize.minimize_scalar(lambda late: -shown(late), bounds=around, method="bounded")
        return replace(driven, late=float(found.x)) if -found.fun > prompt + SIGNIFICANT else driven

    def _of(self, corner: _Driven | _Reversing) -> tuple[float, float]:
        """The factor of a further corner, and its F."""
        return _factor(*(_off_cubic(self.stamps, one) for one in (self.smooth, corner.at(self.stamps))))

    def _corners(self, x: Array) -> Array:
        return np.asarray(np.sum([np.zeros(len(x)), *(factor * one.at(x) for factor, one in self.corners)], axis=0))


def _with_corners(at: Array, signal: Array, driven: _Driven) -> _Cornered:
    """A signal (n,) at its stamps (n,) with the corners that are significant: of the torque, and of the friction that a
    speed under this torque turns round at its reversals."""
    plain = _Cornered(at, signal)
    found = by_torque = plain.with_corner(plain.when_driven(driven))
    reversing, step = _Reversing.of(at, signal), np.diff(at)
    if not driven.speed or not found.corners[0][0] or not len(reversing.instants):
        return found
    k = np.searchsorted(at, reversing.instants, side="right") - 1
    slope = np.diff(signal)[k] / step[k]
    for _ in range(REVERSAL_PASSES):
        found = by_torque.with_corner(reversing)
        moved = reversing.instants - found.at(reversing.instants) / slope
        reversing = replace(reversing, instants=np.clip(moved, at[k], at[k + 1]))
    return by_torque.with_corner(reversing)


def _factor(y: Array, x: Array) -> tuple[float, float]:
    """The factor of x (n,) that leaves least of y (n,), where x is not zero, and its F: by how much the squared error
    falls, in units of what noise would."""
    seen = np.abs(x) > NOTHING * np.abs(x).max()
    if not seen.any():
        return 0.0, 0.0
    y, x = y[seen], x[seen]
    factor = _heavy_median(y / np.where(x == 0.0, 1.0, x), x**2)
    for _ in range(PASSES):  # Cauchy's weights: what sticks or is disturbed, tells of neither torque nor friction
        left = y - factor * x
        usual = 2.0 * float(np.median(np.abs(left))) + LATE * np.abs(factor * x)
        weights = 1.0 / (1.0 + np.square(left / np.maximum(usual, 1e-300)))
        factor = float((weights * x) @ y) / max(float((weights * x) @ x), 1e-300)
    left = y - factor * x
    gain = 1.0 - float(weights @ left**2) / max(float(weights @ y**2), 1e-300)
    return factor, gain * len(y)


def _heavy_median(values: Array, weights: Array) -> float:
    """The value (n,) below which half of the weight (n,) lies."""
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])


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
    as those of a logger that writes when it finds the time, and not the sampling. Smoothness is the median distance of
    a sample from the cubic through its four neighbours. at, numbers, angle : (n,)."""
    steps = np.lib.stride_tricks.sliding_window_view(np.diff(at), 4)  # evenly spaced samples look alike on both
    uneven = steps.max(axis=1) > UNEVEN * steps.min(axis=1)
    where = uneven if int(uneven.sum()) >= MIN_TO_COMPARE else np.ones(len(steps), dtype=bool)
    rough = [float(np.median(np.abs(_off_cubic(x, angle)[where]))) for x in (numbers, at)]
    return rough[0] < SMOOTHER * rough[1]


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
