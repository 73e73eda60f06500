"""What a refit comes to: a model with its parameters, its motion on every segment, and what that leaves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble, with_effect
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.settings import REFIT
from robotid.estimate.fitted_model import FittedModel, SimulatedSegment
from robotid.estimate.noise.whitening import InnovationsFilter
from robotid.estimate.residual import measured_output, observed
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure, belongs
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity
from robotid.simulation.trajectory import Trajectory

LEAST_LENGTH = 1e-140  # of a column: the variance of what no sample shows is huge, yet finite


@dataclass(frozen=True, slots=True, eq=False)
class SegmentFit(SimulatedSegment):
    """A segment as a model simulates it, with the whitening by which it was fitted.

    energy : of the whitened residual, in variances of the noise; fit_percent : eq. (15) of the paper [%].
    """

    whitening: InnovationsFilter
    energy: float
    fit_percent: float

    @property
    def whitened(self) -> Array:
        """The whitened residual, (n,)."""
        return self.whitening(self.residual)


def decrease(before: SegmentFit, after: SegmentFit) -> Array:
    """Of the whitened squared error of every sample of a segment, (n,), from one model to another."""
    return np.asarray(before.whitened**2 - after.whitened**2)


def segment_fit(segment: Segment, trajectory: Trajectory, output: Quantity) -> SegmentFit:
    """A segment with a simulated trajectory of it, compared in a quantity."""
    y, simulated = measured_output(segment.record, output), observed(trajectory, output)
    residual = y - simulated
    energy = segment.energy(residual)
    return SegmentFit(segment.record, trajectory, residual, segment.whitening, energy, fit_percent(y, simulated))


@dataclass(frozen=True, slots=True, eq=False)
class RecordFit:
    """A record, or a part of it, as a model simulates it: in one segment, or piece by piece."""

    segments: tuple[SegmentFit, ...]
    output: Quantity

    @property
    def samples(self) -> int:
        """Of all segments."""
        return sum(len(one.residual) for one in self.segments)

    @property
    def energy(self) -> float:
        """Energy of the whitened residuals, in variances of the noise."""
        return float(sum(one.energy for one in self.segments))

    @property
    def fit_percent(self) -> float:
        """Fit of the segments together [%]: of one in which the motor rests, a percentage means nothing."""
        if len(self.segments) == 1:
            return self.segments[0].fit_percent
        measured = np.concatenate([measured_output(one.record, self.output) for one in self.segments])
        return fit_percent(measured, measured - np.concatenate([one.residual for one in self.segments]))


def by_record(segments: Iterable[SegmentFit], output: Quantity) -> dict[str, RecordFit]:
    """Simulated segments, the pieces of each record together, by its name."""
    found: dict[str, list[SegmentFit]] = {}
    for one in segments:
        found.setdefault(one.record.name, []).append(one)
    return {name: RecordFit(tuple(own), output) for name, own in found.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Trajectories:
    """Trajectories of the fitted and the validation segments by a model nearby, from which a fit may start; none where
    none are known."""

    fitted: tuple[Trajectory, ...] = ()
    validation: tuple[Trajectory, ...] = ()


UNKNOWN = Trajectories()


@dataclass(frozen=True, slots=True)
class Unknowns:
    """What is compared, and what a fit shapes of it: parameters, as indices into theta, and first values of states."""

    output: Quantity
    parameters: tuple[int, ...] = ()
    first_states: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class RefittedModel:
    """A model refitted to the fitted segments of evaluation data.

    unknowns : the fitted parameters, and the states whose first values were fitted on every segment. factor : (m, m),
    factor^T factor being the information of the unknowns: the fitted parameters, then the first states segment by
    segment. fitted, validation : the segments as the model simulates them; on those that validate, only first states
    were fitted.
    """

    joint: Joint
    parameters: Parameters
    unknowns: Unknowns
    factor: Array
    fitted: tuple[SegmentFit, ...]
    validation: tuple[SegmentFit, ...]

    @property
    def structure(self) -> Structure:
        """The effects of the model."""
        return self.joint.structure

    @property
    def output(self) -> Quantity:
        """The quantity that is compared."""
        return self.unknowns.output

    @property
    def columns(self) -> tuple[int, ...]:
        """The fitted parameters, as indices into theta."""
        return self.unknowns.parameters

    @property
    def samples(self) -> int:
        """Of the fitted segments."""
        return sum(len(one.residual) for one in self.fitted)

    @property
    def energy(self) -> float:
        """Energy of the whitened residuals on the fitted segments, in variances of the noise."""
        return float(sum(one.energy for one in self.fitted))

    @property
    def validation_energy(self) -> float:
        """The same on the validation segments."""
        return float(sum(one.energy for one in self.validation))

    @property
    def validation_fit_percent(self) -> float:
        """Mean fit over the validation records [%], nan without any."""
        fits = [one.fit_percent for one in by_record(self.validation, self.output).values()]
        return float(np.mean(fits)) if fits else float("nan")

    @property
    def trajectories(self) -> Trajectories:
        """From which a fit of a similar model may start."""
        return Trajectories(
            tuple(one.trajectory for one in self.fitted), tuple(one.trajectory for one in self.validation)
        )

    @property
    def covariance(self) -> Array:
        """Covariance of the unknowns, parameters first, (m, m), the noise as large as the residual shows it."""
        scale = np.maximum(np.linalg.norm(self.factor, axis=0), LEAST_LENGTH)
        inverse = np.linalg.pinv(self.factor / scale, rcond=REFIT.unidentifiable) / scale[:, None]
        return np.asarray(inverse @ inverse.T * max(1.0, self.energy / self.samples))

    def put_into(self, model: FittedModel) -> FittedModel:
        """A diagnosed model with these effects and parameters; its first states were those of others."""
        return replace(model, joint=self.joint, parameters=self.parameters, first_states={})

    def own_columns(self, effect: str) -> list[int]:
        """The fitted parameters of an effect, by their number among all fitted ones."""
        return [i for i, k in enumerate(self.columns) if belongs(self.parameters.names[k], effect)]

    def energy_of(self, effect: str) -> float:
        """Energy that the model would lose to first order without an effect, all other unknowns refitted: the Wald
        statistic of its parameters that have a null, in variances of the noise."""
        numbered = ((i, self.columns[i]) for i in self.own_columns(effect))
        away = {
            i: self.parameters.values[k] - null
            for i, k in numbered
            if (null := self.joint.declared[k].null) is not None
        }
        own, distance = list(away), np.array(list(away.values()))
        if not own:
            return 0.0
        covariance = self.covariance[np.ix_(own, own)] / max(1.0, self.energy / self.samples)
        return float(distance @ np.linalg.pinv(covariance, hermitian=True) @ distance)


def extended(model: RefittedModel, effect: str, values: Mapping[str, float]) -> tuple[Structure, Parameters]:
    """The structure with one effect more, and where its refit starts: the model's values, the effect's as given."""
    structure = with_effect(model.structure, effect)
    return structure, carried(model.parameters, structure, values)


def reduced(model: RefittedModel, effect: str) -> tuple[Structure, Parameters]:
    """The structure with one effect less, and where its refit starts."""
    structure = model.structure.without(effect)
    return structure, carried(model.parameters, structure, {})


def carried(old: Parameters, structure: Structure, values: Mapping[str, float]) -> Parameters:
    """Parameters of a similar structure: values, bounds and freedom of the old by name, over them `values`, kept within
    the bounds."""
    same = assemble(structure).parameters().taken_from(old)
    start = [values.get(name, value) for name, value in zip(same.names, same.values.tolist(), strict=True)]
    given = [name in values for name in same.names]
    return same.with_values(np.where(given, np.clip(start, same.lower, same.upper), same.values))
