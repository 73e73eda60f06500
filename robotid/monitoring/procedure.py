"""Whether an accepted model is still right on new logs, and what has changed where it is not.

Two questions are asked of every log, each by a test whose distribution without any change is known: whether it asks for
other parameters, and whether the model leaves more than it did. An alarm needs significance over all logs and both
tests (Holm 1979), and for the residual a size that matters, beyond what the uncertainty of the parameters explains.
What has changed is then sought as the diagnosis seeks what differs on validation records.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import EFFECTS
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.search.coloured import in_colour, left_by
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.record_changes import changes_of
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.comparison import holm
from robotid.estimate.fitted_model import FittedModel, simulate_record
from robotid.monitoring.evidence import (
    LogEvidence,
    evidence_of,
    parameters_p_value,
    residual_p_value,
    single_shift,
    unforeseen_p_value,
)
from robotid.monitoring.results import ParameterShift, WatchedLog, WatchResult
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record
from robotid.signals.stretches import stretches

LOUDER = 1.5  # times the energy that the model leaves of the records of its fit: a larger residual matters from here on
BLOCKS = 20  # of time, into which the shorter of the log and the records of the fit is cut
SHORTEST = 50  # samples of a block
SAME_SHARE = 0.05  # of what a change explains: others that explain so much less are not distinguished from it
MOST_SHARE = 0.5  # of what is new in a log: a parameter that explains less is not what has changed

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """How a model is watched. level : of significance of all logs together; horizon [s] : of pieces that are simulated
    afresh, None for whole records; max_samples : longer records count in stretches."""

    level: float = 0.01
    horizon: float | None = None
    max_samples: int = 100_000


def watch(
    model: FittedModel,
    fitted: Sequence[Record],
    logs: Sequence[Record],
    options: WatchOptions | None = None,
    log: Log = lambda _: None,
) -> WatchResult:
    """Hold a model against new logs. fitted : the records of its fit.

    Raises ConfigError where there is nothing to compare, NumericsError where the model cannot be simulated on the
    records of its own fit.
    """
    options = options or WatchOptions()
    if not logs or not fitted:
        raise ConfigError("there is no log", where="watch", hint="give one or more")
    log("measuring the noise")
    parts = [part for record in fitted for part in stretches(record, options.max_samples)]
    runs = [simulate_record(model, part, options.horizon) for part in parts]
    usual = float(np.mean([fit_percent(run.measured(model.output), run.signal(model.output)) for run in runs]))
    watched, lost = [], []
    for record in logs:
        try:
            simulate_record(model, record, options.horizon)
            watched.append(record)
        except NumericsError:
            lost.append(record.name)
    new = [part for record in watched for part in stretches(record, options.max_samples)]
    state = first_state(Evidence(model, runs, new, options.horizon), Criteria(skip=tuple(EFFECTS)))
    left = left_by(state.first)
    data = in_colour(state.first, state.data, left.noise)
    tests = [_tested(state.first, data, record.name) for record in watched]
    corrected = iter(holm([p for one in tests for p in (one.p_parameters, one.p_residual)]))
    results = []
    for record, one in zip(watched, tests, strict=True):
        log(f"comparing {record.name}")
        p_parameters, p_residual = next(corrected), next(corrected)
        results.append(_verdict(state.first, data, one, (p_parameters, p_residual), options.level, usual, left.energy))
    remarks = tuple(f"the simulation of {name} diverges" for name in lost)
    results += [WatchedLog(name, "not explained", 0.0, 0.0, 0.0, float("-inf"), usual, float("inf")) for name in lost]
    order = {record.name: k for k, record in enumerate(logs)}
    results.sort(key=lambda one: order[one.record])
    return WatchResult(model.name, model.records, options.level, tuple(results), remarks)


@dataclass(frozen=True, slots=True, eq=False)
class _Tested:
    """A log beside the records of the fit."""

    record: str
    fitted: LogEvidence
    log: LogEvidence
    fit_percent: float
    p_parameters: float
    p_residual: float

    @property
    def ratio(self) -> float:
        """What the model leaves, in energy, over what it leaves of the records of the fit."""
        return float(np.mean(self.log.residual_energy) / np.mean(self.fitted.residual_energy))


def _tested(model: RefittedModel, data: EvaluationData, name: str) -> _Tested:
    at = [k for k, segment in enumerate(data.validation) if segment.record.name == name]
    fits, segments = [model.validation[k] for k in at], [data.validation[k] for k in at]
    samples = sum(len(one.residual) for one in fits)
    length = max(SHORTEST, min(samples, data.samples) / BLOCKS)
    fitted = evidence_of(model.fitted, data.fitted, model.unknowns, length)
    found = evidence_of(fits, segments, model.unknowns, length)
    percent = float(np.average([one.fit_percent for one in fits], weights=[len(one.residual) for one in fits]))
    return _Tested(name, fitted, found, percent, parameters_p_value(fitted, found), residual_p_value(fitted, found))


def _verdict(
    model: RefittedModel,
    data: EvaluationData,
    one: _Tested,
    p_values: tuple[float, float],
    level: float,
    usual: float,
    energy: float,
) -> WatchedLog:
    """What a log shows. p_values : of both tests, corrected; usual : fit [%] on the records of the fit; energy : a
    sample there, in variances of the noise."""
    p_parameters, p_residual = p_values
    other, louder = p_parameters < level, p_residual < level and one.ratio > LOUDER
    if louder and not other:  # parameters that the fit left uncertain may show for the first time
        louder = unforeseen_p_value(one.fitted, one.log) < level
    found = WatchedLog(
        record=one.record,
        state="unchanged",
        p_value=min(p_parameters, p_residual if louder else 1.0),
        p_parameters=one.p_parameters,
        p_residual=one.p_residual,
        fit_percent=one.fit_percent,
        usual_percent=usual,
        residual_ratio=one.ratio,
    )
    if not other and not louder:
        return found
    segments = [segment for segment in data.validation if segment.record.name == one.record]
    single, twins, share = _single_change(model, one, segments, max(1.0, energy))
    if share > MOST_SHARE:
        return replace(found, state="changed", change=single, twins=twins)
    return replace(found, state="changed" if other else "not explained")


def _single_change(
    model: RefittedModel, one: _Tested, segments: Sequence[Segment], usual: float
) -> tuple[ParameterShift | None, tuple[str, ...], float]:
    """The parameter whose change explains a log best, what explains it as well, and the share of what is new that it
    explains. usual : energy a sample on the records of the fit."""
    before, changes = changes_of(model, segments)
    left = {change.parameter: change.energy for change in changes}
    if not left:
        return None, (), 0.0
    new = max(before - usual * sum(len(s.record) for s in segments), np.finfo(np.float64).tiny)
    ranked = sorted(left, key=lambda n: left[n])
    best = ranked[0]
    twins = tuple(n for n in ranked if left[n] - left[best] < SAME_SHARE * (before - left[best]))
    value = next(change.value for change in changes if change.parameter == best)
    at = model.parameters.names.index(best)
    shift = replace(_shift(model, one, model.columns.index(at)), shift=value)
    return shift, twins, (before - left[best]) / new


def _shift(model: RefittedModel, one: _Tested, k: int) -> ParameterShift:
    """What a log asks a parameter to be more than it is, all others as they are."""
    found, at, p = single_shift(one.fitted, one.log, k), model.columns[k], model.parameters
    return ParameterShift(p.names[at], p.units[at], float(p.values[at]), found.value, found.std)
