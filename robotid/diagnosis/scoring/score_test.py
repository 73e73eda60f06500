"""Which missing effect would explain a residual: every candidate scored at its null, without a refit.

The residual and the candidates' columns are whitened and projected on the complement of what the fit has shaped; what
is left of the residual is explained by a candidate as far as its columns reach (the score test; Rao 1948).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from robotid.diagnosis.scoring.candidate import Candidate, columns_of
from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


@dataclass(frozen=True, slots=True)
class Score:
    """What a candidate explains.

    energy : of the whitened residual, in variances of the noise; amplitude : of each of its scored parameters, in their
    units; directions (d, k) : its columns, orthonormal, in the space of `Projected`; moved (p,) : how far the fitted
    parameters go with it.
    """

    candidate: Candidate
    energy: float
    amplitude: tuple[float, ...]
    directions: Array
    moved: Array


def score(projected: Projected, candidates: Sequence[Candidate]) -> list[Score]:
    """Every candidate by itself, best first."""
    found = [_score(projected, one, at) for one, at in zip(candidates, columns_of(candidates), strict=True)]
    return sorted(found, key=_place)


def _place(one: Score) -> tuple[float, int]:
    """The more is explained the further ahead, and of laws that are one on these motions, as a cogging of one period a
    turn and gravity, the simpler one: which of them has the larger last digit is chance."""
    return -float(f"{one.energy:.6g}"), len(one.candidate.parameters)


def _score(projected: Projected, candidate: Candidate, at: slice) -> Score:
    own, length = projected.missing[:, at], np.linalg.norm(projected.whole[:, at], axis=0)
    nothing = Score(candidate, 0.0, (0.0,) * own.shape[1], np.zeros((len(own), 0)), np.zeros(len(projected.fitted)))
    left = np.linalg.norm(own, axis=0)
    if not np.all(left > SCORING.dependent * length) or not length.all():
        return nothing
    q, r = np.linalg.qr(own / left)
    along = q.T @ projected.residual
    amplitude = np.linalg.lstsq(r, along, rcond=None)[0] / left
    if not candidate.allows(amplitude.tolist()):
        return nothing
    return Score(candidate, float(along @ along), tuple(amplitude.tolist()), q, projected.moved(amplitude, at))


def significance(energy: float, parameters: int, total: float, samples: int, tries: int) -> float:
    """p-value of an explained energy by the F-test, for the best of so many tries.

    energy, total : explained and in all, in variances of the noise; parameters : that explain it.
    """
    rest = max(total - energy, 1e-300) / max(1, samples - parameters)
    return float(min(1.0, tries * scipy.stats.f.sf(energy / parameters / rest, parameters, samples)))
