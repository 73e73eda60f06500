"""The check of the records between `collect` and everything that is fitted to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import Made, load, save, save_axes
from robotid.config.suggest import suggest
from robotid.errors import ConfigError, InputError, NumericsError, RobotidError
from robotid.pipeline.execute import execute, one_error, reader, status
from robotid.pipeline.freshness import State
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.table import COLLECT, EXCITE, STAGES
from robotid.progress import Log
from robotid.signals.plausibility import CHECKS, Axis, Plausibility, check_records, refuse_meaningless

FILE = ".robotid.check"
"""Where the findings of a check are kept."""
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
    return _checked(run, _collected(run), accepted, again=True)


def check_collected(run: Runs, accepted: Collection[str] = ()) -> dict[str, Plausibility]:
    """The same for the axes whose records are up to date: on others no stage works. Records that were checked before
    are not checked again."""
    _require_known(accepted)
    return _checked(run, _collected(run), accepted)


def _require_known(accepted: Collection[str]) -> None:
    for name in accepted:
        if name not in CHECKS:
            raise ConfigError(f'there is no check "{name}"', where="--accept", hint=suggest(name, CHECKS, many=20))


def _collected(run: Runs) -> dict[str, Provenance]:
    """Where a check of an axis comes from, for the axes whose records are up to date."""
    states = [s for s in status(run) if s.stage == COLLECT.name and s.state is State.FRESH]
    return {s.axis: _provenance(run.axes[s.axis], s.header.digest) for s in states if s.header is not None}


def _provenance(run: Run, digest: str) -> Provenance:
    config = run.loaded.config
    known = {"gear_ratio": repr(config.robot.gear_ratio), "linear": repr(config.robot.linear)}
    return Provenance("check", run.public_command("check"), known, {COLLECT.name: digest}, run.loaded.resolved_text())


def _checked(
    run: Runs, origins: Mapping[str, Provenance], accepted: Collection[str], *, again: bool = False
) -> dict[str, Plausibility]:
    """The findings in records, by axis, and keep them. origins : of a check of each axis; again : also where they are
    known."""
    found = {} if again else _checked_before(run, origins)
    if due := [axis for axis in origins if axis not in found]:
        contents = reader(run, COLLECT, due)()
        for axis in due:
            robot = run.axes[axis].loaded.config.robot
            recordings = contents[axis] if run.several else contents
            found[axis] = check_records(recordings, Axis(robot.gear_ratio, robot.linear))
        made = {axis: Made(found[axis], origins[axis]) for axis in due}
        if run.several:
            save_axes(run.out / FILE, made, run.names)
        else:
            save(run.out / FILE, made[""].content, made[""].provenance)
    return {axis: found[axis].accepting({*accepted, *run.axes[axis].loaded.config.check.accept}) for axis in origins}


def _checked_before(run: Runs, origins: Mapping[str, Provenance]) -> dict[str, Plausibility]:
    """What a check by this version has found before in the same records."""
    found: dict[str, Plausibility] = {}
    for axis, origin in origins.items():
        with suppress(InputError, ConfigError):
            kept = load(run.out / FILE, Plausibility, axis)
            made = kept.provenance
            if (made.version, made.sections, made.inputs) == (origin.version, origin.sections, origin.inputs):
                found[axis] = kept.content
    return found


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
