"""The size at which an effect scores enough to be refitted, beside the noise that it makes itself.

Until it is named, an effect is part of the residual from which the noise is read: what it adds below the lowest
frequency that looks like noise counts as a misfit, the rest as a noise of the torque. So the noise of the search is
estimated again with the effect in the residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from robotid.diagnosis.noise.noise_estimate import sensor_noise
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.scoring.projection import Projected, project
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.search.added_signals import added_signals, in_any_proportion
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array

GREATEST = 2.0  # times the size by the noise without the effect: one so large no longer looks like noise
NOISES = 2  # that are estimated: a noise that grows faster than the effect's energy shows at the larger size


def least_scored(
    scans: Sequence[Scan], projected: Projected, at: slice, energy: float, data: EvaluationData, asked: float = 0.0
) -> float:
    """The least size of the amplitudes of the columns `at`, in any proportion, whose score reaches an energy in
    variances of the noise as it is estimated beside them; infinite where nothing of them is visible.

    scans : every segment with all columns, through the whitening of the search; projected : these; data : of the
    search. Where these allow for errors of the torque, what candidates explain is no part of the noise. asked : size
    that is asked for anyway; where the noise that the effect makes cannot lead beyond it, it is not estimated, and any
    size below may be returned.
    """
    plain = _least(projected, at, energy)
    if plain == inf or data.torque_errors or GREATEST * plain <= asked:
        return plain
    size = plain
    for _ in range(NOISES):
        noisy = sensor_noise(residuals_with(scans, projected, at, in_any_proportion(at, size)), data.output)
        own = [one.with_only(at).whitened_as(segment) for one, segment in zip(scans, noisy, strict=True)]
        # the noise that it makes is as its energy: s^2 = plain^2 (1 + made s^2)
        made = max(0.0, (_least(project(own), slice(0, at.stop - at.start), energy) / plain) ** 2 - 1.0) / size**2
        before, size = size, plain / sqrt(max(1.0 - made * plain**2, GREATEST**-2.0))
        if size <= before:
            break
    return size


def residuals_with(
    scans: Sequence[Scan], projected: Projected, at: slice, amplitude: Array
) -> tuple[SimulatedSegment, ...]:
    """The segments with amplitudes of the columns `at` in their residuals, less what the fit and the first states would
    take of them."""
    added = added_signals(scans, projected, [(at, amplitude)])
    pairs = zip(scans, added, strict=True)
    return tuple(SimulatedSegment(s.segment.record, s.segment.trajectory, s.signals[-1] + a[0]) for s, a in pairs)


def _least(projected: Projected, at: slice, energy: float) -> float:
    length = projected.visible_length(at)
    return float(np.sqrt(energy)) / length if length > 0.0 else inf
