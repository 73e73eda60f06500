"""The command watch: an accepted model against new logs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from robotid.artifacts.store import load, read_header
from robotid.cli.console import print_json, print_message, print_tables
from robotid.cli.progress import watching
from robotid.config.records import RecordSettings
from robotid.config.suggest import suggest
from robotid.errors import ConfigError, InputError, ThresholdError
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.result import FitResult, Fits
from robotid.extension.results import Extension
from robotid.monitoring import WatchOptions, watch
from robotid.parallel import working
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.table import COLLECT, EXTEND, FIT
from robotid.progress import Begun, Progress
from robotid.report.tables import watch as view
from robotid.report.tables.sliding import in_units_of_axis
from robotid.signals.quality import Recordings
from robotid.signals.readers import read
from robotid.signals.record import Record, usable_horizon
from robotid.stages.ingestion.measured import measured_records


@dataclass(frozen=True, slots=True)
class WatchRequest:
    """How a model is watched. like : record whose columns the logs have, None for the first that has a file; level : of
    significance; model : which fitted model, None for the accepted one."""

    like: str | None = None
    level: float = 0.01
    model: str | None = None
    jobs: int | None = None
    as_json: bool = False
    quiet: bool = False


def watch_logs(run: Runs, logs: Sequence[Path], request: WatchRequest) -> None:
    """Print whether the accepted model of a run is still right on new logs.

    Raises ThresholdError where it is not, InputError where the run has no model or a log cannot be read, ConfigError
    for a record or a model that does not exist.
    """
    if not isinstance(run, Run):
        what = f"the robot has {len(run.axes)} axes"
        raise ConfigError(what, where="watch", hint=f"name one by --axis: {', '.join(run.axes)}")
    if not 0.0 < request.level < 1.0:
        raise ConfigError(f"the level is {request.level:g}", where="--level", hint="give a number between 0 and 1")
    recordings = load(run.file(COLLECT), Recordings, run.loaded.axis).content
    fit = _accepted(run, request.model)
    new = tuple(_read(run, logs, request.like, [r.name for r in recordings.records]))
    used = [r for r in recordings.records if r.name in fit.records]
    model = fitted_model(fit, estimate_states=run.loaded.config.fit.initial_states == "free")
    horizon = run.loaded.config.fit.fixed_horizon or usable_horizon(fit.horizon, [*used, *new])
    options = WatchOptions(request.level, horizon, run.loaded.config.diagnose.samples)
    with watching(quiet=request.quiet) as log, working(request.jobs):
        if log is not None:
            log(Begun("watch"))
        say = (lambda text: log(Progress(text))) if log is not None else (lambda text: None)
        found = watch(model, used, new, options, say)
    if request.as_json:
        print_json(view.document(found))
    elif not request.quiet:
        linear = run.loaded.config.robot.linear
        print_tables(tuple(map(partial(in_units_of_axis, linear=linear), view.tables(found))))
    if found.alarm:
        raise ThresholdError(view.sentence(found))
    print_message(view.sentence(found), quiet=request.quiet)


def _accepted(run: Run, name: str | None) -> FitResult:
    """The model with its causes where the run has extended it, else the best one. Raises InputError where the run's
    model was not fitted to its records."""
    axis = run.loaded.axis
    made = load(run.file(FIT), Fits, axis)
    if made.provenance.inputs.get(COLLECT.name) != read_header(run.file(COLLECT), axis).digest:
        what = f"it was not fitted to the records in {COLLECT.output}"
        raise InputError(what, where=str(run.file(FIT)), hint=f"run `{run.command('fit')}`")
    fits = made.content
    if name is not None:
        if name not in fits.models:
            raise ConfigError(f'there is no model "{name}"', where="--model", hint=suggest(name, fits.models))
        return fits.models[name]
    if run.file(EXTEND).is_file():
        extension = load(run.file(EXTEND), Extension, axis)
        if extension.provenance.inputs.get(FIT.name) == made.header.digest and extension.content.added:
            return extension.content.fit
    return fits.models[fits.best]


def _read(run: Run, logs: Sequence[Path], like: str | None, taken: Sequence[str]) -> Iterator[Record]:
    """The logs, their columns as those of a record of the configuration; all of each file, whole or in pieces where
    gaps have cut it."""
    config = run.loaded.config
    known = {r.name: r for r in config.records if r.files}
    if like is not None and like not in known:
        what = f'there is no record "{like}" with a file'
        raise ConfigError(what, where="--like", hint=suggest(like, known))
    names = set(taken)
    for path in logs:
        if not path.exists():
            raise InputError("there is no such file", where=str(path), hint="check the path")
        name = _name(path, names)
        pattern = known[like] if like is not None else next(iter(known.values()), None)
        changes = {"name": name, "role": "validate", "file": str(path), "start": None, "stop": None}
        settings = (
            RecordSettings(name=name, role="validate", file=str(path))
            if pattern is None
            else pattern.model_copy(update=changes)
        )
        for record, _ in measured_records(settings, read(path), linear=config.robot.linear):
            yield record


def _name(path: Path, taken: set[str]) -> str:
    """A name that no other record has."""
    stem = re.sub(r"\W", "_", path.stem) or "log"
    name = next(n for n in (stem, *(f"{stem}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
    taken.add(name)
    return name
