"""A fitted model that is to be extended: the same records, the same options, further effects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import reduce

import numpy as np

from robotid.catalogue import assemble, with_effect
from robotid.diagnosis.clock import RecordedLate
from robotid.diagnosis.events.applied import without_events
from robotid.diagnosis.refit.refitted_model import carried
from robotid.diagnosis.results import Diagnosis, Event, SearchOutcome, Tone
from robotid.diagnosis.tones import without_tones
from robotid.diagnosis.verdict import root_mean_square, trace
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import FitResult
from robotid.extension.results import Extension, Score
from robotid.extension.scored_starts import scored_starts
from robotid.model.structure import Structure, belongs, changed, is_change, rests_on
from robotid.parallel import ahead, each
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record

Starts = Mapping[str, float]
"""Values of parameters to start from, by dotted name; the others start as they were."""


@dataclass(frozen=True, slots=True)
class ExtensionTask:
    """A fitted model and what its extension takes.

    before : the fit of the model as it is. records : all of them; those of the fit by their names, the others validate.
    starts : values to start from, of which the best is chosen. options : of every fit. horizon [s] : length of the
    pieces of a record that are simulated afresh, None for whole records. log : is called with what is being done.
    held : parameters of effects that are not fitted but keep a value, by dotted name. clock : by how much the torque
    was recorded late, events : what happened once, tones : in the torque and not in the motion; all are taken out of
    the records already. known : a fit of these records with these options, which is not made again.
    """

    before: FitResult
    records: Sequence[Record]
    starts: Sequence[Starts] = ({},)
    options: FitOptions = field(default_factory=FitOptions)
    horizon: float | None = None
    log: Callable[[str], None] = lambda _: None
    held: Mapping[str, float] = field(default_factory=dict)
    clock: RecordedLate = field(default_factory=RecordedLate)
    events: tuple[Event, ...] = ()
    tones: tuple[Tone, ...] = ()
    known: FitResult | None = None

    @property
    def validation(self) -> list[str]:
        """Names of the records that the fit has not seen."""
        return [r.name for r in self.records if r.name not in self.before.records]

    def structure_with(self, effects: Sequence[str]) -> Structure:
        """The joint with further effects."""
        return reduce(with_effect, effects, self.before.structure)

    def without_sizes(self, effects: Sequence[str]) -> ExtensionTask:
        """The same task, where the sizes of some effects are not known: no start has a value of theirs."""
        kept = ({k: v for k, v in one.items() if not any(belongs(k, e) for e in effects)} for one in self.starts)
        return replace(self, starts=tuple(kept))

    def fit_with(self, effects: Sequence[str]) -> FitResult:
        """The model with further effects, fitted on the records of its fit. Ones that no start has a value of begin as
        their score promises where that suits the records better than what they begin as by default, and also beside
        the values from which the fit itself started, for what it lacks may have led it astray. Raises NumericsError
        where it does not converge."""
        if self.known is not None and self.known.structure == self.structure_with(effects):
            return self.known
        sized = {name for start in self.starts for name in start}
        new = [effect for effect in effects if not any(name.startswith(f"{effect}.") for name in sized)]
        if not new:
            return self._fitted(effects, self.starts)
        scored = scored_starts(self._model, self._used, new, self.horizon)
        origin = self.before.start
        elsewhere = self._attempted(effects, [origin, *(one | origin for one in scored)]) if origin else None
        try:
            found = self._fitted(effects, [*self.starts, *scored])
        except NumericsError:
            if elsewhere is None:
                raise
            return elsewhere
        return found if elsewhere is None or found.misfit <= elsewhere.misfit else elsewhere

    @property
    def _model(self) -> FittedModel:
        return fitted_model(self.before, estimate_states=self.options.estimate_states)

    @property
    def _used(self) -> list[Record]:
        """The records of the fit."""
        return [r for r in self.records if r.name in self.before.records]

    def _attempted(self, effects: Sequence[str], starts: Sequence[Starts]) -> FitResult | None:
        """The same from these starts, None where it does not converge."""
        try:
            return self._fitted(effects, starts)
        except NumericsError:
            return None

    def _fitted(self, effects: Sequence[str], starts: Sequence[Starts]) -> FitResult:
        """The same from the best of these starts."""
        old, structure = self._model.parameters, self.structure_with(effects)
        joint = assemble(structure, angle=self.before.keeps_angle)
        first, *others = (carried(old, structure, values).held_at(self.held) for values in starts)
        options = replace(self.options, other_starts=tuple(others))
        return replace(fit_model(self.before.name, joint, first, self._used, options), horizon=self.horizon)

    def scores(self, fit: FitResult, *, everywhere: bool = True) -> dict[str, Score]:
        """A fit on every record on which it can be simulated, by record name. everywhere : on those of the fit, too."""
        shared = (fitted_model(fit, estimate_states=self.options.estimate_states), self.horizon)
        records = [r for r in self.records if everywhere or r.name in self.validation]
        found = each(_score, shared, records, samples=self.samples // max(1, len(self.records)))
        return {r.name: score for r, score in zip(records, found, strict=True) if score is not None}

    @property
    def samples(self) -> int:
        """Of all records."""
        return sum(map(len, self.records))

    def on_simulated(self, fits: Iterable[ScoredFit]) -> ExtensionTask:
        """The task without records held out on which none of these fits can be simulated: they tell nothing apart."""
        known = {name for one in fits for name in one.scores} | {*self.before.records}
        return replace(self, records=[r for r in self.records if r.name in known])

    def validation_fit(self, scores: Mapping[str, Score]) -> float:
        """Mean fit on the validation records [%], minus infinity where one of them cannot be simulated."""
        return float(np.mean([scores[name].fit_percent if name in scores else -np.inf for name in self.validation]))


def _score(shared: tuple[FittedModel, float | None], record: Record) -> Score | None:
    """A model on a record, None where it cannot be simulated."""
    model, horizon = shared
    try:
        run = simulate_record(model, record, horizon)
    except NumericsError:
        return None
    measured, simulated = run.measured(model.output), run.signal(model.output)
    return Score(
        record.role,
        record.name in model.records,
        fit_percent(measured, simulated),
        root_mean_square(measured - simulated),
        trace(run, model),
    )


@dataclass(frozen=True, slots=True, eq=False)
class ScoredFit:
    """A fit and what it scores, as of `ExtensionTask.scores`."""

    fit: FitResult
    scores: dict[str, Score]


@dataclass(frozen=True, slots=True)
class _Asked:
    """A fit with further effects. deviations : with its standard deviations; everywhere : as of
    `ExtensionTask.scores`."""

    effects: tuple[str, ...]
    deviations: bool
    everywhere: bool


def fits_with(task: ExtensionTask, choices: Sequence[Sequence[str]], *, everywhere: bool = True) -> list[ScoredFit]:
    """The model with each choice of further effects, fitted and scored; without any, as it was. The last alone has
    standard deviations. everywhere : as of `ExtensionTask.scores`. Raises NumericsError where one does not converge."""
    asked = _asked(choices, everywhere=everywhere)
    return fits_made(task, choices, each(_fitted, _silenced(task), asked, samples=task.samples))


def fits_ahead(task: ExtensionTask, choices: Sequence[Sequence[str]]) -> AbstractContextManager[Sequence[ScoredFit]]:
    """The same on the records held out, for `fits_made`: other processes make them while this one does something
    else."""
    asked = _asked(choices, everywhere=False)
    return ahead(_fitted, _silenced(task), asked, samples=task.samples, meanwhile=True)


def fits_made(task: ExtensionTask, choices: Sequence[Sequence[str]], found: Iterable[ScoredFit]) -> list[ScoredFit]:
    """Fits with each choice of further effects, that without any as this process has it."""
    for effects in choices:
        task.log(_announced(effects))
    return [one if effects else replace(one, fit=task.before) for effects, one in zip(choices, found, strict=True)]


def tried_with(task: ExtensionTask, choices: Sequence[Sequence[str]]) -> list[ScoredFit | None]:
    """The model with each choice of further effects as of `fits_with`, on the records held out and without standard
    deviations; None for one that does not converge."""
    asked = [_Asked(tuple(effects), deviations=False, everywhere=False) for effects in choices]
    return each(_tried, _silenced(task), asked, samples=task.samples)


def tries_with(
    task: ExtensionTask, choices: Sequence[Sequence[str]]
) -> AbstractContextManager[Sequence[ScoredFit | None]]:
    """The same on all records, each when it is asked for."""
    asked = [_Asked(tuple(effects), deviations=False, everywhere=True) for effects in choices]
    return ahead(_tried, _silenced(task), asked, samples=task.samples)


def _asked(choices: Sequence[Sequence[str]], *, everywhere: bool) -> list[_Asked]:
    return [_Asked(tuple(effects), k + 1 == len(choices), everywhere) for k, effects in enumerate(choices)]


def _announced(effects: Sequence[str]) -> str:
    return f"fitting with {', '.join(effects)}" if effects else "measuring the model as it is"


def _silenced(task: ExtensionTask) -> ExtensionTask:
    """A task for another process, where nobody listens."""
    return replace(task, log=_nobody)


def _nobody(_: str) -> None:
    pass


def _fitted(task: ExtensionTask, asked: _Asked) -> ScoredFit:
    wanted = replace(task, options=replace(task.options, deviations=asked.deviations))
    fit = wanted.fit_with(asked.effects) if asked.effects else task.before
    return ScoredFit(fit, task.scores(fit, everywhere=asked.everywhere))


def _tried(task: ExtensionTask, asked: _Asked) -> ScoredFit | None:
    try:
        return _fitted(task, asked)
    except NumericsError:
        return None


def extension_task(
    diagnosis: Diagnosis | SearchOutcome,
    fit: FitResult,
    records: Sequence[Record],
    options: FitOptions | None = None,
    *,
    horizon: float | None = None,
    log: Callable[[str], None] = lambda _: None,
) -> ExtensionTask:
    """The task to extend a diagnosed model, from where the diagnosis left its parameters or those of its causes.

    diagnosis : or what its search has found; fit : the diagnosed one; records : all of them, from which the events of
    the diagnosis are taken, their torque put where it acts; options : of every fit, absent: those by default, with the
    output of the diagnosed one; horizon [s] : of its pieces, unless the diagnosis has chosen some. Causes that were
    found beside a curve which no effect is keep their parameters, for without the curve a fit would lead them astray.
    """
    of_causes = {p.name: p.value for cause in diagnosis.causes for p in cause.parameters}
    starts, held = (diagnosis.refitted, of_causes), of_causes if diagnosis.beside_shape else {}
    options, clock = options or FitOptions(output=fit.output), RecordedLate(diagnosis.late, diagnosis.late_within)
    records = [corrected(record, diagnosis) for record in records]
    if diagnosis.horizon is not None:
        horizon, options = diagnosis.horizon, replace(options, horizon=diagnosis.horizon)
    return ExtensionTask(fit, records, starts, options, horizon, log, held, clock, diagnosis.events, diagnosis.tones)


def corrected(record: Record, found: Diagnosis | SearchOutcome | Extension) -> Record:
    """A record as an extension takes it: its torque without the tones that were found, moved by what it was recorded
    late, that of events accounted for."""
    clock = RecordedLate(found.late, found.late_within)
    return without_events(clock.corrected(without_tones(record, found.tones)), found.events)


def effects_to_add(diagnosis: Diagnosis | SearchOutcome, fit: FitResult) -> tuple[str, ...]:
    """The causes of a diagnosis that a fit on the same records can take; a difference on a validation record is
    reported, not fitted."""
    return tuple(cause.effect for cause in diagnosis.causes if _can_be_fitted(cause.effect, fit.records))


def _can_be_fitted(effect: str, records: Sequence[str]) -> bool:
    return not is_change(effect) or changed(effect)[0] in records


def gain(after: float, before: float) -> float:
    """Difference of two mean fits [% points], nan where either model cannot be simulated."""
    return after - before if np.isfinite([after, before]).all() else float("nan")


def others_than(effects: Sequence[str], effect: str) -> list[str]:
    """The effects that can be without one."""
    return [e for e in effects if e != effect and not rests_on(e, effect)]
