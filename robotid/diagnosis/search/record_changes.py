"""What differs on validation records: one parameter, or several that together leave nothing, as a payload changes an
inertia and a weight. Found on their first part and measured on the second, each with half of what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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

    value : its difference, in `unit`, beside the others that differ there. explained : share of the misfit's energy on
    the second part that it removes beside those before it; gain : of the fit there [% points]; twins : what explains
    as much, itself first.
    """

    effect: str
    value: float
    unit: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Changed:
    """A record with changes, found on its first part. values : theirs; after : what the model simulates of the second
    part with them."""

    candidates: tuple[RecordChangeCandidate, ...]
    values: tuple[float, ...]
    after: SegmentFit


def find_record_changes(
    model: RefittedModel, data: EvaluationData, usual: float, level: float
) -> tuple[RecordChange, ...]:
    """What changed on each validation record that is simulated clearly worse than the fitted ones.

    usual : energy a sample on the fitted segments, what the fit could still take left out; level : of significance.
    """
    found: dict[str, tuple[RecordChange, ...]] = {}
    for segment, seen in zip(data.validation, model.validation, strict=True):
        growing = [*_growing(model, segment, seen.residual, usual, level)]
        stand = (changes for changes in reversed(growing) if _differs(model, data, changes, usual, level))
        if changes := next(stand, None):
            found.setdefault(segment.record.name, changes)
    return tuple(change for changes in found.values() for change in changes)


def _growing(
    model: RefittedModel, segment: Segment, residual: Array, usual: float, level: float
) -> Iterator[tuple[RecordChange, ...]]:
    """The changes of a segment that stand out of it, parameter by parameter, until nothing asks for a reason. Several
    must leave nothing, for something else would ask for ever more of them; less than all may tell little."""
    first, second = _parts(segment, residual)
    before = _simulated(model, second)
    if before is None:
        return
    misfit, at = _beyond(before, usual), _Changed((), (), before)
    stood, found, tried = at, list[RecordChange](), 0
    while asks_for_a_reason(at.after, usual, model.output) and len(found) < CHANGES.most:
        asked = _asked_for(model, first, at)
        tried += len(asked)
        if not asked or at.after.energy - asked[0].after.energy < CHANGES.confirmed_share * _beyond(at.after, usual):
            return
        alone = [replace(one, twins=(one.effect,)) for one in found]  # what explained as much was not tried beside all
        found = [*alone, _last_change(model, at.after, asked, misfit)]
        at = asked[0]
        if len(found) > 1 and asks_for_a_reason(at.after, usual, model.output):
            continue
        known = len(stood.candidates)
        p = _p_value(stood.after, at.after, len(found) - known, usual, tried)
        if p < level:
            found = [*found[:known], *(replace(one, p_value=p) for one in found[known:])]
            yield tuple(replace(one, value=value) for one, value in zip(found, at.values, strict=True))
            stood = at


def _beyond(one: SegmentFit, usual: float) -> float:
    """Energy that a segment leaves beyond the usual."""
    return one.energy - usual * len(one.residual)


def _differs(
    model: RefittedModel, data: EvaluationData, changes: Sequence[RecordChange], usual: float, level: float
) -> bool:
    """Whether parameters are not the same on a validation record and on those of the fit: the fit to all of them must
    leave a misfit that the changes explain. Else its own records have only determined them badly."""
    both = Together.of(model, data, {changed(changes[0].effect)[0]})
    same = both.refitted()
    if same is None:
        return True
    apart = both.refitted({change.effect: change.value for change in changes})
    if apart is None:
        return False
    removed = same.energy - apart.energy
    if removed < CHANGES.confirmed_share * (same.energy - usual * same.samples):
        return False
    known = same.energy / usual, same.samples, len(model.columns)
    if significance(removed / usual, len(changes), *known) >= level:
        return False
    left = left_by(apart)
    return all(p_value(apart, change.effect, left) < level for change in changes)


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
        end = _run(model, segment, (candidate,))
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


def _asked_for(model: RefittedModel, first: Segment, at: _Changed) -> list[_Changed]:
    """The changes of a record with one more each, of those with which the fit of its second part rises, the one that
    carries over best first."""
    second = Segment(at.after.record, at.after.whitening)
    found = []
    for candidate in record_changes(model.joint, model.columns, [first.record.name]):
        if candidate not in at.candidates:
            candidates = (*at.candidates, candidate)
            values = _fitted_values(model, first, candidates)
            after = None if values is None else _simulated(model, second, candidates, values)
            if values is not None and after is not None and after.fit_percent > at.after.fit_percent:
                found.append(_Changed(candidates, values, after))
    return sorted(found, key=lambda one: one.after.energy)


def _last_change(model: RefittedModel, before: SegmentFit, asked: Sequence[_Changed], misfit: float) -> RecordChange:
    """The last change of the best of those that are asked for, not tested yet. before : what the record leaves without
    it; misfit : energy that it leaves without any."""
    best = asked[0]
    candidate, close = best.candidates[-1], best.after.energy + CHANGES.same_share * misfit
    return RecordChange(
        effect=candidate.name,
        value=best.values[-1],
        unit=on_axis(linear=model.structure.linear)(candidate.parameter.unit),
        explained=min(1.0, (before.energy - best.after.energy) / misfit),
        gain=best.after.fit_percent - before.fit_percent,
        p_value=1.0,
        twins=tuple(one.candidates[-1].name for one in asked if one.after.energy < close),
    )


def _p_value(before: SegmentFit, after: SegmentFit, parameters: int, usual: float, tried: int) -> float:
    """Of so many parameters being the same on a record, by the noise and by the scatter from block to block, where they
    are the best of so many fits."""
    removed, whole = (before.energy - after.energy) / usual, before.energy / usual
    by_noise = significance(removed, parameters, whole, len(before.residual), tried)
    return max(by_noise, min(1.0, tried * held_out_gain((before,), (after,)).p_value))


def _fitted_values(
    model: RefittedModel, segment: Segment, candidates: Sequence[RecordChangeCandidate]
) -> tuple[float, ...] | None:
    """The changes that a segment asks for, all other parameters fixed; None where it diverges."""
    end = _run(model, segment, candidates)
    return None if end is None else tuple(end.unknowns[: len(candidates)].tolist())


def _simulated(
    model: RefittedModel,
    segment: Segment,
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] = (),
) -> SegmentFit | None:
    """A segment with all parameters fixed, its first states free; None where it diverges."""
    end = _run(model, segment, candidates, values)
    return None if end is None else segment_fit(segment, end.trajectories[0], model.output)


def _run(
    model: RefittedModel,
    segment: Segment,
    candidates: Sequence[RecordChangeCandidate] = (),
    values: Sequence[float] | None = None,
) -> Evaluation | None:
    """A segment with the parameters fixed but for changes, which are sought unless their values are given."""
    structure, names = model.structure, [one.name for one in candidates]
    for name in names:
        structure = structure.extended(name)
    parameters = carried(model.parameters, structure, dict(zip(names, values or (), strict=False)))
    sought = [values is None and name in names for name in parameters.names]
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
