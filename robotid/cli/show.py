"""The command show: an artifact's content and where it comes from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import ArtifactHeader, load, read_header, read_headers
from robotid.cli.console import print_json, print_message, print_tables
from robotid.config.load import parse
from robotid.errors import InputError
from robotid.model.units import on_axis
from robotid.pipeline.stage import Stage
from robotid.pipeline.table import STAGES
from robotid.report.tables import by_axis
from robotid.report.tables.table import Json, Table


def show_artifact(file: Path, axis: str | None = None, *, as_json: bool = False) -> None:
    """Print an artifact of any stage. axis : one of several alone. Raises InputError where it is missing, foreign or
    damaged, ConfigError where it has no such axis."""
    headers = read_headers(file) if axis is None else {axis: read_header(file, axis)}
    stages = {name: _stage(file, header) for name, header in headers.items()}
    contents = {name: load(file, stage.type(), name).content for name, stage in stages.items()}
    view = next(iter(stages.values())).view()
    if as_json:
        documents = {
            name: {"content": view.document(contents[name]), "provenance": _document(header)}
            for name, header in headers.items()
        }
        print_json(by_axis.document(documents))
    else:
        linear = {name: _linear(header) for name, header in headers.items()}
        provenance = [replace(_provenance(h), title=by_axis.titled(name, "Provenance")) for name, h in headers.items()]
        print_tables([*by_axis.tables(view, contents, linear), *provenance])


def plot_artifact(file: Path, figure: Path, axis: str | None = None) -> None:
    """Draw an artifact into a file, whole or not at all. Raises ConfigError for a format that cannot be drawn, and for
    one of several axes that is not named."""
    from robotid.report.figures import draw
    from robotid.report.save import check_format, save_figure

    check_format(figure.suffix.removeprefix("."), str(figure))
    header = read_header(file, axis or "")
    content = load(file, _stage(file, header).type(), axis or "").content
    save_figure(draw(content, on_axis(linear=_linear(header))), figure)
    print_message(f"{figure} written")


def _linear(header: ArtifactHeader) -> bool:
    """Whether the axis slides."""
    return parse(header.provenance.configuration).robot.linear


def _stage(file: Path, header: ArtifactHeader) -> Stage:
    """The stage that made an artifact. Raises InputError where there is none of its name."""
    name = header.provenance.stage
    if name not in STAGES:
        raise InputError(f'made by a stage "{name}" that this version does not know', where=str(file))
    return STAGES[name]


def _document(header: ArtifactHeader) -> Json:
    made = header.provenance
    return {
        "kind": header.kind,
        "digest": header.digest,
        "stage": made.stage,
        "command": made.command,
        "version": made.version,
        "created": made.created,
        "inputs": made.inputs,
        "seed": made.seed,
        "environment": made.environment,
        "configuration": made.configuration,
    }


def _provenance(header: ArtifactHeader) -> Table:
    made: Provenance = header.provenance
    facts = [
        ("kind", header.kind),
        ("made by", f"{made.command}, version {made.version}"),
        ("on", made.created),
        ("seed", "-" if made.seed is None else str(made.seed)),
        ("from", "; ".join(f"{name} {digest[:12]}" for name, digest in made.inputs.items()) or "the configuration"),
        ("content", header.digest[:12]),
        ("with", ", ".join(f"{name} {version}" for name, version in made.environment.items())),
    ]
    return Table("Provenance", ("", ""), tuple(facts), "the configuration itself: --json")
