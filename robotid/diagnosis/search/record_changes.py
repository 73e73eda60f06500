"""What differs on validation records: one parameter at a time, found on their first part and measured on the second,
each with half of what is wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, carried, segment_fit
from robotid.diagnosis.refit.settings import REFIT
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate, record_changes
from robotid.diagnosis.scoring.score_test import significance
from robotid.diagnosis.search.agreement import Together, is_loud
from robotid.diagnosis.search.carry_over import held_out_gain
from robotid.diagnosis.search.coloured import left_by, p_value
from robotid.diagnosis.search.settings import CHANGES
from robotid.errors import NumericsError
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.sensing import joint_for
from robotid.model.array import Array
from robotid.model.structure import changed
from robotid.model.units import on_axis
from robotid.signals.record import SHORTEST_PIECE, Quantity


@dataclass(frozen=True, slots=True, eq=False)
class RecordChange:
    """A parameter that differs on a validation record.

    value : its difference, in `unit`. explained : share of the misfit's energy on the second part that it removes;
    gain : of the fit there [% points]; twins : what explains as much, itself first.
    """

    effect: str
    value: float
    unit: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    """A change found on the first part of a record. explained : of the misfit on the second, where `after` is what the
    model simulates with it."""

    candidate: RecordChangeCandidate
    value: float
    explained: float
    after: SegmentFit


def find_record_changes(
    model: RefittedModel, data: EvaluationData, usual: float, level: float
) -> tuple[RecordChange, ...]:
    """At most one change for each validation record that is simulated clearly worse than the fitted ones.

    usual : energy a sample on the fitted segments, what the fit could still take left out; level : of significance.
    """
    found: dict[str, RecordChange] = {}
    for segment, seen in zip(data.validation, model.validation, strict=True):
        first, second = _parts(segment, seen.residual)
        before = _simulated(model, second)
        if before is not None and asks_for_a_reason(before, usual, model.output):
            change = _best(model, first, before, usual)
            if change is not None and change.p_value < level and _differs(model, data, change, usual, level):
                found.setdefault(segment.record.name, change)
    return tuple(found.values())


def _differs(model: RefittedModel, data: EvaluationData, change: RecordChange, usual: float, level: float) -> bool:
    """Whether a parameter is not the same on a validation record and on those of the fit: the fit to all of them must
    leave a misfit that the change explains. Else its own records have only determined it badly."""
    both = Together.of(model, data, {changed(change.effect)[0]})
    same = both.refitted()
    if same is None:
        return True
    apart = both.refitted(change.effect, change.value)
    if apart is None:
        return False
    removed = same.energy - apart.energy
    if removed < CHANGES.confirmed_share * (same.energy - usual * same.samples):
        return False
    if significance(removed / usual, 1, same.energy / usual, same.samples, len(model.columns)) >= level:
        return False
    return p_value(apart, change.effect, left_by(apart)) < level


@dataclass(frozen=True, slots=True)
class SegmentChange:
    """A parameter, by name, as a whole segment asks for it: its difference, and the energy that is left with it."""

    parameter: str
    value: float
    energy: float


def changes_of(model: RefittedModel, segment: Segment) -> tuple[float, tuple[SegmentChange, ...]]:
    """The energy that a model leaves of a segment, and the change of each of its parameters by itself, those with
    which it diverges left out. Infinite energy where the model itself diverges."""
    before = _simulated(model, segment)
    found = []
    for candidate in record_changes(model.joint, model.columns, [segment.record.name]):
        end = _run(model, segment, candidate, None)
        if end is not None:
            after = segment_fit(segment, end.trajectories[0], model.output)
            name = model.joint.names[candidate.column]
            found.append(SegmentChange(name, float(end.unknowns[0]), after.energy))
    return np.inf if before is None else before.energy, tuple(found)


def asks_for_a_reason(before: SegmentFit, usual: float, output: Quantity) -> bool:
    """Whether a segment is simulated clearly worse than usual. usual : energy a sample on the fitted segments."""
    return is_loud([before], usual, output)


def _parts(segment: Segment, residual: Array) -> tuple[Segment, Segment]:
    """A segment in two, each with half the energy of its residual (n,): the second tests what the first asks for, which
    no part does that rests or hardly shows it. None is shorter than a share of the whole."""
    record, left = segment.record, np.cumsum(np.square(segment.whitening(residual)))
    shortest = max(round(CHANGES.shortest_part * len(record)), min(SHORTEST_PIECE, len(record) // 2))
    cut = int(np.clip(np.searchsorted(left, left[-1] / 2.0), shortest, len(record) - shortest))
    return replace(segment, record=record.piece(0, cut)), replace(segment, record=record.piece(cut, len(record)))


def _best(model: RefittedModel, first: Segment, before: SegmentFit, usual: float) -> RecordChange | None:
    """The change that carries over best from the first part of a record to the second, `before` without it, of those
    with which the fit of that rises."""
    second = Segment(before.record, before.whitening)
    misfit = before.energy - usual * len(before.residual)
    tried = []
    for candidate in record_changes(model.joint, model.columns, [first.record.name]):
        value = _fitted_value(model, first, candidate)
        after = None if value is None else _simulated(model, second, candidate, value)
        if value is not None and after is not None and after.fit_percent > before.fit_percent:
            tried.append(_Tried(candidate, value, (before.energy - after.energy) / misfit, after))
    tried.sort(key=lambda one: -one.explained)
    if not tried or tried[0].explained < CHANGES.confirmed_share:
        return None
    best = tried[0]
    removed, whole = best.explained * misfit / usual, before.energy / usual
    scatter = held_out_gain((before,), (best.after,)).p_value
    return RecordChange(
        effect=best.candidate.name,
        value=best.value,
        unit=on_axis(linear=model.structure.linear)(best.candidate.parameter.unit),
        explained=min(1.0, best.explained),
        gain=best.after.fit_percent - before.fit_percent,
        p_value=max(significance(removed, 1, whole, len(before.residual), len(tried)), min(1.0, len(tried) * scatter)),
        twins=tuple(one.candidate.name for one in tried if one.explained > best.explained - CHANGES.same_share),
    )


def _fitted_value(model: RefittedModel, segment: Segment, candidate: RecordChangeCandidate) -> float | None:
    """The change that a segment asks for, all other parameters fixed; None where it diverges."""
    end = _run(model, segment, candidate, None)
    return None if end is None else float(end.unknowns[0])


def _simulated(
    model: RefittedModel, segment: Segment, candidate: RecordChangeCandidate | None = None, value: float = 0.0
) -> SegmentFit | None:
    """A segment with all parameters fixed, its first states free; None where it diverges."""
    end = _run(model, segment, candidate, value)
    return None if end is None else segment_fit(segment, end.trajectories[0], model.output)


def _run(
    model: RefittedModel, segment: Segment, candidate: RecordChangeCandidate | None, value: float | None
) -> Evaluation | None:
    """A segment with the parameters fixed but for a change, which is sought unless its value is given."""
    structure = model.structure if candidate is None else model.structure.extended(candidate.name)
    start = {} if candidate is None or value is None else {candidate.name: value}
    parameters = carried(model.parameters, structure, start)
    sought = [value is None and candidate is not None and name == candidate.name for name in parameters.names]
    problem = OutputError(
        joint_for(structure, model.output, (segment.record,)),
        replace(parameters, free=np.array(sought)),
        (segment.record,),
        model.output,
        np.ones(1),
        bool(model.unknowns.first_states),
        (segment.whitening,),
        REFIT.patience,
    )
    try:
        return solve(problem, problem.start(), SolveOptions(CHANGES.max_iterations, REFIT.tolerance)).evaluation
    except NumericsError:
        return None
