"""What the stages offer to other programs: a function a content, named by the stage's row in the table."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotid.artifacts.store import ArtifactHeader, load, read_header
from robotid.config.load import parse
from robotid.config.schema import Config
from robotid.config.suggest import suggest
from robotid.errors import ConfigError, NumericsError
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.result import FitResult, Fits
from robotid.export.handover.handed_model import HandedModel
from robotid.export.linear_model import model_tree, parameter_columns
from robotid.export.responses import response_columns
from robotid.export.signals import signal_columns
from robotid.export.write import Columns, Tree
from robotid.pipeline.stage import find
from robotid.pipeline.table import COLLECT, FIT, STAGES
from robotid.signals.quality import Recordings
from robotid.signals.record import Record


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be exported. model, record : one of several, absent: the best model, all records. speed [rad/s] : of
    the motor, about which a model is linearised. remark : gets a sentence on what is left out. to : file that is
    written; joint, into : of a model that is handed over, the name of the joint in the other program, and text of the
    file that is to have it; axis : of a robot of several, empty for a single joint."""

    model: str | None
    record: str | None
    speed: float
    remark: Callable[[str], None]
    to: Path = Path("joint")
    joint: str = ""
    into: str = ""
    axis: str = ""


@dataclass(frozen=True, slots=True)
class Export:
    """What is offered. summary : of all of it; tree : for MATLAB and JSON; columns : for CSV, a file each; handed : a
    model as it is handed over to other programs, None where there is none."""

    summary: str
    tree: Callable[[], Tree]
    columns: Mapping[str, Columns]
    handed: Callable[[], HandedModel] | None = None


@dataclass(frozen=True, slots=True)
class Source:
    """An artifact, and what is wanted of it."""

    file: Path
    header: ArtifactHeader
    content: Any
    config: Config
    wanted: Wanted


def export_of(file: Path, wanted: Wanted) -> Export:
    """What an artifact offers. Raises ConfigError where that is nothing, or a name is not in it."""
    header = read_header(file, wanted.axis)
    stage = STAGES.get(header.provenance.stage)
    if stage is None or not stage.export:
        known = ", ".join(s.output for s in sorted(STAGES.values(), key=lambda s: s is not FIT) if s.export)
        what = f"nothing is exported of what {header.provenance.stage} makes"
        raise ConfigError(what, where=str(file), hint=f"give {known}")
    content = load(file, stage.type(), wanted.axis).content
    found: Export = find(stage.export)(Source(file, header, content, parse(header.provenance.configuration), wanted))
    return found


def model(source: Source) -> Export:
    """A fitted model: its linearisation and parameters, as columns the parameters alone."""
    return _model(source, _fit(source.content, source.wanted.model, source.file))


def extended_model(source: Source) -> Export:
    """The same of the model with its causes."""
    if source.wanted.model not in (None, source.content.model):
        _known(source.wanted.model or "", {source.content.model: None}, "model", source.file)
    return _model(source, source.content.fit)


def _model(source: Source, fit: FitResult) -> Export:
    return Export(
        f"model {fit.name}",
        lambda: model_tree(fit, source.wanted.speed, {r.name: r.sampling_time for r in _records(source, fit)}),
        {fit.name: parameter_columns(fit)},
        lambda: _handed(source, fit),
    )


def _handed(source: Source, fit: FitResult) -> HandedModel:
    """A model with the records that it can be simulated on."""
    wanted, config = source.wanted, source.config
    records = _records(source)
    if not records:
        what = f"there is no {COLLECT.output} beside {source.file.name} that it was made from"
        wanted.remark(f"{what}: what the file lacks is listed, its cost is not simulated")
    chosen = [r for r in records if wanted.record in (None, r.name)]
    if wanted.record is not None and not chosen:
        _known(wanted.record, {r.name: r for r in records}, "record", source.file)
    return HandedModel(
        robot=config.robot.name,
        fit=fit,
        estimate_states=config.fit.initial_states == "free",
        records=tuple(chosen),
        joint_name=wanted.joint,
        file_stem=re.sub(r"\W", "_", wanted.to.stem) or "joint",
        patched=wanted.into,
    )


def signals(source: Source) -> Export:
    """Signals of each record, with those of the model beside it where that was fitted to these records."""
    records = {r.name: r for r in source.content.records}
    fit = _fit_beside(source)
    free, linear = source.config.fit.initial_states == "free", source.config.robot.linear
    fitted = None if fit is None else fitted_model(fit, estimate_states=free)
    tables: dict[str, Columns] = {}
    for name in _chosen(source, records):
        try:
            tables[name] = signal_columns(records[name], fitted, linear=linear)
        except NumericsError as error:
            source.wanted.remark(f"{name}: {error.what}; its measured signals alone are written")
            tables[name] = signal_columns(records[name], None, linear=linear)
    return _by_record(tables)


def responses(source: Source) -> Export:
    """Measured frequency responses."""
    frfs = {frf.record: frf for frf in source.content.frfs}
    if not frfs:
        raise ConfigError("it holds no frequency response", where=str(source.file), hint="a rigid axis has none")
    linear = source.config.robot.linear
    return _by_record({name: response_columns(frfs[name], linear=linear) for name in _chosen(source, frfs)})


def _by_record(tables: Mapping[str, Columns]) -> Export:
    return Export(", ".join(tables), lambda: {name: _fields(columns) for name, columns in tables.items()}, tables)


def _fields(columns: Columns) -> dict[str, Any]:
    """Columns as fields without their units, and the units beside them."""
    units = {head.partition(" [")[0]: head.partition(" [")[2].rstrip("]") for head in columns}
    return {**dict(zip(units, columns.values(), strict=True)), "units": units}


def _records(source: Source, fit: FitResult | None = None) -> tuple[Record, ...]:
    """The records, or those of a fit, where they still lie beside it."""
    file = source.file.with_name(COLLECT.output)
    axis = source.wanted.axis
    if not file.exists() or read_header(file, axis).digest != source.header.provenance.inputs.get(COLLECT.name):
        return ()
    return tuple(r for r in load(file, Recordings, axis).content.records if fit is None or r.name in fit.records)


def _fit(fits: Fits, name: str | None, file: Path) -> FitResult:
    return fits.models[_known(name or fits.best, fits.models, "model", file)]


def _fit_beside(source: Source) -> FitResult | None:
    file = source.file.with_name(FIT.output)
    if not file.exists() and source.wanted.model is None:
        source.wanted.remark(f"there is no {file.name} beside it: measured signals alone are written")
        return None
    made = load(file, Fits, source.wanted.axis)
    if made.provenance.inputs.get(COLLECT.name) != source.header.digest:
        what = f"its models were fitted to other records than {source.file.name} holds"
        raise ConfigError(what, where=str(file), hint="run its stage again")
    return _fit(made.content, source.wanted.model, file)


def _chosen(source: Source, found: Mapping[str, Any]) -> list[str]:
    record = source.wanted.record
    return list(found) if record is None else [_known(record, found, "record", source.file)]


def _known(name: str, found: Mapping[str, Any], what: str, file: Path) -> str:
    if name not in found:
        raise ConfigError(f'there is no {what} "{name}"', where=str(file), hint=suggest(name, found))
    return name
