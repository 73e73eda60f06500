"""Noise of any colour: of the output, and white and red of the torque, as a model leaves it.

Every recorded torque carries slow errors. Whatever a model leaves, be it noise or misfit, counts here as noise, as far
as these three can explain it: a test by this noise is blunter than one by the sensors' alone, never sharper.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from robotid.diagnosis.noise.drawn import drawn_residuals
from robotid.diagnosis.noise.settings import NOISE
from robotid.diagnosis.noise.whitening import Segment
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.floor import torque_floor
from robotid.estimate.noise.information import are_explained, is_explained, loudest_octave
from robotid.estimate.noise.levels import corners_of, fit_levels, fit_levels_by_record
from robotid.estimate.noise.lines import Innovations, Residual
from robotid.estimate.noise.passage import TorquePassage, passed_noise
from robotid.estimate.noise.passed import PassedNoise
from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.settings import SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.estimate.residual import measured_output
from robotid.model.array import Array
from robotid.parallel import each
from robotid.signals.derivation import Derivation
from robotid.signals.quality import quantum
from robotid.signals.record import Quantity
from robotid.simulation.trajectory import Trajectory


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
        of_records = zip(self._by_record, self._linearly, strict=True)
        return all(linearly or self._explain(pieces, drawn=True) for pieces, linearly in of_records)

    @property
    def linearly_explained(self) -> bool:
        """The same by the joint's linear response alone."""
        return all(self._linearly)

    @cached_property
    def _by_record(self) -> list[list[int]]:
        """The segments of each record, by their numbers."""
        names = [one.record.name for one in self.simulated]
        return [[k for k, other in enumerate(names) if other == name] for name in dict.fromkeys(names)]

    @cached_property
    def _linearly(self) -> tuple[bool, ...]:
        """Whether the residuals of each record show nothing else."""
        return tuple(self._explain(pieces) for pieces in self._by_record)

    def _explain(self, pieces: Sequence[int], *, drawn: bool = False) -> bool:
        """Whether the noises are all that the residuals of a record's segments show. drawn : also by simulations."""
        seen = [self.residuals[k] for k in pieces]
        levels = [self.segments[k].whitening.levels for k in pieces]
        made = partial(self._drawn, pieces, levels) if drawn else tuple
        return are_explained(seen, levels, tolerance=NOISE.tolerance, among=len(self._by_record), drawn=made)

    @cached_property
    def levels_in_motion(self) -> tuple[NoiseLevels, ...]:
        """Levels at which errors of the torque show what the residuals show where all that they have done is lost once
        the motor rests: those that a joint which slips all the time asks for make too little of them. What shows more
        than there, in bursts, is left out of it: linear about every sample it is too much, and no level would be left.
        """
        seen = [
            replace(one, passed=None if by is None else replace(by, most=1.0 / one.response.share))
            for one, by in zip(self.residuals, self._passed, strict=True)
        ]
        slipping = [one.whitening.levels for one in self.segments]
        found = _levels(seen, [one.record.name for one in self.simulated], slipping)
        pairs = zip(slipping, found, strict=True)
        return tuple(max(pair, key=lambda one: one.torque + one.red) for pair in pairs)

    def drawn(self, times: int = 1, levels: Sequence[NoiseLevels] | None = None) -> list[tuple[Array, ...]]:
        """Residuals that such noise makes of every segment, (n,) each, as many times as all can be simulated under it.
        times : as of `drawn_residuals`; levels : of the segments, by default those of their filters."""
        levels = [one.whitening.levels for one in self.segments] if levels is None else levels
        return self._drawn(range(len(levels)), levels, times)

    def _drawn(self, at: Sequence[int], levels: Sequence[NoiseLevels], times: int = 1) -> list[tuple[Array, ...]]:
        """The same of the segments that have these numbers."""
        parts = [(self.simulated[k], level) for k, level in zip(at, levels, strict=True)]
        samples = times * NOISE.draws * sum(len(one.record) for one, _ in parts) // len(parts)
        return list(zip(*each(_drawn, (self.output, times), parts, samples=samples), strict=False))

    def along_the_motion(self) -> ColouredNoise:
        """The same noises where errors of the torque pass along the simulated motion, which rests and reverses, and not
        as through a joint that slips all the time: of each segment's own, as large as its residual asks for. This one
        where some segment shows more, or they grow beyond all numbers."""
        pairs = [one for one in map(self._along, range(len(self.residuals))) if one is not None]
        if len(pairs) < len(self.residuals):
            return self
        segments = tuple(
            Segment(one.record, _filter_along(*pair)) for one, pair in zip(self.segments, pairs, strict=True)
        )
        return replace(self, segments=segments, residuals=tuple(seen for seen, _ in pairs))

    def _along(self, k: int) -> tuple[Residual, NoiseLevels] | None:
        """A residual with what passes along its motion, and the slow errors by which no octave stands out: of every
        corner those of the residual's energy, for a likelihood heeds most what bursts do at the highest frequencies,
        and of these a motion that is linear about every sample knows least. None where there are none that are no
        larger than the record asks for of its own through a joint that slips: larger ones would pass for anything."""
        slipping = self.residuals[k]
        seen = replace(slipping, passed=self._passed[k])
        if seen.passed is None:
            return None
        known, (own,) = self.segments[k].whitening.levels, fit_levels([slipping], _clipped())
        most = slipping.response.share * max(one.torque + one.red for one in (known, own))
        levels = [one for one in _of_its_energy(seen, known.output) if one.red <= most]
        among = len(self.residuals)
        explaining = [one for one in levels if is_explained(seen, one, tolerance=NOISE.tolerance, among=among)]
        return (seen, min(explaining, key=lambda level: loudest_octave(seen, level))) if explaining else None

    def passage(self, k: int) -> TorquePassage:
        """From the torque of a segment to what its sensor shows, along its motion."""
        derived = self.residuals[k].response.derivation is not None
        return TorquePassage.of(self.simulated[k].trajectory, self.output, derived=derived)

    @cached_property
    def _passed(self) -> tuple[PassedNoise | None, ...]:
        """What of the torque's noise shows along the motion of every segment."""
        parts = zip(self.residuals, self.segments, map(self.passage, range(len(self.segments))), strict=True)
        samples = sum(len(one.record) for one in self.segments) // len(self.segments)
        return tuple(each(_passed_of, None, list(parts), samples=samples))


def _passed_of(_: None, part: tuple[Residual, Segment, TorquePassage]) -> PassedNoise | None:
    seen, one, passage = part
    return passed_noise(seen, one.whitening, passage)


def _drawn(shared: tuple[Quantity, int], part: tuple[SimulatedSegment, NoiseLevels]) -> list[Array]:
    output, times = shared
    return drawn_residuals(*part, output, times)


def coloured_noise(segments: Sequence[SimulatedSegment], columns: Sequence[Array], output: Quantity) -> ColouredNoise:
    """The noise of every segment beside columns (m, n), of which a fit has taken out what lies along them."""
    pairs = zip(segments, columns, strict=True)
    residuals = [_residual(one, taken, output) for one, taken in pairs]
    levels = _levels(residuals, [one.record.name for one in segments])
    found = [
        Segment(one.record, innovations_filter(seen.response, level))
        for one, seen, level in zip(segments, residuals, levels, strict=True)
    ]
    return ColouredNoise(tuple(found), tuple(segments), tuple(residuals), output)


def _clipped() -> LevelSettings:
    """How levels are sought: bursts do not count."""
    return LevelSettings(clip=NOISE.clip)


def _levels(
    residuals: Sequence[Residual], records: Sequence[str], near: Sequence[NoiseLevels] | None = None
) -> list[NoiseLevels]:
    """The levels of every residual. records : of which one each is, by name; near : levels to start from."""
    levels = list(fit_levels_by_record(residuals, records, _clipped(), near))
    for derived in (False, True):  # an angle's noise and a speed's do not compare
        alike = [k for k, seen in enumerate(residuals) if (seen.response.derivation is not None) == derived]
        for k, level in zip(alike, without_rest([levels[k] for k in alike]) if alike else (), strict=True):
            levels[k] = level
    return levels


def _of_its_energy(seen: Residual, output: float) -> Iterator[NoiseLevels]:
    """Red noises of the torque of every corner that show the energy of a residual, beside a noise of the output."""
    plain = Innovations.of(seen, innovations_filter(seen.response, NoiseLevels(output)), SETTINGS)
    corners = corners_of([seen], SETTINGS)
    _, shown = plain.of_the_torque(seen, corners)
    left = float(plain.power.sum()) - output * float(plain.gain.sum())
    for corner, unit in zip(corners.tolist(), shown.sum(axis=1).tolist(), strict=True):
        if unit > 0.0:
            yield NoiseLevels(output, 0.0, max(0.0, left / unit), corner)
        else:  # the motor rests all the time, and no error of the torque moves it
            yield NoiseLevels(output)


def _filter_along(seen: Residual, levels: NoiseLevels) -> InnovationsFilter:
    """The filter of noises that explain a residual along its motion, which allows for the energy that they show."""
    whiten = innovations_filter(seen.response, levels)
    return whiten.allowing_for(max(1.0, float(np.mean(Innovations.of(seen, whiten, SETTINGS).power))))


def _residual(one: SimulatedSegment, taken: Array, output: Quantity) -> Residual:
    t, record = one.trajectory, one.record
    response = torque_response(t.joint, t.theta, t.sampling_time, output, Derivation.of(record))
    shown = record.phi_m if response.derivation else measured_output(record, output)
    rounding = quantum(shown) ** 2 / 12
    response = response.some_of_the_time(slipping_share(t))
    return Residual(one.residual, response, taken, least=rounding, most_torque=torque_floor(record.tau_m))


def slipping_share(trajectory: Trajectory) -> float:
    """Share of the time in which dry friction does not hold the motor, a sample's at least: no error of the torque
    shows in the rest of it, and of records that rest for different times each shows another share of them."""
    slips = trajectory.x[trajectory.joint.motor_speed] != 0.0
    return float(max(np.mean(slips), 1.0 / len(slips)))


def without_rest(levels: Sequence[NoiseLevels]) -> list[NoiseLevels]:
    """A segment that shows much less noise of the output than the others was at rest."""
    least = NOISE.rest_share**2 * float(np.median([one.output for one in levels]))
    return [replace(one, output=max(one.output, least)) for one in levels]
