"""Noise of any colour: of the output, and white and red of the torque, as a model leaves it.

Every recorded torque carries slow errors. Whatever a model leaves, be it noise or misfit, counts here as noise, as far
as these three can explain it: a test by this noise is blunter than one by the sensors' alone, never sharper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from robotid.diagnosis.noise.drawn import drawn_residuals
from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.whitening import Segment
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.floor import torque_floor
from robotid.estimate.noise.information import is_explained
from robotid.estimate.noise.levels import fit_levels, fit_levels_by_record
from robotid.estimate.noise.lines import Residual, whitened_lines
from robotid.estimate.noise.passage import TorquePassage, passed_noise
from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.settings import ROUGHLY, SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.estimate.residual import measured_output
from robotid.model.array import Array
from robotid.signals.derivation import Derivation
from robotid.signals.quality import quantum
from robotid.signals.record import Quantity

CLIPPED = LevelSettings(clip=NOISE.clip)
PASSAGES = 2  # of the torque's noise along a motion: the first by filters that are roughly right


@dataclass(frozen=True, eq=False)
class ColouredNoise:
    """segments : the records with the filters that whiten their noise; simulated : what they were found in, and
    residuals : as they were seen there, in the output that was compared."""

    segments: tuple[Segment, ...]
    simulated: tuple[SimulatedSegment, ...]
    residuals: tuple[Residual, ...]
    output: Quantity

    @cached_property
    def explained(self) -> bool:
        """Whether these noises are all that the residuals show, by the joint's linear response or, where that leaves
        something, by simulations."""
        return all(linearly or self._explains(k) for k, linearly in enumerate(self._linearly))

    @property
    def linearly_explained(self) -> bool:
        """The same by the joint's linear response alone."""
        return all(self._linearly)

    @cached_property
    def _linearly(self) -> tuple[bool, ...]:
        pairs = zip(self.segments, self.residuals, strict=True)
        return tuple(is_explained(seen, one.whitening.levels, tolerance=NOISE.tolerance) for one, seen in pairs)

    def along_the_motion(self) -> ColouredNoise:
        """The same noises at levels by which they explain what every segment shows where errors of the torque pass
        along the simulated motion, which rests and reverses, and not as through a joint that slips all the time. This
        one where none do, or they grow beyond all numbers.

        Such a likelihood has several hollows: levels in common and of each record's own are tried, with all that shows
        and with bursts clipped.
        """
        levels = [fit_levels([seen], ROUGHLY)[0] for seen in self.residuals]
        residuals, found = list(self.residuals), dict[int, tuple[Residual, NoiseLevels]]()
        for settings in (SETTINGS, CLIPPED):
            for _ in range(PASSAGES):  # what passes is told through the filter that the levels make
                residuals = [self._passed(k, level) for k, level in enumerate(levels)]
                if any(seen.passed is None for seen in residuals):
                    return self
                levels = _levels(residuals, [one.record.name for one in self.simulated], settings)
                for tried in (fit_levels(residuals, settings), levels):
                    for k, pair in enumerate(zip(residuals, tried, strict=True)):
                        if k not in found and is_explained(*pair, tolerance=NOISE.tolerance):
                            found[k] = pair
                if len(found) == len(residuals):
                    return self._with([found[k] for k in range(len(residuals))])
        return self

    def _passed(self, k: int, levels: NoiseLevels) -> Residual:
        """A residual with what passes along its motion, as a filter of these levels shows it."""
        one, seen = self.simulated[k], self.residuals[k]
        passage = TorquePassage.of(one.trajectory, self.output, derived=seen.response.derivation is not None)
        return replace(seen, passed=passed_noise(seen, innovations_filter(seen.response, levels), passage))

    def _with(self, found: Sequence[tuple[Residual, NoiseLevels]]) -> ColouredNoise:
        """The same with residuals of which passages are known, and levels for each."""
        segments = tuple(
            Segment(one.record, _filter_along(*pair)) for one, pair in zip(self.segments, found, strict=True)
        )
        return replace(self, segments=segments, residuals=tuple(seen for seen, _ in found))

    def _explains(self, k: int) -> bool:
        levels = self.segments[k].whitening.levels
        drawn = partial(drawn_residuals, self.simulated[k], levels, self.output)
        return is_explained(self.residuals[k], levels, tolerance=NOISE.tolerance, drawn=drawn)


def coloured_noise(segments: Sequence[SimulatedSegment], columns: Sequence[Array], output: Quantity) -> ColouredNoise:
    """The noise of every segment beside columns (m, n), of which a fit has taken out what lies along them."""
    pairs = zip(segments, columns, strict=True)
    residuals = [_residual(one, taken, output) for one, taken in pairs]
    levels = _levels(residuals, [one.record.name for one in segments], CLIPPED)
    found = [
        Segment(one.record, innovations_filter(seen.response, level))
        for one, seen, level in zip(segments, residuals, levels, strict=True)
    ]
    return ColouredNoise(tuple(found), tuple(segments), tuple(residuals), output)


def _levels(residuals: Sequence[Residual], records: Sequence[str], settings: LevelSettings) -> list[NoiseLevels]:
    """The levels of every residual. records : of which one each is, by name."""
    levels = list(fit_levels_by_record(residuals, records, settings))
    for derived in (False, True):  # an angle's noise and a speed's do not compare
        alike = [k for k, seen in enumerate(residuals) if (seen.response.derivation is not None) == derived]
        for k, level in zip(alike, without_rest([levels[k] for k in alike]) if alike else (), strict=True):
            levels[k] = level
    return levels


def _filter_along(seen: Residual, levels: NoiseLevels) -> InnovationsFilter:
    """The filter of these noises, which allows for what passes along the motion."""
    whiten = innovations_filter(seen.response, levels)
    _, expected = whitened_lines(seen, whiten)
    return whiten.allowing_for(float(np.mean(expected)))


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
