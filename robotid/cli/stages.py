"""The stage commands, all alike: one row a stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from robotid.cli.options import Accept, AsJson, AxisName, ConfigPath, Debug, DryRun, Force, Jobs, Out, Quiet, Set, Size
from robotid.interrupt import Interrupted
from robotid.pipeline.table import REPORT, STAGES


def add_stages(app: typer.Typer) -> None:
    """One command a stage, and `run` for all of them."""
    app.command("run", help="Every stage that is not up to date, in order.")(_run)
    for stage in STAGES.values():
        app.command(stage.name, help=stage.summary)(_command(stage.name))
    app.command(REPORT.name, help=REPORT.summary)(_report)


def _run(
    config: ConfigPath,
    out: Out = None,
    overrides: Set = None,
    axis: AxisName = None,
    accept: Accept = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    force: Force = False,
    jobs: Jobs = None,
    dry_run: DryRun = False,
    debug: Debug = False,
) -> None:
    options = {"as_json": as_json, "quiet": quiet, "force": force, "dry_run": dry_run, "accept": tuple(accept or ())}
    _perform(None, Source(config, out, overrides, axis), jobs, **options)


def _command(stage: str) -> Callable[..., None]:
    def command(
        config: ConfigPath,
        out: Out = None,
        overrides: Set = None,
        axis: AxisName = None,
        accept: Accept = None,
        as_json: AsJson = False,
        quiet: Quiet = False,
        force: Force = False,
        jobs: Jobs = None,
        dry_run: DryRun = False,
        debug: Debug = False,
    ) -> None:
        chosen = {"as_json": as_json, "quiet": quiet, "force": force, "dry_run": dry_run}
        _perform(stage, Source(config, out, overrides, axis), jobs, accept=tuple(accept or ()), **chosen)

    return command


def _report(
    config: ConfigPath,
    figures: Annotated[
        Path | None, typer.Option("--figures", metavar="DIR", help="Write every figure into DIR as well.")
    ] = None,
    form: Annotated[str, typer.Option("--format", metavar="FORMAT", help="Of the figures: pdf, svg or png.")] = "pdf",
    size: Size = None,
    out: Out = None,
    overrides: Set = None,
    axis: AxisName = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    force: Force = False,
    jobs: Jobs = None,
    dry_run: DryRun = False,
    debug: Debug = False,
) -> None:
    options = {"as_json": as_json, "quiet": quiet, "force": force, "dry_run": dry_run, "figures": figures, "form": form}
    options["size"] = size
    _perform(REPORT.name, Source(config, out, overrides, axis), jobs, **options)


@dataclass(frozen=True, slots=True)
class Source:
    """What a command works on."""

    config: Path
    out: Path | None
    overrides: list[str] | None
    axis: str | None


def _perform(stage: str | None, source: Source, jobs: int | None, **options: Any) -> None:
    """A stage, or all of them. options : as of `robotid.cli.perform.StageOptions`."""
    from robotid.cli.perform import StageOptions, open_run, perform

    try:
        run = open_run(source.config, source.out, source.overrides or [], source.axis)
        perform(stage, run, StageOptions(jobs=jobs, **options))
    except KeyboardInterrupt:
        raise Interrupted from None
