"""What would have been named: the smallest size at which each effect of the catalogue would have been a cause.

A candidate's column, whitened by what the causes leave and projected on the complement of what the fit has shaped, is
what one unit of the effect adds to the residual that no parameter can take. The size at which it passes the tests of a
cause follows without a refit: its energy beside the noise of that colour, its spread from block to block of time,
what errors of the torque make of it along the motion, which rests and reverses, what it gains in a fit, and how well a
fit knows it, which weighs all of a residual alike.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from math import inf
from operator import itemgetter

import numpy as np
from scipy.stats import f as fisher

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.colour import ColouredNoise
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.results import DetectionLimit
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, solved
from robotid.diagnosis.scoring.candidate import Candidate, EffectCandidate, columns_of
from robotid.diagnosis.scoring.projection import Projected, project, without_states
from robotid.diagnosis.scoring.ranking import CandidateScan, Round
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.search.coloured import Tried, are_too_few
from robotid.diagnosis.search.drawn_sizes import covariance_along_the_motion, weights_of
from robotid.diagnosis.search.least_gained import least_gained
from robotid.diagnosis.search.least_scored import least_scored
from robotid.diagnosis.search.physical_sense import least_deviations
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.settings import VERDICT
from robotid.model.array import Array


def detection_limits(found: SearchResult, criteria: Criteria) -> tuple[DetectionLimit, ...]:
    """The limit of every effect of the catalogue that the last model lacks, by name.

    Of shapes on a grid the typical one counts, the median over those that are visible.
    """
    seen, model = found.rounds[-1], found.last
    missing = list(typical_shapes(seen, model.structure.effects))
    columns = CandidateScan(model, tuple(missing), scans(model.fitted, model.unknowns, missing))
    coloured = found.data if found.coloured is None else found.coloured
    searched, seen_through = columns.whitened_as(found.data.fitted).scans, columns.whitened_as(coloured.fitted).scans
    by_search, by_colour = project(searched), project(seen_through)
    own_columns = list(columns_of(missing))
    plain = columns.whitened_as([Segment(one.record, UNIT_WHITENING) for one in model.fitted]).scans
    in_motion = deviations_in_motion(found.noise, by_colour, seen_through, own_columns)
    in_a_fit = deviations_in_motion(found.noise, project(plain), plain, own_columns)
    tried, usual = Tried.of(seen), max(1.0, by_colour.energy / model.samples)
    improvement = criteria.min_improvement_sigma**2 * found.data.samples
    gained = least_gained(searched, by_search, own_columns, VERDICT.least_gain if found.data.validation else 0.0)
    limits = []
    for one, own, deviation, known, gaining in zip(missing, own_columns, in_motion, in_a_fit, gained, strict=True):
        k, length = len(one.scored), by_colour.visible_length(own)
        size = inf
        if length > 0.0:
            energy = least_energy(k, usual, criteria, tried.candidates, model.samples)
            spread = least_size(by_colour.beside_fitted(own), k, criteria.significance / tried.effects)
            if spread == inf and coloured.validation:  # records that were held out tell of it instead
                spread = 0.0
            alone = least_energy(k, usual, criteria, 1, model.samples)
            by_noise = float(np.sqrt(energy)) / length
            sized = least_deviations(len(one.parameters), criteria.significance / len(missing)) * known
            beside = max(by_noise, spread, float(np.sqrt(alone)) * deviation, float(gaining), sized)
            size = max(beside, least_scored(searched, by_search, own, improvement, found.data, beside))
        limits.append(_limit(one, size))
    return tuple(limits)


def typical_shapes(seen: Round, present: Collection[str] = ()) -> Iterator[EffectCandidate]:
    """The candidate of typical shape of every effect of a round, by name. present : effects that are not asked for."""
    found: dict[str, list[tuple[float, EffectCandidate]]] = {}
    for one, at in zip(seen.candidates, columns_of(seen.candidates), strict=True):
        if isinstance(one, EffectCandidate) and one.name not in present:
            found.setdefault(one.name, []).append((seen.projected.visible_length(at), one))
    for _, shapes in sorted(found.items()):
        visible = sorted((shape for shape in shapes if shape[0] > 0.0), key=itemgetter(0))
        yield (visible[len(visible) // 2] if visible else shapes[0])[1]


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
    return float(np.sqrt(blocks.least_wald(at, level))) * _deviation(blocks.covariance()[np.ix_(at, at)])


def deviations_in_motion(
    noise: ColouredNoise | None, projected: Projected, scans: Sequence[Scan], at: Sequence[slice]
) -> list[float]:
    """Of the amplitudes of the columns of each of `at`, in any proportion, as the least squares of a whitening find
    them, where errors of the torque pass along the motion; zero where there are no such errors.

    scans : every segment with all columns, through that whitening; projected : these.
    """
    levels = () if noise is None else tuple(one.whitening.levels for one in noise.segments)
    if noise is None or not any(one.torque + one.red for one in levels):
        return [0.0] * len(at)
    first = len(projected.fitted)
    own = [range(first + one.start, first + one.stop) for one in at]
    every = [[*one, *range(first)] for one in own]
    ways = [weights_of(projected.blocks, k, len(one)) for k, one in zip(every, own, strict=True)]
    columns = (without_states(one) for one in scans)
    of_white = [np.concatenate([way @ one[k] for way, k in zip(ways, every, strict=True)]) for one in columns]
    weights = [one.whitening.transposed(own) for one, own in zip(scans, of_white, strict=True)]
    covariance = covariance_along_the_motion(noise, levels, weights)
    parts = [covariance[one.start : one.stop, one.start : one.stop] for one in at]
    return [_deviation(one) for one in parts]


def _deviation(covariance: Array) -> float:
    """Of amplitudes in any proportion. covariance : (k, k)."""
    information = solved(covariance, np.eye(len(covariance)))
    return float(np.sqrt(len(covariance) / max(np.trace(information), 1e-300)))


def _limit(one: Candidate, limit: float) -> DetectionLimit:
    """Infinite where no size that the effect may have reaches it."""
    size = one.parameters[one.scored[0]]
    assert size.null is not None
    return DetectionLimit(one.name, size.symbol, limit, size.unit).within(size.null, size.bounds)
