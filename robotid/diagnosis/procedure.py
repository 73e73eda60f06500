"""The diagnosis of a fitted model, from noise to verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from robotid.diagnosis.clock import RecordedLate, found_late, in_time, is_filtered, is_undone
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.applied import without_events
from robotid.diagnosis.experiment import Experiments, with_experiments
from robotid.diagnosis.measured_torque import CONTRADICTED, MeasuredTorque, contradicts, without_contradicted
from robotid.diagnosis.results import Diagnosis, SearchOutcome, Tone
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.search import search
from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.search.torque_errors import is_swamped, lead_astray, leaves_only_noise, strays
from robotid.diagnosis.tones import as_remarks, tones, without_tones
from robotid.diagnosis.verdict import (
    all_explained,
    as_reported,
    explains_all,
    explains_nothing,
    not_explained,
    verdict,
)
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated, fitted_model, simulate_record, simulate_records
from robotid.estimate.result import FitResult
from robotid.interrupt import OutOfTime, deadline
from robotid.model.array import Array
from robotid.model.units import on_axis
from robotid.numerals import listed, plain
from robotid.parallel import each, expect
from robotid.signals.plausibility.checks.recording import repeats
from robotid.signals.record import Record, usable_horizon
from robotid.signals.stretches import stretches

Log = Callable[[str], None]
IN_PIECES = "what is missing leads a simulation of whole records astray: diagnosed in pieces of {} s"
BY_PIECES = "causes that show in pieces of the records"
LATE_INSTEAD = "whether the torque is recorded late instead of filtered"
NOT_LATE = "what is missing with the torque as it was recorded"
OUT_OF_REACH = "{} cannot be simulated on {}, held out of its fit: no cause is tested there"
PIECES = (16, 32, 64)  # of a record, in which causes are sought that the simulation of the whole hides
REFITS = 20  # that take as long as a diagnosis does at least, to tell whether processes are worth their start


@dataclass(frozen=True, slots=True)
class DiagnosisOptions:
    """How a model is diagnosed.

    horizon [s] : length of the pieces of a record that are simulated afresh, None for whole records. max_samples :
    longer records are sampled in stretches of so many samples in all. experiments : what could be driven to tell causes
    apart that these records do not; None, and no experiment is proposed. budget [s] : for the search, None for all the
    time that it takes; the remarks of the diagnosis state what was not examined in it. The noise, the place of the
    misfit and the verdict are found in any case.
    """

    horizon: float | None = None
    max_samples: int = 100_000
    experiments: Experiments | None = None
    budget: float | None = None


def diagnose(
    fit: FitResult | FittedModel,
    records: Sequence[Record],
    criteria: Criteria | None = None,
    options: DiagnosisOptions | None = None,
    log: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Diagnose a fitted model: causes are fitted on the records of its fit and measured on the others.

    records : all of them; those that bear the names of the fit's records are fitted, the others validate. log : is
    called with what is being done. The gains of the causes are those of the search, which weighs a residual by its
    noise; `extension.diagnose_with_gains` has those of fits as the pipeline makes them.

    Raises ConfigError without any record of the fit, and NumericsError where the model cannot be simulated on one; a
    held-out one on which it cannot be is left out, with a remark.
    """
    return examine(fit, records, criteria, options, log).diagnosis()


@dataclass(frozen=True, slots=True, eq=False)
class Examination:
    """What a search has found of a model, and the diagnosis, which takes longer: it measures where the misfit sits, and
    what would have been seen."""

    outcome: SearchOutcome
    diagnosis: Callable[[], Diagnosis]


def examine(
    fit: FitResult | FittedModel,
    records: Sequence[Record],
    criteria: Criteria | None = None,
    options: DiagnosisOptions | None = None,
    log: Callable[[str], None] = lambda _: None,
) -> Examination:
    """Search for what a fitted model lacks. Arguments and errors as of `diagnose`."""
    begin = time.monotonic()
    model = fit if isinstance(fit, FittedModel) else fitted_model(fit)
    criteria, options = criteria or Criteria(), options or DiagnosisOptions()
    given = _given(model, records, options, log)
    fitted = [run for run in given.runs if run.record.name in model.records]
    measured = cache(lambda: MeasuredTorque.of(model.joint, model.parameters, [run.record for run in fitted]))
    unsought = _without_search(model, given.runs, measured, criteria)
    if unsought is not None:
        found = replace(unsought, remarks=(*unsought.remarks, *given.remarks))
        return Examination(SearchOutcome(refitted=unsought.refitted), lambda: found)
    held_out = [part for part in given.parts if part.name not in model.records]
    evidence, parts = Evidence(model, fitted, held_out, options.horizon), given.parts
    heard = tuple(tone for run in given.runs for tone in tones(run, model.output))
    hums = [*as_remarks(heard, on_axis(linear=model.joint.structure.linear)("Nm"))]
    for remark in hums:
        log(remark)
    if heard:
        parts = [without_tones(part, heard) for part in parts]
        evidence = evidence.on(partial(without_tones, tones=heard))
    until = None if options.budget is None else begin + options.budget
    sought = _sought(evidence, measured(), criteria, until, log)
    outcome = _outcome(sought, heard)

    def diagnosis() -> Diagnosis:
        log("measuring where the misfit sits")
        found, runs, judged = sought.found, given.runs, model
        changed = bool(outcome.events or outcome.late or heard)
        if changed:
            judged = replace(model, parameters=found.first.parameters, first_states={})
        if changed or outcome.horizon is not None:
            now = [without_events(sought.clock.corrected(part), found.events) for part in parts]
            runs = simulate_records(judged, now, options.horizon or outcome.horizon)
        answer = verdict(judged, runs, found, criteria)
        used = [record for record in records if record.name not in given.lost]
        done = (*given.remarks, *hums, *sought.remarks, *_repeated(used, model), *_unexamined(found, options.budget))
        answer = replace(
            answer,
            remarks=(*answer.remarks, *done),
            late=outcome.late,
            late_within=outcome.late_within,
            tones=heard,
            horizon=outcome.horizon,
        )
        if options.experiments is None or found.late:
            return answer
        return with_experiments(answer, found, options.experiments)

    return Examination(outcome, diagnosis)


def _outcome(sought: _Sought, heard: tuple[Tone, ...]) -> SearchOutcome:
    """heard : tones of the torque, which were taken out of the records."""
    found, clock = sought.found, sought.clock
    return SearchOutcome(
        causes=tuple(map(as_reported, found.causes)),
        refitted=found.last.parameters.by_name,
        events=found.events,
        late=clock.late,
        late_within=clock.most,
        tones=heard,
        horizon=sought.pieces,
        beside_shape=found.beside_curve,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Given:
    """What a model is diagnosed on. parts : the records, or stretches of long ones; runs : the model simulated on each
    of them; lost : names of records held out on which it cannot be; remarks : on what is not used, in sentences."""

    parts: list[Record]
    runs: list[Simulated]
    lost: tuple[str, ...]
    remarks: tuple[str, ...]


def _given(model: FittedModel, records: Sequence[Record], options: DiagnosisOptions, log: Log) -> _Given:
    """The records as far as they can be used. Raises ConfigError without any of the fit, NumericsError where one of
    these cannot be simulated."""
    if not any(record.name in model.records for record in records):
        hint = f"give those as well: {listed(model.records, 'and')}"
        raise ConfigError("none of these records is one of the fit", where=model.name, hint=hint)
    remarks = tuple(_shortened(r, options.max_samples) for r in records if len(r) > options.max_samples)
    for remark in remarks:
        log(remark)
    parts = [part for r in records for part in stretches(r, options.max_samples)]
    expect(REFITS * sum(map(len, parts)))
    runs = _all_simulated(model, parts, options.horizon)
    lost = tuple(dict.fromkeys(part.name for part, run in zip(parts, runs, strict=True) if run is None))
    if lost:
        remarks = (*remarks, OUT_OF_REACH.format(model.name, listed(lost, "or")))
        log(remarks[-1])
    followed = [run for run in runs if run is not None and run.record.name not in lost]
    return _Given([part for part in parts if part.name not in lost], followed, lost, remarks)


def _without_search(
    model: FittedModel,
    runs: Sequence[Simulated],
    measured: Callable[[], MeasuredTorque | None],
    criteria: Criteria,
) -> Diagnosis | None:
    """The diagnosis of a model of which no search can tell anything, for it explains nothing of the records of its fit,
    errs by more than their torque, or leaves nothing; None of another. measured : the torque of these records."""
    if explains_nothing(model, runs):
        return not_explained(model, runs)
    if contradicts(model, measured(), criteria):
        return not_explained(model, runs, CONTRADICTED)
    return all_explained(model, runs) if explains_all(model, runs) else None


@dataclass(frozen=True, slots=True, eq=False)
class _Sought:
    """What a search finds: with the torque where it acts, and by how much it was recorded late; with the torque as it
    was recorded where causes undo that. pieces [s] : their length where it shows in pieces of the records only."""

    clock: RecordedLate
    found: SearchResult
    pieces: float | None = None

    @property
    def remarks(self) -> Iterator[str]:
        """What was done to the records, in a sentence each."""
        if self.clock.late:
            yield self.clock.remark
        if self.pieces is not None:
            yield IN_PIECES.format(plain(self.pieces))


def _sought(
    evidence: Evidence, measured: MeasuredTorque | None, criteria: Criteria, until: float | None, log: Log
) -> _Sought:
    """What a model lacks. measured : the torque of the records of the fit; until : when the time is up, None for
    never."""
    with deadline(until):
        moved = in_time(evidence, criteria, log)
        if moved.clock.late:
            log(moved.clock.remark)
        clock, seen, pieces = moved.clock, moved.evidence, None
        found = search(seen, criteria, log, moved.start)
        if not clock.late:
            clock, seen, found = _unless_late(evidence, found, criteria, log)
        if is_undone(clock, found.causes) or is_filtered(evidence, clock, found, criteria):
            log("the torque is not late but filtered or delayed: searching with the torque as it was recorded")
            again = search(evidence, criteria, log)
            found, clock = (_unasked(found, NOT_LATE), clock) if again.late else (again, RecordedLate())
        else:
            found, pieces = _in_pieces(seen, found, criteria, log)
        return _Sought(clock, without_contradicted(found, measured), pieces)


def _unless_late(
    evidence: Evidence, found: SearchResult, criteria: Criteria, log: Log
) -> tuple[RecordedLate, Evidence, SearchResult]:
    """What a search finds once more with the torque where it acts, where it was recorded late and the first search has
    taken that for a filter; what that one found where it was not, or where no time is left to know."""
    as_it_is = RecordedLate(), evidence
    try:
        unseen = None if found.late else found_late(evidence, found)
    except OutOfTime:
        return *as_it_is, _unasked(found, LATE_INSTEAD)
    if unseen is None:
        return *as_it_is, found
    log(unseen[0].remark)
    again = search(unseen[1], criteria, log)
    return (*as_it_is, _unasked(found, LATE_INSTEAD)) if again.late else (*unseen, again)


def _in_pieces(
    evidence: Evidence, found: SearchResult, criteria: Criteria, log: Log
) -> tuple[SearchResult, float | None]:
    """What a search in pieces finds, and their length [s], where what the one of whole records leaves leads the
    simulation far from the motion, for along another motion no effect shows as it is, or where no simulation of whole
    records follows what a cause may be. What was found, and None, where that is not so, and where there is nothing in
    pieces either, or nothing that comes nearer to the motion, piece by piece, than what was found."""
    unfollowed = any(cause.unfollowed for cause in found.causes)
    if evidence.horizon is not None or found.late or found.events or not (lead_astray(found) or unfollowed):
        return found, None
    log("searching in pieces of the records")
    try:
        length = _length_of_pieces(evidence, found)
        again = search(evidence.in_pieces(length), criteria, log)
        named = bool(again.causes or (again.events and not found.causes))
        compared = named and bool(found.causes)
        nearer = not compared or _left_in_pieces(evidence, again, length) < _left_in_pieces(evidence, found, length)
    except NumericsError:
        return found, None
    except OutOfTime:
        return _unasked(found, BY_PIECES), None
    if named:
        return (again, length) if nearer else (found, None)
    if again.late:
        return _unasked(found, BY_PIECES), None
    nothing_more = leaves_only_noise(again) or is_swamped(again)
    return (found, None) if found.causes or not leaves_only_noise(found) or nothing_more else (again, length)


def _unasked(found: SearchResult, what: str) -> SearchResult:
    """What was found, the time being up before something more was known, in words."""
    return replace(found, late=True, unexamined=(*found.unexamined, what))


def _length_of_pieces(evidence: Evidence, found: SearchResult) -> float:
    """The longest of some lengths [s] over which the model that was found stays with the motion, else the shortest."""
    records = [run.record for run in evidence.fitted]
    longest = max(record.duration for record in records)
    *longer, shortest = (usable_horizon(longest / count, [*records, *evidence.validation]) for count in PIECES)
    for length in longer:
        left = _residuals_in_pieces(evidence, found, records, length)
        if left is not None and not strays(found, left):
            return length
    return shortest


def _left_in_pieces(evidence: Evidence, found: SearchResult, length: float) -> float:
    """Squared error of what was found in pieces of this length [s] of the records held out, or of all where none are;
    infinite where these cannot be simulated."""
    records = evidence.validation or [run.record for run in evidence.fitted]
    left = _residuals_in_pieces(evidence, found, records, length)
    return float("inf") if left is None else float(sum(np.sum(one**2) for one in left))


def _residuals_in_pieces(
    evidence: Evidence, found: SearchResult, records: Sequence[Record], length: float
) -> list[Array] | None:
    """What the model that was found leaves of each record in pieces of this length [s], (n,); None where these cannot
    be simulated."""
    model = found.last.put_into(evidence.model)
    try:
        return [run.residual(model.output) for run in simulate_records(model, records, length)]
    except NumericsError:
        return None


def _all_simulated(model: FittedModel, parts: Sequence[Record], horizon: float | None) -> list[Simulated | None]:
    """All records, together where they share what they are simulated with, else each by itself; None for a held-out
    one that the model cannot be simulated on. Raises NumericsError for a record of the fit."""
    if not model.joint.changes:
        try:
            return [*simulate_records(model, parts, horizon)]
        except NumericsError:  # of which record it does not tell
            pass
    return each(_simulated, (model, horizon), parts, samples=sum(map(len, parts)) // len(parts))


def _simulated(shared: tuple[FittedModel, float | None], part: Record) -> Simulated | None:
    model, horizon = shared
    try:
        return simulate_record(model, part, horizon)
    except NumericsError:
        if part.name in model.records:
            raise
        return None


def _repeated(records: Sequence[Record], model: FittedModel) -> Iterator[str]:
    """Held-out records on which no cause can fail, in a sentence each."""
    for record in records:
        fitted = (other for other in records if other.name in model.records)
        same = next((other.name for other in fitted if repeats(record, other)), None)
        if record.name not in model.records and same is not None:
            yield f"{record.name} repeats the motion of {same}, which is fitted: a gain on it proves little"


def _unexamined(found: SearchResult, budget: float | None) -> Iterator[str]:
    """What no time was left for, in a sentence."""
    if found.late and budget is not None:
        yield f"the budget of {budget:g} s is spent; not examined: {', '.join(found.unexamined)}"


def _shortened(record: Record, samples: int) -> str:
    taken = sum(map(len, stretches(record, samples)))
    return f"{record.name}: {taken} of {len(record)} samples are used, in stretches (diagnose.samples)"
