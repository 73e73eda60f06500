"""What a stage makes: its pure function on the contents of its inputs, for one joint or for each axis of a robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotid.config.schema import Config
from robotid.errors import NumericsError, RobotidError
from robotid.interrupt import check
from robotid.parallel import ahead, one_thread, workers
from robotid.pipeline.stage import Stage, find
from robotid.progress import Begun, Log, Progress, Step


@dataclass(frozen=True, slots=True)
class Job:
    """What a stage takes of one axis: its configuration and the contents of its inputs."""

    config: Config
    contents: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Work:
    """What a stage has to do. jobs : by axis, "" for a single joint; check : the command that examines the records."""

    stage: Stage
    jobs: Mapping[str, Job]
    check: str


def compute(work: Work, log: Log | None) -> Iterator[tuple[str, Any]]:
    """Axis and content, one after the other; of several axes an error that a person can correct instead of the content.

    Axes are worked on in parallel where there are enough of them to keep the processes busy, otherwise each of them has
    all processes for itself; one after the other where they share what the stage computes. Raises what the stage
    raises.
    """
    axes = list(work.jobs)
    if "" in work.jobs:
        yield "", _content(work, "", log)
    elif work.stage.shared:
        shared = find(work.stage.shared)()
        yield from ((axis, _content_or_error(work, axis, log, shared=shared)) for axis in axes)
    elif len(axes) > 1 and 2 * len(axes) > workers():
        samples = sum(map(_samples, work.jobs.values())) // len(axes)
        with ahead(_content_or_error, work, axes, samples=samples, log=log, hands_on_interrupts=True) as found:
            yield from zip(axes, found, strict=True)
    else:
        yield from ((axis, _content_or_error(work, axis, log)) for axis in axes)


def _content_or_error(work: Work, axis: str, log: Log | None = None, **options: Any) -> Any:
    try:
        return _content(work, axis, None if log is None else _labelled(axis, log), **options)
    except RobotidError as error:
        return error


def _content(work: Work, axis: str, log: Log | None, **options: Any) -> Any:
    job = work.jobs[axis]
    options |= {"log": _stopping(log)} if work.stage.logs else {}
    with _arithmetic(work), one_thread():
        return work.stage(job.config, *job.contents, **options)


def _samples(job: Job) -> int:
    """Of all records that a job takes."""
    from robotid.signals.quality import Recordings

    return sum(len(r) for content in job.contents if isinstance(content, Recordings) for r in content.records)


@contextmanager
def _arithmetic(work: Work) -> Iterator[None]:
    """Raises NumericsError for arithmetic that breaks down: a singular matrix, a division by zero, an overflow."""
    try:
        yield
    except (ArithmeticError, ValueError) as error:
        from numpy.linalg import LinAlgError

        if not isinstance(error, (ArithmeticError, LinAlgError)):
            raise
        hint = f"`{work.check}` examines the records; bounds and guesses are the parameters'"
        raise NumericsError(f"the arithmetic breaks down: {error}", where=work.stage.name, hint=hint) from error


def _stopping(log: Log | None) -> Log:
    """A log whose every event is a point at which the run may be stopped."""

    def stop_or_log(event: Begun | Progress | Step) -> None:
        check()
        if log is not None:
            log(event)

    return stop_or_log


def _labelled(axis: str, log: Log) -> Log:
    """A log whose events name the axis."""

    def labelled(event: Begun | Progress | Step) -> None:
        if isinstance(event, Progress):
            event = replace(event, label=f"{axis}: {event.label}" if event.label else axis)
        elif isinstance(event, Step):
            names = tuple(f"{axis} {model}" for model in event.models)
            event = replace(event, model=f"{axis} {event.model}", models=names)
        log(event)

    return labelled


class MeasuredTables(Mapping[str, Any]):
    """The measured files of each record as a table, several files of one record joined. files : by record, in the order
    in which they are asked for. keep : they are asked for again, by another axis.

    A file is read when it is asked for, and unless it is kept forgotten once no later record needs it: long recordings
    are in memory one at a time. Raises InputError for a file that cannot be read.
    """

    def __init__(self, files: Mapping[str, Sequence[Path]], *, keep: bool = False) -> None:
        self._files, self._tables, self._keep = files, dict[Path, Any](), keep

    def __getitem__(self, record: str) -> Any:
        read, joined = find("robotid.signals.readers:read"), find("robotid.signals.joining:joined")
        paths, names = self._files[record], list(self._files)
        tables = {path: self._tables.get(path) or read(path) for path in paths}
        later = {path for name in names[names.index(record) + 1 :] for path in self._files[name]}
        self._tables = {p: table for p, table in (self._tables | tables).items() if self._keep or p in later}
        return joined([tables[path] for path in paths])

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)
