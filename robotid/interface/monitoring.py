"""Accepted models later on: beside other fits, and on new logs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from robotid.artifacts.provenance import digest
from robotid.display import Displayed
from robotid.errors import ConfigError
from robotid.interface.dataset import Dataset, as_dataset
from robotid.interface.files import RunContents
from robotid.interface.identification import Fit, fields_of, with_more
from robotid.interface.improvement import DiagnosedFit, ExtendedFit
from robotid.monitoring import WatchOptions, WatchResult
from robotid.monitoring import watch as watch_model
from robotid.parallel import computing
from robotid.pipeline.compare import ComparedRun, compared, load_run, named, with_gains, with_verdict
from robotid.report.comparison import RunComparison, RunSummary
from robotid.report.display import Columns, View, shows
from robotid.report.tables import watch as watch_tables
from robotid.report.tables.table import Table
from robotid.signals.record import Record, usable_horizon

Comparable = str | Path | RunContents | Fit | DiagnosedFit | ExtendedFit
"""What can be compared: a run directory, or what `rid.load`, `rid.fit`, `rid.diagnose` and `rid.extend` return."""

Log = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class WatchedFit(Displayed, WatchResult):
    """A model on new logs, with the fit that was accepted."""

    fit: Fit = field(kw_only=True)


def compare(
    runs: Mapping[str, Comparable] | Sequence[str | Path],
    *,
    model: str | None = None,
    axis: str = "",
    extended: bool = False,
) -> RunComparison:
    """Compare fits with the first of them, as `robotid compare` does: which parameters differ by more than their
    uncertainties allow, of one machine on two days, or of two machines.

    runs : a list of run directories, which are called by their own names; or a mapping of names to run directories or
    to what `rid.load`, `rid.fit`, `rid.diagnose` and `rid.extend` return; two or more.
    Of run directories alone: model : which of the fitted models, by default the best; axis : of robots of several;
    extended : the model with its causes, where the run has any.

    `found.fits.changed` has the significant differences, the most certain first; `found.remarks` what makes them
    doubtful. Raises ConfigError for fewer than two runs, for a name that is not there and for axes of different kinds,
    InputError where a run has no model.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> model = rid.Model(motor=["inertia", "viscous", "coulomb"])
    >>> monday, friday = (rid.fit(model, rid.read(motor_log(seed=k), name="log")) for k in (1, 2))
    >>> found = rid.compare({"monday": monday, "friday": friday})
    >>> found.fits.reference, [one.parameter for one in found.fits.changed]
    ('monday', [])
    """
    if isinstance(runs, str | Path):
        runs = [runs]
    if not isinstance(runs, Mapping):
        runs = named([_path(one) for one in runs])
    if len(runs) < 2:
        raise ConfigError("there is nothing to compare with", where="compare", hint="give two runs or more")
    return compared({name: _compared_run(one, model, axis, extended=extended) for name, one in runs.items()})


def watch(
    fit: Fit | ExtendedFit | RunContents,
    logs: Record | Iterable[Record],
    records: Record | Iterable[Record] = (),
    *,
    level: float = 0.01,
    jobs: int | None = 1,
    log: Log | None = None,
) -> WatchedFit:
    """Hold an accepted model against new logs, as `robotid watch` does: whether it is still right, and what has changed
    where it is not.

    fit : what `rid.fit` or `rid.extend` returned, or a run directory that was loaded: its model with causes where it
    has any. logs : as `rid.read` returns them. records : those of the fit, where it was saved without them.
    level : the chance of an alarm over all logs while nothing has changed. jobs : processes, None for one a core. log :
    is called with what is being done, such as `print`.

    `found.alarm` tells whether the model is no longer right on one of the logs, `found.logs` what each of them shows.
    Raises ConfigError where there is no log, for a level that is not between 0 and 1 and for two records of one name,
    NumericsError where the model cannot be simulated on the records of its own fit.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> found = rid.watch(fit, rid.read(motor_log(seed=2), name="monday"))
    >>> found.alarm, found.logs[0].state
    (False, 'unchanged')
    """
    if not 0.0 < level < 1.0:
        raise ConfigError(f"the level is {level:g}", where="watch", hint="give a number between 0 and 1")
    accepted = _accepted(fit)
    used, new = with_more(accepted, as_dataset(records)).only(accepted.records), as_dataset(logs)
    Dataset((*used, *new))  # refuses two records of one name
    longest = fit.config.diagnose.samples if isinstance(fit, RunContents) else WatchOptions().max_samples
    horizon = usable_horizon(accepted.options.fixed_horizon, [*used, *new])
    options = WatchOptions(level, horizon, longest)
    with computing(jobs):
        found = watch_model(accepted.fitted_model, used.records, new.records, options, log or (lambda _: None))
    return WatchedFit(**fields_of(found, WatchResult), fit=accepted)


def _path(one: object) -> Path:
    """A run directory. Raises ConfigError for a fit, which has no name of its own."""
    if isinstance(one, str | Path):
        return Path(one)
    if isinstance(one, RunContents):
        return one.folder
    hint = 'give a mapping, rid.compare({"monday": ..., "friday": ...})'
    raise ConfigError("what is compared has no names", where="compare", hint=hint)


def _compared_run(one: Comparable, model: str | None, axis: str, *, extended: bool) -> ComparedRun:
    """What is compared of a run directory or of a fit. Raises ConfigError for anything else."""
    if isinstance(one, str | Path | RunContents):
        return load_run(_path(one), model, axis, extended=extended)
    if isinstance(one, DiagnosedFit):
        return with_verdict(_compared_fit(one.fit), one)
    if isinstance(one, ExtendedFit):
        return with_gains(_compared_fit(one.origin), one, extended=True)
    if isinstance(one, Fit):
        return _compared_fit(one)
    hint = "give run directories, or what rid.fit, rid.diagnose or rid.extend returns"
    raise ConfigError(f"a result of type {type(one).__name__} cannot be compared", where="compare", hint=hint)


def _compared_fit(fit: Fit) -> ComparedRun:
    """What is known of a fit; records that are not here have no digest."""
    used = [record for record in fit.dataset if record.name in fit.records]
    signals = b"".join(np.ascontiguousarray(signal).tobytes() for r in used for signal in (r.tau_m, r.phi_m, r.dphi_m))
    summary = RunSummary(fit.model.name, fit.name, dict(fit.fit_percent))
    return ComparedRun(fit, summary, digest(signals) if signals else "")


def _accepted(fit: Fit | ExtendedFit | RunContents) -> Fit:
    """The model that is watched. Raises ConfigError where there is none."""
    if isinstance(fit, RunContents):
        extended = fit.extension is not None and bool(fit.extension.added)
        fit = fit.extension if extended else fit.fit  # type: ignore[assignment]
    if isinstance(fit, ExtendedFit):
        fit = fit.fit
    if not isinstance(fit, Fit):
        hint = "give what rid.fit or rid.extend returns, or a run directory as rid.load returns it"
        raise ConfigError("there is no fitted model to watch", where="watch", hint=hint)
    return fit


@shows(WatchedFit)
class WatchView(View[WatchedFit]):
    """A model on new logs."""

    @property
    def linear(self) -> bool:
        return self.content.fit.structure.linear

    def line(self) -> str:
        return watch_tables.sentence(self.content)

    def tables(self) -> Sequence[Table]:
        return watch_tables.tables(self.content)

    def columns(self) -> Columns:
        names = ("record", "state", "p_value", "fit_percent", "usual_percent", "residual_ratio")
        changes = [log.change for log in self.content.logs]
        return {name: [getattr(log, name) for log in self.content.logs] for name in names} | {
            "parameter": [one.parameter if one else "" for one in changes],
            "change": [one.shift if one else float("nan") for one in changes],
            "std": [one.std if one else float("nan") for one in changes],
        }
