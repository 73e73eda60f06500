"""Events set aside: what happened once is taken out of the records before causes are sought, or sought again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.applied import event_torque, without_events
from robotid.diagnosis.events.detection import (
    FoundEvent,
    PlacedEvents,
    energy_of,
    find_event,
    placed_events,
    tries_among,
)
from robotid.diagnosis.events.pieces import scan_pieces, simulated_pieces
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit
from robotid.diagnosis.results import Event, EventKind
from robotid.diagnosis.scoring.candidate import Candidate, EffectCandidate
from robotid.diagnosis.scoring.projection import Projected, beyond, project
from robotid.diagnosis.scoring.ranking import missing_effects
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.scoring.score_test import Score, score
from robotid.diagnosis.search.coloured import blocks_with, by_noise, judged_along_the_motion, left_beside, left_by
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.errors import NumericsError
from robotid.interrupt import OutOfTime
from robotid.model.array import Array

CERTAINLY = 2.0  # times the energy of whole records: no event explains more of their pieces
RIVALS = 2  # effects, with which an event is compared before it is with the whole catalogue


@dataclass(frozen=True, slots=True)
class SeenEvent:
    """An event; leading : it explains so much beside the best effect of the catalogue that no cause can be sought
    before it is out of the way. energy : that it explains, in variances of the noise."""

    event: Event
    leading: bool
    energy: float = np.inf


class ModelInPieces:
    """What a model leaves on all records cut into pieces, those that validate among them: an event there would be
    counted against every cause. Each simulation and search is made when it is first asked for, and kept.

    diagnosed : the model of the evidence; model : with its parameters as they are; data : of whose noise. What is asked
    for raises NumericsError where a piece cannot be simulated, and OutOfTime.
    """

    def __init__(self, evidence: Evidence, model: RefittedModel, data: EvaluationData) -> None:
        self.diagnosed, self.model, self.data = evidence.model, model, data

    @cached_property
    def pieces(self) -> list[SegmentFit]:
        """All pieces, each from the first states that suit it best."""
        return self.cut()

    @cached_property
    def placed(self) -> PlacedEvents:
        """The largest events beside the fitted parameters."""
        return placed_events(self.scans())

    def scans(self, candidates: Sequence[EffectCandidate] = ()) -> tuple[Scan, ...]:
        """The columns of all pieces."""
        return scans(self.pieces, self.model.unknowns, candidates)

    def is_better_without(self, event: Event, model: RefittedModel) -> bool:
        """Whether a model that was refitted without an event leaves less of its record, in pieces. Where dry friction
        hardly holds a motor, or hardly lets it go, a torque as large as columns ask for may do anything.
        """
        own = (one for one in (*self.data.fitted, *self.data.validation) if one.record.name == event.record)
        segments = [replace(one, record=without_events(one.record, [event])) for one in own]
        after = simulated_pieces(self.diagnosed, model, segments)
        before = (one for one in self.pieces if one.record.name == event.record)
        return sum(one.energy for one in after) < sum(one.energy for one in before)

    def cut(self, further: int = 0) -> list[SegmentFit]:
        """The records in pieces, each segment in so many further ones: as of `simulated_pieces`."""
        return simulated_pieces(self.diagnosed, self.model, (*self.data.fitted, *self.data.validation), further)


def largest_event(
    records: ModelInPieces,
    criteria: Criteria,
    scores: Sequence[Score] = (),
    least: float = 0.0,
    *,
    least_share: float | None = None,
    doubtful: bool = False,
) -> SeenEvent | None:
    """The largest event that a model leaves, None where there is none, nothing to explain, or no time for it; and where
    it is known from less work that it would explain less than `least`, or that it would not lead. least_share : of the
    misfit that one explains which leads; doubtful : one that explains no more than a share of it that is worth a word
    will do, and one that leads, where none is certain.

    scores : of candidates on whole records, best first, which tell what the event is to be compared with.
    """
    model, data = records.model, records.data
    if not leaves_something(model, data) or CERTAINLY * data.energy(model.fitted, model.validation) < least:
        return None
    missing = missing_effects(model, criteria.skip)
    try:
        placed, share = records.placed, ACCEPTANCE.unknown_share if doubtful else 0.0
        if (
            placed.energy < least
            or placed.share < share
            or not (doubtful or _may_lead(records, _best(scores, missing), least_share))
        ):
            return None
        seen = records.scans(missing)
        found = find_event(seen, criteria.significance, placed, doubtful=doubtful)
    except (NumericsError, OutOfTime):
        return None
    if found is None:
        return None
    rival = max((one.energy for one in score(project(seen), missing)), default=0.0)
    leading = leads(found.energy, rival, found.share, least_share)
    certain = found.event.p_value < criteria.significance
    if not ((leading or certain) and _is_of_no_cut(found, records)):
        return None
    return SeenEvent(found.event, leading, found.energy)


def _is_of_no_cut(found: FoundEvent, records: ModelInPieces) -> bool:
    """Whether an event shows where the records are cut elsewhere, too. A piece that begins as a motor comes to rest or
    sets off has a first state that no linear model tells, and leaves a burst there."""
    try:
        again = energy_of(found.event, scans(records.cut(further=1), records.model.unknowns, ()))
    except (NumericsError, OutOfTime):
        return False
    return shows_again(again, found.energy)


def shows_again(again: float, energy: float) -> bool:
    """Whether an event explains enough of pieces that are cut elsewhere of what it explains of the first ones."""
    return again > EVENTS.cut_share * energy


def _best(scores: Sequence[Score], missing: Sequence[EffectCandidate]) -> list[EffectCandidate]:
    """The best points of the best effects by these scores, as far as they are among the missing ones."""
    found, known = dict[str, EffectCandidate](), dict[Candidate, EffectCandidate](zip(missing, missing, strict=True))
    for one in scores:
        if one.candidate in known:
            found.setdefault(one.candidate.name, known[one.candidate])
    return list(found.values())[:RIVALS]


def _may_lead(records: ModelInPieces, some: Sequence[EffectCandidate], least_share: float | None) -> bool:
    """Whether the largest event may lead, as far as some candidates show."""
    placed = records.placed
    if not leads(placed.energy, 0.0, placed.share, least_share):  # without any work
        return False
    return leads(placed.energy, _rival_among(records, some), placed.share, least_share)


def _rival_among(records: ModelInPieces, some: Sequence[EffectCandidate]) -> float:
    """The most energy that one of some candidates explains on these pieces."""
    if not some:
        return 0.0
    return max(one.energy for one in score(project(records.scans(some)), some))


def placed_again(
    evidence: Evidence, event: Event, model: RefittedModel, data: EvaluationData, criteria: Criteria
) -> Event:
    """An event as it shows beside a model that was refitted without it, in records that have it still: parameters that
    it has led astray hide when it began. One that was doubtful may be so again. data : of the records without it."""
    back = replace(event, torque=-event.torque)
    segments = [replace(one, record=without_events(one.record, [back])) for one in (*data.fitted, *data.validation)]
    missing = missing_effects(model, criteria.skip)
    try:
        seen = scan_pieces(evidence.model, model, segments, missing)
        found = find_event(seen, criteria.significance, doubtful=event.p_value >= criteria.significance)
    except (NumericsError, OutOfTime):
        return event
    same = found is not None and _what(found.event) == _what(event)
    return found.event if found is not None and same else event


def _what(event: Event) -> tuple[str, str, bool]:
    return event.record, event.kind, event.friction


def resized(event: Event, model: RefittedModel) -> Event:
    """An event with the size that whole records ask for, beside a model that was refitted without it as it was. One on
    a validation record stays as it is."""
    if not is_fitted(event, model):
        return event
    projected = project(scans(model.fitted, model.unknowns, (), _unit_forces(event, model)))
    change, energy = _size(projected)
    if energy <= EVENTS.least_left * float(projected.length[0]) ** 2:
        return event
    return replace(event, torque=event.torque + change, std=_deviation(energy, model))


def sized_beside(events: Sequence[Event], model: RefittedModel, data: EvaluationData) -> list[Event]:
    """Events with the sizes that whole records ask for beside a model that was refitted without them, and may change
    with these. data : of the records without them. Raises NumericsError where these cannot be simulated."""
    sized = [resized(event, model) for event in events]
    for _ in range(EVENTS.max_resizings):
        changes = [replace(one, torque=one.torque - by.torque) for one, by in zip(sized, events, strict=True)]
        if all(abs(change.torque) <= one.std for change, one in zip(changes, sized, strict=True)):
            break
        fitted = (replace(one, record=without_events(one.record, changes)) for one in data.fitted)
        data, events = replace(data, fitted=tuple(fitted)), sized
        model = refit(model.joint, [model.parameters], data, model.trajectories, CAREFUL)
        sized = [resized(event, model) for event in events]
    return sized


def with_deviation(event: Event, model: RefittedModel) -> Event:
    """An event that was taken out of the records of a model, with the deviation that its size has where its times are
    known from the records only, by the noise of any colour which the model leaves, where that is larger than by the
    sensors' noise. Beside a torque that errs slowly, reversals make of the errors what they make of the event, which
    only simulations know: the size is found in drawn noise, too. One on a validation record stays as it is, and one for
    which there is no time."""
    if not is_fitted(event, model):
        return event
    try:
        seen = scans(model.fitted, model.unknowns, (), _unit_forces(event, model, free_in_time=True))
        event = replace(event, std=max(event.std, _deviation(_size(project(seen))[1], model)))
        sizes = _sizes_in_noise(seen, model)
    except (NumericsError, OutOfTime):
        return event
    return replace(event, std=max(event.std, float(np.sqrt(np.mean(np.square(sizes)))))) if sizes else event


def _sizes_in_noise(seen: Sequence[Scan], model: RefittedModel) -> list[float]:
    """The sizes [Nm] that an event seems to have in drawn noise of any colour, where there is none.

    seen : the columns of the fitted segments, those of the event and of what its size is not to be taken for last.
    """
    noise = judged_along_the_motion(left_beside(model, seen)).noise
    return [
        _size(project([one.with_residual(residual) for one, residual in zip(seen, residuals, strict=True)]))[0]
        for residuals in noise.drawn()
    ]


def _deviation(energy: float, model: RefittedModel) -> float:
    """Standard deviation [Nm] by the noise of the sensors of a size whose column has this energy, zero where nothing of
    it is left."""
    inflation = max(1.0, model.energy / model.samples)
    return float(np.sqrt(inflation / energy)) if energy > 0.0 else 0.0


def _size(projected: Projected) -> tuple[float, float]:
    """The size that the first missing column asks for beside the others and all that a fit has shaped, and the energy
    of what is its own."""
    column, others = projected.missing[:, 0], projected.missing[:, 1:]
    column = beyond(column, others.T)
    energy = float(column @ column)
    return (float(column @ projected.residual) / energy if energy > 0.0 else 0.0), energy


def is_fitted(event: Event, model: RefittedModel) -> bool:
    """Whether an event is on a record of the fit."""
    return any(one.record.name == event.record for one in model.fitted)


def stands_out(event: Event, model: RefittedModel, criteria: Criteria) -> bool:
    """Whether an event that was taken out of the records of a model stands out of the noise of any colour that the
    model leaves, of so many events that it might have been, and has a size that drawn noise has not; one on a
    validation record does."""
    if not is_fitted(event, model):
        return True
    left = left_by(model, _unit_forces(event, model))
    at = len(model.unknowns.parameters)
    p = by_noise(blocks_with(left, {at: event.torque}), [at], left.energy, model.samples)
    if tries_among({one.record.name for one in model.fitted}) * p >= criteria.significance:
        return False
    found = with_deviation(event, model)
    return abs(found.torque) >= ACCEPTANCE.amplitude_sigma * found.std


def _unit_forces(event: Event, model: RefittedModel, *, free_in_time: bool = False) -> list[Array]:
    """Generalised forces (nv, m, n) of an event of 1 Nm on every fitted segment; free_in_time : followed by what it
    does when it begins, and when it ends, a little later."""
    found = []
    for one in model.fitted:
        unit, h = replace(event, torque=1.0), one.record.sampling_time
        courses = [event_torque(unit, one.record)]
        for end in _FREE_ENDS[event.kind] if free_in_time else ():
            at = getattr(event, end)
            later, earlier = (event_torque(replace(unit, **{end: at + way}), one.record) for way in (h, -h))
            courses.append((later - earlier) / 2.0)
        forces = np.zeros((model.joint.masses, len(courses), len(one.record)))
        if one.record.name == event.record:
            forces[0] = courses
        found.append(forces)
    return found


_FREE_ENDS: dict[EventKind, tuple[str, ...]] = {"bump": ("start", "end"), "step": ("start",), "drift": ()}
"""Of each kind, the ends that are no ends of its record."""


def leads(energy: float, rival: float, share: float, least_share: float | None = None) -> bool:
    """Whether an event that explains so much comes before the causes, where the best of them explains `rival`: one that
    is the lesser part of the misfit of all records may be a moment at which something else shows most.

    share : of that misfit; least_share : that will do, absent: half of it.
    """
    return energy > EVENTS.leading_share * rival and share > (
        EVENTS.least_share if least_share is None else least_share
    )


def leaves_something(model: RefittedModel, data: EvaluationData) -> bool:
    """Whether the residuals of a model have more energy than noise has by chance, on the fitted or on the validation
    segments. data : by whose noise."""
    pairs = (
        (data.fitted_energy(model.fitted), data.samples),
        (data.validation_energy(model.validation), data.validation_samples),
    )
    return any(energy > n + EVENTS.chance * np.sqrt(2.0 * n) for energy, n in pairs)


def without_event(evidence: Evidence, event: Event) -> Evidence:
    """The evidence as it would be without an event, the model fitted to the records without it."""
    return evidence.on(lambda record: without_events(record, [event]))
