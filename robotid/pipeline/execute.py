"""Walking over the table of stages: load what is needed, run, save, and leave alone what is fresh."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import Label, load, save, write_text
from robotid.errors import InputError, ThresholdError
from robotid.model.units import on_axis
from robotid.pipeline.freshness import StageStatus, State, judge
from robotid.pipeline.stage import Run, Stage, find
from robotid.pipeline.table import STAGES
from robotid.progress import Begun, Log

FRESH, FORCED = "fresh", "forced"  # reasons


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one stage.

    ran : False where it was fresh, or only asked about (dry). content : None when dry. interrupted : the content is
    what was reached, and does not count as done.
    """

    stage: str
    file: Path
    ran: bool
    why: str
    seconds: float = 0.0
    content: Any = None
    interrupted: bool = False


def status(run: Run, *, checked: bool = True) -> tuple[StageStatus, ...]:
    """State of every stage's artifact, in order. checked : a damaged one is not fresh; without, much faster."""
    found: dict[str, StageStatus] = {}
    for stage in STAGES.values():
        found[stage.name] = judge(run, stage, found, checked=checked)
    return tuple(found.values())


def execute(run: Run, name: str, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Outcome:
    """Run one stage unless it is fresh. log : told of what goes on.

    Raises InputError where an input is missing or stale, ThresholdError where the result is worse than demanded (it is
    saved all the same), and what the stage raises.
    """
    before = {s.stage: s for s in status(run, checked=False)}  # what is read is checked as it is loaded
    for needed in STAGES[name].inputs:
        _require_fresh(run, before[needed])
    before[name] = judge(run, STAGES[name], before)
    return _settle(run, STAGES[name], before, force=force, dry_run=dry_run, log=log)


def execute_all(run: Run, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Iterator[Outcome]:
    """Run every stage that is not fresh, in order, up to one that is interrupted. Raises as `execute` does."""
    before: dict[str, StageStatus] = {}
    would_run = False
    for stage in STAGES.values():
        if would_run:
            yield Outcome(stage.name, run.file(stage), False, "an earlier stage would run")
            continue
        before[stage.name] = judge(run, stage, before)
        outcome = _settle(run, stage, before, force=force, dry_run=dry_run, log=log)
        yield outcome
        if outcome.interrupted:
            return
        would_run = dry_run and outcome.why != FRESH
        if outcome.ran:
            before[stage.name] = judge(run, stage, before)


def _require_fresh(run: Run, needed: StageStatus) -> None:
    if needed.state is not State.FRESH:
        what = "is missing" if needed.state is State.ABSENT else f"is stale ({needed.why})"
        hint = f"run `{run.command(needed.stage)}` first, or `{run.command('run')}` for all"
        raise InputError(what, where=str(needed.file), hint=hint)


def _settle(
    run: Run, stage: Stage, before: Mapping[str, StageStatus], *, force: bool, dry_run: bool, log: Log | None
) -> Outcome:
    """Make a stage's artifact fresh. before : the state of this stage and of those before it."""
    now = before[stage.name]
    why = now.why or (FORCED if force else "")
    if dry_run:
        return Outcome(stage.name, now.file, False, why or FRESH)
    content = None
    if not why:
        try:
            content = load(now.file, stage.type()).content
        except InputError as error:  # this version wrote it when its layout was another
            why = error.what
    if why:
        labels = {name: label for name in stage.inputs if (label := before[name].label) is not None}
        outcome = _perform(run, stage, labels, why, log)
    else:
        outcome = Outcome(stage.name, now.file, False, FRESH, content=content)
        _put_beside(run, stage, content)
    return _judged(run, stage, outcome)


def _perform(run: Run, stage: Stage, labels: Mapping[str, Label], why: str, log: Log | None) -> Outcome:
    begin = time.perf_counter()
    if log is not None:
        log(Begun(stage.name))
    config = run.loaded.config
    contents: list[Any] = [load(run.file(STAGES[name]), STAGES[name].type()).content for name in stage.inputs]
    if stage.files:
        contents.append(_tables(run))
    content = stage(config, *contents, **({"log": log} if stage.logs else {}))
    made = Provenance(
        stage.name,
        run.public_command(stage.name),
        run.sections(stage),
        run.inputs(stage, labels),
        run.loaded.resolved_text(),
        seed=config.plant.seed if config.plant is not None else None,
        interrupted=bool(getattr(content, "interrupted", False)),
    )
    _put_beside(run, stage, content)
    save(run.file(stage), content, made, on_axis(linear=config.robot.linear))
    seconds = time.perf_counter() - begin
    return Outcome(stage.name, run.file(stage), True, why, seconds, content, made.interrupted)


def _put_beside(run: Run, stage: Stage, content: Any) -> None:
    """Write the text that goes beside an artifact, unless it is there as it is to be: it may hold more of the
    configuration than the stage depends on."""
    if stage.beside is None:
        return
    name, function = stage.beside
    file, text = run.out / name, find(function)(run.loaded, content, run.out)
    if not file.exists() or file.read_bytes() != text.encode():
        write_text(file, text)


def _tables(run: Run) -> dict[str, Any]:
    """The measured files as tables, by record."""
    read = find("robotid.signals.readers:read")
    tables = {path: read(path) for path in dict.fromkeys(run.measured().values())}
    return {record: tables[path] for record, path in run.measured().items()}


def _judged(run: Run, stage: Stage, outcome: Outcome) -> Outcome:
    """The outcome, unless it is worse than the configuration demands.

    make asks by time: what is done is new from here on, and what is not is older than its inputs.
    """
    failed = getattr(outcome.content, "failed", ())
    if failed or outcome.interrupted:
        before = min((run.file(STAGES[name]).stat().st_mtime for name in stage.inputs), default=1.0) - 1.0
        os.utime(outcome.file, (before, before))
    else:
        os.utime(outcome.file)
    if failed:
        raise ThresholdError("; ".join(failed), where=str(outcome.file), hint="see `robotid show` of it")
    return outcome
