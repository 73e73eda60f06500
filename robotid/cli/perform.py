"""Running stages: what the pipeline does, in lines for a person on stderr and documents for scripts on stdout."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import typer

from robotid.cli.closing import closing
from robotid.cli.console import print_json, print_message, print_tables
from robotid.cli.progress import watching
from robotid.config.load import load, load_robot
from robotid.errors import INTERRUPTED, RobotidError, ThresholdError
from robotid.numerals import fixed
from robotid.parallel import working
from robotid.pipeline.check import check_collected, precedes_a_fit, require_meaningful
from robotid.pipeline.execute import AFTER_ANOTHER, FRESH, Outcome, execute, execute_all, one_error, reader
from robotid.pipeline.lock import locked
from robotid.pipeline.report_page import findings_of
from robotid.pipeline.run import Run, Runs, linear_axes, runs_of
from robotid.pipeline.table import COLLECT, PRODUCTS, REPORT, STAGES, VALIDATE
from robotid.progress import Begun, Log
from robotid.report.tables import by_axis
from robotid.report.tables import check as check_view
from robotid.report.tables.table import Json, Table
from robotid.signals.plausibility import Plausibility

STATES = {"made": "green", "fresh": "dim", "yes": "yellow", "no": "dim"}

Keep = Callable[[Mapping[str, Plausibility]], None]
"""Gets what the check found in the records of each axis."""


@dataclass(frozen=True, slots=True)
class StageOptions:
    """How stages are run and shown. figures, form, size : folder, format and
    size of the report's figures. accept : findings of the
    check that do not stop a run. jobs : processes, None for one a core."""

    as_json: bool = False
    quiet: bool = False
    force: bool = False
    dry_run: bool = False
    figures: Path | None = None
    form: str = "pdf"
    size: str | None = None
    accept: tuple[str, ...] = ()
    jobs: int | None = None


def open_run(config: Path, out: Path | None, overrides: Sequence[str], axis: str | None = None) -> Runs:
    """A configuration and its run directory, by default runs/<stem> of the current directory. axis : one of several
    alone."""
    out = out or Path("runs") / config.stem
    return runs_of(load_robot(config, overrides), out) if axis is None else Run(load(config, overrides, axis), out)


def perform(stage: str | None, run: Runs, options: StageOptions) -> None:
    """Run one stage, or all of them, and print what came of it. Waits for another process in the same run directory.
    Raises what the stages raise."""
    if options.dry_run:
        _perform(stage, run, options)
        return
    with locked(run.out, run.command(stage or "run"), partial(print_message, quiet=options.quiet)):
        _perform(stage, run, options)


def _perform(stage: str | None, run: Runs, options: StageOptions) -> None:
    done: list[Outcome] = []
    checked: list[Mapping[str, Plausibility]] = []
    failure: RobotidError | None = None
    with watching(quiet=options.quiet or options.dry_run) as log, working(options.jobs):
        try:
            for outcome in _outcomes(stage, run, options, log, checked.append):
                done.append(outcome)
                if log is not None:
                    log(Begun(""))  # or a heartbeat would follow the line of its end
                print_message(_line(outcome), quiet=options.quiet or options.dry_run)
                for axis, error in outcome.failures.items():
                    print_message(f"{outcome.stage}: axis {axis} goes no further: {error}", quiet=options.quiet)
        except ThresholdError as error:
            failure = error
            done.append(_kept(stage or VALIDATE.name, run))
            if stage is None:
                done.append(_reported(run, options, log))
    if options.dry_run:
        _print_plan(run, done, options)
        return
    _print_results(stage, run, done, options, checked)
    failures = {axis: error for outcome in done for axis, error in outcome.failures.items()}
    failure = failure or (one_error(failures) if failures else None)
    if failure is not None:
        raise failure
    if any(outcome.interrupted for outcome in done):
        print_message("interrupted; what was reached is saved, and the next run begins this stage again")
    for line in () if options.quiet else closing(run, stage, done):
        print_message(line)
    if any(outcome.interrupted for outcome in done):
        raise typer.Exit(INTERRUPTED)


def _outcomes(
    stage: str | None,
    run: Runs,
    options: StageOptions,
    log: Log | None,
    keep: Keep,
) -> Iterator[Outcome]:
    """The stages as they are done. keep : gets what the check found in the records."""
    if stage is None:
        outcome = None
        for outcome in execute_all(run, force=options.force, dry_run=options.dry_run, log=log):
            yield outcome
            if outcome.stage == COLLECT.name and not outcome.interrupted and not options.dry_run:
                _check(stage, run, options, keep)
        if outcome is not None and not outcome.interrupted:
            yield _reported(run, options, log, would_change=options.dry_run and outcome.why != FRESH)
    elif stage == REPORT.name:
        yield _reported(run, options, log)
    else:
        if not options.dry_run:
            _check(stage, run, options, keep)
        yield execute(run, stage, force=options.force, dry_run=options.dry_run, log=log)


def _check(stage: str | None, run: Runs, options: StageOptions, keep: Keep) -> None:
    """Stop before anything is computed from records that make no sense; a warning is a line on stderr."""
    working = precedes_a_fit(run, stage, force=options.force)
    found = check_collected(run, options.accept) if working or (options.as_json and stage is None) else {}
    if not found:
        return
    keep(found)
    if not working:
        return
    if options.as_json and stage is None and not all(found.values()):
        documents: dict[str, dict[str, Json]] = {a: {"check": check_view.document(one)} for a, one in found.items()}
        print_json({"out": str(run.out), **by_axis.document(documents)})
    require_meaningful(run, found)
    for line in (by_axis.titled(axis, line) for axis, one in found.items() for line in check_view.lines(one)):
        print_message(line, quiet=options.quiet)


def _reported(run: Runs, options: StageOptions, log: Log | None, *, would_change: bool = False) -> Outcome:
    if would_change:
        return Outcome(REPORT.name, run.file(REPORT), False, AFTER_ANOTHER)
    from robotid.cli.report import FigureFiles, make_report
    from robotid.report.save import parse_size

    figures = None if options.figures is None else FigureFiles(options.figures, options.form, parse_size(options.size))
    return make_report(run, force=options.force, dry_run=options.dry_run, log=log, figures=figures)


def _kept(stage: str, run: Runs) -> Outcome:
    """What a stage saved before it missed its threshold."""
    return Outcome(stage, run.file(STAGES[stage]), True, "", read=reader(run, STAGES[stage]))


def _line(outcome: Outcome) -> str:
    if not outcome.ran:
        return f"{outcome.stage}: {outcome.file} is fresh"
    return f"{outcome.stage}: {outcome.file} written in {fixed(outcome.seconds)} s ({outcome.why})"


def _print_plan(run: Runs, plan: Sequence[Outcome], options: StageOptions) -> None:
    if options.as_json:
        print_json({"out": str(run.out), "stages": [_entry(o) for o in plan]})
        return
    rows = tuple((o.stage, "no" if o.why == FRESH else "yes", o.why, str(o.file)) for o in plan)
    print_tables([Table("", ("stage", "would run", "why", "file"), rows, styles=STATES)])


def _print_results(
    stage: str | None,
    run: Runs,
    done: Sequence[Outcome],
    options: StageOptions,
    checked: Sequence[Mapping[str, Plausibility]],
) -> None:
    shown = done[-1:] if stage is not None else _of_a_run(done)
    if options.as_json and stage is not None:
        print_json(by_axis.document(_documents(shown[-1])))
    elif options.as_json:
        results: dict[str, dict[str, Json]] = {axis: {} for axis in run.axes}
        for axis, one in checked[-1].items() if checked else ():
            results[axis]["check"] = check_view.document(one)
        for outcome in shown:
            for axis, document in _documents(outcome).items():
                results[axis][outcome.stage] = document
        print_json({"out": str(run.out), "stages": [_entry(o) for o in done], **by_axis.document(results)})
    elif not options.quiet:
        linear = linear_axes(run)
        tables = [
            table
            for o in shown
            for table in by_axis.tables(PRODUCTS[o.stage].view(), o.contents, linear, brief=stage is None)
        ]
        print_tables(tables if stage is not None else [_summary(done), *tables, *_overview(run, done)])


def _overview(run: Runs, done: Sequence[Outcome]) -> Iterator[Table]:
    """The axes side by side, of several; with the records where these tell of a body."""
    with_body = run.several and "body" in run.loaded.robot["robot"]
    made = [
        o for o in done if o.several and (STAGES[o.stage].after_run != "never" or (with_body and o.stage == "collect"))
    ]
    if made:
        from robotid.report.tables.overview import overview

        found = {axis: {o.stage: o.contents[axis] for o in made if axis in o.contents} for axis in run.axes}
        yield overview({axis: findings_of(run.axes[axis], contents) for axis, contents in found.items()})


def _documents(outcome: Outcome) -> dict[str, Json]:
    """The document of each axis."""
    view = PRODUCTS[outcome.stage].view()
    return {axis: view.document(content) for axis, content in outcome.contents.items()}


def _of_a_run(done: Sequence[Outcome]) -> list[Outcome]:
    """The outcomes that a whole run prints: the latest of those marked so, and those that it always does."""
    after = [(o, STAGES[o.stage].after_run) for o in done if o.stage in STAGES]
    return [*[o for o, when in after if when == "latest"][-1:], *[o for o, when in after if when == "always"]]


def _entry(outcome: Outcome) -> Json:
    return {
        "stage": outcome.stage,
        "file": str(outcome.file),
        "ran": outcome.ran,
        "why": outcome.why,
        "seconds": outcome.seconds,
    }


def _summary(done: Sequence[Outcome]) -> Table:
    rows = tuple((o.stage, "made" if o.ran else "fresh", fixed(o.seconds), str(o.file)) for o in done)
    return Table("Stages", ("stage", "state", "seconds", "file"), rows, styles=STATES)
