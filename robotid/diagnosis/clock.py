"""The torque of a log, put where it acts.

A log holds the torque of one instant for each interval. Where the controller sets it several times meanwhile, the
recorded one is late by up to half an interval: what acts has gone on to the next when that is recorded. Stamps that
vary are those of a recorder with a clock of its own, which reads the torque of the controller's last cycle, begun up to
an interval before; there all torques may be late by some part of an interval, or early by as much as the stamps vary.
A log on a regular clock may hold the torque of its last interval, too; so late it is taken for that only where nothing
explains the records better, for no effect of a machine is early, or beside causes where a filter explains no more. No
cause in the machine is to be sought for any of these. What is not late but smoothed, as by the filter of a drive, is no
matter of clocks, and has an effect of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from robotid.catalogue import is_late
from robotid.channels.torque_filter import TorqueFilter
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended, reduced
from robotid.diagnosis.scoring.blocked_regression import gain_of
from robotid.diagnosis.scoring.candidate import Candidate, columns_of
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.carry_over import gain_by_blocks, proven
from robotid.diagnosis.search.data import Evidence, first_state, unweighted
from robotid.diagnosis.search.physical_sense import deviation
from robotid.diagnosis.search.refits import start_values
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.state import AcceptedCause, Log, SearchResult, SearchState
from robotid.errors import NumericsError
from robotid.interrupt import OutOfTime, deadline
from robotid.model.array import Array
from robotid.model.parameters import Parameters
from robotid.model.port import Port
from robotid.model.structure import Structure
from robotid.numerals import plain
from robotid.signals.plausibility.delay import torque_delay
from robotid.signals.record import Record
from robotid.signals.torque_steps import moved

DELAY, FILTER = "torque.torque_delay", f"torque.{TorqueFilter.name}"
TIME = f"{FILTER}.{TorqueFilter.parameters[0].symbol}"
HALF = 0.5  # [intervals] by which a torque that is set at every instant is recorded late
LAST = 1.0  # [intervals] by which it is recorded later still where a log holds the torque of its last interval
NEAR = 0.02  # [intervals] to which a lateness is sought by fits
UNUSABLE = 1e300  # squared error of a model that cannot be simulated
ROUNDING = 1e-9  # of a number of intervals
MAX_STEPS = 3  # of an estimate that is linear in a delay


@dataclass(frozen=True, slots=True)
class RecordedLate:
    """By how much the torque of logs is recorded late [s], early where negative. most : [intervals] that regular clocks
    explain of it."""

    late: float = 0.0
    most: float = HALF

    def corrected(self, record: Record) -> Record:
        """A record with its torque where it acts, as far as its clock explains that it does not; another as it is."""
        if self.late == 0.0:
            return record
        late = self.late / record.sampling_time
        torque, steps = moved(record.tau_m, record.torque_steps, -late)
        if record.torque_steps is not None:
            return replace(record, tau_m=torque, torque_steps=steps)
        return replace(record, tau_m=torque) if 0.0 < late <= self.most * (1.0 + ROUNDING) else record

    @property
    def remark(self) -> str:
        """In a sentence."""
        way = "late" if self.late > 0.0 else "early"
        return (
            f"the torque is recorded {plain(1e3 * abs(self.late), 2)} ms {way}, within what clocks explain:"
            f" moved by as much before causes were sought (for all stages add {self.late:.3g} to their torque_delay)"
        )


@dataclass(frozen=True, slots=True, eq=False)
class InTime:
    """The evidence with the torque where it acts, the state in which a search of it begins, and how late it was."""

    clock: RecordedLate
    evidence: Evidence
    start: SearchState


def in_time(evidence: Evidence, criteria: Criteria, log: Log = lambda _: None) -> InTime:
    """The evidence, its torque moved where it is surely recorded late by what a clock explains, unless the simulation
    is surely worse then; as it is where a deadline passes before that is known. Raises NumericsError where the model
    cannot be simulated."""
    with deadline(None):  # without the noise and a round of the score there is no answer at all
        log("measuring the noise")
        first = first_state(evidence, criteria)
        log("scoring the catalogue for cause 1")
        as_it_is = InTime(RecordedLate(), evidence, first.scored(criteria))
    try:
        return _put_in_time(as_it_is, criteria)
    except OutOfTime:
        return as_it_is


def _put_in_time(as_it_is: InTime, criteria: Criteria) -> InTime:
    """The same of evidence whose effects have been scored. Raises OutOfTime."""
    evidence, leads = as_it_is.evidence, _leads(as_it_is)
    by_fits = None if leads else _late_by_fits(as_it_is, criteria)
    most = HALF + LAST if leads or by_fits is not None else HALF
    found = by_fits or as_it_is
    for _ in range(MAX_STEPS):
        late, std = _lateness(found, criteria)
        if abs(late) <= ACCEPTANCE.amplitude_sigma * std:
            break
        total = _as_clocks_are(evidence, found.clock.late + late, std, most)
        if total is None:  # the first step of a longer delay may be one that a clock explains
            return as_it_is
        try:
            clock = RecordedLate(total, most)
            moved_on = evidence.on(clock.corrected)
            if total == found.clock.late or _is_worse(moved_on, found.evidence):
                break
            found = InTime(clock, moved_on, first_state(moved_on, criteria).scored(criteria))
        except NumericsError:
            break
    return as_it_is if _is_smoothed(evidence, found) else found


def is_undone(clock: RecordedLate, causes: Sequence[AcceptedCause]) -> bool:
    """Whether the causes move the torque that was moved: what they explain besides looked like a delay."""
    return clock.late != 0.0 and any(is_late(cause.effect) for cause in causes)


def is_filtered(evidence: Evidence, clock: RecordedLate, found: SearchResult, criteria: Criteria) -> bool:
    """Whether a torque that was taken for later than half an interval was rather recorded through a filter, by fits of
    the last model with either, from block to block of time: beside causes that were missing before, that did not show.
    It was not where no time is left to tell. evidence : with the torque as it was recorded."""
    asked = clock.late > HALF * _interval(evidence) and FILTER not in (*criteria.skip, *found.last.structure.effects)
    if not asked or found.late or found.events or _is_irregular(evidence):
        return False
    structure, start = extended(found.last, FILTER, {TIME: clock.late})
    recorded = [piece for run in evidence.fitted for piece in run.record.pieces(evidence.horizon)]
    try:
        filtered = _refitted_on(recorded, structure, start, found)
    except (NumericsError, OutOfTime):
        return False
    return proven(gain_by_blocks(found.last.fitted, filtered.fitted))


def _refitted_on(
    records: Sequence[Record], structure: Structure, start: Parameters, found: SearchResult
) -> RefittedModel:
    """A model refitted by the noise of a search to the records of its fit with another torque. Raises NumericsError
    where they cannot be simulated."""
    segments = (replace(one, record=record) for one, record in zip(found.data.fitted, records, strict=True))
    data = replace(found.data, fitted=tuple(segments), validation=())
    return refit(structure, [start], data, found.last.trajectories, CAREFUL)


def found_late(evidence: Evidence, found: SearchResult) -> tuple[RecordedLate, Evidence] | None:
    """By how much a torque is recorded late on regular clocks where a search has found a filter that is no slower than
    clocks explain, for beside what else is missing it may not show before; and the evidence with the torque where it
    acts. A filter that is slower than half an interval must explain no more than a lateness. None where that is not so,
    or where the model cannot be simulated then. Raises OutOfTime."""
    interval = _interval(evidence)
    if _is_irregular(evidence) or all(cause.effect != FILTER for cause in found.causes):
        return None
    time = found.last.parameters[TIME]
    least = (time - ACCEPTANCE.amplitude_sigma * deviation(found.last, TIME)) / interval
    with suppress(NumericsError):
        if least <= HALF:
            clock: RecordedLate | None = RecordedLate(min(time, HALF * interval))
        else:
            clock = _instead_of_a_filter(found, interval) if least <= HALF + LAST else None
        return None if clock is None else (clock, evidence.on(clock.corrected))
    return None


def _instead_of_a_filter(found: SearchResult, interval: float) -> RecordedLate | None:
    """The lateness on regular clocks with which the last model fits best without its filter of the torque; None where
    the filter is surely better, from block to block of time. interval [s] : of the clocks."""
    structure, start = reduced(found.last, FILTER)

    def fitted(clock: RecordedLate) -> RefittedModel:
        records = [clock.corrected(one.record) for one in found.data.fitted]
        return _refitted_on(records, structure, start, found)

    clock, _ = _likeliest(interval, lambda late: fitted(late).energy)
    return None if proven(gain_by_blocks(fitted(clock).fitted, found.last.fitted)) else clock


def _likeliest(interval: float, energy: Callable[[RecordedLate], float]) -> tuple[RecordedLate, float]:
    """The lateness that leaves the least energy, of those that regular clocks explain, and that energy. interval [s] :
    of the clocks; energy : raises NumericsError where the records cannot be simulated so."""

    def moved_by(intervals: float) -> RecordedLate:
        return RecordedLate(intervals * interval, HALF + LAST)

    def left(intervals: float) -> float:
        try:
            return energy(moved_by(intervals))
        except NumericsError:
            return UNUSABLE

    found = minimize_scalar(left, bounds=(0.0, HALF + LAST), method="bounded", options={"xatol": NEAR})
    return moved_by(float(found.x)), float(found.fun)


def _lateness(found: InTime, criteria: Criteria) -> tuple[float, float]:
    """By how much the torque is recorded late, with its standard deviation [s]: by the simulation, or by what a rigid
    axis' motion explains of the torque where that tells it better, as beside slow errors of the torque or an effect
    that leads the simulation far astray. Nothing where neither tells, or the model has a delay of its own."""
    state = found.start
    places, at = _places(state)
    if at is None or DELAY in criteria.skip:
        return 0.0, np.inf
    return min(_beside_the_best(state, places, at), _by_the_motion(found.evidence), key=lambda delay: delay[1])


def _places(state: SearchState) -> tuple[list[tuple[Candidate, slice]], slice | None]:
    """Where all candidates' columns are, and those of the delay."""
    places = list(zip(state.round.candidates, columns_of(state.round.candidates), strict=True))
    return places, next((at for one, at in places if one.name == DELAY), None)


def _leads(found: InTime) -> bool:
    """Whether a torque that is recorded late on regular clocks explains more of the misfit than any effect."""
    state, (_, at) = found.start, _places(found.start)
    if at is None or _is_irregular(found.evidence):
        return False
    regression, best = state.round.projected.beside_fitted(at), _best_in_machine(state)
    last = regression.moment.shape[1] - 1
    return bool(regression.estimate()[last] < 0.0) and regression.energy_of([last]) > (best.energy if best else 0.0)


def _late_by_fits(found: InTime, criteria: Criteria) -> InTime | None:
    """The evidence at the lateness on regular clocks with which the model fits best, None unless it explains more than
    a fit with the effect that promises most: where a model is far off, promises are no measure of what either leaves.
    """
    evidence, best = found.evidence, _best_in_machine(found.start)
    interval = _interval(evidence)
    late, std = _lateness(found, criteria)
    surely = late - ACCEPTANCE.amplitude_sigma * std > HALF * interval
    if not surely or best is None or _is_irregular(evidence):
        return None
    clock, least = _likeliest(interval, lambda late: _energy(evidence.on(late.corrected)))
    if least >= _energy_with(evidence, found.start, best):
        return None
    try:
        moved_on = evidence.on(clock.corrected)
        return InTime(clock, moved_on, first_state(moved_on, criteria).scored(criteria))
    except NumericsError:
        return None


def _best_in_machine(state: SearchState) -> Score | None:
    """The effect that explains most and does not only shift the torque in time."""
    in_machine = (s for s in state.round.best_of_each if s.candidate.name not in (DELAY, FILTER))
    return next(in_machine, None)


def _is_irregular(evidence: Evidence) -> bool:
    return any(run.record.torque_steps is not None for run in evidence.fitted)


def _interval(evidence: Evidence) -> float:
    """The shortest sampling interval of the fitted records [s]."""
    return min(run.record.sampling_time for run in evidence.fitted)


def _energy(evidence: Evidence) -> float:
    """Squared error of the model on the records of its fit."""
    return float(sum(np.sum(np.square(one)) for one in _residuals(evidence)))


def _energy_with(evidence: Evidence, state: SearchState, score: Score) -> float:
    """The same of the model fitted with an effect, from where its score promises the end."""
    structure, start = extended(state.model, score.candidate.name, start_values(state.model, score, 1.0))
    data = unweighted(evidence.model, [run.record for run in evidence.fitted], evidence.horizon)
    try:
        return refit(structure, [start], data).energy
    except NumericsError:
        return UNUSABLE


def _is_smoothed(evidence: Evidence, found: InTime) -> bool:
    """Whether a torque that is recorded later than half an interval was rather recorded through a filter as slow as
    that, by the simulations of the model fitted to the torque before either, from block to block."""
    late = found.clock.late
    if late <= HALF * _interval(evidence) or _is_irregular(evidence):
        return False

    def unfiltered(record: Record) -> Record:
        return replace(record, tau_m=TorqueFilter().apply(record.tau_m, record.sampling_time, [late]))

    try:
        return _is_worse(found.evidence, evidence.on(unfiltered))
    except NumericsError:
        return False


def _by_the_motion(evidence: Evidence) -> tuple[float, float]:
    """The mean delay [s] of all records on a regular clock, with its standard deviation, as many times larger as they
    differ by more than theirs (Birge 1932); nothing where the axis is flexible."""
    if any(term.partition(".")[0] == Port.GEAR for term in evidence.model.joint.structure.terms):
        return 0.0, np.inf
    records = [*(run.record for run in evidence.fitted), *evidence.validation]
    delays = [torque_delay(record, rigid=True) for record in records if record.torque_steps is None]
    known = [one for one in delays if 0.0 < one.std < np.inf]
    if not known:
        return 0.0, np.inf
    values, weights = np.array([one.value for one in known]), np.array([one.std for one in known]) ** -2.0
    mean = float(weights @ values / weights.sum())
    excess = float(weights @ (values - mean) ** 2) / max(1, len(known) - 1)
    return mean, float(np.sqrt(max(1.0, excess) / weights.sum()))


def _beside_the_best(state: SearchState, places: Sequence[tuple[Candidate, slice]], at: slice) -> tuple[float, float]:
    """The delay [s] beside what scores best, with its standard deviation; nothing where that does not carry over from
    block to block. places : of all candidates' columns; at : those of the delay."""
    scored = (s.candidate for s in state.round.scores if s.candidate.name != FILTER)
    best = next((one for one in scored if not getattr(one, "is_late", False)), None)
    beside = [k for one, own in places if one is best for k in range(own.start, own.stop)]
    fitted = len(state.round.projected.fitted)
    columns = [*range(fitted), *(fitted + k for k in beside), fitted + at.start]
    regression = state.round.projected.blocks.take(columns)
    last = len(columns) - 1
    if not proven(regression.gain([last])):
        return 0.0, np.inf
    return -float(regression.estimate()[last]), float(np.sqrt(regression.covariance()[last, last]))


def _as_clocks_are(evidence: Evidence, late: float, std: float, intervals: float) -> float | None:
    """A lateness as far as the clocks of all records explain it, None where they do not. intervals : by which a torque
    may be recorded late on a regular clock."""
    records = [run.record for run in evidence.fitted]
    irregular = [(one.sampling_time, one.torque_steps.spread) for one in records if one.torque_steps is not None]
    if irregular:
        return late if all(-interval * spread <= late <= interval for interval, spread in irregular) else None
    most = intervals * _interval(evidence)
    return min(late, most) if 0.0 < late <= most + ACCEPTANCE.amplitude_sigma * std else None


def _is_worse(after: Evidence, before: Evidence) -> bool:
    """Whether the simulation of the fitted records is worse, beyond its own spread from block to block of time. What
    else is missing may lead it astray by far more than a torque that is late does."""
    left, right = (np.concatenate([np.square(one) for one in _residuals(evidence)]) for evidence in (after, before))
    blocks = np.array_split(left - right, ACCEPTANCE.gain_blocks)
    return proven(gain_of(np.array([float(block.sum()) for block in blocks])))


def _residuals(evidence: Evidence) -> Iterator[Array]:
    """Those of all segments of the fitted records, (n,) each."""
    for run in evidence.fitted:
        yield from (segment.residual for segment in run.segments(evidence.model.output))
