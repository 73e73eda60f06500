"""Whether one model simulates the records of the fit and those held out.

A model that leaves noise on its own records may be far off on others because a parameter was badly determined, because
one has changed, or because something is missing that its own records do not show. A fit to both tells the first from
the others.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from robotid.diagnosis.noise.drawn import drawn_residuals
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit_to_confirm
from robotid.diagnosis.refit.refitted_model import (
    RecordFit,
    RefittedModel,
    SegmentFit,
    Trajectories,
    by_record,
    carried,
    segment_fit,
)
from robotid.diagnosis.search.settings import CHANGES
from robotid.model.array import Array
from robotid.signals.record import Quantity


@dataclass(frozen=True, eq=False)
class Together:
    """A model, and the records of its fit with some that were held out of it: data : all of them to be fitted; near :
    how the model simulates them."""

    model: RefittedModel
    data: EvaluationData
    near: Trajectories

    @classmethod
    def of(cls, model: RefittedModel, data: EvaluationData, names: Collection[str]) -> Together:
        """With the validation records of these names."""
        held = [k for k, segment in enumerate(data.validation) if segment.record.name in names]
        both = (*data.fitted, *(data.validation[k] for k in held))
        near = (*model.fitted, *(model.validation[k] for k in held))
        own = replace(data, fitted=both, validation=())
        return cls(model, own, Trajectories(tuple(one.trajectory for one in near)))

    @cached_property
    def same(self) -> RefittedModel | None:
        """The model fitted to all of them without changes; None where they cannot be simulated so."""
        return self.refitted()

    def refitted(self, changes: Mapping[str, float] = MappingProxyType({})) -> RefittedModel | None:
        """The model fitted to all of them, with changes of a record that start at these values, by name; None where
        they cannot be simulated so."""
        structure = self.model.structure
        for effect in changes:
            structure = structure.extended(effect)
        start = carried(self.model.parameters, structure, changes)
        return refit_to_confirm(structure, start, self.data, self.near)


@dataclass(frozen=True, slots=True)
class Agreement:
    """Names of validation records that a model simulates clearly worse than those of its fit. joined : fitted together
    with these, it simulates all of them as well; apart : no parameters do."""

    joined: tuple[str, ...] = ()
    apart: tuple[str, ...] = ()


def agreement(model: RefittedModel, data: EvaluationData, usual: float) -> Agreement:
    """Whether a model can be that of its validation records, too.

    usual : energy a sample on the fitted segments, by the noise of `data`.
    """
    names = _loud(held_out(model, data), usual)
    if not names:
        return Agreement()
    together = Together.of(model, data, names).same
    loud = None if together is None else _loud(by_record(together.fitted, data.output), usual)
    if loud is None or set(loud).difference(names):
        return Agreement(apart=names)
    return Agreement(tuple(name for name in names if name not in loud), loud)


def held_out(model: RefittedModel, data: EvaluationData) -> dict[str, RecordFit]:
    """The validation records as a model simulates them, by the noise of `data`, by name."""
    pairs = zip(data.validation, model.validation, strict=True)
    return by_record((segment_fit(segment, one.trajectory, data.output) for segment, one in pairs), data.output)


def _loud(records: Mapping[str, RecordFit], usual: float) -> tuple[str, ...]:
    """Names of records with clearly more energy a sample than usual, by the noise through which they are whitened."""
    return tuple(name for name, own in records.items() if is_loud(own.segments, usual, own.output))


def is_loud(segments: Sequence[SegmentFit], usual: float, output: Quantity) -> bool:
    """Whether segments are simulated clearly worse than usual, and than the errors of the torque make of a joint that
    reverses and rests there; or are off by clearly more, plainly, than such errors ever move them: where these are
    slow, what is off as slowly counts little among them. usual : energy a sample on the fitted segments."""
    energy, samples = sum(one.energy for one in segments), sum(len(one.residual) for one in segments)
    if energy <= usual * samples:  # without any work
        return False
    drawn = [_drawn(one, output) for one in segments]
    if _is_far_off(segments, drawn):
        return True
    if energy <= CHANGES.loud_energy * usual * samples:
        return False
    return energy > CHANGES.loud_energy * sum(map(_expected_energy, segments, drawn))


def _drawn(one: SegmentFit, output: Quantity) -> list[Array]:
    """What errors of the torque of a segment's noise make of it, (n,) each; none where there are no such errors."""
    levels = one.whitening.levels
    return drawn_residuals(one, levels, output) if levels.torque + levels.red > 0.0 else []


def _is_far_off(segments: Sequence[SegmentFit], drawn: Sequence[Sequence[Array]]) -> bool:
    """Whether segments are off by so many times as much as in the worst of what was drawn for them."""
    if not all(drawn):
        return False
    off = np.sqrt(sum(float(one.residual @ one.residual) for one in segments))
    worst = np.sqrt(sum(max(float(moved @ moved) for moved in ones) for ones in drawn))
    return bool(off > CHANGES.far_off * worst)


def _expected_energy(one: SegmentFit, drawn: Sequence[Array]) -> float:
    """Energy that the noise of a segment makes of it, in its variances."""
    found = [float(white @ white) for white in map(one.whitening, drawn)]
    return float(np.mean(found)) if found else float(len(one.residual))
