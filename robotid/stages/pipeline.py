"""The one table of stages, and walking over it: load, run, save, tell what is fresh.

A stage is fresh when its artifact was made by this version from the same configuration and the same input content. Times
of files do not matter, so a copied run directory stays fresh and a touched one does too.
"""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from robotid import __version__
from robotid.artifacts.provenance import digest, provenance
from robotid.artifacts.store import Artifact, Label, load, peek, save
from robotid.config.load import Loaded
from robotid.errors import InputError, ThresholdError
from robotid.model.units import sliding

Log = Callable[..., None]


@dataclass(frozen=True, slots=True)
class Stage:
    """One row. inputs : stages whose content the function takes, after the configuration; sections : of the configuration
    that it reads; function, content : where they are, imported when needed; files : it takes the measured files too;
    logs : it takes a callable that is told of every iteration."""

    name: str
    output: str
    function: str
    content: str
    inputs: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    files: bool = False
    logs: bool = False

    def type(self) -> type[Any]:
        """Class of the content."""
        kind: type[Any] = _find(self.content)
        return kind


STAGES: dict[str, Stage] = {
    stage.name: stage
    for stage in (
        Stage(
            "excite",
            "excitation.h5",
            "robotid.stages.excite:excite",
            "robotid.signals.reference:Excitation",
            sections=("robot", "records", "plant"),
        ),
        Stage(
            "collect",
            "records.h5",
            "robotid.stages.collect:collect",
            "robotid.signals.quality:Recordings",
            inputs=("excite",),
            sections=("robot", "records", "plant"),
            files=True,
        ),
        Stage(
            "init-rigid",
            "rigid.h5",
            "robotid.stages.init_rigid:init_rigid",
            "robotid.estimate.rigid:RigidResult",
            inputs=("collect",),
            sections=("robot", "init_rigid"),
        ),
        Stage(
            "init-flex",
            "flex.h5",
            "robotid.stages.init_flex:init_flex",
            "robotid.estimate.flexible:FlexResult",
            inputs=("collect", "init-rigid"),
            sections=("robot", "init_flex"),
        ),
        Stage(
            "fit",
            "model.h5",
            "robotid.stages.fit:fit",
            "robotid.estimate.result:Fits",
            inputs=("collect", "init-rigid", "init-flex"),
            sections=("robot", "fit"),
            logs=True,
        ),
        Stage(
            "validate",
            "validation.h5",
            "robotid.stages.validate:validate",
            "robotid.judge.validation:Validation",
            inputs=("collect", "init-rigid", "init-flex", "fit"),
            sections=("robot", "plant", "controller", "fit", "validate"),
        ),
    )
}


class State(StrEnum):
    """What an artifact is worth."""

    FRESH = "fresh"
    STALE = "stale"
    ABSENT = "absent"


@dataclass(frozen=True, slots=True)
class StageStatus:
    """State of one stage's artifact, and why it is not fresh."""

    stage: str
    file: Path
    state: State
    why: str = ""
    label: Label | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one stage. ran : False where it was fresh, or only asked about (dry). content : None when dry."""

    stage: str
    file: Path
    ran: bool
    why: str
    seconds: float = 0.0
    content: Any = None
    interrupted: bool = False


@dataclass(slots=True)
class Run:
    """A configuration and its run directory. Digests of measured files are worked out once."""

    loaded: Loaded
    out: Path
    _files: dict[str, str] = field(default_factory=dict)

    def file(self, stage: Stage) -> Path:
        """Where a stage's artifact is."""
        return self.out / stage.output

    def sections(self, stage: Stage) -> dict[str, str]:
        """The configuration that a stage depends on, as canonical text."""
        return {name: self.loaded.section_text(name) for name in stage.sections}

    def measured(self) -> dict[str, Path]:
        """Measured files by record name."""
        return {r.name: self.loaded.directory / r.file for r in self.loaded.config.records if r.file is not None}

    def inputs(self, stage: Stage, labels: Mapping[str, Label]) -> dict[str, str]:
        """Digests of all that a stage reads. labels : of the stages before it."""
        found = {name: labels[name].digest for name in stage.inputs if name in labels}
        if stage.files:
            found |= {f"file {path.name}": self._file_digest(path) for path in self.measured().values()}
        return found

    def _file_digest(self, path: Path) -> str:
        if str(path) not in self._files:
            try:
                self._files[str(path)] = digest(path.read_bytes())
            except OSError as error:
                raise InputError(f"cannot be read: {error.strerror}", where=str(path), hint="check `file` of the record") from error
        return self._files[str(path)]


def status(run: Run) -> tuple[StageStatus, ...]:
    """State of every stage, in order."""
    return tuple(_statuses(run))


def _statuses(run: Run) -> Iterator[StageStatus]:
    labels: dict[str, Label] = {}
    for stage in STAGES.values():
        found = _status(run, stage, labels)
        if found.state is State.FRESH and found.label is not None:
            labels[stage.name] = found.label
        yield found


def _status(run: Run, stage: Stage, labels: Mapping[str, Label]) -> StageStatus:
    file = run.file(stage)
    if not file.is_file():
        return StageStatus(stage.name, file, State.ABSENT, "not made yet")
    try:
        label = peek(file)
        why = _why_stale(run, stage, label, labels)
    except InputError as error:
        return StageStatus(stage.name, file, State.STALE, error.what)
    return StageStatus(stage.name, file, State.STALE if why else State.FRESH, why, label)


def _why_stale(run: Run, stage: Stage, label: Label, labels: Mapping[str, Label]) -> str:
    made = label.provenance
    missing = [name for name in stage.inputs if name not in labels]
    if missing:
        return f"{STAGES[missing[0]].output} is not fresh"
    if made.version != __version__:
        return f"made by version {made.version}"
    if "interrupted" in made.sections:
        return "its run was interrupted"
    sections, inputs = run.sections(stage), run.inputs(stage, labels)
    changed = [name for name in sections if made.sections.get(name) != sections[name]]
    if changed:
        return f"configuration changed: {', '.join(changed)}"
    renewed = [name for name in sorted(inputs.keys() | made.inputs.keys()) if made.inputs.get(name) != inputs.get(name)]
    if renewed:
        return f"{STAGES[renewed[0]].output if renewed[0] in STAGES else renewed[0]} changed"
    return ""


def execute(run: Run, name: str, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Outcome:
    """Run one stage unless it is fresh. Raises InputError where an input is missing or stale."""
    before = {s.stage: s for s in status(run)}
    stage, now = STAGES[name], before[name]
    for needed in stage.inputs:
        if before[needed].state is not State.FRESH:
            what = "is missing" if before[needed].state is State.ABSENT else f"is stale ({before[needed].why})"
            hint = f"run `robotid {needed} {run.loaded.path}` first, or `robotid run {run.loaded.path}` for all"
            raise InputError(what, where=str(before[needed].file), hint=hint)
    if now.state is State.FRESH and not force:
        if dry_run:
            return Outcome(name, now.file, False, "fresh")
        os.utime(now.file)  # make asks by time: what is fresh by content is so by time from here on
        return _judged(Outcome(name, now.file, False, "fresh", content=load(now.file, stage.type()).content))
    why = now.why or "forced"
    if dry_run:
        return Outcome(name, now.file, False, why)
    labels = {needed: before[needed].label for needed in stage.inputs}
    return _judged(_perform(run, stage, {k: v for k, v in labels.items() if v is not None}, why, log))


def execute_all(
    run: Run, *, force: bool = False, dry_run: bool = False, log: Log | None = None, told: Callable[[str], None] | None = None
) -> Iterator[Outcome]:
    """Run every stage that is not fresh, in order. told : called with a stage's name before it starts."""
    stale = False
    for name in STAGES:
        if dry_run and stale:
            yield Outcome(name, run.file(STAGES[name]), False, "an earlier stage would run")
            continue
        if told is not None:
            told(name)
        outcome = execute(run, name, force=force, dry_run=dry_run, log=log)
        stale = stale or (dry_run and outcome.why != "fresh")
        yield outcome
        if outcome.interrupted:
            return


def _perform(run: Run, stage: Stage, labels: Mapping[str, Label], why: str, log: Log | None) -> Outcome:
    begin = time.perf_counter()
    config = run.loaded.config
    arguments: list[Any] = [load(run.file(STAGES[name]), STAGES[name].type()).content for name in stage.inputs]
    options: dict[str, Any] = {"log": log} if stage.logs else {}
    if stage.files:
        arguments.append(_tables(run))
    content = _find(stage.function)(config, *arguments, **options)
    interrupted = bool(getattr(content, "interrupted", False))
    sections = run.sections(stage) | ({"interrupted": "yes"} if interrupted else {})
    seed = config.plant.seed if config.plant is not None else None
    made = provenance(stage.name, sections, run.inputs(stage, labels), run.loaded.resolved_text(), seed)
    units = sliding if config.robot.linear else str
    save(run.file(stage), Artifact(content, made), units)
    return Outcome(stage.name, run.file(stage), True, why, time.perf_counter() - begin, content, interrupted)


def _tables(run: Run) -> dict[str, Any]:
    read = _find("robotid.signals.readers:read")
    return {name: read(path) for name, path in run.measured().items()}


def _judged(outcome: Outcome) -> Outcome:
    failed = getattr(outcome.content, "failed", ())
    if failed:
        raise ThresholdError("; ".join(failed), where=str(outcome.file), hint="see `robotid show` of it")
    return outcome


def _find(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
