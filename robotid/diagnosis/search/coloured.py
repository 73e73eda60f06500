"""What a model leaves by noise of any colour: whether a cause stands out of it, and whether anything but noise is left.

The search weighs residuals by the noise of the sensors. Every real torque has slow errors besides, of which some effect
always explains a little. So a cause is judged once more beside what the model with it leaves: by the white and red
noises that show there, and by the scatter of the cause's size from block to block of time, whichever is blunter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import f as fisher

from robotid.diagnosis.noise.colour import ColouredNoise, coloured_noise
from robotid.diagnosis.noise.whitening import Segment, with_typical_noise
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, Unknowns
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.diagnosis.scoring.projection import beyond, project
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.scan import Scan, scan, scans
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.errors import NumericsError
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """What a model leaves, linearised: the regression of its residual on the fitted parameters, in the unit of the
    coloured noise, block by block of time. noise : that shows in it; energy : a sample, in its variances; scans : the
    columns of its segments through that noise."""

    blocks: BlockedRegression
    noise: ColouredNoise
    energy: float
    scans: tuple[Scan, ...] = ()


def left_by(model: RefittedModel, forces: Sequence[Array] | None = None) -> Left:
    """What a refitted model leaves on the fitted segments.

    forces : (nv, m, n) further generalised forces on each, whose columns follow those of the fitted parameters, and
    which take from the residual what they can before its noise is measured.
    """
    return left_beside(model, scans(model.fitted, model.unknowns, (), forces))


def left_beside(model: RefittedModel, seen: Sequence[Scan]) -> Left:
    """The same, the columns of the fitted segments at hand, and of further forces with them."""
    noise = coloured_noise(model.fitted, [one.signals[:-1] for one in seen], model.output)
    whitened = _whitened(seen, noise)
    projected = project(whitened)
    return Left(projected.blocks, noise, projected.energy / model.samples, whitened)


def explains_more(first: RefittedModel, last: RefittedModel, left: Left, coloured: EvaluationData) -> bool:
    """Whether a model explains more than another, by the noise that it leaves: as they are, or with the parameters of
    each where this noise would have them, to first order, which tells little of a model that is far from the motion. A
    cause that was found by another noise may not. left : by the last model; coloured : the data by that noise."""
    if coloured.fitted_energy(first.fitted) > coloured.fitted_energy(last.fitted):
        return True
    seen = _whitened(scans(first.fitted, first.unknowns, ()), left.noise)
    return project(seen).energy > left.energy * first.samples


def _whitened(seen: Sequence[Scan], noise: ColouredNoise) -> tuple[Scan, ...]:
    return tuple(one.whitened_as(segment) for one, segment in zip(seen, noise.segments, strict=True))


@dataclass(frozen=True, slots=True)
class Tried:
    """Of how many candidates, and of how many effects, a cause is the best, and one of how many refits."""

    candidates: int = 1
    effects: int = 1
    refits: int = 1

    @classmethod
    def of(cls, seen: Round, refits: int = 1) -> Tried:
        """Of all that were scored in a round, so many of which were refitted."""
        return cls(len(seen.scores), len({one.candidate.name for one in seen.scores}), refits)


ALONE = Tried()


def p_value(
    model: RefittedModel,
    effect: str,
    left: Left,
    tried: Tried = ALONE,
    elsewhere: Callable[[], RefittedModel | None] = lambda: None,
) -> float:
    """p-value of an effect of a refitted model being absent, zero where no amplitude of it was fitted.

    left : by the model; elsewhere : gives it refitted to the segments that were held out alone.

    By the coloured noise it is the best of all candidates. From block to block of time an amplitude scatters by a few
    blocks only, hardly more in one shape of an effect than in the others: there it is the best of all effects. Where
    only a moment or two of the records tell of it, blocks cannot, and records that were held out may instead.

    Without the effect its shape is nothing to be known, and beside a shape that may take any value little would be left
    of an amplitude. So by noise all its fitted parameters are tested at once, and from block to block the amplitudes in
    the shape that was found.
    """
    sizes = amplitudes(model, effect)
    if not sizes:
        return 0.0
    at, own, with_effect = list(sizes), model.own_columns(effect), blocks_with(left, sizes)
    noise = tried.candidates * by_noise(with_effect, own, left.energy, model.samples)
    shaped, there = in_the_shape(with_effect, at, own)
    again = tried.effects * shaped.significance(there)
    found = min(1.0, max(noise, again))
    if are_too_few(with_effect.telling_blocks(at), len(at)) and (other := elsewhere()) is not None:
        found = min(found, tried.effects * confirmation(other, effect, sizes))
    return found


def in_the_shape(
    blocks: BlockedRegression, at: Sequence[int], own: Sequence[int]
) -> tuple[BlockedRegression, list[int]]:
    """The regression on amplitudes in the shape that was found, and where they are in it. at : where they were; own :
    numbers of all parameters of their effects, which tell the shape but for these."""
    kept = [k for k in range(blocks.moment.shape[1]) if k in at or k not in own]
    return blocks.take(kept), [kept.index(k) for k in at]


def are_too_few(telling: float, amplitudes: int) -> bool:
    """Whether so few blocks tell of so many amplitudes that these have no spread from block to block."""
    return telling < amplitudes + ACCEPTANCE.telling_blocks


def confirmation(other: RefittedModel, effect: str, sizes: Mapping[int, float]) -> float:
    """p-value of an effect being absent from records that served for no fit, by a model fitted to these alone, beside
    noise of any colour and, where enough of their blocks tell of it, from block to block; one where they find it of
    another size, or fit a joint that none can be. Several amplitudes are compared by what they do in these records, for
    two that hardly differ there may take each other's place.

    sizes : its amplitudes by the fit of the other records, by number of the fitted parameter.
    """
    try:
        left = left_by(other)
    except NumericsError:  # few records may ask for an inertia or a damping below zero
        return 1.0
    found = amplitudes(other, effect)
    apart = {k: found[k] - size for k, size in sizes.items()}
    if _energy(left, apart) > ACCEPTANCE.constant_spread**2 * _energy(left, sizes):
        return 1.0
    own, with_effect = other.own_columns(effect), blocks_with(left, found)
    return max(by_noise(with_effect, own, left.energy, other.samples), by_blocks(with_effect, list(found), own))


def by_blocks(blocks: BlockedRegression, at: Sequence[int], own: Sequence[int]) -> float:
    """p-value of amplitudes being absent by their scatter from block to block, in the shape that was found; zero where
    too few blocks tell of them to have any. at, own : as of `in_the_shape`."""
    if are_too_few(blocks.telling_blocks(at), len(at)):
        return 0.0
    shaped, there = in_the_shape(blocks, at, own)
    return shaped.significance(there)


def _energy(left: Left, sizes: Mapping[int, float]) -> float:
    """What amplitudes do that no other parameter can, in variances of the noise. sizes : by their number."""
    return replace(left.blocks, moment=_moment(left, sizes)).energy_of(list(sizes))


def blocks_with(left: Left, sizes: Mapping[int, float]) -> BlockedRegression:
    """The regression of what a model leaves, with what amplitudes of it explain put back. sizes : by their number."""
    return replace(left.blocks, moment=left.blocks.moment + _moment(left, sizes))


def _moment(left: Left, sizes: Mapping[int, float]) -> Array:
    """The moment of what amplitudes do, (blocks, m)."""
    return np.asarray(left.blocks.information[:, :, list(sizes)] @ np.array(list(sizes.values())))


def by_noise(blocks: BlockedRegression, at: Sequence[int], energy: float, samples: int) -> float:
    """p-value of the regressors `at` being absent, by the F-test. energy : a sample, in variances of the noise."""
    return float(fisher.sf(blocks.energy_of(at) / len(at) / max(1.0, energy), len(at), samples))


def judged_along_the_motion(left: Left) -> Left:
    """The same with noise whose torque passes along the simulated motion, where that explains what a model leaves and
    the linear response of the joint does not."""
    if left.noise.linearly_explained:
        return left
    noise = left.noise.along_the_motion()
    return replace(left, noise=noise, energy=1.0) if noise.linearly_explained else left


def in_colour(model: RefittedModel, data: EvaluationData, noise: ColouredNoise) -> EvaluationData:
    """The data of a search by the coloured noise that its last model leaves."""
    records = [segment.record for segment in data.validation]
    held_out = with_typical_noise(noise.segments, records, model.joint, model.parameters.values, model.output)
    return replace(data, fitted=noise.segments, validation=held_out, noise_reached=noise.explained)


def energy_a_sample(one: SegmentFit, segment: Segment, unknowns: Unknowns) -> float:
    """What a segment leaves by the noise of another whitening, less what its first states could still take.

    unknowns : of the model's fit.
    """
    seen = scan(one, Unknowns(unknowns.output, (), unknowns.first_states), ())
    white = segment.whitening(seen.signals)
    left = beyond(white[-1], white[:-1])
    return float(left @ left) / len(left)
