"""What errors of the torque make of the size of a cause, or of a free curve, along the motion.

The noise of any colour passes in `coloured` as through a joint that slips all the time. Where it rests and reverses,
what an error of the torque has done so far lasts or is lost, and the instants shift: of the same errors a cause may
seem to have many times the size. By the motion linear about every sample that follows from one adjoint solve, and is
rather too much; by simulations with drawn errors it shows as it is, though by few of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import t as student

from robotid.diagnosis.noise.colour import ColouredNoise
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, solved, wald
from robotid.diagnosis.scoring.projection import project, without_states
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.search.coloured import (
    Left,
    blocks_with,
    by_noise,
    judged_along_the_motion,
    left_beside,
)
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.estimate.noise.information import SeenDerivatives
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.model.array import Array

TWICE = 2  # as many draws as elsewhere: of a sine and a cosine half of those tell a covariance too badly
CERTAINLY_NONE = 0.05  # p-value of a curve above which nobody asks for simulations


@dataclass(frozen=True, eq=False)
class DrawnSizes:
    """Amplitudes of a model, found by least squares beside its other parameters in what it leaves.

    left : by the model; sizes : its amplitudes, by number of the fitted parameter, whose order all results have;
    beside : numbers of the parameters that are found with them.
    """

    left: Left
    sizes: Mapping[int, float]
    beside: Sequence[int]

    @classmethod
    def of(cls, model: RefittedModel, effect: str, left: Left) -> DrawnSizes | None:
        """Of an effect of a refitted model in the shape that was found, None where no amplitude was fitted."""
        sizes, own = amplitudes(model, effect), model.own_columns(effect)
        return cls(left, sizes, [k for k in range(len(model.columns)) if k not in own]) if sizes else None

    @cached_property
    def found(self) -> Array:
        """The amplitudes by the noise of any colour, (k,)."""
        blocks = blocks_with(self.left, self.sizes).take([*self.sizes, *self.beside])
        return blocks.estimate()[: len(self.sizes)]

    @cached_property
    def drawn(self) -> Array:
        """The same of drawn noise, where there is none, (draws, k)."""
        noise, found = self.left.noise, []
        for residuals in noise.drawn(TWICE, noise.levels_in_motion):
            parts = zip(self._weights, self.left.scans, residuals, strict=True)
            found.append(np.sum([weights @ one.whitening(residual) for weights, one, residual in parts], axis=0))
        return np.array(found).reshape(len(found), len(self.sizes))

    @property
    def variances(self) -> Array:
        """Of the amplitudes by drawn noise, (k,), zero where none could be drawn."""
        return np.mean(np.square(self.drawn), axis=0) if len(self.drawn) else np.zeros(len(self.sizes))

    def p_value(self, level: float) -> float:
        """Of the amplitudes being nothing: along the motion, among draws where that is not below this level."""
        along = self.p_value_along_the_motion
        return along if along < level else min(along, self.p_value_among_draws)

    @property
    def p_value_along_the_motion(self) -> float:
        """Of the amplitudes being nothing, where errors of the torque pass along the motion, linear about every one."""
        noise = self.left.noise
        pairs = zip(self.left.scans, self._weights, strict=True)
        weights = [one.whitening.transposed(own) for one, own in pairs]
        covariance = covariance_along_the_motion(noise, noise.levels_in_motion, weights)
        wald = _wald(self.found, covariance) / max(1.0, self.left.energy)
        samples = sum(weights.shape[1] for weights in self._weights)
        return float(fisher.sf(wald / len(self.sizes), len(self.sizes), samples))

    @property
    def p_value_among_draws(self) -> float:
        """Of the amplitudes being drawn noise themselves (Hotelling 1931); one where too few could be drawn."""
        k, count = len(self.sizes), len(self.drawn)
        if count <= k:
            return 1.0
        wald = _wald(self.found, self.drawn.T @ self.drawn / count)
        return float(fisher.sf(wald * (count - k + 1) / (k * count), k, count - k + 1))

    @cached_property
    def _weights(self) -> list[Array]:
        """Of every sample of each segment's whitened residual in the amplitudes, (k, n) each."""
        at = [*self.sizes, *self.beside]
        factor = weights_of(self.left.blocks, at, len(self.sizes))
        return [factor @ without_states(one)[at] for one in self.left.scans]


def weights_of(blocks: BlockedRegression, at: Sequence[int], amplitudes: int) -> Array:
    """Of the moments of the regressors `at` in the estimates of the first of them, (amplitudes, m)."""
    information = blocks.information.sum(axis=0)[np.ix_(at, at)]
    return np.asarray(solved(information, np.eye(len(at))[:, :amplitudes]).T)


def covariance_along_the_motion(noise: ColouredNoise, levels: Sequence[NoiseLevels], weights: Sequence[Array]) -> Array:
    """Of sums of the residuals of all segments with weights (k, n) each, where errors of the torque of these levels
    pass along the motion, (k, k)."""
    parts = []
    for k, (level, own) in enumerate(zip(levels, weights, strict=True)):
        parts.append(SeenDerivatives.of(own, noise.residuals[k].response, noise.passage(k)).information(level))
    return np.asarray(np.sum(parts, axis=0))


def curve_p_value(model: RefittedModel, forces: Sequence[Array]) -> float:
    """p-value of a free curve being absent from what a model leaves, beside noise of any colour: by that noise, by what
    the curve explains of blocks of time that did not serve to fit it, or among drawn noise, whichever is largest.

    forces : (nv, m, n) of its knots on each fitted segment.
    """
    seen = scans(model.fitted, model.unknowns, (), forces)
    left, first = left_beside(model, seen), len(model.unknowns.parameters)
    at = range(first, first + forces[0].shape[1])
    found = max(by_noise(left.blocks, at, left.energy, model.samples), left.blocks.gain(at).p_value)
    return found if found > CERTAINLY_NONE else max(found, curve_among_draws(model, seen))


def curve_among_draws(model: RefittedModel, seen: Sequence[Scan]) -> float:
    """p-value of a free curve explaining drawn noise of any colour as well as it explains what a model leaves, where
    all of that is such noise; one where too little could be drawn, or more than numbers hold.

    How large noise is says little along a motion that rests: a slow error shifts where it rests, and draws of one noise
    differ by orders of magnitude. The share of it that a curve explains differs far less, and its logarithmic odds are
    about normal: what is left gives one more of them than was drawn (Student 1908). seen : the columns of the fitted
    segments, and then of the curve.
    """
    noise = judged_along_the_motion(left_beside(model, [one.bare for one in seen])).noise
    drawings = (zip(seen, residuals, strict=True) for residuals in noise.drawn(TWICE))
    drawn = [[one.with_residual(residual) for one, residual in drawing] for drawing in drawings]
    count = len(drawn)
    if count < 2 or not all(map(_is_within_numbers, drawn)):
        return 1.0
    odds = np.array([_odds(one) for one in drawn])
    deviation = float(np.std(odds, ddof=1)) * np.sqrt(1.0 + 1.0 / count)
    return float(student.sf((_odds(seen) - float(np.mean(odds))) / max(deviation, 1e-300), count - 1))


def _is_within_numbers(seen: Sequence[Scan]) -> bool:
    """Whether the energy of the residuals is a number."""
    with np.errstate(over="ignore"):
        return bool(np.isfinite(sum(float(np.sum(one.whitening(one.signals[-1]) ** 2)) for one in seen)))


def _odds(seen: Sequence[Scan]) -> float:
    """Logarithm of what columns explain of a residual over what they leave beyond the noise of the sensors, which is
    there in either case, and of which chance makes so much.

    seen : the columns of every segment after those that a fit has shaped, and last the residual.
    """
    projected, samples = project(seen), sum(one.signals.shape[1] for one in seen)
    first = len(projected.fitted)
    explained = projected.blocks.energy_of(range(first, first + projected.missing.shape[1]))
    left = max(projected.energy - explained - samples, float(np.sqrt(2.0 * samples)))
    return float(np.log(max(explained, 1e-300)) - np.log(left))


def _wald(sizes: Array, covariance: Array) -> float:
    """Squared distance of sizes (k,) from nothing in deviations of their covariance (k, k), none where that is beyond
    all numbers."""
    return wald(sizes, covariance) if np.isfinite(covariance).all() else 0.0
