"""The arguments and options that commands share, each declared once."""

from pathlib import Path
from typing import Annotated

import typer

ConfigPath = Annotated[Path, typer.Argument(metavar="CONFIG", help="Configuration, a YAML file.", show_default=False)]
Out = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Run directory; by default runs/<stem of CONFIG>.")
]
Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY.PATH=VALUE", help="Change the configuration; repeatable.")
]
AxisName = Annotated[
    str | None, typer.Option("--axis", metavar="NAME", help="One axis of a robot of several; by default all.")
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON document on stdout, nothing else.")]
Accept = Annotated[
    list[str] | None,
    typer.Option(
        "--accept", metavar="CHECK", help="A finding of `robotid check` that is known to be right; repeatable."
    ),
]
Size = Annotated[
    str | None, typer.Option("--size", metavar="WxH", help="Of figures in millimetres, such as 88x60 for a column.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No talk on stderr but errors.")]
Force = Annotated[bool, typer.Option("--force", help="Run even what is up to date.")]
Jobs = Annotated[
    int | None,
    typer.Option(
        "--jobs",
        "-j",
        min=1,
        metavar="N",
        envvar="ROBOTID_JOBS",
        help="Processes; by default one a core. Results do not depend on it.",
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Say what would run, and why, and stop.")]
Debug = Annotated[bool, typer.Option("--debug", help="A traceback with every error.")]
