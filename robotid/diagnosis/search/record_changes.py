"""What differs on validation records: one parameter, or several that together leave nothing, as a payload changes an
inertia and a weight. Found on their first part, tested on the second, and sized by a fit to all records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RecordFit, RefittedModel
from robotid.diagnosis.scoring.record_change_candidate import record_changes
from robotid.diagnosis.scoring.score_test import significance
from robotid.diagnosis.search.agreement import Together, held_out
from robotid.diagnosis.search.carry_over import gain_by_blocks
from robotid.diagnosis.search.changed_record import Changed, Halves, record_fit, run, segments_of, simulated
from robotid.diagnosis.search.coloured import blocks_with, by_noise, left_by
from robotid.diagnosis.search.drawn_sizes import DrawnSizes
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.settings import ACCEPTANCE, CHANGES
from robotid.errors import NumericsError
from robotid.model.units import on_axis


@dataclass(frozen=True, slots=True, eq=False)
class RecordChange:
    """A parameter that differs on a validation record.

    value, std : its difference, in `unit`, beside the others that differ there, and its standard deviation, by the fit
    to all records where there is one. explained : share of the misfit's energy on the record that it removes beside
    those before it; gain : of the fit of the record [% points]; twins : what explains as much, itself first.
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
    records = held_out(model, data).values()
    return tuple(change for seen in records for change in _of_record(model, data, seen, usual, level))


def _of_record(
    model: RefittedModel, data: EvaluationData, seen: RecordFit, usual: float, level: float
) -> tuple[RecordChange, ...]:
    """What changed on one record: what a payload changes, or anything, of which the simpler is taken."""
    halves = Halves.of(model, seen, usual)
    if halves is None:
        return ()
    payload = [*_payload(halves, level)]
    others = [*_growing(halves, level, 1 if payload else CHANGES.most)]  # one of any other kind is simpler still
    if not payload and not others:
        return ()
    both = Together.of(model, data, {seen.segments[0].record.name})
    for standing in sorted(filter(None, (payload, others)), key=_simplest):
        for one in reversed(standing):
            found = _sized(both, one.changes, usual, level)
            if found is not None:
                found = _fewer(both, found, usual, level) or found
                return _with_gains(halves, seen, found.changes)
    return ()


def _fewer(both: Together, found: _Sized, usual: float, level: float) -> _Sized | None:
    """The changes that are certain to be there, where they explain as much without the others."""
    certain = tuple(one for one in found.changes if not abs(one.value) < ACCEPTANCE.amplitude_sigma * one.std)
    if not 0 < len(certain) < len(found.changes):
        return None
    fewer = _sized(both, certain, usual, level)
    as_good = fewer is not None and fewer.removed > (1.0 - CHANGES.same_share) * found.removed
    return fewer if as_good else None


def _simplest(standing: Sequence[_Standing]) -> tuple[bool, int, int]:
    """Order of what explains a record: all of it, by few parameters, and more of it."""
    last = standing[-1]
    explained = sum(one.explained for one in last.changes)
    return not last.complete, len(last.changes), -round(explained / CHANGES.same_share)


def _payload(halves: Halves, level: float) -> Iterator[_Standing]:
    """All that a payload adds to, where that is more than one parameter and leaves nothing that asks for a reason: none
    of them need do any good without the others."""
    before, added = halves.before, halves.payload
    at = halves.with_all(added) if len(added) > 1 and halves.beyond(before) > 0.0 else None
    if at is None or halves.asks_for_more(at.after):
        return
    changes, least = list[RecordChange](), before.energy
    for part in (*(halves.with_values(*at.first(k)) for k in range(1, len(added))), at):
        if part is None:
            return
        changes.append(_last_change(halves, before, [part], least))
        least = min(least, part.after.energy)
    p = _p_value(before, at.after, len(changes), halves.usual, 2)
    if p < level:
        yield _Standing(tuple(replace(one, p_value=p) for one in changes), complete=True)


def _growing(halves: Halves, level: float, most: int) -> Iterator[_Standing]:
    """The changes that stand out of a record, parameter by parameter. Several must leave nothing that asks for a
    reason, for something else would ask for ever more of them; less than all may tell little. most : parameters."""
    at = stood = halves.unchanged
    found, tried, least = list[RecordChange](), 0, at.after.energy
    while len(found) < most and (at is not stood or halves.beyond(at.after) > 0.0):
        asked = _asked_for(halves, at)
        tried += len(asked)
        if not asked or at.after.energy - asked[0].after.energy < CHANGES.confirmed_share * halves.beyond(at.after):
            return
        alone = [replace(one, twins=(one.effect,)) for one in found]  # what explained as much was not tried beside all
        found = [*alone, _last_change(halves, at.after, asked, least)]
        at, least = asked[0], min(least, asked[0].after.energy)
        complete = not halves.asks_for_more(at.after)
        if len(found) > 1 and not complete:
            continue
        known = len(stood.candidates)
        p = _p_value(stood.after, at.after, len(found) - known, halves.usual, tried)
        if p < level:
            found = [*found[:known], *(replace(one, p_value=p) for one in found[known:])]
            yield _Standing(tuple(replace(one, value=v) for one, v in zip(found, at.values, strict=True)), complete)
            stood = at


def _asked_for(halves: Halves, at: Changed) -> list[Changed]:
    """The changes of a record with one more each, of those with which the fit of its second part rises, the one that
    carries over best first."""
    found = halves.with_one_more(at, halves.candidates)
    return [one for one in found if one.after.fit_percent > at.after.fit_percent]


def _last_change(halves: Halves, before: RecordFit, asked: Sequence[Changed], least: float) -> RecordChange:
    """The last change of the best of those that are asked for, not tested yet. before : what the record leaves without
    it; least : energy that it leaves with any of those before."""
    best, misfit = asked[0], halves.beyond(halves.before)
    candidate, close = best.candidates[-1], best.after.energy + CHANGES.same_share * misfit
    return RecordChange(
        effect=candidate.name,
        value=best.values[-1],
        unit=on_axis(linear=halves.model.structure.linear)(candidate.parameter.unit),
        explained=float(np.clip((least - best.after.energy) / misfit, 0.0, 1.0)),
        gain=best.after.fit_percent - before.fit_percent,
        p_value=1.0,
        twins=tuple(one.candidates[-1].name for one in asked if one.after.energy < close),
    )


def _p_value(before: RecordFit, after: RecordFit, parameters: int, usual: float, tried: int) -> float:
    """Of so many parameters being the same on a record, by the noise and by the scatter from block to block, where they
    are the best of so many fits."""
    removed, whole = (before.energy - after.energy) / usual, before.energy / usual
    by_noise = significance(removed, parameters, whole, before.samples, tried)
    return max(by_noise, min(1.0, tried * gain_by_blocks(before.segments, after.segments).p_value))


@dataclass(frozen=True, slots=True, eq=False)
class _Sized:
    """Changes as a fit to all records finds them. removed : energy that they explain there."""

    changes: tuple[RecordChange, ...]
    removed: float


def _sized(both: Together, changes: tuple[RecordChange, ...], usual: float, level: float) -> _Sized | None:
    """Changes as a fit to all records finds them, None where parameters may be the same there: the fit without changes
    must leave a misfit that they explain. Else the model's own records have only determined them badly."""
    same = both.same
    if same is None:
        return _Sized(changes, np.inf)
    apart = both.refitted({change.effect: change.value for change in changes})
    if apart is None:
        return None
    removed = same.energy - apart.energy
    if removed < CHANGES.confirmed_share * (same.energy - usual * same.samples):
        return None
    known = same.energy / usual, same.samples, len(both.model.columns)
    if significance(removed / usual, len(changes), *known) >= level:
        return None
    try:
        left, sizes = left_by(apart), dict[int, float]()
    except NumericsError:
        return None
    for change in changes:
        sizes |= amplitudes(apart, change.effect)
    blocks = blocks_with(left, sizes)
    as_one = blocks.combined(sizes)  # few blocks tell one size from several
    again = as_one.significance([as_one.moment.shape[1] - 1])
    if max(by_noise(blocks, [*sizes], left.energy, apart.samples), again) >= level:
        return None
    among = DrawnSizes(left, sizes, [k for k in range(len(apart.columns)) if k not in sizes])
    if among.p_value(level) >= level:
        return None
    deviations = np.sqrt(np.maximum(among.variances, np.diag(blocks.covariance())[list(sizes)]))
    sized = zip(changes, among.found.tolist(), deviations.tolist(), strict=True)
    return _Sized(tuple(replace(change, value=value, std=std) for change, value, std in sized), removed)


def _with_gains(halves: Halves, seen: RecordFit, changes: tuple[RecordChange, ...]) -> tuple[RecordChange, ...]:
    """Changes with what each gains on the whole record beside those before it, the one first that gains most; what
    gains nothing so, beside all others. As they were where the record cannot be simulated with some of them."""
    candidates, segments = {one.name: one for one in halves.candidates}, segments_of(seen)

    def with_these(some: Sequence[RecordChange]) -> RecordFit | None:
        return simulated(halves.model, segments, [candidates[c.effect] for c in some], [c.value for c in some])

    ordered, left, at = list[RecordChange](), list(changes), with_these([])
    if at is None:
        return changes
    misfit = least = halves.beyond(at)
    while left:
        found = [with_these([*ordered, one]) for one in left]
        ends = [after for after in found if after is not None]
        if len(ends) < len(found):
            return changes
        k = int(np.argmax([after.fit_percent for after in ends]))
        remaining = max(0.0, min(least, halves.beyond(ends[k])))
        explained = (least - remaining) / misfit if misfit > 0.0 else left[k].explained
        ordered.append(replace(left.pop(k), gain=ends[k].fit_percent - at.fit_percent, explained=explained))
        at, least = ends[k], remaining
    for k, one in enumerate(ordered[:-1]):
        without = with_these([*ordered[:k], *ordered[k + 1 :]]) if one.gain <= 0.0 else None
        if without is not None:
            ordered[k] = replace(one, gain=at.fit_percent - without.fit_percent)
    return tuple(ordered)


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """A parameter, by name, as a whole record asks for it: its difference, and the energy that is left with it."""

    parameter: str
    value: float
    energy: float


def changes_of(model: RefittedModel, segments: Sequence[Segment]) -> tuple[float, tuple[ParameterChange, ...]]:
    """The energy that a model leaves of a record, and the change of each of its parameters by itself, those with which
    it diverges left out. Infinite energy where the model itself diverges."""
    before = simulated(model, segments)
    found = []
    for candidate in record_changes(model.joint, model.columns, [segments[0].record.name]):
        end = run(model, segments, (candidate,))
        if end is not None:
            after = record_fit(model, segments, end)
            found.append(ParameterChange(model.joint.names[candidate.column], float(end.unknowns[0]), after.energy))
    return np.inf if before is None else before.energy, tuple(found)
