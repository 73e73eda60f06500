"""What would have been seen: the smallest size at which each effect of the catalogue would have shown itself.

A candidate's column, whitened and projected on the complement of what the fit has shaped, is what one unit of the
effect adds to the residual that no parameter can take. Its length is the effect's strength in standard deviations of
the noise, so that a size follows without a refit: the one at which the energy explained reaches what a cause must have.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf

import numpy as np
import scipy

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.results import DetectionLimit
from robotid.diagnosis.scoring.candidate import Candidate, EffectCandidate
from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.settings import SCORING
from robotid.model.array import Array


def detection_limits(seen: Round, criteria: Criteria, present: Collection[str] = ()) -> tuple[DetectionLimit, ...]:
    """The limit of every candidate effect of a round, by name. present : effects that the model has since.

    Of shapes on a grid the typical one counts, the median over those that are visible.
    """
    lengths = visible_lengths(seen.projected, seen.candidates)
    found: dict[str, list[tuple[Candidate, float]]] = {}
    for one, length in zip(seen.candidates, lengths, strict=True):
        if isinstance(one, EffectCandidate) and one.name not in present:
            found.setdefault(one.name, []).append((one, length))
    tries, samples = len(seen.scores), seen.model.samples
    return tuple(_limit(shapes, seen.inflation, criteria, tries, samples) for _, shapes in sorted(found.items()))


def visible_lengths(projected: Projected, candidates: Sequence[Candidate]) -> Array:
    """Length that one unit of each candidate's size leaves after projection, (len(candidates),), zero where nothing is
    left. Several amplitudes, as of sine and cosine, count as one size in any proportion."""
    left, whole = np.linalg.norm(projected.missing, axis=0), projected.length
    visible = np.where(left > SCORING.dependent * whole, left, 0.0)
    found, first = [], 0
    for one in candidates:
        last = first + len(one.scored)
        found.append(float(np.sqrt(np.mean(visible[first:last] ** 2))))
        first = last
    return np.array(found)


def least_energy(parameters: int, inflation: float, criteria: Criteria, tries: int, samples: int) -> float:
    """Energy, in variances of the noise, that a cause of so many amplitudes must explain: three standard deviations of
    the noise as it shows, the level of significance among so many tries, and the least improvement demanded."""
    level = scipy.stats.f.isf(criteria.significance / max(1, tries), parameters, max(1, samples))
    significant = inflation * max(SCORING.limit_sigma**2, parameters * float(level))
    return max(significant, criteria.min_improvement_sigma**2 * samples)


def _limit(
    shapes: Sequence[tuple[Candidate, float]], inflation: float, criteria: Criteria, tries: int, samples: int
) -> DetectionLimit:
    one = shapes[0][0]
    size = one.parameters[one.scored[0]]
    energy = least_energy(len(one.scored), inflation, criteria, tries, samples)
    sizes = [float(np.sqrt(energy)) / length for _, length in shapes if length > 0.0]
    typical = float(np.median(sizes)) if sizes else inf
    assert size.null is not None
    largest = max(abs(bound - size.null) for bound in size.bounds)
    return DetectionLimit(one.name, size.symbol, typical if typical <= largest else inf, size.unit)
