"""The command show: an artifact's content and where it comes from."""

from __future__ import annotations

from pathlib import Path

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import ArtifactHeader, load, read_header
from robotid.cli.console import print_json, print_message, print_tables
from robotid.config.load import parse
from robotid.errors import InputError
from robotid.model.units import on_axis
from robotid.pipeline.stage import Stage
from robotid.pipeline.table import STAGES
from robotid.report.tables.sliding import in_units_of_axis
from robotid.report.tables.table import Json, Table


def show_artifact(file: Path, *, as_json: bool = False) -> None:
    """Print an artifact of any stage. Raises InputError where it is missing, foreign or damaged."""
    header = read_header(file)
    stage = _stage(file, header)
    content, view = load(file, stage.type()).content, stage.view()
    if as_json:
        print_json({"content": view.document(content), "provenance": _document(header)})
    else:
        linear = _linear(header)
        tables = (in_units_of_axis(table, linear=linear) for table in view.tables(content))
        print_tables([*tables, _provenance(header)])


def plot_artifact(file: Path, figure: Path) -> None:
    """Draw an artifact into a file, whole or not at all. Raises ConfigError for a format that cannot be drawn."""
    from robotid.report.figures import draw
    from robotid.report.save import check_format, save_figure

    check_format(figure.suffix.removeprefix("."), str(figure))
    header = read_header(file)
    content = load(file, _stage(file, header).type()).content
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
