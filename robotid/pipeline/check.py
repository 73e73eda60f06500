"""The check of the records between `collect` and everything that is fitted to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from robotid.config.suggest import suggest
from robotid.errors import ConfigError, NumericsError, RobotidError
from robotid.pipeline.execute import execute, one_error, reader, status
from robotid.pipeline.freshness import State
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.table import COLLECT, EXCITE, STAGES
from robotid.progress import Log
from robotid.signals.plausibility import CHECKS, Axis, Plausibility, check_records, refuse_meaningless
from robotid.signals.quality import Recordings

BEFORE = (EXCITE.name, COLLECT.name)
"""Stages that need no check."""


def check(run: Runs, accepted: Collection[str] = (), *, log: Log | None = None) -> dict[str, Plausibility]:
    """Whether the records of a run make sense, by axis; they are collected first unless they are up to date.

    accepted : names of checks besides those that the configuration accepts. Raises ConfigError for a check that does
    not exist, and what `collect` raises.
    """
    _require_known(accepted)
    for stage in BEFORE:
        outcome = execute(run, stage, log=log)
        if outcome.failures:
            raise one_error(outcome.failures)
    return _checked(run, list(run.axes), accepted)


def check_collected(run: Runs, accepted: Collection[str] = ()) -> dict[str, Plausibility]:
    """The same for the axes whose records are up to date: on others no stage works."""
    _require_known(accepted)
    fresh = [s.axis for s in status(run) if s.stage == COLLECT.name and s.state is State.FRESH]
    return _checked(run, fresh, accepted) if fresh else {}


def _require_known(accepted: Collection[str]) -> None:
    for name in accepted:
        if name not in CHECKS:
            raise ConfigError(f'there is no check "{name}"', where="--accept", hint=suggest(name, CHECKS, many=20))


def _checked(run: Runs, axes: Sequence[str], accepted: Collection[str]) -> dict[str, Plausibility]:
    found = reader(run, COLLECT, axes)()
    recordings = found if run.several else {"": found}
    return {axis: _check_axis(run.axes[axis], recordings[axis], accepted) for axis in axes}


def _check_axis(run: Run, recordings: Recordings, accepted: Collection[str]) -> Plausibility:
    config = run.loaded.config
    known = {*accepted, *config.check.accept}
    return check_records(recordings, Axis(config.robot.gear_ratio, config.robot.linear), known)


def precedes_a_fit(run: Runs, stage: str | None = None, *, force: bool = False) -> bool:
    """Whether a stage, or for None a run of all stages, would work on the records."""
    working = set(STAGES) - set(BEFORE) if stage is None else {stage} & (set(STAGES) - set(BEFORE))
    return bool(working) and (force or any(s.state is not State.FRESH for s in status(run) if s.stage in working))


def require_meaningful(run: Runs, found: Mapping[str, Plausibility]) -> None:
    """Raises NumericsError where a fit to the records would be meaningless."""
    failures: dict[str, RobotidError] = {}
    for axis, one in found.items():
        try:
            refuse_meaningless(one, run.command("check"), "`check: {{accept: [{name}]}}` or --accept {name}")
        except NumericsError as error:
            failures[axis] = error
    if failures:
        raise one_error(failures)
