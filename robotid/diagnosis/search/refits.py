"""Refitting: the candidates that score best, fitted with the whole model, and the best of them first."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np

from robotid.catalogue import EFFECTS, with_effect
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.multiple_shooting import refit_from_pieces
from robotid.diagnosis.refit.refit import NoBetter, RefitOptions, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, carried, extended, reduced
from robotid.diagnosis.scoring.candidate import Candidate
from robotid.diagnosis.scoring.ranking import best_of_each
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.events import leaves_something
from robotid.diagnosis.search.physical_sense import deviation
from robotid.diagnosis.search.settings import ACCEPTANCE, CHOICE
from robotid.diagnosis.search.state import Log, SearchState
from robotid.errors import NumericsError
from robotid.interrupt import OutOfTime, until
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure, is_change
from robotid.model.term import Extreme
from robotid.parallel import ahead

BECOMES = "what effects become at the bounds of their parameters"


@dataclass(frozen=True, slots=True, eq=False)
class CandidateRefit:
    """A candidate as it scored, and the model refitted with it. confirmed : as of `Step`; unfollowed : the effect that
    it may be short of a bound, and that no simulation of these records follows."""

    score: Score
    model: RefittedModel
    confirmed: float = 1.0
    unfollowed: str | None = None

    @property
    def effect(self) -> str:
        """The candidate's name."""
        return self.score.candidate.name


@dataclass(frozen=True, slots=True, eq=False)
class RefitRound:
    """The candidates of a round that were refitted, the best first. unexamined : names of those for which no time was
    left, or what else none was left for."""

    refits: tuple[CandidateRefit, ...] = ()
    unexamined: tuple[str, ...] = ()


def refit_hopeful(state: SearchState, criteria: Criteria, log: Log) -> RefitRound:
    """The candidates of the last round that score best, refitted, the best first.

    Where none of them can be refitted, other points of their grids and the candidates that follow.
    """
    least = criteria.min_improvement_sigma**2 * state.data.samples
    points = [s for s in state.round.scores if s.energy > least]
    failed = set[str]()
    for _ in range(CHOICE.max_rounds):
        significant = [s for s in best_of_each(points) if state.round.p_value(s) < criteria.significance]
        new = [s for s in significant if s.candidate.name not in failed]
        again = [s for s in significant if s.candidate.name in failed]
        best = chosen_of(hopeful(new), criteria)
        chosen = [*again, *best, *_variants([*again, *best], points), *_elsewhere(best, state)]
        found = _refits(chosen, state, log)
        if found.refits:
            refits, unexamined = found.refits, found.unexamined
            try:
                refits = _with_extremes(refits, state, log)
            except OutOfTime:
                unexamined = unexamined or (BECOMES,)
            ordered = simpler_first(in_order(refits, state, criteria), state)
            return RefitRound(tuple(ordered), unexamined)
        if found.unexamined:
            return found
        tried = {s.candidate for s in chosen}
        failed |= {candidate.name for candidate in tried}
        points = [s for s in points if s.candidate not in tried]
    return RefitRound()


def hopeful(scores: Sequence[Score]) -> list[Score]:
    """The scores that come near the best, which is the first."""
    return [s for s in scores if s.energy > CHOICE.hopeful_share * scores[0].energy]


def chosen_of(scores: Sequence[Score], criteria: Criteria) -> list[Score]:
    """The best of scores, as many as the criteria allow, and beyond these the next effects of the catalogue where
    changes of records have taken the place of all but a few. A change that is one with another on these records, as the
    same one of the other of two records, takes no place."""
    best, further, places = list[Score](), list[Score](), criteria.max_refits
    for one in scores:
        mirrored = is_change(one.candidate.name) and any(are_collinear(one, other) for other in best)
        (best if mirrored or places > 0 else further).append(one)
        places -= not mirrored
    least = min(CHOICE.least_effects, criteria.max_refits)
    room = least - sum(not is_change(one.candidate.name) for one in best)
    return [*best, *[one for one in further if not is_change(one.candidate.name)][: max(0, room)]]


def are_collinear(one: Score, other: Score) -> bool:
    """Whether the columns of one span what those of another do."""
    if not (one.directions.size and one.directions.shape == other.directions.shape):
        return False
    cosines = np.linalg.svd(one.directions.T @ other.directions, compute_uv=False)
    return bool(cosines.min() > ACCEPTANCE.collinear_cosine)


def _variants(best: Sequence[Score], points: Sequence[Score]) -> list[Score]:
    """The best points of the same effects' other laws, from which a refit does not get to one another."""
    names = {one.candidate.name for one in best}
    found = {(one.candidate.name, one.candidate.variant) for one in best}
    others = []
    for one in points:
        law = one.candidate.name, one.candidate.variant
        if one.candidate.name in names and law not in found:
            found.add(law)
            others.append(one)
    return others


def _elsewhere(best: Sequence[Score], state: SearchState) -> list[Score]:
    """The best effect from other numbers of periods a turn, where its columns explain so little that the best of them
    may well be the wrong one; a refit does not get from one to another."""
    if not best or best[0].energy > CHOICE.doubtful_share * state.misfit or not best[0].candidate.repeats:
        return []
    return other_points(best[0], state.round.scores)


def other_points(best: Score, scores: Sequence[Score]) -> list[Score]:
    """Points of the best effect's grid that are no neighbours of it or of each other, best first."""
    chosen = [best]
    for one in scores:
        if one.candidate.name == best.candidate.name and all(_apart(one.candidate, c.candidate) for c in chosen):
            chosen.append(one)
    return chosen[1 : 1 + CHOICE.other_points]


def _apart(one: Candidate, other: Candidate) -> bool:
    """Whether two points of a grid are no neighbours."""
    return not np.allclose(one.values, other.values, rtol=CHOICE.neighbour_distance, atol=0.0)


def _refits(chosen: Sequence[Score], state: SearchState, log: Log) -> RefitRound:
    """Refits in the order of the scores; once one explains nearly all, and carries over, only what scores nearly as
    well is tried. Of an effect that leads where no simulation follows, no other point is.

    Several processes refit ahead of that decision, which drops what it does not ask for.
    """
    attempts = [_attempt(one, state) for one in chosen]
    found, astray, explained = list[CandidateRefit](), set[str](), 0.0
    with ahead(_refit_directly, (state.model, state.data), attempts, samples=state.data.samples) as direct:
        for k, one in enumerate(chosen):
            whole = not state.data.torque_errors and is_complete(explained, state.misfit)
            if (found and whole and not rivals(one, chosen[0])) or one.candidate.name in astray:
                continue
            log(_announced(state, one, f"{k + 1} of {len(chosen)}"))
            try:
                simulated, strays = _simulated(direct, k)
                after = _kept(simulated, attempts[k], state, explained)
            except OutOfTime:
                unexamined = dict.fromkeys(other.candidate.name for other in chosen[k:])
                return RefitRound(tuple(found), tuple(unexamined))
            if after is None and strays:
                astray.add(one.candidate.name)
            if after is not None:
                found.append(CandidateRefit(one, after))
                if carries_over(state.model, after):
                    explained = max(explained, state.model.energy - after.energy)
    return RefitRound(tuple(found))


def _simulated(direct: Sequence[RefittedModel | None], k: int) -> tuple[RefittedModel | None, bool]:
    """A direct refit, None where it explains nothing, and whether that is because no simulation follows."""
    try:
        return direct[k], False
    except NumericsError:
        return None, True


def _with_extremes(refits: Sequence[CandidateRefit], state: SearchState, log: Log) -> tuple[CandidateRefit, ...]:
    """The same refits and, for each with a parameter that is as good as at its bound, a refit of the simpler effect
    that it becomes there: that one may have scored too little to be refitted, or lost its way. For the best refit this
    is done in any case while it leaves more than noise: short of the bound it may imitate the simpler effect."""
    scores, found, further = state.round.by_effect, list[CandidateRefit](), list[CandidateRefit]()
    best = min(refits, key=lambda one: information_criterion(one.model))
    for one in refits:
        unfollowed = None
        for name, extreme in _becomes(one, everywhere=one is best and leaves_something(one.model, state.data)):
            if name not in scores:
                continue
            log(_announced(state, scores[name], f"what {one.effect} becomes"))
            try:
                further.append(_at_extreme(one, extreme, scores[name], state))
            except NoBetter:
                continue
            except NumericsError:
                unfollowed = name
        found.append(replace(one, unfollowed=unfollowed))
    return (*found, *further)


def _at_extreme(one: CandidateRefit, extreme: Extreme, score: Score, state: SearchState) -> CandidateRefit:
    """What a refitted effect becomes, fitted from there. Raises NumericsError where that cannot be simulated."""
    own = {
        f"{score.candidate.name}.{to}": prod(one.model.parameters[f"{one.effect}.{symbol}"] for symbol in symbols)
        for to, symbols in extreme.values.items()
    }
    structure, parameters = reduced(one.model, one.effect)
    structure = with_effect(structure, score.candidate.name)
    start = carried(parameters, structure, own)
    after = refit(structure, [start], state.data, one.model.trajectories, _options(state.model))
    return CandidateRefit(replace(score, energy=one.score.energy), after)


def _becomes(one: CandidateRefit, *, everywhere: bool = False) -> Iterator[tuple[str, Extreme]]:
    """The effects that a refitted one is as good as, for a parameter of it is at its bound, by name; or those that it
    would be there."""
    port, _, name = one.effect.partition(".")
    for extreme in getattr(EFFECTS.get(name), "extremes", ()):
        if everywhere or _is_at_bound(one.model, f"{one.effect}.{extreme.parameter}"):
            yield f"{port}.{extreme.effect}", extreme


def simpler_first(refits: Sequence[CandidateRefit], state: SearchState) -> list[CandidateRefit]:
    """The same refits; what an effect is as good as, at the bound of a parameter, goes before it where the records do
    not tell the two apart: nothing shows that parameter. So does what it would be there, where it carries over as well:
    the parameter fits what is no part of the machine."""
    ordered = list(refits)
    for one in refits:
        at_bound = {name for name, _ in _becomes(one)}
        anywhere = {name for name, _ in _becomes(one, everywhere=True)}
        further = {s.effect for s in refits if one.model.validation and _carries_further(s, one)}
        names = at_bound | (anywhere & further)
        slack = indistinguishable_energy(state.model.energy - one.model.energy, state.round.inflation)
        simpler = [s for s in ordered if s.effect in names and s.model.energy - one.model.energy <= slack]
        rest = [s for s in ordered if s not in simpler]
        ordered = [*rest[: rest.index(one)], *simpler, *rest[rest.index(one) :]]
    return ordered


def indistinguishable_energy(explained: float, inflation: float) -> float:
    """Energy by which two refits may differ and still not be distinguished, where the better explains so much."""
    chance = min(ACCEPTANCE.same_energy * inflation, ACCEPTANCE.max_same_share * explained)
    return max(ACCEPTANCE.same_share * explained, chance)


def _is_at_bound(model: RefittedModel, name: str) -> bool:
    """Whether a parameter does not differ significantly from one of its bounds."""
    k = model.parameters.names.index(name)
    value, ends = model.parameters.values[k], (model.parameters.lower[k], model.parameters.upper[k])
    return bool(min(abs(value - end) for end in ends) <= ACCEPTANCE.physical_sigma * deviation(model, name))


def carries_over(before: RefittedModel, after: RefittedModel) -> bool:
    """Whether a refit leaves less on records that served for no fit, where there are any: an imitator explains all of
    the fitted records, and more than that it does not."""
    return not before.validation or after.validation_energy < before.validation_energy


def _announced(state: SearchState, one: Score, count: str) -> str:
    """What is being done, and how much time is left of a budget."""
    text = f"round {len(state.rounds)}: refitting with {one.candidate.name}, {count}"
    at = until()
    return text if at is None else f"{text}, {max(0.0, at - time.monotonic()):.0f} s left"


def from_the_start(one: CandidateRefit, state: SearchState) -> CandidateRefit | None:
    """The same candidate, fitted by short pieces from where the fit of the model itself started; None where that leads
    nowhere, or the start is not known.

    A fit that lacks most of what moves a joint ends at parameters of another joint, from where none comes back.
    """
    if not state.start:
        return None
    score, structure = one.score, one.model.structure
    effect = score.candidate.start([min(CHOICE.start_ways) * a for a in score.amplitude])
    parameters = carried(state.model.parameters.with_values(state.start), structure, effect)
    return by_pieces(score, structure, parameters, state)


def by_pieces(score: Score, structure: Structure, start: Parameters, state: SearchState) -> CandidateRefit | None:
    """A candidate, fitted with the whole model by short pieces from given values; None where that leads nowhere."""
    found = _refit_by_pieces((state.model, state.data), _Attempt(structure, (start,), score.energy))
    return None if found is None else CandidateRefit(score, found)


def on_the_whole(score: Score, structure: Structure, start: Parameters, state: SearchState) -> CandidateRefit | None:
    """The same on whole records."""
    try:
        found = _refit_directly((state.model, state.data), _Attempt(structure, (start,), score.energy))
    except NumericsError:
        return None
    return None if found is None else CandidateRefit(score, found)


def rivals(one: Score, best: Score) -> bool:
    """Whether a candidate scores nearly as well as the best, so that it may be the cause as well."""
    return one.energy >= CHOICE.rival_share * best.energy


def is_complete(explained: float, misfit: float) -> bool:
    """Whether a refit that removes this energy explains the whole misfit. Of one that may be errors of the torque in
    any case nothing is known to be whole."""
    return misfit > 0.0 and explained > CHOICE.complete_share * misfit


def in_order(refits: Sequence[CandidateRefit], state: SearchState, criteria: Criteria) -> list[CandidateRefit]:
    """By the information criterion, each effect once; but what has fewer parameters goes before the best where the
    difference is below the least improvement, and a small part of what the best explains. Of several laws of one
    effect, the one that carries over best stands for it, where there are records to carry over to."""
    if not refits:
        return []
    each: dict[str, CandidateRefit] = {}
    for one in sorted(refits, key=lambda one: information_criterion(one.model)):
        known = each.setdefault(one.effect, one)
        law = one.score.candidate.variant
        if state.data.validation and law != known.score.candidate.variant and _carries_further(one, known):
            each[one.effect] = one
    ordered = sorted(each.values(), key=lambda one: information_criterion(one.model))
    explained = max(0.0, state.model.energy - ordered[0].model.energy)
    slack = min(criteria.min_improvement_sigma**2 * state.data.samples, ACCEPTANCE.max_same_share * explained)
    least = ordered[0].model.energy + slack
    return sorted(ordered, key=lambda one: len(one.model.columns) if one.model.energy <= least else np.inf)


def _carries_further(one: CandidateRefit, other: CandidateRefit) -> bool:
    """Whether a refit leaves less on the records that it was not fitted to."""
    return one.model.validation_energy < other.model.validation_energy


def information_criterion(model: RefittedModel) -> float:
    """Bayesian information criterion, up to a constant, of a residual whose variance is unknown (Schwarz 1978)."""
    return model.samples * float(np.log(model.energy)) + len(model.columns) * float(np.log(model.samples))


@dataclass(frozen=True, slots=True, eq=False)
class _Attempt:
    """A candidate's refit: the extended structure and where it may start, the boldest start first. promised : energy
    that the score promises to remove; whole : as of `_whole`."""

    structure: Structure
    starts: tuple[Parameters, ...]
    promised: float
    whole: Parameters | None = None


def _attempt(one: Score, state: SearchState) -> _Attempt:
    """From where the score promises the end, and from part of the way."""
    model = state.round.model
    starts = [extended(model, one.candidate.name, start_values(model, one, way)) for way in CHOICE.start_ways]
    return _Attempt(starts[0][0], tuple(start for _, start in starts), one.energy, _whole(one, model))


def _whole(one: Score, scanned: RefittedModel) -> Parameters | None:
    """Where an effect that mostly is there as a whole, or not at all, starts as declared; None of another. The first
    part of such a share changes the motion in another way than the last, so that a score promises too little."""
    if not any(one.candidate.whole):
        return None
    declared = {f"{one.candidate.name}.{p.symbol}": p.guess for p in one.candidate.parameters}
    return extended(scanned, one.candidate.name, declared)[1]


Around = tuple[RefittedModel, EvaluationData]
"""What the refits of a round share: the model that lacks something, and the records."""


def _options(now: RefittedModel) -> RefitOptions:
    return RefitOptions(start_below=CHOICE.good_start * now.energy, reject_above=now.energy)


def _refit_directly(around: Around, one: _Attempt) -> RefittedModel | None:
    """The model refitted with a candidate, from where its score promises the end; from part of the way where that is
    too far; of an effect that may be there as a whole, what is better from there. None where it explains nothing.
    Raises NumericsError where it cannot be simulated."""
    now, data = around
    found, failed = list[RefittedModel](), None
    for starts in (one.starts, *([] if one.whole is None else [(one.whole,)])):
        try:
            found.append(refit(one.structure, starts, data, now.trajectories, _options(now)))
        except NoBetter:
            continue
        except NumericsError as error:
            failed = error
    if failed is not None and not found:
        raise failed
    return min(found, key=lambda model: model.energy, default=None)


def _refit_by_pieces(around: Around, one: _Attempt) -> RefittedModel | None:
    """The same from short pieces."""
    now, data = around
    try:
        return refit_from_pieces(one.structure, one.starts, data, _options(now))
    except NumericsError:
        return None


def _kept(after: RefittedModel | None, one: _Attempt, state: SearchState, explained: float) -> RefittedModel | None:
    """A direct refit, or one from short pieces where it breaks a large promise and that is better.

    Beside errors of the torque an effect may keep its promise and do harm elsewhere: then it has not lost its way, and
    from pieces it would come to the same end. explained : energy that others explain.
    """
    large = one.promised > max(explained, CHOICE.doubtful_share * state.misfit)
    if not large or (after is not None and keeps_promise(one.promised, state, after)):
        return after
    with ahead(_refit_by_pieces, (state.model, state.data), [one], samples=state.data.samples) as found:
        again = found[0]
    if after is None or again is None:
        return again if after is None else after
    return again if again.energy < after.energy else after


def keeps_promise(promised: float, state: SearchState, after: RefittedModel) -> bool:
    """Whether a refit removes the energy that a score promises, or nearly so, and, where nothing but the effect is
    wrong, does no harm on validation segments."""
    removed = state.model.energy - after.energy
    harmless = state.data.torque_errors is not None or after.validation_energy <= state.model.validation_energy
    return removed > CHOICE.kept_promise * promised and harmless


def start_values(scanned: RefittedModel, one: Score, way: float) -> dict[str, float]:
    """Values by dotted name, of a model's parameters and a candidate's, a part of the way from the null to what the
    score promises.

    scanned : the model in which the candidate was seen.
    """
    old = scanned.parameters
    moved = {old.names[k]: old.values[k] + way * d for k, d in zip(scanned.columns, one.moved, strict=True)}
    return moved | dict(one.candidate.start([way * a for a in one.amplitude]))
