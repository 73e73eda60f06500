"""What would have been named: the smallest size at which each effect of the catalogue would have been a cause.

A candidate's column, whitened by what the causes leave and projected on the complement of what the fit has shaped, is
what one unit of the effect adds to the residual that no parameter can take. The size at which it passes the tests of a
cause follows without a refit: its energy beside the noise of that colour, and its spread from block to block of time.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy.stats import f as fisher

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.results import DetectionLimit
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.diagnosis.scoring.candidate import Candidate, EffectCandidate, columns_of
from robotid.diagnosis.scoring.projection import Projected, project
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.scan import scans
from robotid.diagnosis.scoring.settings import SCORING
from robotid.diagnosis.search.coloured import Tried, are_too_few
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import SearchResult
from robotid.model.array import Array


@dataclass(frozen=True, slots=True)
class Shape:
    """A typical shape of an effect. length : of what one unit of it leaves by the noise of the sensors, after
    projection, 0 where nothing is left."""

    candidate: EffectCandidate
    length: float


def detection_limits(found: SearchResult, criteria: Criteria) -> tuple[DetectionLimit, ...]:
    """The limit of every effect of the catalogue that the last model lacks, by name.

    Of shapes on a grid the typical one counts, the median over those that are visible.
    """
    seen, model = found.rounds[-1], found.last
    shapes = list(typical_shapes(seen, model.structure.effects))
    candidates = [one.candidate for one in shapes]
    coloured = found.data if found.coloured is None else found.coloured
    segments = [replace(one, whitening=s.whitening) for one, s in zip(model.fitted, coloured.fitted, strict=True)]
    projected = project(scans(segments, model.unknowns, candidates))
    tried, usual = Tried.of(seen), max(1.0, projected.energy / model.samples)
    improvement = criteria.min_improvement_sigma * float(np.sqrt(found.data.samples))
    limits = []
    lengths = visible_lengths(projected, candidates).tolist()
    for one, length, own in zip(shapes, lengths, columns_of(candidates), strict=True):
        k, size = len(one.candidate.scored), inf
        if length > 0.0 and one.length > 0.0:
            energy = least_energy(k, usual, criteria, tried.candidates, model.samples)
            spread = least_size(projected.beside_fitted(own), k, criteria.significance / tried.effects)
            if spread == inf and coloured.validation:  # records that were held out tell of it instead
                spread = 0.0
            size = max(improvement / one.length, float(np.sqrt(energy)) / length, spread)
        limits.append(_limit(one.candidate, size))
    return tuple(limits)


def typical_shapes(seen: Round, present: Collection[str] = ()) -> Iterator[Shape]:
    """The typical shape of every candidate effect of a round, by name. present : effects that the model has since."""
    lengths = visible_lengths(seen.projected, seen.candidates)
    found: dict[str, list[Shape]] = {}
    for one, length in zip(seen.candidates, lengths.tolist(), strict=True):
        if isinstance(one, EffectCandidate) and one.name not in present:
            found.setdefault(one.name, []).append(Shape(one, length))
    for _, shapes in sorted(found.items()):
        visible = sorted((one for one in shapes if one.length > 0.0), key=lambda one: one.length)
        yield visible[len(visible) // 2] if visible else shapes[0]


def visible_lengths(projected: Projected, candidates: Sequence[Candidate]) -> Array:
    """Length that one unit of each candidate's size leaves after projection, (len(candidates),), zero where nothing is
    left. Several amplitudes, as of sine and cosine, count as one size in any proportion."""
    left, whole = np.linalg.norm(projected.missing, axis=0), projected.length
    visible = np.where(left > SCORING.dependent * whole, left, 0.0)
    return np.array([float(np.sqrt(np.mean(visible[at] ** 2))) for at in columns_of(candidates)])


def least_energy(parameters: int, usual: float, criteria: Criteria, tries: int, samples: int) -> float:
    """Energy, in variances of the noise, that a cause of so many amplitudes must explain: three standard deviations of
    the noise as it shows, or the level of significance among so many tries.

    usual : energy a sample that is left, in these variances.
    """
    level = fisher.isf(criteria.significance / max(1, tries), parameters, max(1, samples))
    return usual * max(ACCEPTANCE.amplitude_sigma**2, parameters * float(level))


def least_size(blocks: BlockedRegression, parameters: int, level: float) -> float:
    """Size of the last `parameters` amplitudes of a regression, in any proportion, at which their spread from block to
    block of time makes them significant at this level; infinite where too few blocks tell of them."""
    at = list(range(blocks.moment.shape[1] - parameters, blocks.moment.shape[1]))
    if are_too_few(blocks.telling_blocks(at), parameters):
        return inf
    information = np.linalg.pinv(blocks.covariance()[np.ix_(at, at)], hermitian=True)
    return float(np.sqrt(blocks.least_wald(at, level) * parameters / np.trace(information)))


def _limit(one: Candidate, limit: float) -> DetectionLimit:
    """Infinite where no size that the effect may have reaches it."""
    size = one.parameters[one.scored[0]]
    assert size.null is not None
    largest = max(abs(bound - size.null) for bound in size.bounds)
    return DetectionLimit(one.name, size.symbol, limit if limit <= largest else inf, size.unit)
