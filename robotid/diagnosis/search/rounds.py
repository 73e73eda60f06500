"""Rounds of a search beside one noise: score, refit the best few, keep what carries over, repeat; and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_fit import FittedCurve
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.search.acceptance import (
    Steps,
    accept_apart,
    accept_asked_for,
    accept_best,
    accept_from_the_start,
    accept_pair,
    drop_worthless,
)
from robotid.diagnosis.search.agreement import agreement
from robotid.diagnosis.search.coloured import Left, explains_more, in_colour, judged_along_the_motion, left_by
from robotid.diagnosis.search.data import renew_noise
from robotid.diagnosis.search.mere_changes import without_mere_changes
from robotid.diagnosis.search.record_changes import find_record_changes
from robotid.diagnosis.search.refits import refit_hopeful
from robotid.diagnosis.search.settings import ACCEPTANCE, CHOICE
from robotid.diagnosis.search.state import (
    AcceptedCause,
    Log,
    SearchResult,
    SearchState,
    is_covered,
    is_plain,
    misfit_energy,
    share_of_removed,
    share_removed,
)
from robotid.diagnosis.search.unexplained import better_curve, with_unexplained, without_imitations, without_parts
from robotid.interrupt import OutOfTime, check
from robotid.model.structure import RECORD_CHANGE

FURTHER = "further causes"
UNEXPLAINED = "what no effect explains"
NOTHING = "explains nothing by the noise that it leaves: without it, errors of the torque are no larger"
CHANGES = "what differs on the records held out"


def find_causes(start: SearchState, criteria: Criteria, log: Log) -> SearchResult:
    """Extend a model cause by cause until nothing passes, and examine what is left. Where time runs out, what was found
    by then."""
    state, imitated, late = start, None, False
    try:
        while len(state.causes) < criteria.max_causes and len(state.rounds) < 2 * criteria.max_causes:
            if state is not start or not state.rounds:
                state = scored(state, criteria, log)
            before, state = state, add_cause(state, criteria, log)
            if len(state.causes) == len(before.causes) or state.unexamined:
                break
            state = drop_worthless(state, criteria, log)
            state = renew_noise(state.with_model(state.model, criteria))
            if len(state.causes) == ACCEPTANCE.trusted_causes:
                imitated = better_curve(state, criteria)
                if imitated is not None:
                    break
        log("looking for what no effect explains")
        if state.causes and len(state.causes) != ACCEPTANCE.trusted_causes:
            imitated = better_curve(state, criteria)
    except OutOfTime:
        late = True
    result = as_result(state)
    return out_of_time(result) if late or state.unexamined else _completed(result, start, imitated, criteria, log)


def scored(state: SearchState, criteria: Criteria, log: Log) -> SearchState:
    """The state with one round of the score more."""
    log(f"scoring the catalogue for cause {len(state.causes) + 1}")
    if state.rounds:  # the first round is part of every answer
        check()
    return state.scored(criteria)


def out_of_time(result: SearchResult) -> SearchResult:
    """The result of a search that ran out of time among the causes."""
    return replace(result, late=True, unexamined=(*result.unexamined, FURTHER, UNEXPLAINED, CHANGES))


def _completed(
    result: SearchResult, start: SearchState, imitated: FittedCurve | None, criteria: Criteria, log: Log
) -> SearchResult:
    """The result with what its causes leave, and with what differs on validation records; late where time runs out."""
    try:
        if imitated is not None:
            result = without_imitations(result, imitated, start.data)
        result = without_parts(result)
        left, coloured = _noise_left(result)
        if result.causes and coloured.noise_reached and not explains_more(result.first, result.last, left, coloured):
            result = replace(result.without_causes([NOTHING] * len(result.causes)), data=start.data)
            left, coloured = _noise_left(result)
        if imitated is None:
            standing = without_mere_changes(result, coloured)
            if standing is not result:
                left, coloured = _noise_left(standing)
            result = with_unexplained(standing, criteria)
        result = replace(result, noise=left.noise, coloured=coloured)
        if coloured.noise_reached:
            # noise that only simulations explain has another energy than the linear one by which it is weighed
            of_removed = is_covered(result.first, coloured) or not left.noise.linearly_explained
            causes = _by_one_noise(result.causes, result.first, result.last, coloured, of_removed=of_removed)
            result = replace(result, causes=causes, shares_of_removed=of_removed)
    except OutOfTime:
        return replace(result, late=True, unexamined=(UNEXPLAINED, CHANGES))
    if RECORD_CHANGE in criteria.skip:
        return result
    try:
        log("comparing the records held out")
        sought, any_colour = (result.data, max(1.0, _usual_energy(result))), (coloured, max(1.0, left.energy))
        # noise that only simulations explain is so blunt that no change would be seen beside it
        by = any_colour if left.noise.linearly_explained else sought
        changes = find_record_changes(result.last, *by, criteria.significance)
        result = replace(result, changes=changes)
        if changes or result.causes or result.curve is not None:
            return result
        return replace(result, agreement=agreement(result.last, *(any_colour if coloured.noise_reached else sought)))
    except OutOfTime:
        return replace(result, late=True, unexamined=(CHANGES,))


def _noise_left(result: SearchResult) -> tuple[Left, EvaluationData]:
    """The noise of any colour that the last model leaves, and the data by it."""
    left = judged_along_the_motion(left_by(result.last))
    return left, in_colour(result.last, result.data, left.noise)


def _usual_energy(result: SearchResult) -> float:
    """Energy a sample that the last model leaves on the fitted segments, in variances of the sensors' noise."""
    return result.last.energy / result.data.samples


def add_cause(state: SearchState, criteria: Criteria, log: Log) -> SearchState:
    """The state with the best cause of the last round, from where the model is or from where its fit started, or with
    two that carry over only beside each other; where it explains little of a large misfit, with what the torque asks
    for along the measured motion, or with what one record has another than a model of the others has; where none stands
    its tests, with those that were rejected."""
    found = refit_hopeful(state, criteria, log)
    steps = Steps(state, len(found.refits))
    extended = replace(accept_best(state, found.refits, steps, criteria), unexamined=found.unexamined)
    accepted = len(extended.causes) > len(state.causes)
    if found.unexamined or (accepted and extended.causes[-1].explained > CHOICE.doubtful_share * _left_share(state)):
        return extended
    if state.misfit > state.data.samples:  # what scores along another motion than the measured one may be anything
        rejected = state if accepted else extended
        other = accept_asked_for(rejected, found.refits, criteria, log)
        if len(other.causes) > len(state.causes) and not (
            accepted and other.causes[-1].explained < extended.causes[-1].explained
        ):
            return other
    if accepted:
        return extended
    apart = accept_apart(extended, found.refits, criteria, log)
    if len(apart.causes) > len(state.causes):
        return apart
    again = accept_from_the_start(extended, found.refits, steps, criteria, log)
    if len(again.causes) > len(state.causes):
        return again
    return accept_pair(extended, found.refits, steps, criteria, log)


def _left_share(state: SearchState) -> float:
    """Share of the first model's misfit that the causes so far leave."""
    return max(0.0, state.misfit) / max(misfit_energy(state.first, state.data), 1e-9)


def as_result(state: SearchState) -> SearchResult:
    """The result of a search that ends in a state."""
    causes = _by_one_noise(state.causes, state.first, state.model, state.data)
    return SearchResult(
        state.data, state.first, state.model, causes, state.rejected, state.rounds, unexamined=state.unexamined
    )


def _by_one_noise(
    causes: Sequence[AcceptedCause],
    first: RefittedModel,
    last: RefittedModel,
    data: EvaluationData,
    *,
    of_removed: bool = False,
) -> tuple[AcceptedCause, ...]:
    """The causes with what each explains beside those before it by the noise as it shows at last; when they were found
    it was taken for larger, and shares by different noises do not add up. The last one is measured by the model at the
    end, so that all shares and what remains make one. of_removed : `shares_of_removed` of `SearchResult`."""
    models = [*(cause.after for cause in causes[:-1]), last]
    left, plain = [1.0], is_plain(first, data)
    for model in models[: len(causes)]:
        share = (
            share_of_removed(first, model, last, data)
            if of_removed
            else share_removed(first, first, model, data, plain=plain)
        )
        left.append(min(left[-1], 1.0 - share))
    shares = [before - after for before, after in pairwise(left)]
    return tuple(replace(cause, explained=share) for cause, share in zip(causes, shares, strict=True))
