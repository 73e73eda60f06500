"""Accepting a cause: the tests that a refitted candidate must stand, and the causes that lose their worth later."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, reduced
from robotid.diagnosis.scoring.confounding import confounded_with
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.carry_over import gain_by_blocks, proven
from robotid.diagnosis.search.coloured import Tried, are_too_few
from robotid.diagnosis.search.constancy import is_not_constant
from robotid.diagnosis.search.driven import starts_by_itself
from robotid.diagnosis.search.events import leaves_something
from robotid.diagnosis.search.physical_sense import is_not_physical, is_uncertain
from robotid.diagnosis.search.record_apart import changed_apart
from robotid.diagnosis.search.refits import (
    CandidateRefit,
    are_collinear,
    carries_over,
    from_the_start,
    indistinguishable_energy,
    refit_hopeful,
)
from robotid.diagnosis.search.regression import asked_for
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.smoothing import is_smoothing
from robotid.diagnosis.search.state import (
    AcceptedCause,
    Log,
    RejectedCause,
    SearchState,
    misfit_energy,
)
from robotid.diagnosis.search.step import Step
from robotid.errors import NumericsError
from robotid.model.structure import rests_on


def does_harm(step: Step, criteria: Criteria) -> str | None:
    """A cause must help on segments that it was not fitted to."""
    if not step.data.validation:
        return None
    if step.energy_a_sample <= 0:
        return "does not carry over: the held-out records are simulated worse with it"
    if step.gain <= 0.0:
        return "does not carry over: the fit of the held-out records falls with it"
    return None


def gains_by_chance(step: Step, criteria: Criteria) -> str | None:
    """What a cause gains where it was not fitted must be beyond its scatter; where only a moment or two of the segments
    show it, these must ask for it by themselves."""
    gain = step.held_out
    if gain is None:
        return None if step.left_out is None or proven(step.left_out) else LEFT_OUT.format(step.left_out.p_value)
    if proven(gain):
        return None
    momentary = gain.total > 0.0 and are_too_few(gain.telling_blocks, 1)
    return None if momentary and step.confirmation < criteria.significance else HELD_OUT.format(gain.p_value)


HELD_OUT = "does not carry over: its gain on the held-out records is within its scatter (p = {:.2g})"
LEFT_OUT = "does not carry over: on what is left out of its fit, its gain is within its scatter (p = {:.2g})"


def explains_too_little(step: Step, criteria: Criteria) -> str | None:
    """What explains less than the simulation's own errors is none of the machine's."""
    if step.share < ACCEPTANCE.least_share and step.share_of_motion < ACCEPTANCE.least_motion:
        return f"is not worth it: explains {100 * step.share:.2g} % of the misfit"
    return None


def improves_too_little(step: Step, criteria: Criteria) -> str | None:
    """A cause must remove as much as the criteria demand."""
    if step.energy_a_sample < criteria.min_improvement_sigma**2:
        removed = np.sqrt(max(0.0, step.energy_a_sample))
        return f"is not worth it: removes {removed:.2g} noise standard deviations"
    return None


def is_noise(step: Step, criteria: Criteria) -> str | None:
    """A cause must stand out of noise of any colour, also where that passes along a motion that rests and reverses."""
    try:
        found = step.p_value
        if found < criteria.significance:
            found = step.p_value_in_motion(criteria.significance)
    except NumericsError as error:
        return f"cannot be distinguished from noise: {error.what}"
    if found < criteria.significance:
        return None
    return f"may be noise: torque errors as slow as those left may pass for it (p = {found:.2g})"


Objection = Callable[[Step, Criteria], str | None]

OBJECTIONS: tuple[Objection, ...] = (
    does_harm,
    gains_by_chance,
    explains_too_little,
    improves_too_little,
    is_not_physical,
    is_uncertain,
    is_noise,
    is_not_constant,
    is_smoothing,
    starts_by_itself,
)
"""The tests of a cause, in the order in which they are asked. Each says in words why a cause is none, or None."""
SENSELESS: tuple[Objection, ...] = (is_not_physical, starts_by_itself)
"""Those that a cause fails which acts like what is missing, and is not it."""
BY_CHANCE: tuple[Objection, ...] = (gains_by_chance, is_noise)
"""Those that one of two causes that do much the same passes and the other does not."""


def objection(step: Step, criteria: Criteria) -> str | None:
    """Why a refitted cause is none, in words; None where it stands all tests."""
    return next((why for test in OBJECTIONS if (why := test(step, criteria)) is not None), None)


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """The steps from a state to refits of its last round, each made once: several ways of accepting a cause ask for the
    same tests, and these are slow. refits : how many there are."""

    state: SearchState
    refits: int = 1
    made: dict[CandidateRefit, Step] = field(default_factory=dict)

    def to(self, one: CandidateRefit) -> Step:
        """From the state's model to one that is refitted with a candidate."""
        if one not in self.made:
            state, seen = self.state, self.state.round
            tried = Tried.of(seen, max(1, self.refits))
            self.made[one] = Step(state.first, state.model, one.model, state.data, tried, one.confirmed)
        return self.made[one]


def accept_best(state: SearchState, refits: Sequence[CandidateRefit], steps: Steps, criteria: Criteria) -> SearchState:
    """The state with the best cause of a round that stands all tests, and with those before it rejected.

    One that is rejected only because it may be noise, or because its gain may be chance, is a twin of what explains no
    more and is accepted: by chance alone the one passes and the other does not. Where there is no cause yet, the first
    that only makes no sense, or that only rings by itself, imitates what is missing, if it explains clearly more than
    what is accepted. steps : from this state, or from one with the same model and round.
    """
    rejected = list[RejectedCause]()
    for k, one in enumerate(refits):
        step = steps.to(one)
        why = objection(step, criteria)
        if why is None:
            doubted = [before for before in refits[:k] if _is_doubted(steps.to(before), step, criteria)]
            standing = [one, *doubted, *refits[k + 1 :]]
            if not state.causes:
                rejected = _with_imitation(rejected, refits, steps, criteria, step.share / ACCEPTANCE.imitation_share)
            state = state.with_rejected(*rejected)
            named = _simplest_alike(state, standing, steps, criteria)
            others = [other for other in standing if other is not named]
            return state.with_cause(as_cause(state, [named, *others], steps.to(named), criteria))
        rejected.append(RejectedCause(one.effect, step.share, step.gain, why))
    return state.with_rejected(*(rejected if state.causes else _with_imitation(rejected, refits, steps, criteria)))


def _with_imitation(
    rejected: Sequence[RejectedCause],
    refits: Sequence[CandidateRefit],
    steps: Steps,
    criteria: Criteria,
    least: float = -np.inf,
) -> list[RejectedCause]:
    """The first refits of a round, rejected, the first that is only senseless as an imitation. least : share of the
    misfit that it explains more than."""
    found = list(rejected)
    for k, (one, why) in enumerate(zip(refits, rejected, strict=False)):  # those after the first that stands are none
        step = steps.to(one)
        if why.explained > least and _is_only_senseless(step, criteria):
            found[k] = replace(why, imitates=True, undriven=is_not_physical(step, criteria) is None)
            break
    return found


def _simplest_alike(
    state: SearchState, refits: Sequence[CandidateRefit], steps: Steps, criteria: Criteria
) -> CandidateRefit:
    """Of a cause, the first, and those of the others that these data cannot tell from it, the one with the fewest
    parameters that stands all tests and simulates the held-out records no worse: parameters that no record asks for
    tell nothing of a machine."""
    best, *others = refits
    if not state.data.validation:
        return best
    wanted = (one for one in others if _parameters(one) < _parameters(best))
    for one in sorted(wanted, key=_parameters):
        no_worse = one.model.validation_energy <= best.model.validation_energy
        alike = no_worse and _are_alike(best.model, one.model, state, criteria)
        if alike and objection(steps.to(one), criteria) is None:
            return one
    return best


def _parameters(one: CandidateRefit) -> int:
    return len(one.model.unknowns.parameters)


def _is_only_senseless(step: Step, criteria: Criteria) -> bool:
    """Whether all that speaks against a cause is that its parameters make no sense, or that it rings by itself. Where
    that is so, what it explains is no noise all the same."""
    senseless = any(test(step, criteria) is not None for test in SENSELESS)
    return senseless and _stands_all_but(SENSELESS, step, criteria)


def _stands_all_but(excused: Sequence[Objection], step: Step, criteria: Criteria) -> bool:
    """Whether a cause stands all tests but some, whatever these say; the slow one is asked last."""
    asked = sorted((test for test in OBJECTIONS if test not in excused), key=lambda test: test is is_noise)
    return all(test(step, criteria) is None for test in asked)


def _is_doubted(rejected: Step, accepted: Step, criteria: Criteria) -> bool:
    """Whether a cause is rejected by chance alone: it fails only the tests of its scatter, and that of its gain only
    where it simulates the held-out records no worse than one that is accepted."""
    if not _stands_all_but(BY_CHANCE, rejected, criteria):
        return False
    worse = rejected.after.validation_energy > accepted.after.validation_energy
    return not worse or gains_by_chance(rejected, criteria) is None


def is_news(state: SearchState, one: CandidateRefit, steps: Steps, criteria: Criteria) -> bool:
    """Whether a refit shows that something is missing, be it this or another cause: it explains a share of the misfit
    that no noise would."""
    return _removes_much(state, one) and is_noise(steps.to(one), criteria) is None


def _removes_much(state: SearchState, one: CandidateRefit) -> bool:
    """Whether a refit explains more of the misfit than what is no news."""
    return state.share_removed(state.model, one.model) >= ACCEPTANCE.unknown_share


def accept_from_the_start(
    state: SearchState, refits: Sequence[CandidateRefit], steps: Steps, criteria: Criteria, log: Log
) -> SearchState:
    """The state with the best cause of a round where it stands all tests once it is fitted from where the fit of the
    model itself started.

    A refit that lost its way leaves a misfit that any noise may be taken for: where the misfit is large, it is fitted
    once more whether or not it is news.
    """
    if not refits or not _removes_much(state, refits[0]):
        return state
    if state.misfit <= state.data.samples and is_noise(steps.to(refits[0]), criteria) is not None:
        return state
    log(f"refitting with {refits[0].effect} from the first start")
    found = from_the_start(refits[0], state)
    return state if found is None else _with_first_that_stands(state, [found], refits, criteria)


def _with_first_that_stands(
    state: SearchState,
    found: Sequence[CandidateRefit],
    others: Sequence[CandidateRefit],
    criteria: Criteria,
    *,
    scored: bool = True,
) -> SearchState:
    """The state with the first of several refits that stands all tests, where one does; those after it, and then the
    others of other effects, may be its twins. scored : they were found by the score."""
    steps, effects = Steps(state, len(found)), {one.effect for one in found}
    others = [one for one in others if one.effect not in effects]
    for k, one in enumerate(found):
        step = steps.to(one)
        if objection(step, criteria) is None:
            return state.with_cause(as_cause(state, [*found[k:], *others], step, criteria, scored=scored))
    return state


def accept_asked_for(state: SearchState, refits: Sequence[CandidateRefit], criteria: Criteria, log: Log) -> SearchState:
    """The state with the best effect that the torque asks for along the measured motion and that stands all tests."""
    log("regressing the torque along the measured motion")
    return _with_first_that_stands(state, asked_for(state, criteria), refits, criteria, scored=False)


def accept_apart(state: SearchState, refits: Sequence[CandidateRefit], criteria: Criteria, log: Log) -> SearchState:
    """The state with the best change of one record, as a model of the others finds it, that stands all tests; asked
    where the misfit is large."""
    if state.misfit <= state.data.samples:
        return state
    log("fitting all records but one")
    return _with_first_that_stands(state, changed_apart(state, criteria), refits, criteria, scored=False)


def accept_pair(
    state: SearchState, refits: Sequence[CandidateRefit], steps: Steps, criteria: Criteria, log: Log
) -> SearchState:
    """The state with two causes that carry over only beside each other: without the second, the fit turns the first
    into an imitation of it.

    The first is the best that leaves less on records that were held out, where one does: what harms there leads to
    nothing. Where nothing known reaches the noise, a first cause that makes no sense imitates something that is not
    known.
    """
    refits = sorted(refits, key=lambda one: not carries_over(state.model, one.model))
    if not refits or not is_news(state, refits[0], steps, criteria):
        return state
    step = steps.to(refits[0])
    if not (state.data.noise_reached or state.data.torque_errors) and is_not_physical(step, criteria) is not None:
        return state
    first = refits[0].effect
    log(f"looking for a second cause beside {first}")
    beside = state.with_model(step.after, criteria).scored(criteria)
    pairs = refit_hopeful(beside, criteria, log).refits
    further = Steps(beside, len(pairs))
    for k, one in enumerate(pairs):
        second = further.to(one)
        if objection(replace(second, before=state.model), criteria) is None:
            leading = replace(as_cause(state, refits, step, criteria), beside=one.effect)
            return state.with_cause(leading).with_cause(as_cause(beside, pairs[k:], second, criteria))
    return _by_itself(pairs[0], first, refits, state, criteria) if pairs else state


def _by_itself(
    one: CandidateRefit, first: str, refits: Sequence[CandidateRefit], state: SearchState, criteria: Criteria
) -> SearchState:
    """The state with the second of a pair alone, where it stands all tests without the first, which had scored better
    and led to it."""
    score = next((s for s in state.round.scores if s.candidate.name == one.effect), None)
    lean = None if score is None else _without(one.model, first, state.data)
    if score is None or lean is None:
        return state
    return _with_first_that_stands(state, [CandidateRefit(score, lean)], refits, criteria)


def as_cause(
    state: SearchState, refits: Sequence[CandidateRefit], step: Step, criteria: Criteria, *, scored: bool = True
) -> AcceptedCause:
    """The first of the refitted candidates, to which `step` leads, as a cause; its twins are those that these data
    cannot tell from it. scored : it was found by the score, which must be no chance either."""
    best, seen, gain = refits[0], state.round, step.held_out
    alike = [one for one in refits if _are_alike(best.model, one.model, state, criteria)]
    rivals = [one.model for one in alike if one.effect != best.effect]
    refitted = {one.effect for one in refits}
    twins = [one.effect for one in alike]
    twins += [name for name in collinear(best.score, seen) if name not in refitted]
    return AcceptedCause(
        effect=best.effect,
        explained=step.share,
        gain=step.gain,
        p_value=max(seen.p_value(best.score), step.p_value) if scored else step.p_value,
        twins=tuple(dict.fromkeys([best.effect, *twins])),
        before=state.model,
        after=best.model,
        rival=rivals[0] if rivals else None,
        confounded=confounded_with(best.score, seen.projected, seen.scores),
        unfollowed=best.unfollowed,
        gain_p_value=1.0 if gain is None else min(1.0, len(refits) * gain.p_value),
    )


def _are_alike(best: RefittedModel, other: RefittedModel, state: SearchState, criteria: Criteria) -> bool:
    """Whether the records do not distinguish another refit from the best: chance sets two as far apart, or, where the
    best leaves more than the noise by which chance is known, blocks of time do not decide between them, by their ranks
    and by their mean (Vuong 1989)."""
    explained, apart = state.model.energy - best.energy, other.energy - best.energy
    if apart <= indistinguishable_energy(explained, state.round.inflation):
        return True
    if apart > ACCEPTANCE.max_same_share * explained or not leaves_something(best, state.data):
        return False
    gain = gain_by_blocks(other.fitted, best.fitted)
    return max(gain.p_value, gain.by_its_mean) >= criteria.significance


def collinear(best: Score, seen: Round) -> list[str]:
    """Effects whose columns span what those of the best do."""
    return [one.candidate.name for one in seen.best_of_each if are_collinear(one, best)]


def drop_worthless(state: SearchState, criteria: Criteria, log: Log) -> SearchState:
    """The state without the earlier causes that the last has made worthless. One that gains only beside others has the
    gain that it has there."""
    last = state.causes[-1]
    for one in state.causes[:-1]:
        if any(rests_on(other.effect, one.effect) or other.beside == one.effect for other in state.causes):
            continue
        if stands_firm(one, lost_without(one, state)):
            continue
        log(f"trying without {one.effect}")
        lean = _without(state.model, one.effect, state.data)
        if lean is None:
            continue
        step = Step(state.first, lean, state.model, state.data)
        if has_lost_its_worth(step.share, one.explained) and objection(step, criteria) is not None:
            why = f"lost its worth once {last.effect} was there"
            state = _dropped(state, one, lean)
            state = state.with_rejected(RejectedCause(one.effect, one.explained, one.gain, why))
        elif one.gain <= 0.0:
            gained = replace(one, gain=step.gain)
            state = replace(state, causes=tuple(gained if c is one else c for c in state.causes))
    return state


def stands_firm(one: AcceptedCause, lost: float) -> bool:
    """Whether no refit without a cause is needed: its gain is known, and the share of the misfit that is lost without
    it to first order is far more than one that has lost its worth may lose."""
    return not one.gain <= 0.0 and not has_lost_its_worth(lost / ACCEPTANCE.firm_factor, one.explained)


def lost_without(one: AcceptedCause, state: SearchState) -> float:
    """Share of the first model's misfit that is lost without a cause, to first order."""
    return state.model.energy_of(one.effect) / max(misfit_energy(state.first, state.data), 1e-9)


def has_lost_its_worth(lost: float, explained: float) -> bool:
    """Whether a cause that explained so much of the misfit when it was named is worth nothing, where so little is lost
    without it."""
    return lost < ACCEPTANCE.worthless_share * explained


def _dropped(state: SearchState, one: AcceptedCause, lean: RefittedModel) -> SearchState:
    """The state without a cause; the last one takes over what it explained."""
    kept = [cause for cause in state.causes if cause is not one]
    last = kept[-1]
    rival = None if last.rival is None else _without(last.rival, one.effect, state.data)
    both = min(1.0, state.share_removed(last.before, lean) + one.explained)
    causes = (*kept[:-1], replace(last, explained=both, after=lean, rival=rival))
    return replace(state, causes=causes, model=lean)


def _without(model: RefittedModel, effect: str, data: EvaluationData) -> RefittedModel | None:
    """A model refitted without an effect, None where it cannot be."""
    structure, parameters = reduced(model, effect)
    try:
        return refit(structure, [parameters], data, model.trajectories)
    except NumericsError:
        return None
