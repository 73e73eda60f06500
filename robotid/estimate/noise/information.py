"""What noise of known levels does to a least-squares estimate.

An output-error fit weighs all samples alike and is consistent whatever the colour of its residual, but its covariance
is (J J')^-1 J R J' (J J')^-1 with R the covariance of the residual (Ljung 1999, section 9.5). Here R follows from where
the noise arises: an error of the torque passes through the joint and lasts, so R grows along the record, which no
stationary spectrum tells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from scipy.stats import chi2

from robotid.estimate.noise.levels import KINSHIP
from robotid.estimate.noise.lines import Innovations, Residual, whitened_lines
from robotid.estimate.noise.passage import TorquePassage
from robotid.estimate.noise.response import TorqueResponse
from robotid.estimate.noise.settings import SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.model.array import Array

BY_CHANCE = 0.005  # probability that noise lets any octave of the residuals that are judged together stand out
RANK = 1e-13  # smallest eigenvalue that counts, of the largest
BURSTS, QUIET = 1.5, 0.5  # times the linear noise, that are bursts; of the quietest draw, below which there are none
OCTAVE = 8  # lines of the narrowest one


@dataclass(frozen=True, slots=True, eq=False)
class SeenDerivatives:
    """Derivatives of the output of one record as its sensor shows them (m, n), and what the same weights make of the
    torque of every sample, (m, n)."""

    sensed: Array
    torque: Array
    sampling_time: float

    @classmethod
    def of(cls, jacobian: Array, response: TorqueResponse, passage: TorquePassage | None = None) -> SeenDerivatives:
        """jacobian : (m, n). passage : along the motion of the record; without it, or where it grows beyond all
        numbers, the joint slips all the time."""
        if response.derivation is not None:
            jacobian = response.derivation.speed_adjoint(jacobian)
        if passage is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                through = passage.adjoint(jacobian)
            if np.isfinite(through).all():
                return cls(jacobian, through, response.sampling_time)
        n = jacobian.shape[1]
        spectra = np.fft.rfft(jacobian, 2 * n, axis=1) * np.fft.rfft(response.impulse(n), 2 * n).conj()
        return cls(jacobian, np.fft.irfft(spectra, 2 * n, axis=1)[:, :n], response.sampling_time)

    def information(self, levels: NoiseLevels) -> Array:
        """J R J' for the noise of the record, (m, m)."""
        found = levels.output * self.sensed @ self.sensed.T + levels.torque * self.torque @ self.torque.T
        if levels.red > 0.0:
            pole = levels.pole(self.sampling_time)
            lasting = scipy.signal.lfilter([1.0], [1.0, -pole], self.torque[:, ::-1], axis=1)[:, ::-1].copy()
            lasting[:, 1:] *= np.sqrt(1.0 - pole**2)
            found = found + levels.red * lasting @ lasting.T
        return np.asarray(found)


def upper_envelope(one: Array, other: Array) -> Array:
    """The matrix that is in every common direction of two positive semidefinite ones as large as the larger of them.
    (m, m) each."""
    total = one + other
    scale = np.sqrt(np.maximum(np.diag(total), 1e-300))
    values, vectors = np.linalg.eigh(total / np.outer(scale, scale))
    kept = values > RANK * values[-1]
    root = vectors[:, kept] * np.sqrt(values[kept])
    into = vectors[:, kept] / np.sqrt(values[kept])
    shares, directions = np.linalg.eigh(into.T @ (one / np.outer(scale, scale)) @ into)
    spanned = root @ directions
    return np.asarray((spanned * np.maximum(shares, 1.0 - shares)) @ spanned.T * np.outer(scale, scale))


def is_explained(
    one: Residual,
    levels: NoiseLevels,
    settings: LevelSettings = SETTINGS,
    *,
    tolerance: float = 0.0,
    among: int = 1,
    innovations: Innovations | None = None,
) -> bool:
    """Whether noise of these levels is all that a residual shows. innovations : the residual whitened by these levels,
    where they are at hand; the rest as of `are_explained`."""
    known = None if innovations is None else [innovations]
    return are_explained([one], [levels], settings, tolerance=tolerance, among=among, innovations=known)


def are_explained(
    residuals: Sequence[Residual],
    levels: Sequence[NoiseLevels],
    settings: LevelSettings = SETTINGS,
    *,
    tolerance: float = 0.0,
    among: int = 1,
    drawn: Callable[[], Sequence[Sequence[Array]]] = tuple,
    innovations: Sequence[Innovations] | None = None,
) -> bool:
    """Whether noise of these levels is all that the residuals of a record's pieces show: no octave of their whitened
    spectra stands out. Errors of a torque are no larger here than there by law; so the pieces are judged together.

    tolerance : by how much of the noise an octave may differ though it is no chance; among : of how many records none
    may show more by chance; drawn : gives residuals (n,) of all pieces, each time, that such noise makes of a joint
    that is not linear, if need be. An octave may then be as loud as these are on average; and where each of them is
    louder than the linear joint, the bursts that shifted reversals leave must be there. innovations : the residuals
    whitened by these levels, where they are at hand.
    """
    whiten = [innovations_filter(one.response, level) for one, level in zip(residuals, levels, strict=True)]
    known: Sequence[Innovations | None] = innovations or [None] * len(whiten)
    seen, lines = _together(
        _octaves(one, by, settings, own) for one, by, own in zip(residuals, whiten, known, strict=True)
    )
    free = 2.0 * lines / KINSHIP  # of the energy of an octave, which has a chi-squared distribution
    chance = BY_CHANCE / (among * len(lines))
    least = np.minimum(1.0 - tolerance, chi2.ppf(chance, free) / free)
    most = np.maximum(1.0 + tolerance, chi2.isf(chance, free) / free)
    if np.all((least <= seen) & (seen <= most)):
        return True
    made = np.array(
        [
            _together(
                _octaves(replace(one, signal=signal), by, settings)
                for one, signal, by in zip(residuals, signals, whiten, strict=True)
            )[0]
            for signals in drawn()
        ]
    )
    if not made.size:
        return False
    loud = bool(np.any(seen / np.maximum(1.0, made.mean(axis=0)) > most))
    quietest = made.min(axis=0)
    return not loud and not np.any((quietest > BURSTS) & (seen < QUIET * quietest))


def _together(octaves: Iterable[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Mean energies of the octaves of several residuals, and how many frequencies they have in all, (k,) each."""
    found = list(octaves)
    energy, lines = np.zeros((2, max(len(one) for one, _ in found)))
    for ratios, count in found:
        energy[: len(count)] += ratios * count
        lines[: len(count)] += count
    return energy / lines, lines


def loudest_octave(one: Residual, levels: NoiseLevels, settings: LevelSettings = SETTINGS) -> float:
    """Energy of the octave of a residual that stands out most, over what noise of these levels shows there."""
    return float(_octaves(one, innovations_filter(one.response, levels), settings)[0].max())


def _octaves(
    one: Residual, whiten: InnovationsFilter, settings: LevelSettings, innovations: Innovations | None = None
) -> tuple[Array, Array]:
    """Energy of a whitened residual in each octave, over that of the filter's own noise, and how many frequencies the
    octave has, (k,) each."""
    power, expected = whitened_lines(one, whiten, settings, innovations)
    edges = [0, OCTAVE]
    while 2 * edges[-1] < len(power):
        edges.append(2 * edges[-1])
    bands = [slice(a, b) for a, b in pairwise([*edges, len(power)]) if b > a]
    ratios = [float(np.mean(power[band] / expected[band])) for band in bands]
    return np.array(ratios), np.array([band.stop - band.start for band in bands], dtype=np.float64)
