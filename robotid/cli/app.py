"""The command line: it parses, calls and prints. Everything heavy is imported inside the command that needs it."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from robotid import __version__
from robotid.cli.console import print_message
from robotid.cli.options import Accept, AsJson, AxisName, ConfigPath, Debug, Jobs, Out, Quiet, Set, Size
from robotid.cli.stages import add_stages
from robotid.cli.streams import standard_streams
from robotid.errors import INTERRUPTED, InputError, RobotidError
from robotid.interrupt import Interrupted, check, interruptible
from robotid.parallel import ONE_THREAD

app = typer.Typer(
    name="robotid",
    help="From torque and motor-angle recordings of a robot joint to a validated physical model.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line (by default the process's own) and return its exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    # many small matrices: threads cost far more than they bring, and the library reads this before numpy is imported
    os.environ.update(ONE_THREAD)
    with standard_streams() as results:
        code = _run(arguments)
        results.flush()
        if results.failure is not None and code == 0:
            print_message(f"stdout: cannot be written: {results.failure.strerror}")
            return InputError.exit_code
        return code


def _run(arguments: Sequence[str]) -> int:
    debug = "--debug" in arguments
    try:
        with interruptible():
            code = _dispatch(arguments)
            check()
            return code
    except RobotidError as error:
        if debug:
            traceback.print_exc()
        print_message(str(error))
        return error.exit_code
    except OSError as error:  # a full disk or a forbidden folder is nobody's bug
        if debug:
            traceback.print_exc()
        print_message(f"{error.filename or 'system'}: {error.strerror or error}")
        return InputError.exit_code
    except MemoryError:
        if debug:
            traceback.print_exc()
        print_message("system: there is not enough memory for this")
        return InputError.exit_code
    except Interrupted:
        print_message("interrupted")
        return INTERRUPTED
    except Exception:
        traceback.print_exc()
        print_message("this is a bug in robotid; please report it with the lines above")
        return 1


def _dispatch(arguments: Sequence[str]) -> int:
    """The exit code of a command that ends by itself. Raises what the command raises."""
    try:
        app(list(arguments), prog_name="robotid")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"robotid {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """From torque and motor-angle recordings of a robot joint to a validated physical model."""


add_stages(app)


@app.command("check")
def check_records(
    config: ConfigPath,
    out: Out = None,
    overrides: Set = None,
    axis: AxisName = None,
    accept: Accept = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Whether the records make sense, before anything is fitted."""
    from robotid.cli.check import check_configuration
    from robotid.cli.perform import open_run

    check_configuration(open_run(config, out, overrides or [], axis), accept or [], as_json=as_json, quiet=quiet)


@app.command()
def status(
    config: ConfigPath,
    out: Out = None,
    overrides: Set = None,
    axis: AxisName = None,
    as_json: AsJson = False,
    debug: Debug = False,
) -> None:
    """Which artifacts are fresh, stale or absent, and why."""
    from robotid.cli.perform import open_run
    from robotid.cli.status import show_status

    show_status(open_run(config, out, overrides or [], axis), as_json=as_json)


@app.command()
def show(
    artifact: Annotated[
        Path, typer.Argument(metavar="FILE.h5", help="An artifact, or a run directory for a line of each.")
    ],
    axis: AxisName = None,
    as_json: AsJson = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE.png", help="Draw it instead; also .svg and .pdf.")
    ] = None,
    size: Size = None,
    debug: Debug = False,
) -> None:
    """What an artifact or a run directory holds and where it comes from, as tables or as a figure."""
    from robotid.cli.show import plot_artifact, show_artifact, show_directory

    if plot is not None:
        plot_artifact(artifact, plot, axis, size)
    elif artifact.is_dir():
        show_directory(artifact, as_json=as_json)
    else:
        show_artifact(artifact, axis, as_json=as_json)


@app.command()
def export(
    artifact: Annotated[
        Path, typer.Argument(metavar="FILE.h5", help="model.h5, extension.h5, records.h5 or flex.h5 of a run.")
    ],
    to: Annotated[
        Path,
        typer.Argument(
            metavar="TO",
            help="A .mat, .json or .csv file; of a model also .xml (MuJoCo), .urdf, .py or .m (a function).",
        ),
    ],
    model: Annotated[
        str | None, typer.Option("--model", metavar="NAME", help="Which fitted model; by default the best.")
    ] = None,
    record: Annotated[
        str | None, typer.Option("--record", metavar="NAME", help="One record alone; by default all.")
    ] = None,
    axis: Annotated[
        str | None, typer.Option("--axis", metavar="NAME", help="Which axis of a robot of several.")
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", metavar="V", help="Motor speed [rad/s] that a model is linearised about.")
    ] = 0.0,
    joint: Annotated[
        str, typer.Option("--joint", metavar="NAME", help="What the joint is called in MuJoCo or URDF.")
    ] = "",
    into: Annotated[
        Path | None, typer.Option("--into", metavar="FILE", help="A URDF; TO is a copy of it with this joint changed.")
    ] = None,
    debug: Debug = False,
) -> None:
    """A fitted model, signals or frequency responses for other programs."""
    from robotid.cli.export import Request, export_artifact

    export_artifact(artifact, to, Request(model, record, speed, joint, into, axis))


@app.command()
def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run directories; the first is the reference.")],
    model: Annotated[
        str | None, typer.Option("--model", metavar="NAME", help="Which fitted model; by default the best of each.")
    ] = None,
    axis: Annotated[str | None, typer.Option("--axis", metavar="NAME", help="Which axis of robots of several.")] = None,
    extended: Annotated[bool, typer.Option("--extended", help="The models with their causes.")] = False,
    page: Annotated[
        Path | None, typer.Option("--page", metavar="FILE.html", help="Write a page of it, which needs nothing else.")
    ] = None,
    as_json: AsJson = False,
    debug: Debug = False,
) -> None:
    """Runs side by side: what differs significantly, verdicts, gains."""
    from robotid.cli.compare import Compared
    from robotid.cli.compare import compare as compare_runs

    compare_runs(runs, Compared(model, axis or "", page, extended), as_json=as_json)


@app.command()
def watch(
    config: ConfigPath,
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="New logs, of the same columns as the records.")],
    like: Annotated[
        str | None,
        typer.Option("--like", metavar="RECORD", help="Whose columns the logs have; by default the first with a file."),
    ] = None,
    level: Annotated[
        float, typer.Option("--level", metavar="P", help="Chance of an alarm where nothing has changed.")
    ] = 0.01,
    model: Annotated[
        str | None, typer.Option("--model", metavar="NAME", help="A fitted model; by default the extended or best one.")
    ] = None,
    out: Out = None,
    overrides: Set = None,
    axis: AxisName = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    jobs: Jobs = None,
    debug: Debug = False,
) -> None:
    """Whether an accepted model is still right on new logs; exit 5 where it is not, and what has changed."""
    from robotid.cli.perform import open_run
    from robotid.cli.watch import WatchRequest, watch_logs

    request = WatchRequest(like, level, model, jobs, as_json, quiet)
    watch_logs(open_run(config, out, overrides or [], axis), logs, request)


@app.command()
def explain(
    effect: Annotated[str | None, typer.Argument(metavar="EFFECT", help="Such as coulomb or gear.spring.")] = None,
    as_json: AsJson = False,
    debug: Debug = False,
) -> None:
    """Equation, parameters and source of an effect, or a list."""
    from robotid.cli.explain import explain_effect, list_effects

    if effect is None:
        list_effects(as_json=as_json)
    else:
        explain_effect(effect, as_json=as_json)


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the robot; NAME.yaml is written.")],
    from_data: Annotated[
        list[Path] | None,
        typer.Option(
            "--from-data",
            metavar="FILE",
            help="Guess columns and sampling time from FILE; given more than once, the files are joined by time.",
        ),
    ] = None,
    column: Annotated[
        list[str] | None, typer.Option("--column", metavar="SIGNAL=NAME", help="A column that the guess misses.")
    ] = None,
    scale: Annotated[
        list[str] | None, typer.Option("--scale", metavar="SIGNAL=NUMBER", help="How many SI units one of a column is.")
    ] = None,
    sampling_time: Annotated[
        float | None, typer.Option("--sampling-time", metavar="SECONDS", help="Of a FILE without a time column.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite NAME.yaml.")] = False,
    debug: Debug = False,
) -> None:
    """A commented configuration to start from."""
    from robotid.cli.new import write_configuration

    write_configuration(name, from_data or (), column or (), scale or (), sampling_time, force=force)


@app.command()
def example(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Such as demo; without one, a list.")] = None,
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="A folder that does not exist yet; by default NAME.")
    ] = None,
    as_json: AsJson = False,
    debug: Debug = False,
) -> None:
    """Write a shipped example, configuration and data, into a folder."""
    from robotid.cli.example import list_examples, write_example

    if name is None:
        list_examples(as_json=as_json)
    else:
        write_example(name, folder)
