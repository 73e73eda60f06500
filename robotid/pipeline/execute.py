"""Walking over the table of stages: load what is needed, run, save, and leave alone what is fresh.

A single joint is the one axis of its robot, and has no name. Of several axes each has its own state, and one that fails
does not keep the others from going on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from robotid.artifacts.layout import layout_digest
from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import ELSEWHERE, Made, load, load_axes, save, save_axes
from robotid.errors import ConfigError, InputError, RobotidError, ThresholdError
from robotid.files import atomic_write, touch
from robotid.interrupt import check
from robotid.model.units import on_axis
from robotid.pipeline.compute import Job, MeasuredTables, Work, compute
from robotid.pipeline.freshness import Before, StageStatus, State, judge
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.stage import Stage, find
from robotid.pipeline.table import STAGES
from robotid.progress import Begun, Log

FRESH, FORCED = "fresh", "forced"  # reasons
AFTER_ANOTHER = "an earlier stage would run"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one stage.

    ran : False where it was fresh, or only asked about (dry). read : gives the content, None when dry. interrupted :
    the content is what was reached, and does not count as done. several : the content is a mapping by axis. failures :
    of several axes, those that failed, and why; the content is without them unless they missed a threshold.
    """

    stage: str
    file: Path
    ran: bool
    why: str
    seconds: float = 0.0
    read: Callable[[], Any] | None = None
    interrupted: bool = False
    several: bool = False
    failures: Mapping[str, RobotidError] = field(default_factory=dict)

    @property
    def content(self) -> Any:
        """The content, read from the file at the first call where the stage did not run; None when dry."""
        return None if self.read is None else self.read()

    @property
    def contents(self) -> Mapping[str, Any]:
        """The content of each axis, "" for a single joint; nothing when dry."""
        if self.several:
            return self.content or {}
        return {"": self.content} if self.read is not None else {}


def reader(run: Runs, stage: Stage, axes: Iterable[str] | None = None) -> Callable[[], Any]:
    """A function that loads a stage's content when it is first called; of several axes by axis. axes : which ones, by
    default all."""
    chosen = list(run.axes if axes is None else axes)
    return cache(lambda: _loaded(run, stage, chosen) if run.several else _loaded(run, stage, chosen)[""])


def status(run: Runs) -> tuple[StageStatus, ...]:
    """State of every stage's artifact, in order, and of each axis in it."""
    found: dict[str, dict[str, StageStatus]] = {axis: {} for axis in run.axes}
    for stage in STAGES.values():
        _note(found, judge(run, stage, found))
    return tuple(found[axis][stage] for stage in STAGES for axis in run.axes)


def _note(before: Mapping[str, dict[str, StageStatus]], states: Mapping[str, StageStatus]) -> None:
    for axis, state in states.items():
        before[axis][state.stage] = state


def execute(run: Runs, name: str, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Outcome:
    """Run one stage unless it is fresh. log : gets the events of the run.

    Raises InputError where an input is missing or stale, ThresholdError where the result is worse than demanded (it is
    saved all the same), and what the stage raises; of several axes only where all of them fail.
    """
    stage, before = STAGES[name], _by_axis(status(run))
    for axis, joint in run.axes.items():
        for needed in joint.needs(stage):
            _require_fresh(run, before[axis][needed])
    whys = {axis: _why_run(stage, before[axis][name], force=force) for axis in run.axes}
    return _make_fresh(run, stage, before, whys, dry_run=dry_run, log=log)


def _by_axis(found: tuple[StageStatus, ...]) -> dict[str, dict[str, StageStatus]]:
    states: dict[str, dict[str, StageStatus]] = {}
    for one in found:
        states.setdefault(one.axis, {})[one.stage] = one
    return states


def execute_all(run: Runs, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Iterator[Outcome]:
    """Run every stage that is not fresh, in order, up to one that is interrupted. An axis that fails is left at the
    stage that it failed in. Raises as `execute` does."""
    before: dict[str, dict[str, StageStatus]] = {axis: {} for axis in run.axes}
    would_run, something_runs = False, any(s.state is not State.FRESH for s in status(run))
    active = dict.fromkeys(run.axes)
    for stage in STAGES.values():
        if would_run:
            yield Outcome(stage.name, run.file(stage), False, AFTER_ANOTHER, several=run.several)
            continue
        _note(before, judge(run, stage, before))
        is_read = something_runs or stage.after_run != "never"
        whys = {axis: _why_run(stage, before[axis][stage.name], force=force, is_read=is_read) for axis in active}
        outcome = _make_fresh(run, stage, before, whys, dry_run=dry_run, log=log)
        yield outcome
        if outcome.interrupted:
            return
        would_run = dry_run and outcome.why != FRESH
        active = {axis: None for axis in active if axis not in outcome.failures}
        if not active:
            return
        if outcome.ran:
            _note(before, judge(run, stage, before))


def _require_fresh(run: Runs, needed: StageStatus) -> None:
    if needed.state is not State.FRESH:
        what = "is missing" if needed.state is State.ABSENT else f"is stale ({needed.why})"
        hint = f"run `{run.command(needed.stage)}` first, or `{run.command('run')}` for all"
        where = f"{needed.file}, axis {needed.axis}" if needed.axis else str(needed.file)
        raise InputError(what, where=where, hint=hint)


def _why_run(stage: Stage, now: StageStatus, *, force: bool, is_read: bool = True) -> str:
    """Why a stage has to run, empty where its artifact is fresh. is_read : somebody will read the content, so that it
    must have the layout of its class: while a version is being written its number stays, but not its classes."""
    if now.why or force:
        return now.why or FORCED
    if is_read and now.header is not None and now.header.layout != layout_digest(stage.type()):
        return "of another version"
    return ""


def _make_fresh(
    run: Runs, stage: Stage, before: Before, whys: Mapping[str, str], *, dry_run: bool, log: Log | None
) -> Outcome:
    """Make a stage's artifact fresh. before : the states of this stage and of those before it. whys : for the axes that
    are to be fresh, why the stage has to run, empty where it is fresh."""
    file, due = run.file(stage), [axis for axis, why in whys.items() if why]
    if dry_run:
        return Outcome(stage.name, file, False, _joined(whys) or FRESH, several=run.several)
    if due:
        outcome, failed = _run(run, stage, due, before, _joined(whys), log)
    else:
        read, failed = reader(run, stage, whys), {}
        outcome = Outcome(stage.name, file, False, FRESH, read=read, several=run.several)
        _write_companion(run, stage, outcome)
    for axis in whys.keys() - set(due):
        header = before[axis][stage.name].header
        failed |= {axis: header.provenance.failed} if header is not None else {}
    if due and run.several:
        outcome = replace(outcome, read=_with_fresh(run, stage, outcome, [axis for axis in whys if axis not in due]))
    return _judged(run, stage, outcome, {axis: missed for axis, missed in failed.items() if missed})


def _joined(whys: Mapping[str, str]) -> str:
    """The reasons of all axes as one."""
    axes: dict[str, list[str]] = {}
    for axis, why in whys.items():
        if why:
            axes.setdefault(why, []).append(axis)
    if len(axes) == 1 and len(next(iter(axes.values()))) == len(whys):
        return next(iter(axes))
    return "; ".join(f"{', '.join(names)}: {why}" for why, names in axes.items())


def _with_fresh(run: Runs, stage: Stage, outcome: Outcome, fresh: list[str]) -> Callable[[], Any]:
    """The contents of all axes: those that were made, and those that were fresh."""
    made, order = outcome.content, run.axes

    @cache
    def read() -> Any:
        every = made | (_loaded(run, stage, fresh) if fresh else {})
        return {axis: every[axis] for axis in order if axis in every}

    return read


def _run(
    run: Runs, stage: Stage, due: list[str], before: Before, why: str, log: Log | None
) -> tuple[Outcome, dict[str, tuple[str, ...]]]:
    """The outcome of running a stage for the axes that are due, and the demands that they fail."""
    begin = time.perf_counter()
    check()
    if log is not None:
        log(Begun(stage.name))
    work = Work(stage, _jobs(run, stage, due), run.command("check"))
    contents: dict[str, Any] = {}
    made: dict[str, Made] = {}
    failures: dict[str, RobotidError] = {}
    read: Callable[[], Any] = lambda: contents if run.several else contents[""]  # noqa: E731
    outcome = Outcome(stage.name, run.file(stage), True, why, 0.0, read, several=run.several, failures=failures)
    try:
        for axis, content in compute(work, log):
            if isinstance(content, RobotidError):
                failures[axis] = content
                continue
            contents[axis] = content
            made[axis] = _made(run.axes[axis], stage, content, before[axis])
    finally:
        if made:
            outcome = replace(outcome, interrupted=any(one.provenance.interrupted for one in made.values()))
            _write_companion(run, stage, outcome)
            _save(run, stage, made)
    if len(failures) == len(run.axes):
        raise one_error(failures)
    failed = {axis: one.provenance.failed for axis, one in made.items()}
    return replace(outcome, seconds=time.perf_counter() - begin), failed


def _jobs(run: Runs, stage: Stage, due: list[str]) -> dict[str, Job]:
    """What the stage takes of each axis; every file is read once."""
    needs = {axis: run.axes[axis].needs(stage) for axis in due}
    inputs: dict[str, list[Any]] = {axis: [] for axis in due}
    for name in stage.inputs:
        needing = [axis for axis in due if name in needs[axis]]
        found = _loaded(run, STAGES[name], needing) if needing else {}
        for axis in due:
            inputs[axis].append(found.get(axis))
    if stage.reads_files:
        tables = MeasuredTables(run.axes[due[0]].measured(), keep=len(due) > 1)
        for axis in due:
            inputs[axis].append(tables)
    return {axis: Job(run.axes[axis].loaded.config, tuple(contents)) for axis, contents in inputs.items()}


def _loaded(run: Runs, stage: Stage, axes: list[str]) -> dict[str, Any]:
    file = run.file(stage)
    if not run.several:
        return {"": load(file, stage.type()).content}
    return {axis: one.content for axis, one in load_axes(file, stage.type(), axes).items()}


def _made(run: Run, stage: Stage, content: Any, before: Mapping[str, StageStatus]) -> Made:
    """The content of one axis with all that is known of where it comes from."""
    config = run.loaded.config
    headers = {name: header for name in run.needs(stage) if (header := before[name].header) is not None}
    provenance = Provenance(
        stage.name,
        run.public_command(stage.name),
        run.sections(stage),
        run.inputs(stage, headers),
        run.loaded.resolved_text(),
        seed=config.plant.seed if config.plant is not None else None,
        interrupted=bool(getattr(content, "interrupted", False)),
        failed=tuple(getattr(content, "failed", ())),
    )
    return Made(content, provenance, on_axis(linear=config.robot.linear))


def _save(run: Runs, stage: Stage, made: Mapping[str, Made]) -> None:
    if run.several:
        save_axes(run.file(stage), made, run.names)
    else:
        save(run.file(stage), made[""].content, made[""].provenance, made[""].units)


def _write_companion(run: Runs, stage: Stage, outcome: Outcome) -> None:
    """Write the text that goes with an artifact, unless it is there as it is to be: it may hold more of the
    configuration than the stage depends on."""
    if stage.companion is None:
        return
    file, content = run.out / stage.companion.output, outcome.content
    if run.several:
        content = _others(run, stage, content) | content
    text = find(stage.companion.function)(run.loaded, content, run.out)
    if not file.exists() or file.read_bytes() != text.encode():
        atomic_write(file, text, hint=ELSEWHERE)


def _others(run: Runs, stage: Stage, but: Mapping[str, Any]) -> dict[str, Any]:
    """What an artifact holds of other axes, as far as it can be read."""
    found = {}
    for axis in run.names:
        with suppress(InputError, ConfigError):
            if axis not in but:
                found[axis] = load(run.file(stage), stage.type(), axis).content
    return found


def _judged(run: Runs, stage: Stage, outcome: Outcome, missed: Mapping[str, tuple[str, ...]]) -> Outcome:
    """The outcome, with the axes that are worse than the configuration demands among its failures.

    make compares times of files: what is done is new from here on, and what is not is older than its inputs.
    """
    missing = {axis: _missing(stage, outcome.file, axis, sentences) for axis, sentences in missed.items()}
    outcome = replace(outcome, failures={**outcome.failures, **missing})
    if not outcome.file.exists():
        return outcome
    if outcome.failures or outcome.interrupted:
        needed = {name for joint in run.axes.values() for name in joint.needs(stage)}
        touch(outcome.file, min((run.file(STAGES[name]).stat().st_mtime for name in needed), default=1.0) - 1.0)
    else:
        touch(outcome.file)
    if missing and len(outcome.failures) == len(run.axes):
        raise one_error(outcome.failures)
    return outcome


def _missing(stage: Stage, file: Path, axis: str, sentences: tuple[str, ...]) -> ThresholdError:
    return ThresholdError("; ".join(sentences), where=str(file), hint="see `robotid show` of it")


def one_error(failures: Mapping[str, RobotidError]) -> RobotidError:
    """The errors of all axes as one, of the kind of the first."""
    first = next(iter(failures.values()))
    if "" in failures:
        return first
    if len(failures) == 1:
        where = ": ".join(filter(None, (f"axis {next(iter(failures))}", first.where)))
        return type(first)(first.what, where=where, hint=first.hint)
    return type(first)("; ".join(f"axis {axis}: {error}" for axis, error in failures.items()))
