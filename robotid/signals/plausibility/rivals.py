"""Other readings of the same columns: do they explain the torque surely better than the recorded one?

Two linear regressions of one filtered torque are compared block by block. The mean of the logarithms of what one leaves
over what the other leaves, over its own deviation, says whether one of them is better, whatever the noise (as Diebold &
Mariano 1995 compare forecasts; logarithms, lest the few blocks in which the motion reverses decide alone).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil

import numpy as np

from robotid.model.array import Array
from robotid.signals.plausibility.regression import (
    Determined,
    FilteredMotion,
    LeastSquares,
    explained_share,
)
from robotid.signals.plausibility.relation import MASS
from robotid.signals.plausibility.settings import REGRESSION

FINE = 16  # shifts within a sample: a low-pass filter leaves few samples


@dataclass(frozen=True, slots=True)
class Rival:
    """Another reading of a record. gain : mean logarithm of what the recorded reading leaves of the torque's energy in
    a block over what this one leaves; recorded, explained : shares of the torque's variance that the two explain;
    inertia [kg m2] under this one; shift [s] : by which the torque that it takes is later in the file."""

    gain: Determined
    recorded: float
    explained: float
    inertia: Determined
    shift: float = 0.0


def angle_as_speed(recorded: Sequence[FilteredMotion], turns: float | None) -> Rival | None:
    """The column of the angle taken for the speed; None for a record too short. recorded : the record at all cut-offs;
    turns : as of `FilteredMotion.of`."""
    record = recorded[0].record
    other = replace(record, phi_m=np.cumsum(record.phi_m - record.phi_m.mean()) * record.sampling_time)
    rivals = (FilteredMotion.at(other, one.cutoff, turns) for one in recorded)
    return _best(_rival(one.columns, one.torque, r.columns, r.torque) for one, r in zip(recorded, rivals, strict=True))


def torque_shifted(recorded: Sequence[FilteredMotion]) -> Rival | None:
    """The torque moved in time against the motion, by what makes the motion explain most of it; None for a record too
    short. recorded : the record at all cut-offs."""
    return _best(_shifted(one) for one in recorded)


def _best(rivals: Iterable[Rival | None]) -> Rival | None:
    """That of several cut-offs which explains most."""
    return max((one for one in rivals if one is not None), key=lambda one: one.explained, default=None)


def _shifted(recorded: FilteredMotion) -> Rival | None:
    columns, n = recorded.columns, len(recorded.torque)
    basis, whole = LeastSquares.basis(columns)[0].T, np.fft.rfft(recorded.torque - recorded.torque.mean())
    shares = np.square(np.fft.irfft(np.fft.rfft(basis, axis=1).conj() * whole, n * FINE, axis=1)).sum(axis=0)
    late = float(np.argmax(shares)) / FINE
    late -= n if late > n / 2 else 0
    moved = np.fft.irfft(whole * np.exp(2j * np.pi * np.fft.rfftfreq(n) * late), n)
    kept = slice(max(0, ceil(-late)), n - max(0, ceil(late)))  # the ends of a shifted torque belong to no motion
    found = _rival(columns[:, kept], recorded.torque[kept], columns[:, kept], moved[kept])
    return found and replace(found, shift=late * recorded.spacing)


def _rival(columns: Array, torque: Array, other: Array, moved: Array) -> Rival | None:
    """Torques (n,), each over its columns (p, n)."""
    if len(torque) < REGRESSION.samples_a_column * len(columns):
        return None
    mass = np.zeros(len(other))
    mass[MASS] = 1.0
    found = LeastSquares.of(other, moved)
    edges = np.linspace(0, len(torque), REGRESSION.blocks + 1).astype(int).tolist()
    left = [
        np.array([float(np.sum(one.residual[a:b] ** 2)) for a, b in pairwise(edges)]) / max(float(np.var(u)), 1e-300)
        for one, u in ((LeastSquares.of(columns, torque), torque), (found, moved))
    ]
    gains = np.log(np.maximum(left[0], 1e-300) / np.maximum(left[1], 1e-300))
    gain = Determined(float(gains.mean()), float(np.std(gains, ddof=1)) / np.sqrt(len(gains)))
    shares = explained_share(columns, torque), explained_share(other, moved)
    return Rival(gain, *shares, found.combination(mass))
