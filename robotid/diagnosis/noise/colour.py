"""Noise of any colour: of the output, and white and red of the torque, as a model leaves it.

Every recorded torque carries slow errors. Whatever a model leaves, be it noise or misfit, counts here as noise, as far
as these three can explain it: a test by this noise is blunter than one by the sensors' alone, never sharper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.whitening import Segment
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.floor import torque_floor
from robotid.estimate.noise.information import is_explained
from robotid.estimate.noise.levels import fit_levels
from robotid.estimate.noise.lines import Residual
from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.settings import LevelSettings
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.estimate.residual import measured_output
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.derivation import Derivation
from robotid.signals.quality import quantum
from robotid.signals.record import Quantity, Record


@dataclass(frozen=True, slots=True, eq=False)
class ColouredNoise:
    """segments : the records with the filters that whiten their noise; explained : these noises are all that the
    residuals show."""

    segments: tuple[Segment, ...]
    explained: bool


def coloured_noise(segments: Sequence[SimulatedSegment], columns: Sequence[Array], output: Quantity) -> ColouredNoise:
    """The noise of every segment beside columns (m, n), of which a fit has taken out what lies along them."""
    pairs = zip(segments, columns, strict=True)
    residuals = [_residual(one, taken, output) for one, taken in pairs]
    levels = list(fit_levels(residuals, LevelSettings(clip=NOISE.clip)))
    for derived in (False, True):  # an angle's noise and a speed's do not compare
        alike = [k for k, seen in enumerate(residuals) if (seen.response.derivation is not None) == derived]
        for k, level in zip(alike, without_rest([levels[k] for k in alike]) if alike else (), strict=True):
            levels[k] = level
    found = [
        Segment(one.record, innovations_filter(seen.response, level))
        for one, seen, level in zip(segments, residuals, levels, strict=True)
    ]
    explained = all(
        is_explained(seen, level, tolerance=NOISE.tolerance) for seen, level in zip(residuals, levels, strict=True)
    )
    return ColouredNoise(tuple(found), explained)


def _residual(one: SimulatedSegment, taken: Array, output: Quantity) -> Residual:
    t, record = one.trajectory, one.record
    response = torque_response(t.joint, t.theta, t.sampling_time, output, Derivation.of(record))
    shown = record.phi_m if response.derivation else measured_output(record, output)
    rounding = quantum(shown) ** 2 / 12
    return Residual(one.residual, response, taken, least=rounding, most_torque=torque_floor(record.tau_m))


def without_rest(levels: Sequence[NoiseLevels]) -> list[NoiseLevels]:
    """A segment that shows much less noise of the output than the others was at rest."""
    least = NOISE.rest_share**2 * float(np.median([one.output for one in levels]))
    return [replace(one, output=max(one.output, least)) for one in levels]


def typical(
    noise: ColouredNoise, records: Sequence[Record], joint: Joint, theta: Array, output: Quantity
) -> tuple[Segment, ...]:
    """Records that served for no fit, with the typical noise of those that did: their own residual may be a misfit.

    theta : (p,) of the joint.
    """
    found = []
    for record in records:
        own = joint.in_record(theta, record.name)
        response = torque_response(joint, own, record.sampling_time, output, Derivation.of(record))
        usual = float(np.median([one.whitening.output_noise(response.derivation) for one in noise.segments]))
        levels = replace(noise.segments[0].whitening.levels, output=usual)
        found.append(Segment(record, innovations_filter(response, levels)))
    return tuple(found)
