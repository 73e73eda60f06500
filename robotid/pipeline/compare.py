"""Runs to be compared: what their artifacts hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotid.artifacts.store import Artifact, load, read_headers
from robotid.config.load import parse
from robotid.config.suggest import suggest
from robotid.diagnosis.results import Diagnosis
from robotid.errors import ConfigError, InputError
from robotid.estimate.comparison import compare_fits
from robotid.estimate.result import FitResult, Fits
from robotid.extension.results import Extension
from robotid.pipeline.stage import Stage
from robotid.pipeline.table import COLLECT, DIAGNOSE, EXTEND, FIT, VALIDATE
from robotid.report.comparison import RunComparison, RunSummary


@dataclass(frozen=True, slots=True, eq=False)
class ComparedRun:
    """A run's model and what is known of it. records : digest of the records that it was fitted to."""

    fit: FitResult
    summary: RunSummary
    records: str


def compare_runs(
    folders: Sequence[Path], model: str | None = None, axis: str = "", *, extended: bool = False
) -> RunComparison:
    """Compare runs with the first of them. model : which of their fitted models, None for the best of each; axis : of
    robots of several; extended : the models with their causes, where they have any.

    Raises ConfigError for fewer than two runs, InputError where a run has no model.
    """
    if len(folders) < 2:
        raise ConfigError("there is nothing to compare with", where="compare", hint="give two run directories or more")
    return compared({name: load_run(folder, model, axis, extended=extended) for name, folder in named(folders).items()})


def compared(runs: Mapping[str, ComparedRun]) -> RunComparison:
    """Compare runs with the first of them. Raises ConfigError for fewer than two."""
    found = compare_fits({name: run.fit for name, run in runs.items()})
    return RunComparison({name: run.summary for name, run in runs.items()}, found, tuple(_remarks(runs)))


def load_run(folder: Path, model: str | None = None, axis: str = "", *, extended: bool = False) -> ComparedRun:
    """What a run directory holds of its model, or of that of an axis. Raises InputError where it holds none,
    ConfigError for a name."""
    if not folder.is_dir():
        if folder.is_file():
            raise InputError("it is a file", where=str(folder), hint=f"give the run directory, {folder.parent}")
        raise InputError(
            "there is no such run directory", where=str(folder), hint="run `robotid run` of its configuration"
        )
    made = load(folder / FIT.output, Fits, axis)
    fits, config = made.content, parse(made.provenance.configuration)
    name = model or fits.best
    if name not in fits.models:
        raise ConfigError(f'there is no model "{name}"', where=str(folder), hint=suggest(name, fits.models))
    fit = fits.models[name]
    validation, diagnosis, extension = (_beside(folder, stage, made, axis) for stage in (VALIDATE, DIAGNOSE, EXTEND))
    percent = dict(fit.fit_percent)
    if validation is not None and name in validation.models:
        percent = {record: one.fit_percent for record, one in validation.models[name].records.items()}
    own = diagnosis is not None and diagnosis.model == fits.best
    summary = RunSummary(config.robot.name, name, percent)
    run = ComparedRun(fit, summary, made.provenance.inputs.get(COLLECT.name, ""))
    run = with_verdict(run, diagnosis) if own else run
    return run if extension is None or extension.model != name else with_gains(run, extension, extended=extended)


def with_verdict(run: ComparedRun, diagnosis: Diagnosis) -> ComparedRun:
    """A run with what its diagnosis found."""
    causes = tuple(cause.effect for cause in diagnosis.causes)
    return replace(run, summary=replace(run.summary, verdict=diagnosis.verdict, causes=causes))


def with_gains(run: ComparedRun, extension: Extension, *, extended: bool) -> ComparedRun:
    """A run with the gains of its extension, where that added anything. extended : with the extended model, too."""
    if not extension.added:
        return run
    both = [r for r in extension.after if r in extension.before and not extension.after[r].used]
    gains = {r: (extension.before[r].fit_percent, extension.after[r].fit_percent) for r in both}
    summary = replace(run.summary, gains=gains)
    if not extended:
        return replace(run, summary=summary)
    percent = {r: score.fit_percent for r, score in extension.after.items()}
    summary = replace(summary, model=f"{extension.model} extended", fit_percent=percent)
    return replace(run, fit=extension.fit, summary=summary)


def _beside(folder: Path, stage: Stage, model: Artifact[Fits], axis: str) -> Any:
    """The content of an artifact that was made from this model, None where there is none."""
    file = folder / stage.output
    header = read_headers(file).get(axis) if file.is_file() else None
    if header is None or header.provenance.inputs.get(FIT.name) != model.header.digest:
        return None
    return load(file, stage.type(), axis).content


def named(folders: Sequence[Path]) -> dict[str, Path]:
    """Runs by short names: those of their directories, or where these are alike the paths as given. Raises ConfigError
    for one that is given twice."""
    short = [folder.resolve().name for folder in folders]
    names = short if len(set(short)) == len(short) else [str(folder) for folder in folders]
    if len(set(names)) < len(names):
        raise ConfigError("a run is given twice", where="compare", hint="give each run once")
    return dict(zip(names, folders, strict=True))


def _remarks(runs: Mapping[str, ComparedRun]) -> Iterator[str]:
    """What makes a comparison doubtful, in sentences."""
    (first, reference), *others = runs.items()
    for name, run in others:
        if run.records and run.records == reference.records:
            yield f"{name} was fitted to the very records of {first}: their errors are not independent"
        differing = set(run.fit.structure.effects) ^ set(reference.fit.structure.effects)
        if differing:
            yield f"{name} and {first} are models of different effects ({', '.join(sorted(differing))})"
        if run.fit.structure.gear_ratio != reference.fit.structure.gear_ratio:
            yield f"{name} and {first} have different gear ratios"
    for name, run in runs.items():
        if not run.fit.converged:
            yield f"{name}: {run.fit.end.value}"
        yield from (f"{name}: {remark}" for remark in run.fit.remarks)
