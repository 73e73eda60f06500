"""The search for what a model lacks: by each noise, beside what happened once, and beside what no effect explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.noise.noise_estimate import TorqueErrors
from robotid.diagnosis.results import Event
from robotid.diagnosis.search.acceptance import accept_asked_for
from robotid.diagnosis.search.beside_curve import explain_most, with_causes, with_curve, without_readers
from robotid.diagnosis.search.data import Evidence, first_state, renew_noise, settled_state
from robotid.diagnosis.search.events import (
    ModelInPieces,
    SeenEvent,
    is_fitted,
    largest_event,
    placed_again,
    resized,
    sized_beside,
    stands_out,
    with_deviation,
    without_event,
)
from robotid.diagnosis.search.rounds import as_result, find_causes, out_of_time, scored
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import Log, SearchResult, SearchState, is_plain, misfit_energy, share_removed
from robotid.diagnosis.search.torque_errors import lead_astray, leaves_only_noise, prevail
from robotid.diagnosis.search.unexplained import is_complete, is_imitated, stands
from robotid.errors import NumericsError
from robotid.interrupt import OutOfTime, check, deadline
from robotid.numerals import plain as plain_number

EVENT = "what happened once in {} at {} s"
ONCE = "what happened once beside causes"
BESIDE_CURVE = "causes beside what no effect explains"


def search(evidence: Evidence, criteria: Criteria, log: Log, begun: SearchState | None = None) -> SearchResult:
    """What a model lacks, by the noise of the sensors; and where that is out of reach, as it is on most machines, by
    that of torque errors besides, and by the sensors' only if that names nothing.

    What happened once is set aside first; and where it shows only beside the causes, these are sought again without it.
    An event beside causes must be needed: where these explain as much with it in the records, it is one of their
    moments. A deadline that passes where nothing that was found can be kept leaves what was known at first. begun : the
    first state of this evidence, where it is known. Raises NumericsError where the model cannot be simulated.
    """
    with deadline(None):  # without the noise and a round of the score there is no answer at all
        if begun is None:
            log("measuring the noise")
        begun = begun or first_state(evidence, criteria)
        begun = begun if begun.rounds else scored(begun, criteria, log)
    try:
        result = _searched(evidence, criteria, log, begun)
    except OutOfTime:
        result = out_of_time(as_result(begun))
    if not result.events:
        return result
    return replace(result, events=tuple(with_deviation(event, result.last) for event in result.events))


def _searched(evidence: Evidence, criteria: Criteria, log: Log, begun: SearchState) -> SearchResult:
    """What is missing, events by the noise of the sensors. begun : the first state of the evidence, scored."""
    whole = Aside.of(evidence, begun)
    result, plain = _beside_events(whole, criteria, log)
    if not (result.events or result.late or (leaves_only_noise(result) and (result.causes or not prevail(result)))):
        in_short_pieces = evidence.horizon is None and lead_astray(result) and not leaves_only_noise(result)
        if not in_short_pieces:  # where both are sought once more
            result = _beside_lesser_events(result, whole, criteria, log)
        return _beside_curve(evidence, result, criteria, log) if not result.events else result
    if not (result.events and result.causes) or result.late:
        return result
    if plain is None:
        with deadline(None):
            log("searching with the events in the records")
        plain = _by_each_noise(evidence, begun, criteria, log)
    return result if plain.late or _needs_events(result, plain) else plain


def _needs_events(result: SearchResult, plain: SearchResult) -> bool:
    """Whether events explain what the causes of a search that leaves them in the records do not. By the noise that is
    left without them."""
    data, misfit = result.data, misfit_energy(result.first, result.data)
    left, plainly = (data.energy(one.last.fitted, one.last.validation) for one in (result, plain))
    return not plain.causes or plainly - left >= ACCEPTANCE.unknown_share * max(misfit, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Aside:
    """The evidence with what happened once set aside. evidence : without the events; start : its first state; records :
    in pieces, by the model of that state."""

    evidence: Evidence
    start: SearchState
    records: ModelInPieces
    events: tuple[Event, ...] = ()

    @classmethod
    def of(cls, evidence: Evidence, start: SearchState, events: Sequence[Event] = ()) -> Aside:
        """Evidence that is without these events already."""
        return cls(evidence, start, ModelInPieces(evidence, start.first, start.data), tuple(events))

    def scored(self, criteria: Criteria, log: Log) -> Aside:
        """The same with a round of the score at least."""
        return self if self.start.rounds else replace(self, start=scored(self.start, criteria, log))


def _beside_events(whole: Aside, criteria: Criteria, log: Log) -> tuple[SearchResult, SearchResult | None]:
    """What is found once the events are set aside, with these; and what was found with all of them in the records,
    where that was searched before an event showed. whole : without any, its first state scored."""
    aside, settled, plain = whole, False, None
    while True:
        more = not settled and len(aside.events) < EVENTS.max_events
        if more:
            with deadline(None):
                aside = aside.scored(criteria, log)
                log("looking for events")
        seen, white = _leading_event(aside, criteria, log) if more else (None, None)
        result = None
        if seen is None or not seen.leading:
            known = None if aside.events else plain
            result = known or _by_each_noise(aside.evidence, aside.start, criteria, log, white)
            plain = plain if aside.events else result
            result, aside = _sized_beside_causes(result, aside, criteria, log)
            late, data = more and bool(result.causes) and not result.late, aside.start.data
            least = ACCEPTANCE.unknown_share * misfit_energy(result.first, data) if late else 0.0
            scores = result.rounds[-1].scores if late else ()
            # By the noise of the sensors: as an error of the torque an event would be part of the noise.
            beside = ModelInPieces(aside.evidence, result.last, data)
            seen = largest_event(beside, criteria, scores, least) if late else None
            if seen is None or not seen.leading or seen.energy < least:
                return (replace(result, events=aside.events) if aside.events else result), plain
        try:
            further = _set_aside(aside, seen.event, criteria)
            settled, aside = further is None, further or aside
        except NumericsError:  # records without it cannot be simulated: they keep it
            settled = True
        except OutOfTime:
            found = out_of_time(as_result(aside.start)) if result is None else replace(result, late=True)
            unexamined = (EVENT.format(seen.event.record, plain_number(seen.event.start)), *found.unexamined)
            return replace(found, unexamined=unexamined, events=aside.events), plain


def _sized_beside_causes(found: SearchResult, aside: Aside, criteria: Criteria, log: Log) -> tuple[SearchResult, Aside]:
    """What is found with events of the size that they have beside the causes, and these aside; both as they were where
    no cause had led them astray. What an event was sized too small by beside parameters that make up for a cause would
    be named as what differs on its record."""
    if not found.causes or found.late:
        return found, aside
    try:
        sized = sized_beside(aside.events, found.last, found.data)
        changes = [after.torque - event.torque for event, after in zip(aside.events, sized, strict=True)]
        known = zip(changes, aside.events, strict=True)
        if all(abs(by) <= ACCEPTANCE.amplitude_sigma * one.std for by, one in known):
            return found, aside
        log("searching with events as large as they are beside causes")
        evidence = aside.evidence
        for event, by in zip(aside.events, changes, strict=True):
            evidence = without_event(evidence, replace(event, torque=by))
        again = Aside.of(evidence, scored(first_state(evidence, criteria), criteria, log), sized)
        return _by_each_noise(evidence, again.start, criteria, log), again
    except NumericsError:
        return found, aside
    except OutOfTime:
        return replace(found, late=True, unexamined=(ONCE, *found.unexamined)), aside


def _leading_event(aside: Aside, criteria: Criteria, log: Log) -> tuple[SeenEvent | None, SearchState | None]:
    """The largest event, by the noise of the sensors; where that is out of reach and shows none that leads, beside
    white errors of the torque, for what these move along may hide it. With the first state beside these, scored, where
    it was asked for. aside : its first state scored."""
    seen = largest_event(aside.records, criteria, aside.start.round.scores)
    if (seen is not None and seen.leading) or aside.start.data.noise_reached:
        return seen, None
    try:
        white = scored(_beside_torque_errors("white", aside.evidence, criteria, log), criteria, log)
    except (NumericsError, OutOfTime):
        return seen, None
    found = largest_event(ModelInPieces(aside.evidence, white.first, white.data), criteria, white.round.scores)
    return (found if found is not None and found.leading else seen), white


def _beside_lesser_events(found: SearchResult, whole: Aside, criteria: Criteria, log: Log) -> SearchResult:
    """What is found once events are set aside that are but a part of what is missing or that effects together might
    pass for, where they and causes leave no more than noise, or they alone next to nothing, and each stands out of what
    is left; else what was found without. Where that passes for errors of the torque, an event that does not lead must
    have hidden a cause. whole : without any event set aside, by the model before the causes."""
    log("looking for events beside causes")
    aside, leading = whole, True
    try:
        while len(aside.events) < EVENTS.max_events:
            seen = _lesser_event(aside.records, found, criteria)
            leading = leading and (seen is None or seen.leading)
            further = None if seen is None else _set_aside(aside, seen.event, criteria)
            if further is None:
                break
            aside = further
        if aside is whole:
            return found
        aside = aside.scored(criteria, log)
        again = _by_each_noise(aside.evidence, aside.start, criteria, log)
        again, aside = _sized_beside_causes(again, aside, criteria, log)
        first, plain = found.first, is_plain(found.first, found.data)
        explained = share_removed(first, first, again.first, found.data, plain=plain)
        needed = leaves_only_noise(again) or explained > 1.0 - ACCEPTANCE.unknown_share
        needed = needed and (leading or bool(again.causes) or not leaves_only_noise(found))
        needed = needed and replaces_the_curve(again, found)
        stand = needed and all(stands_out(event, again.last, criteria) for event in aside.events)
        return replace(again, events=aside.events) if stand else found
    except NumericsError:
        return found
    except OutOfTime:
        return replace(found, late=True, unexamined=(ONCE, *found.unexamined))


def replaces_the_curve(again: SearchResult, found: SearchResult) -> bool:
    """Whether what is found with events out of the records explains as much as the curve of a search that left them
    there: what recurs at a speed or a place may look like something that began once. A curve along time is no rival of
    events, but another view of them."""
    if found.curve is None or found.curve.variable.along == "t":
        return True
    first, data = found.first, found.data
    explained = share_removed(first, first, again.last, data, plain=is_plain(first, data))
    return stands(explained, found.curve_share, data, alone=True)


def _lesser_event(records: ModelInPieces, found: SearchResult, criteria: Criteria) -> SeenEvent | None:
    """The next event that may be but a part of what is missing. Beside causes it leads; and where all that was found to
    be left passes for errors of the torque, it leads or is certain, and is on a record of the fit."""
    passes = leaves_only_noise(found)
    share = ACCEPTANCE.unknown_share if passes else None
    seen = largest_event(records, criteria, least_share=share, doubtful=not passes)
    if seen is None or (passes and not is_fitted(seen.event, records.model)):
        return None
    return seen if seen.leading or not found.causes else None


def _beside_curve(evidence: Evidence, found: SearchResult, criteria: Criteria, log: Log) -> SearchResult:
    """What was found, with the causes beside its curve where nothing else was named, and these explain most of what the
    curve leaves."""
    if found.curve is None or found.causes or found.late:
        return found
    log("searching beside what no effect explains")
    try:
        check()
        beside, without = with_curve(evidence, found), without_readers(criteria)
        if beside is None:
            return found
        again = _by_each_noise(beside, scored(first_state(beside, without), without, log), without, log)
        return with_causes(found, again) if explain_most(again) else found
    except NumericsError:
        return found
    except OutOfTime:
        return replace(found, late=True, unexamined=(BESIDE_CURVE, *found.unexamined))


def _set_aside(aside: Aside, event: Event, criteria: Criteria) -> Aside | None:
    """The evidence without one event more, as it is without what it led astray; None where its size may be none, or its
    record is simulated no better without it. Raises NumericsError where records without it cannot be simulated."""
    event = _settled(aside.evidence, event, criteria)
    if abs(event.torque) < ACCEPTANCE.amplitude_sigma * event.std:
        return None
    without = without_event(aside.evidence, event)
    state = first_state(without, criteria)
    better = aside.records.is_better_without(event, state.first)
    return Aside.of(without, state, (*aside.events, event)) if better else None


def _settled(evidence: Evidence, event: Event, criteria: Criteria) -> Event:
    """An event placed and sized beside parameters that it no longer leads astray."""
    placings = 1 if event.p_value < criteria.significance else EVENTS.max_resizings
    for _ in range(placings):
        first = first_state(without_event(evidence, event), criteria)
        before, event = event, placed_again(evidence, event, first.first, first.data, criteria)
        if event is before:
            break
    for _ in range(EVENTS.max_resizings):
        before, first = event, first_state(without_event(evidence, event), criteria)
        event = resized(event, first.first)
        if abs(event.torque - before.torque) < event.std:
            break
    return event


def _by_each_noise(
    evidence: Evidence, start: SearchState, criteria: Criteria, log: Log, white: SearchState | None = None
) -> SearchResult:
    """By the noise of the sensors where all that is known leaves no more than that, else by that of torque errors,
    which are white at first: red ones as large as a misfit leave little of it to be seen. By another noise where one
    names nothing, and leaves more than noise of any colour, or mostly errors of the torque, beside which slow ones have
    been given too much weight; unless a free curve explains all of it. What a later search names stands only where it
    does not imitate a curve that an earlier one has found. Where none names anything, what rings by itself says more
    than a curve that explains less; and where a record that was held out is simulated far worse than those of the fit,
    one that tells what differs there says more than one that does not.

    white : the first state beside white errors, scored, where it is known.
    """
    found: list[SearchResult] = []
    reached: tuple[TorqueErrors, ...] = (None, "coloured")  # no white error shows beside the sensors' noise there
    beyond: tuple[TorqueErrors, ...] = ("white", "coloured", None)
    for errors in reached if start.data.noise_reached else beyond:
        try:
            known = {None: start, "white": white}.get(errors)
            begun = known or _beside_torque_errors(errors, evidence, criteria, log)
            if errors == "white":
                white = begun = begun if begun.rounds else scored(begun, criteria, log)
            found.append(find_causes(begun, criteria, log))
        except OutOfTime:
            return out_of_time(found[-1] if found else as_result(start))
        last = found[-1]
        if last.causes:
            return next((one for one in found[:-1] if is_imitated(one, last)), last)
        if last.late or is_complete(last) or (leaves_only_noise(last) and not prevail(last)):
            return last
        noise = [one for one in found if leaves_only_noise(one)]
        if noise and errors == "coloured":
            changed = [one for one in noise if one.changes] if noise[0].agreement.apart else []
            try:
                return _asked_for_by_the_motion(evidence, criteria, log, white) or (changed or noise)[0]
            except OutOfTime:
                return out_of_time((changed or noise)[0])
    curve = next((one for one in found if one.curve is not None), found[0])
    shaken = next((one for one in found if one.shaken_share), curve)
    return shaken if shaken.shaken_share > curve.curve_share else curve


def _asked_for_by_the_motion(
    evidence: Evidence, criteria: Criteria, log: Log, white: SearchState | None = None
) -> SearchResult | None:
    """What a search finds that begins with what the torque asks for along the measured motion, None where that is
    nothing. What rests in a simulation where the motor moves shows nothing, and all that it leaves passes for errors of
    the torque. white : as of `_by_each_noise`."""
    try:
        white = white or scored(_beside_torque_errors("white", evidence, criteria, log), criteria, log)
        extended = accept_asked_for(white, (), criteria, log)
        if not extended.causes:
            return None
        beyond = renew_noise(extended.with_model(extended.model, criteria))
        return find_causes(scored(beyond, criteria, log), criteria, log)
    except NumericsError:
        return None


def _beside_torque_errors(errors: TorqueErrors, evidence: Evidence, criteria: Criteria, log: Log) -> SearchState:
    """The state in which a search beside such errors of the torque begins."""
    if errors == "white":
        log("allowing for errors of the torque")
        return first_state(evidence, criteria, torque_errors=errors)
    log("allowing for slow errors of the torque")
    return settled_state(evidence, criteria)
