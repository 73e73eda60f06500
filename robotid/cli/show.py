"""The command show: an artifact's content and where it comes from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import Label, load, read_header
from robotid.cli.console import print_json, print_tables, say
from robotid.config.load import parse
from robotid.errors import InputError
from robotid.model.units import on_axis
from robotid.pipeline.table import STAGES
from robotid.report.tables import view
from robotid.report.tables.sliding import slid
from robotid.report.tables.table import Json, Table


def show_artifact(file: Path, *, as_json: bool = False) -> None:
    """Print an artifact of any stage. Raises InputError where it is missing, foreign or damaged."""
    label = read_header(file)
    stage, content = label.provenance.stage, _content(file, label)
    if as_json:
        print_json({"content": view(stage).document(content), "provenance": _document(label)})
    else:
        linear = _linear(label)
        print_tables([*(slid(table, linear=linear) for table in view(stage).tables(content)), _provenance(label)])


def plot_artifact(file: Path, figure: Path) -> None:
    """Draw an artifact into a file, whole or not at all. Raises ConfigError for a format that cannot be drawn."""
    from robotid.report.save import check_format, save_figure

    check_format(figure.suffix.removeprefix("."), str(figure))
    label = read_header(file)
    content = _content(file, label)
    from robotid.report.figures import draw

    save_figure(draw(content, on_axis(linear=_linear(label))), figure)
    say(f"{figure} written")


def _linear(label: Label) -> bool:
    """Whether the axis slides."""
    return parse(label.provenance.configuration).robot.linear


def _content(file: Path, label: Label) -> Any:
    stage = label.provenance.stage
    if stage not in STAGES:
        raise InputError(f'made by a stage "{stage}" that this version does not know', where=str(file))
    return load(file, STAGES[stage].type()).content


def _document(label: Label) -> Json:
    made = label.provenance
    return {
        "kind": label.kind,
        "digest": label.digest,
        "stage": made.stage,
        "command": made.command,
        "version": made.version,
        "created": made.created,
        "inputs": made.inputs,
        "seed": made.seed,
        "environment": made.environment,
        "configuration": made.configuration,
    }


def _provenance(label: Label) -> Table:
    made: Provenance = label.provenance
    facts = [
        ("kind", label.kind),
        ("made by", f"{made.command}, version {made.version}"),
        ("on", made.created),
        ("seed", "-" if made.seed is None else str(made.seed)),
        ("from", "; ".join(f"{name} {digest[:12]}" for name, digest in made.inputs.items()) or "the configuration"),
        ("content", label.digest[:12]),
        ("with", ", ".join(f"{name} {version}" for name, version in made.environment.items())),
    ]
    return Table("Provenance", ("", ""), tuple(facts), "the configuration itself: --json")
