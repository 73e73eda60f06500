"""What differs on validation records: one parameter, or several that together leave nothing, as a payload changes an
inertia and a weight. Found on their first part and measured on the second, each with half of what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, carried, segment_fit
from robotid.diagnosis.refit.settings import REFIT
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate, record_changes
from robotid.diagnosis.scoring.score_test import significance
from robotid.diagnosis.search.agreement import Together, is_loud
from robotid.diagnosis.search.carry_over import held_out_gain
from robotid.diagnosis.search.coloured import blocks_with, by_noise, left_by
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.settings import ACCEPTANCE, CHANGES
from robotid.errors import NumericsError
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.sensing import joint_for
from robotid.model.array import Array
from robotid.model.port import Port
from robotid.model.structure import changed
from robotid.model.units import on_axis
from robotid.signals.record import SHORTEST_PIECE, Quantity


@dataclass(frozen=True, slots=True, eq=False)
class RecordChange:
    """A parameter that differs on a validation record.

    value, std : its difference, in `unit`, beside the others that differ there, and its standard deviation, by the fit
    to all records where there is one. explained : share of the misfit's energy on the second part that it removes
    beside those before it; gain : of the fit of the record [% points]; twins : what explains as much, itself first.
    """

    effect: str
    value: float
    unit: str
    explained: float
    gain: float
    p_value: float
    twins: tuple[str, ...]
    std: float = float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class _Changed:
    """A record with changes, found on its first part. values : theirs; after : what the model simulates of the second
    part with them."""

    candidates: tuple[RecordChangeCandidate, ...]
    values: tuple[float, ...]
    after: SegmentFit


@dataclass(frozen=True, slots=True, eq=False)
class _Standing:
    """Changes that stand out of a record. complete : they leave nothing that asks for a reason."""

    changes: tuple[RecordChange, ...]
    complete: bool


def find_record_changes(
    model: RefittedModel, data: EvaluationData, usual: float, level: float
) -> tuple[RecordChange, ...]:
    """What changed on each validation record that is simulated clearly worse than the fitted ones.

    usual : energy a sample on the fitted segments, what the fit could still take left out; level : of significance.
    """
    found: dict[str, tuple[RecordChange, ...]] = {}
    for segment, seen in zip(data.validation, model.validation, strict=True):
        changes = _of_record(model, data, segment, seen.residual, usual, level)
        if changes:
            found.setdefault(segment.record.name, changes)
    return tuple(change for changes in found.values() for change in changes)


def _of_record(
    model: RefittedModel, data: EvaluationData, segment: Segment, residual: Array, usual: float, level: float
) -> tuple[RecordChange, ...]:
    """What changed on one record: what a payload changes, or anything, of which the simpler is taken."""
    first, second = _parts(segment, residual)
    before = _simulated(model, second)
    if before is None or not asks_for_a_reason(before, usual, model.output):
        return ()
    candidates = record_changes(model.joint, model.columns, [segment.record.name])
    payload = [*_payload(model, first, before, candidates, usual, level)]
    most = 1 if payload else CHANGES.most  # one of any other kind is simpler still
    others = [*_growing(model, first, before, candidates, usual, level, most)]

    def order(ones: Sequence[_Standing]) -> tuple[bool, int, int]:
        last = ones[-1]
        explained = sum(one.explained for one in last.changes)
        return not last.complete, len(last.changes), -round(explained / CHANGES.same_share)

    for standing in sorted(filter(None, (payload, others)), key=order):
        for one in reversed(standing):
            changes = _apart(model, data, one.changes, usual, level)
            seen = tuple(
                change for change in changes if not abs(change.value) < ACCEPTANCE.amplitude_sigma * change.std
            )
            if 0 < len(seen) < len(changes):
                changes = _apart(model, data, seen, usual, level) or changes
            if changes:
                return _with_gains(model, segment, changes)
    return ()


def _payload(
    model: RefittedModel,
    first: Segment,
    before: SegmentFit,
    candidates: Sequence[RecordChangeCandidate],
    usual: float,
    level: float,
) -> Iterator[_Standing]:
    """All that a payload adds to, at the outermost place that carries one, where that is more than one parameter and
    leaves nothing that asks for a reason: none of them need do any good without the others."""
    carried_there = [one for one in candidates if one.parameter.carried]
    outermost = max(map(_place, carried_there), key=[*Port].index, default=None)
    added = [one for one in carried_there if _place(one) == outermost]
    at = _carried(model, first, before, added) if len(added) > 1 else None
    if at is None or asks_for_a_reason(at.after, usual, model.output):
        return
    changes, least = list[RecordChange](), before.energy
    for k in range(1, len(added) + 1):
        after = _simulated(model, _second(before), at.candidates[:k], at.values[:k])
        if after is None:
            return
        part = _Changed(at.candidates[:k], at.values[:k], after)
        changes.append(_last_change(model, before, [part], least, _beyond(before, usual)))
        least = min(least, after.energy)
    p = _p_value(before, at.after, len(changes), usual, 2)
    if p < level:
        yield _Standing(tuple(replace(one, p_value=p) for one in changes), True)


def _carried(
    model: RefittedModel, first: Segment, before: SegmentFit, added: Sequence[RecordChangeCandidate]
) -> _Changed | None:
    """The changes that belong together: all at once or one after the other, whichever carries over better."""
    at: _Changed | None = _Changed((), (), before)
    while at is not None and len(at.values) < len(added):
        at = next(iter(_with_one_more(model, first, at, added)), None)
    values = _fitted_values(model, first, added)
    after = None if values is None else _simulated(model, _second(before), added, values)
    ends = [at] if values is None or after is None else [at, _Changed(tuple(added), values, after)]
    return min(filter(None, ends), key=lambda one: one.after.energy, default=None)


def _second(before: SegmentFit) -> Segment:
    """The second part of a record, by what a model leaves of it."""
    return Segment(before.record, before.whitening)


def _place(candidate: RecordChangeCandidate) -> Port:
    return Port(changed(candidate.name)[1].partition(".")[0])


def _growing(
    model: RefittedModel,
    first: Segment,
    before: SegmentFit,
    candidates: Sequence[RecordChangeCandidate],
    usual: float,
    level: float,
    most: int,
) -> Iterator[_Standing]:
    """The changes that stand out of a record, parameter by parameter. Several must leave nothing that asks for a
    reason, for something else would ask for ever more of them; less than all may tell little.

    before : what the model leaves of the second part; most : parameters.
    """
    misfit, at = _beyond(before, usual), _Changed((), (), before)
    stood, found, tried, least = at, list[RecordChange](), 0, before.energy
    while len(found) < most and (at is not stood or _beyond(at.after, usual) > 0.0):
        asked = _asked_for(model, first, at, candidates)
        tried += len(asked)
        if not asked or at.after.energy - asked[0].after.energy < CHANGES.confirmed_share * _beyond(at.after, usual):
            return
        alone = [replace(one, twins=(one.effect,)) for one in found]  # what explained as much was not tried beside all
        found = [*alone, _last_change(model, at.after, asked, least, misfit)]
        at, least = asked[0], min(least, asked[0].after.energy)
        quiet = not asks_for_a_reason(at.after, usual, model.output)
        if len(found) > 1 and not quiet:
            continue
        known = len(stood.candidates)
        p = _p_value(stood.after, at.after, len(found) - known, usual, tried)
        if p < level:
            found = [*found[:known], *(replace(one, p_value=p) for one in found[known:])]
            yield _Standing(tuple(replace(one, value=v) for one, v in zip(found, at.values, strict=True)), quiet)
            stood = at


def _beyond(one: SegmentFit, usual: float) -> float:
    """Energy that a segment leaves beyond the usual."""
    return one.energy - usual * len(one.residual)


def _apart(
    model: RefittedModel, data: EvaluationData, changes: tuple[RecordChange, ...], usual: float, level: float
) -> tuple[RecordChange, ...]:
    """Changes as a fit to all records finds them, none where parameters may be the same there: the fit without changes
    must leave a misfit that they explain. Else the model's own records have only determined them badly."""
    both = Together.of(model, data, {changed(changes[0].effect)[0]})
    same = both.refitted()
    if same is None:
        return changes
    apart = both.refitted({change.effect: change.value for change in changes})
    if apart is None:
        return ()
    removed = same.energy - apart.energy
    if removed < CHANGES.confirmed_share * (same.energy - usual * same.samples):
        return ()
    known = same.energy / usual, same.samples, len(model.columns)
    if significance(removed / usual, len(changes), *known) >= level:
        return ()
    left, sizes = left_by(apart), dict[int, float]()
    for change in changes:
        sizes |= amplitudes(apart, change.effect)
    blocks = blocks_with(left, sizes)
    as_one = blocks.combined(sizes)  # few blocks tell one size from several
    again = as_one.significance([as_one.moment.shape[1] - 1])
    if max(by_noise(blocks, [*sizes], left.energy, apart.samples), again) >= level:
        return ()
    inflation = max(1.0, apart.energy / apart.samples)
    variances = inflation * np.diag(apart.covariance)
    return tuple(
        replace(change, value=size, std=float(np.sqrt(max(0.0, variances[k]))))
        for change, (k, size) in zip(changes, sizes.items(), strict=True)
    )


def _with_gains(model: RefittedModel, segment: Segment, changes: tuple[RecordChange, ...]) -> tuple[RecordChange, ...]:
    """Changes with what each gains on the whole segment beside those before it."""
    candidates = {one.name: one for one in record_changes(model.joint, model.columns, [segment.record.name])}
    at, values, fits = [candidates[one.effect] for one in changes], [one.value for one in changes], list[float]()
    for k in range(len(changes) + 1):
        seen = _simulated(model, segment, at[:k], values[:k])
        if seen is None:
            return changes
        fits.append(seen.fit_percent)
    return tuple(replace(one, gain=b - a) for one, (a, b) in zip(changes, pairwise(fits), strict=True))


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


def _asked_for(
    model: RefittedModel, first: Segment, at: _Changed, candidates: Sequence[RecordChangeCandidate]
) -> list[_Changed]:
    """The changes of a record with one more of the candidates each, of those with which the fit of its second part
    rises, the one that carries over best first."""
    found = _with_one_more(model, first, at, candidates)
    return [one for one in found if one.after.fit_percent > at.after.fit_percent]


def _with_one_more(
    model: RefittedModel, first: Segment, at: _Changed, candidates: Sequence[RecordChangeCandidate]
) -> list[_Changed]:
    """The changes of a record with one more of the candidates each, the one that carries over best first."""
    found = []
    for candidate in candidates:
        if candidate not in at.candidates:
            tried = (*at.candidates, candidate)
            values = _fitted_values(model, first, tried)
            after = None if values is None else _simulated(model, _second(at.after), tried, values)
            if values is not None and after is not None:
                found.append(_Changed(tried, values, after))
    return sorted(found, key=lambda one: one.after.energy)


def _last_change(
    model: RefittedModel, before: SegmentFit, asked: Sequence[_Changed], least: float, misfit: float
) -> RecordChange:
    """The last change of the best of those that are asked for, not tested yet. before : what the record leaves without
    it; least : energy that it leaves with any of those before; misfit : beyond the usual, without any."""
    best = asked[0]
    candidate, close = best.candidates[-1], best.after.energy + CHANGES.same_share * misfit
    return RecordChange(
        effect=candidate.name,
        value=best.values[-1],
        unit=on_axis(linear=model.structure.linear)(candidate.parameter.unit),
        explained=float(np.clip((least - best.after.energy) / misfit, 0.0, 1.0)),
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
    """The changes that a segment asks for, all other parameters fixed; None where it diverges. From none, and from what
    the plain squared error asks for, which noise that passes for slow errors hides where the segment is far off."""
    plain = _run(model, segment, candidates, whitened=False)
    starts = [None] if plain is None else [None, _values(plain, candidates)]
    found = [end for end in (_run(model, segment, candidates, start=start) for start in starts) if end is not None]
    return _values(min(found, key=lambda end: end.cost), candidates) if found else None


def _values(end: Evaluation, candidates: Sequence[RecordChangeCandidate]) -> tuple[float, ...]:
    """The changes at the end of a fit."""
    return tuple(end.unknowns[: len(candidates)].tolist())


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
    *,
    start: Sequence[float] | None = None,
    whitened: bool = True,
) -> Evaluation | None:
    """A segment with the parameters fixed but for changes, which are sought unless their values are given. start : of
    those that are sought; whitened : by the noise of the segment."""
    structure, names = model.structure, [one.name for one in candidates]
    for name in names:
        structure = structure.extended(name)
    parameters = carried(model.parameters, structure, dict(zip(names, values or start or (), strict=False)))
    sought = [values is None and name in names for name in parameters.names]
    problem = OutputError(
        joint_for(structure, model.output, (segment.record,)),
        replace(parameters, free=np.array(sought)),
        (segment.record,),
        model.output,
        np.ones(1),
        bool(model.unknowns.first_states),
        (segment.whitening,) if whitened else (),
        REFIT.patience,
    )
    try:
        return solve(problem, problem.start(), SolveOptions(CHANGES.max_iterations, REFIT.tolerance)).evaluation
    except NumericsError:
        return None
