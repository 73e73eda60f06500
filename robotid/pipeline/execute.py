"""Walking over the table of stages: load what is needed, run, save, and leave alone what is fresh."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from robotid.artifacts.layout import layout_digest
from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import ELSEWHERE, ArtifactHeader, load, save
from robotid.errors import InputError, NumericsError, ThresholdError
from robotid.files import atomic_write, touch
from robotid.interrupt import check
from robotid.model.units import on_axis
from robotid.parallel import one_thread
from robotid.pipeline.freshness import StageStatus, State, judge
from robotid.pipeline.run import Run
from robotid.pipeline.stage import Stage, find
from robotid.pipeline.table import STAGES
from robotid.progress import Begun, Log, Progress, Step

FRESH, FORCED = "fresh", "forced"  # reasons
AFTER_ANOTHER = "an earlier stage would run"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one stage.

    ran : False where it was fresh, or only asked about (dry). read : gives the content, None when dry. interrupted :
    the content is what was reached, and does not count as done.
    """

    stage: str
    file: Path
    ran: bool
    why: str
    seconds: float = 0.0
    read: Callable[[], Any] | None = None
    interrupted: bool = False

    @property
    def content(self) -> Any:
        """The content, read from the file at the first call where the stage did not run; None when dry."""
        return None if self.read is None else self.read()


def reader(run: Run, stage: Stage) -> Callable[[], Any]:
    """A function that loads a stage's content when it is first called."""
    return cache(lambda: load(run.file(stage), stage.type()).content)


def status(run: Run) -> tuple[StageStatus, ...]:
    """State of every stage's artifact, in order."""
    found: dict[str, StageStatus] = {}
    for stage in STAGES.values():
        found[stage.name] = judge(run, stage, found)
    return tuple(found.values())


def execute(run: Run, name: str, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Outcome:
    """Run one stage unless it is fresh. log : gets the events of the run.

    Raises InputError where an input is missing or stale, ThresholdError where the result is worse than demanded (it is
    saved all the same), and what the stage raises.
    """
    before = {s.stage: s for s in status(run)}
    for needed in run.needs(STAGES[name]):
        _require_fresh(run, before[needed])
    why = _why_run(STAGES[name], before[name], force=force)
    return _make_fresh(run, STAGES[name], before, why, dry_run=dry_run, log=log)


def execute_all(run: Run, *, force: bool = False, dry_run: bool = False, log: Log | None = None) -> Iterator[Outcome]:
    """Run every stage that is not fresh, in order, up to one that is interrupted. Raises as `execute` does."""
    before: dict[str, StageStatus] = {}
    would_run, something_runs = False, any(s.state is not State.FRESH for s in status(run))
    for stage in STAGES.values():
        if would_run:
            yield Outcome(stage.name, run.file(stage), False, AFTER_ANOTHER)
            continue
        before[stage.name] = judge(run, stage, before)
        is_read = something_runs or stage.after_run != "never"
        why = _why_run(stage, before[stage.name], force=force, is_read=is_read)
        outcome = _make_fresh(run, stage, before, why, dry_run=dry_run, log=log)
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


def _why_run(stage: Stage, now: StageStatus, *, force: bool, is_read: bool = True) -> str:
    """Why a stage has to run, empty where its artifact is fresh. is_read : somebody will read the content, so that it
    must have the layout of its class: while a version is being written its number stays, but not its classes."""
    if now.why or force:
        return now.why or FORCED
    if is_read and now.header is not None and now.header.layout != layout_digest(stage.type()):
        return "of another version"
    return ""


def _make_fresh(
    run: Run, stage: Stage, before: Mapping[str, StageStatus], why: str, *, dry_run: bool, log: Log | None
) -> Outcome:
    """Make a stage's artifact fresh. before : the state of this stage and of those before it. why : it has to run."""
    now = before[stage.name]
    if dry_run:
        return Outcome(stage.name, now.file, False, why or FRESH)
    if why:
        headers = {name: header for name in run.needs(stage) if (header := before[name].header) is not None}
        outcome, failed = _run(run, stage, headers, why, log)
    else:
        outcome = Outcome(stage.name, now.file, False, FRESH, read=reader(run, stage))
        failed = () if now.header is None else now.header.provenance.failed
        _write_companion(run, stage, outcome)
    return _judged(run, stage, outcome, failed)


def _run(
    run: Run, stage: Stage, headers: Mapping[str, ArtifactHeader], why: str, log: Log | None
) -> tuple[Outcome, tuple[str, ...]]:
    """The outcome of running a stage, and the demands that it fails."""
    begin = time.perf_counter()
    log = _stopping(log)
    log(Begun(stage.name))
    config = run.loaded.config
    needed = run.needs(stage)
    contents: list[Any] = [
        load(run.file(STAGES[name]), STAGES[name].type()).content if name in needed else None for name in stage.inputs
    ]
    if stage.reads_files:
        contents.append(MeasuredTables(run.measured()))
    with _arithmetic(run, stage), one_thread():
        content = stage(config, *contents, **({"log": log} if stage.logs else {}))
    made = Provenance(
        stage.name,
        run.public_command(stage.name),
        run.sections(stage),
        run.inputs(stage, headers),
        run.loaded.resolved_text(),
        seed=config.plant.seed if config.plant is not None else None,
        interrupted=bool(getattr(content, "interrupted", False)),
        failed=tuple(getattr(content, "failed", ())),
    )
    outcome = Outcome(stage.name, run.file(stage), True, why, 0.0, lambda: content, made.interrupted)
    _write_companion(run, stage, outcome)
    save(run.file(stage), content, made, on_axis(linear=config.robot.linear))
    return replace(outcome, seconds=time.perf_counter() - begin), made.failed


@contextmanager
def _arithmetic(run: Run, stage: Stage) -> Iterator[None]:
    """Raises NumericsError for arithmetic that breaks down: a singular matrix, a division by zero, an overflow."""
    try:
        yield
    except (ArithmeticError, ValueError) as error:
        from numpy.linalg import LinAlgError

        if not isinstance(error, (ArithmeticError, LinAlgError)):
            raise
        hint = f"`{run.command('check')}` examines the records; bounds and guesses are the parameters'"
        raise NumericsError(f"the arithmetic breaks down: {error}", where=stage.name, hint=hint) from error


def _stopping(log: Log | None) -> Log:
    """A log whose every event is a point at which the run may be stopped."""

    def stop_or_log(event: Begun | Progress | Step) -> None:
        check()
        if log is not None:
            log(event)

    return stop_or_log


def _write_companion(run: Run, stage: Stage, outcome: Outcome) -> None:
    """Write the text that goes with an artifact, unless it is there as it is to be: it may hold more of the
    configuration than the stage depends on."""
    if stage.companion is None:
        return
    file = run.out / stage.companion.output
    text = find(stage.companion.function)(run.loaded, outcome.content, run.out)
    if not file.exists() or file.read_bytes() != text.encode():
        atomic_write(file, text, hint=ELSEWHERE)


class MeasuredTables(Mapping[str, Any]):
    """The measured files of each record as a table, several files of one record joined. files : by record, in the order
    in which they are asked for.

    A file is read when it is asked for, and forgotten once no later record needs it: long recordings are in memory one
    at a time. Raises InputError for a file that cannot be read.
    """

    def __init__(self, files: Mapping[str, Sequence[Path]]) -> None:
        self._files, self._tables = files, dict[Path, Any]()

    def __getitem__(self, record: str) -> Any:
        read, joined = find("robotid.signals.readers:read"), find("robotid.signals.joining:joined")
        paths, names = self._files[record], list(self._files)
        tables = {path: self._tables.get(path) or read(path) for path in paths}
        later = {path for name in names[names.index(record) + 1 :] for path in self._files[name]}
        self._tables = {path: table for path, table in (self._tables | tables).items() if path in later}
        return joined([tables[path] for path in paths])

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


def _judged(run: Run, stage: Stage, outcome: Outcome, failed: tuple[str, ...]) -> Outcome:
    """The outcome, unless it is worse than the configuration demands.

    make compares times of files: what is done is new from here on, and what is not is older than its inputs.
    """
    if failed or outcome.interrupted:
        before = min((run.file(STAGES[name]).stat().st_mtime for name in run.needs(stage)), default=1.0) - 1.0
        touch(outcome.file, before)
    else:
        touch(outcome.file)
    if failed:
        raise ThresholdError("; ".join(failed), where=str(outcome.file), hint="see `robotid show` of it")
    return outcome
