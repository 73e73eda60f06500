"""The command export: a fitted model, signals or frequency responses in the files of other programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotid.artifacts.store import Label, load, read_header
from robotid.cli.console import say
from robotid.config.load import parse
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.result import FitResult, Fits
from robotid.export.linear_model import model_tree, parameter_columns
from robotid.export.responses import response_columns
from robotid.export.signals import signal_columns
from robotid.export.write import Columns, check_format, write_columns, write_tree
from robotid.pipeline.table import STAGES
from robotid.signals.quality import Recordings

EXPORTED = ("fit", "collect", "init-flex")


@dataclass(frozen=True, slots=True)
class _Source:
    """An artifact, and what was asked of it."""

    file: Path
    label: Label
    content: Any
    config: Config
    model: str | None
    record: str | None


def export_artifact(file: Path, to: Path, *, model: str | None, record: str | None, speed: float) -> None:
    """Write what an artifact holds. Raises ConfigError for an artifact, a format or a name that cannot be exported."""
    check_format(to)
    label = read_header(file)
    stage = label.provenance.stage
    if stage not in EXPORTED:
        known = ", ".join(STAGES[name].output for name in EXPORTED)
        raise ConfigError(f"nothing is exported of what {stage} makes", where=str(file), hint=f"give {known}")
    content = load(file, STAGES[stage].type()).content
    source = _Source(file, label, content, parse(label.provenance.configuration), model, record)
    if stage == "fit":
        _model(source, to, speed)
    else:
        _tables(source, to, _signals(source) if stage == "collect" else _responses(source))


def _model(source: _Source, to: Path, speed: float) -> None:
    fit = _fit(source.content, source.model, source.file)
    if to.suffix.lower() == ".csv":
        write_columns(to, parameter_columns(fit))
    else:
        write_tree(to, model_tree(fit, speed, _sampling_times(source, fit)))
    say(f"{to} written: model {fit.name}")


def _sampling_times(source: _Source, fit: FitResult) -> dict[str, float]:
    """Of the records of a fit, where they still lie beside it."""
    file = source.file.with_name(STAGES["collect"].output)
    if not file.exists() or read_header(file).digest != source.label.provenance.inputs.get("collect"):
        return {}
    return {r.name: r.sampling_time for r in load(file, Recordings).content.records if r.name in fit.records}


def _fit(fits: Fits, name: str | None, file: Path) -> FitResult:
    return fits.models[_known(name or fits.best, fits.models, "model", file)]


def _signals(source: _Source) -> dict[str, Columns]:
    """Signals of each record, with those of the model beside it where that was fitted to these records."""
    found = {r.name: r for r in source.content.records}
    fit = _fit_beside(source)
    free = source.config.fit.initial_states == "free"
    model = None if fit is None else fitted_model(fit, estimate_states=free)
    tables = {}
    for name in _wanted(source, found):
        try:
            tables[name] = signal_columns(found[name], model, linear=source.config.robot.linear)
        except NumericsError as error:
            say(f"{name}: {error.what}; its measured signals alone are written")
            tables[name] = signal_columns(found[name], None, linear=source.config.robot.linear)
    return tables


def _fit_beside(source: _Source) -> FitResult | None:
    file = source.file.with_name(STAGES["fit"].output)
    if not file.exists() and source.model is None:
        say(f"there is no {file.name} beside it: measured signals alone are written")
        return None
    made = load(file, Fits)
    if made.provenance.inputs.get("collect") != source.label.digest:
        what = f"its models were fitted to other records than {source.file.name} holds"
        raise ConfigError(what, where=str(file), hint="run its stage again")
    return _fit(made.content, source.model, file)


def _responses(source: _Source) -> dict[str, Columns]:
    found = {frf.record: frf for frf in source.content.frfs}
    if not found:
        raise ConfigError("it holds no frequency response", where=str(source.file), hint="a rigid axis has none")
    linear = source.config.robot.linear
    return {name: response_columns(found[name], linear=linear) for name in _wanted(source, found)}


def _wanted(source: _Source, found: Mapping[str, Any]) -> list[str]:
    return list(found) if source.record is None else [_known(source.record, found, "record", source.file)]


def _known(name: str, found: Mapping[str, Any], what: str, file: Path) -> str:
    if name not in found:
        raise ConfigError(f'there is no {what} "{name}"', where=str(file), hint=suggest(name, found))
    return name


def _tables(source: _Source, to: Path, tables: Mapping[str, Columns]) -> None:
    """All in one file, but as CSV a file each, where there are several: TO_RECORD.csv."""
    if to.suffix.lower() != ".csv":
        write_tree(to, {name: _fields(columns) for name, columns in tables.items()})
        say(f"{to} written: {', '.join(tables)}")
        return
    for name, columns in tables.items():
        file = to if len(tables) == 1 else to.with_name(f"{to.stem}_{name}{to.suffix}")
        write_columns(file, columns)
        say(f"{file} written")


def _fields(columns: Columns) -> dict[str, Any]:
    """Columns as fields without their units, and the units beside them."""
    split = {head.partition(" [")[0]: head.partition(" [")[2].rstrip("]") for head in columns}
    values = dict(zip(split, columns.values(), strict=True))
    return {**values, "units": split}
