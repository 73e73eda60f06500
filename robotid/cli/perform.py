"""Running stages: what the pipeline does, in lines for a person on stderr and documents for scripts on stdout."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import typer

from robotid.cli.closing import closing
from robotid.cli.console import print_json, print_message, print_tables
from robotid.cli.progress import watching
from robotid.config.load import load
from robotid.errors import INTERRUPTED, ThresholdError
from robotid.numerals import fixed
from robotid.parallel import working
from robotid.pipeline.check import check_collected, precedes_a_fit, require_meaningful
from robotid.pipeline.execute import AFTER_ANOTHER, FRESH, Outcome, execute, execute_all, reader
from robotid.pipeline.lock import locked
from robotid.pipeline.run import Run
from robotid.pipeline.table import COLLECT, PRODUCTS, REPORT, STAGES, VALIDATE
from robotid.progress import Log
from robotid.report.tables import check as check_view
from robotid.report.tables.sliding import in_units_of_axis
from robotid.report.tables.table import Json, Table
from robotid.signals.plausibility import Plausibility

STATES = {"made": "green", "fresh": "dim", "yes": "yellow", "no": "dim"}


@dataclass(frozen=True, slots=True)
class StageOptions:
    """How stages are run and shown. figures, form : folder and format of the report's figures. accept : findings of the
    check that do not stop a run. jobs : processes, None for one a core."""

    as_json: bool = False
    quiet: bool = False
    force: bool = False
    dry_run: bool = False
    figures: Path | None = None
    form: str = "pdf"
    accept: tuple[str, ...] = ()
    jobs: int | None = None


def open_run(config: Path, out: Path | None, overrides: Sequence[str]) -> Run:
    """A configuration and its run directory, by default runs/<stem> of the current directory."""
    return Run(load(config, overrides), out or Path("runs") / config.stem)


def perform(stage: str | None, run: Run, options: StageOptions) -> None:
    """Run one stage, or all of them, and print what came of it. Waits for another process in the same run directory.
    Raises what the stages raise."""
    if options.dry_run:
        _perform(stage, run, options)
        return
    with locked(run.out, run.command(stage or "run"), partial(print_message, quiet=options.quiet)):
        _perform(stage, run, options)


def _perform(stage: str | None, run: Run, options: StageOptions) -> None:
    done: list[Outcome] = []
    checked: list[Plausibility] = []
    failure = None
    with watching(quiet=options.quiet or options.dry_run) as log, working(options.jobs):
        try:
            for outcome in _outcomes(stage, run, options, log, checked.append):
                done.append(outcome)
                print_message(_line(outcome), quiet=options.quiet or options.dry_run)
        except ThresholdError as error:
            failure = error
            done.append(_kept(stage or VALIDATE.name, run))
            if stage is None:
                done.append(_reported(run, options, log))
    if options.dry_run:
        _print_plan(run, done, options)
        return
    _print_results(stage, run, done, options, checked)
    if failure is not None:
        raise failure
    if any(outcome.interrupted for outcome in done):
        print_message("interrupted; what was reached is saved, and the next run begins this stage again")
    for line in () if options.quiet else closing(run, stage, done):
        print_message(line)
    if any(outcome.interrupted for outcome in done):
        raise typer.Exit(INTERRUPTED)


def _outcomes(
    stage: str | None, run: Run, options: StageOptions, log: Log | None, keep: Callable[[Plausibility], None]
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


def _check(stage: str | None, run: Run, options: StageOptions, keep: Callable[[Plausibility], None]) -> None:
    """Stop before anything is computed from records that make no sense; a warning is a line on stderr."""
    working = precedes_a_fit(run, stage, force=options.force)
    found = check_collected(run, options.accept) if working or (options.as_json and stage is None) else None
    if found is None:
        return
    keep(found)
    if not working:
        return
    if options.as_json and stage is None and not found:
        print_json({"out": str(run.out), "check": check_view.document(found)})
    require_meaningful(run, found)
    for line in check_view.lines(found):
        print_message(line, quiet=options.quiet)


def _reported(run: Run, options: StageOptions, log: Log | None, *, would_change: bool = False) -> Outcome:
    if would_change:
        return Outcome(REPORT.name, run.file(REPORT), False, AFTER_ANOTHER)
    from robotid.cli.report import make_report

    return make_report(
        run, force=options.force, dry_run=options.dry_run, log=log, figures=options.figures, form=options.form
    )


def _kept(stage: str, run: Run) -> Outcome:
    """What a stage saved before it missed its threshold."""
    return Outcome(stage, run.file(STAGES[stage]), True, "", read=reader(run, STAGES[stage]))


def _line(outcome: Outcome) -> str:
    if not outcome.ran:
        return f"{outcome.stage}: {outcome.file} is fresh"
    return f"{outcome.stage}: {outcome.file} written in {fixed(outcome.seconds)} s ({outcome.why})"


def _print_plan(run: Run, plan: Sequence[Outcome], options: StageOptions) -> None:
    if options.as_json:
        print_json({"out": str(run.out), "stages": [_entry(o) for o in plan]})
        return
    rows = tuple((o.stage, "no" if o.why == FRESH else "yes", o.why, str(o.file)) for o in plan)
    print_tables([Table("", ("stage", "would run", "why", "file"), rows, styles=STATES)])


def _print_results(
    stage: str | None, run: Run, done: Sequence[Outcome], options: StageOptions, checked: Sequence[Plausibility]
) -> None:
    shown = done[-1:] if stage is not None else _of_a_run(done)
    if options.as_json and stage is not None:
        print_json(PRODUCTS[stage].view().document(shown[-1].content))
    elif options.as_json:
        results: dict[str, Json] = {"check": check_view.document(checked[-1])} if checked else {}
        results |= {o.stage: PRODUCTS[o.stage].view().document(o.content) for o in shown}
        print_json({"out": str(run.out), "stages": [_entry(o) for o in done], **results})
    elif not options.quiet:
        linear = run.loaded.config.robot.linear
        tables = [in_units_of_axis(table, linear=linear) for o in shown for table in _tables(o, brief=stage is None)]
        print_tables(tables if stage is not None else [_summary(done), *tables])


def _of_a_run(done: Sequence[Outcome]) -> list[Outcome]:
    """The outcomes that a whole run prints: the latest of those marked so, and those that it always does."""
    after = [(o, STAGES[o.stage].after_run) for o in done if o.stage in STAGES]
    return [*[o for o, when in after if when == "latest"][-1:], *[o for o, when in after if when == "always"]]


def _tables(outcome: Outcome, *, brief: bool) -> tuple[Table, ...]:
    module = PRODUCTS[outcome.stage].view()
    tables: tuple[Table, ...] = getattr(module, "brief" if brief else "tables", module.tables)(outcome.content)
    return tables


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
