"""The check of the records between `collect` and everything that is fitted to them."""

from __future__ import annotations

from collections.abc import Collection

from robotid.artifacts.store import load
from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.pipeline.execute import execute, status
from robotid.pipeline.freshness import State
from robotid.pipeline.run import Run
from robotid.pipeline.table import COLLECT, EXCITE, STAGES
from robotid.progress import Log
from robotid.signals.plausibility import CHECKS, Axis, Plausibility, check_records, refuse_meaningless

BEFORE = (EXCITE.name, COLLECT.name)
"""Stages that need no check."""


def check(run: Run, accepted: Collection[str] = (), *, log: Log | None = None) -> Plausibility:
    """Whether the records of a run make sense; they are collected first unless they are up to date.

    accepted : names of checks besides those that the configuration accepts. Raises ConfigError for a check that does
    not exist, and what `collect` raises.
    """
    _require_known(accepted)
    for stage in BEFORE:
        execute(run, stage, log=log)
    return _checked(run, accepted)


def check_collected(run: Run, accepted: Collection[str] = ()) -> Plausibility | None:
    """The same for records that are up to date; None where they are not, for then no stage works on them."""
    _require_known(accepted)
    fresh = {s.stage for s in status(run) if s.state is State.FRESH}
    return _checked(run, accepted) if COLLECT.name in fresh else None


def _require_known(accepted: Collection[str]) -> None:
    for name in accepted:
        if name not in CHECKS:
            raise ConfigError(f'there is no check "{name}"', where="--accept", hint=suggest(name, CHECKS, many=20))


def _checked(run: Run, accepted: Collection[str]) -> Plausibility:
    robot = run.loaded.config.robot
    recordings = load(run.file(COLLECT), COLLECT.type()).content
    known = {*accepted, *run.loaded.config.check.accept}
    return check_records(recordings, Axis(robot.gear_ratio, robot.linear), known)


def precedes_a_fit(run: Run, stage: str | None = None, *, force: bool = False) -> bool:
    """Whether a stage, or for None a run of all stages, would work on the records."""
    working = set(STAGES) - set(BEFORE) if stage is None else {stage} & (set(STAGES) - set(BEFORE))
    return bool(working) and (force or any(s.state is not State.FRESH for s in status(run) if s.stage in working))


def require_meaningful(run: Run, found: Plausibility) -> None:
    """Raises NumericsError where a fit to the records would be meaningless."""
    refuse_meaningless(found, run.command("check"), "`check: {{accept: [{name}]}}` or --accept {name}")
