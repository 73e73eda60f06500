"""The whitened spectrum of a residual, and what noise of the output and of the torque would show there.

What a fit or a catalogue of effects has taken from a residual is missing in its spectrum. Its leverage, the share that
it takes of white noise at each frequency, is allowed for; otherwise noise would look smaller than it is where many
columns lie.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpstrf
from scipy.signal.windows import hann

from robotid.estimate.noise.passed import PassedNoise, red_spectra
from robotid.estimate.noise.response import TorqueResponse
from robotid.estimate.noise.settings import MEDIAN, SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter
from robotid.model.array import Array, Index

DEPENDENT = 1e-10  # of a column's energy, below which nothing of it is its own


@dataclass(frozen=True, slots=True, eq=False)
class Residual:
    """A residual (n,) with the torque's response to it. columns : (m, n) that a fit or a catalogue has taken out of it;
    least : smallest variance of what the sensor adds, as the quantum of an encoder sets it; most_torque : largest
    variance of the torque's white noise [Nm2], as the recorded torque itself shows it (`torque_floor`); passed : what
    of the torque's noise shows along the motion, None where the joint slips all the time."""

    signal: Array
    response: TorqueResponse
    columns: Array | None = None
    least: float = 0.0
    most_torque: float = np.inf
    passed: PassedNoise | None = None

    @property
    def sensed(self) -> Array:
        """The residual of what the sensor shows, (n,)."""
        derivation = self.response.derivation
        return self.signal if derivation is None else derivation.centred_angle(self.signal)


def whitened_lines(
    one: Residual,
    whiten: InnovationsFilter,
    settings: LevelSettings = SETTINGS,
    innovations: Innovations | None = None,
) -> tuple[Array, Array]:
    """Periodogram of a whitened residual at the frequencies that tell of its noise, and what noise of the filter's own
    levels would show there, (f,) each. innovations : of this filter, where they are at hand."""
    innovations = Innovations.of(one, whiten, settings) if innovations is None else innovations
    levels = whiten.levels
    expected = levels.output * innovations.gain
    if levels.torque + levels.red > 0.0:
        white, red = innovations.of_the_torque(one, np.array([levels.corner]))
        expected = expected + levels.torque * white + levels.red * red[0]
    return innovations.power, expected


@dataclass(frozen=True, slots=True, eq=False)
class Innovations:
    """Periodogram of a whitened residual at the frequencies omega (f,) [rad per sample] that tell of its noise, and the
    squared gain (f,) by which noise of the output gets there. basis (r, n) : what has been taken out of it; energy :
    mean square of the rest."""

    omega: Array
    power: Array
    gain: Array
    basis: Array
    energy: float

    @classmethod
    def of(cls, one: Residual, whiten: InnovationsFilter, settings: LevelSettings) -> Innovations:
        n = len(one.signal)
        omega = 2 * np.pi * np.arange(1, n // 2 + 1) / n
        innovations, left, basis = whiten(one.signal), np.ones(n // 2), np.zeros((0, n))
        if one.columns is not None and len(one.columns):
            basis = orthonormal(whiten(one.columns))[-(n // 2) :]  # of a few samples, columns would leave no frequency
            innovations = innovations - (basis @ innovations) @ basis
            left = 1.0 - np.minimum(1.0, periodogram(basis).sum(axis=0))
        seen = np.flatnonzero(left > 1.0 - settings.full)
        if not len(seen):  # of all of them much has been taken, and no other tells more
            seen = np.flatnonzero(left >= np.median(left))
        if one.columns is None:
            seen = seen[seen >= settings.skipped]
        innovations = _clipped(innovations, settings.clip)
        power, energy = periodogram(innovations), float(innovations @ innovations) / max(1, n - len(basis))
        return cls(omega[seen], power[seen], whiten.squared(omega[seen]) * left[seen], basis, energy)

    def of_the_torque(self, one: Residual, corners: Array) -> tuple[Array, Array]:
        """What noise of the torque of unit variance adds to the periodogram: white (f,), and red of every corner,
        (corners, f)."""
        slipping = self.gain * one.response.squared(self.omega)
        spectra = red_spectra(corners, one.response.sampling_time, self.omega)
        if one.passed is None:
            return slipping, slipping * spectra
        factors = one.passed.factors(corners, self.omega)
        return slipping * factors[0], slipping * spectra * factors[1:]


def _clipped(signal: Array, most: float) -> Array:
    """A signal (n,) within so many robust standard deviations of what is not exactly zero, as all is where the motor
    rests and the simulation does."""
    size = np.abs(signal[signal != 0.0])
    if not np.isfinite(most) or not len(size):
        return signal
    limit = most * float(np.median(size)) / np.sqrt(MEDIAN)
    return np.clip(signal, -limit, limit)


def periodogram(signals: Array) -> Array:
    """Under a Hann taper, above frequency zero; that of white noise is its variance. (..., n) -> (..., n / 2)."""
    n = signals.shape[-1]
    taper = hann(n + 2)[1:-1]
    return np.asarray(np.abs(np.fft.rfft(taper * signals)[..., 1:]) ** 2 / np.sum(taper**2))


def orthonormal(columns: Array) -> Array:
    """Rows (r, n) that span the same as columns (m, n), those that hold most of them last: by a Cholesky factor of
    their products, the largest pivot first."""
    length = np.linalg.norm(columns, axis=1)
    scaled = columns[length > 0] / length[length > 0, None]
    if not len(scaled):
        return np.asarray(scaled)
    factor, order, rank, _ = dpstrf(scaled @ scaled.T, tol=DEPENDENT, lower=1)
    pivots = scaled[order[:rank] - 1]
    # from the right, on the transposed rows, which neither the solution nor their spectra have to be copied for
    rows = dtrsm(1.0, factor[:rank, :rank], pivots.T, side=1, lower=1, trans_a=1, overwrite_b=1).T
    return np.asarray(rows[::-1])


def band_edges(lines: int, settings: LevelSettings) -> Index:
    """First line of every band over which a spectrum is averaged: single lines, then bands of constant relative width.

    Smooth shapes hardly change within a band, and a long record has no more bands than it needs.
    """
    ratio = 1.0 + settings.band
    count = int(np.log(max(lines, 2)) / np.log(ratio)) + 2
    edges = np.unique(np.minimum(np.round(ratio ** np.arange(count)).astype(np.intp) - 1, max(lines - 1, 0)))
    return np.asarray(edges[: lines or 1])


def band_means(values: Array, edges: Index) -> Array:
    """Means over bands of the last axis, (..., f) -> (..., bands)."""
    if values.shape[-1] == 0:
        return values
    count = np.diff(np.append(edges, values.shape[-1]))
    return np.asarray(np.add.reduceat(values, edges, axis=-1) / count)
