"""The command show: an artifact's content and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import ArtifactHeader, load, read_header, read_headers
from robotid.cli.console import print_json, print_message, print_tables
from robotid.config.load import parse
from robotid.errors import ConfigError, InputError
from robotid.model.units import on_axis
from robotid.pipeline.stage import Stage
from robotid.pipeline.table import REPORT, STAGES
from robotid.report.stamp import stamp_of
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


def plot_artifact(file: Path, figure: Path, axis: str | None = None, size: str | None = None) -> None:
    """Draw an artifact into a file, whole or not at all. axis : one of several. Raises ConfigError for a directory, for
    a format or a size that cannot be drawn, and for one of several axes that is not named."""
    from robotid.report.figures import draw
    from robotid.report.save import check_format, letters_remark, parse_size, save_figure

    check_format(figure.suffix.removeprefix("."), str(figure))
    wanted = parse_size(size)
    if file.is_dir():
        hint = f"name an artifact in it, or write all figures by `robotid report CONFIG --out {file} --figures DIR`"
        raise ConfigError("a run directory is not one figure", where=str(file), hint=hint)
    header = read_header(file, axis or "")
    content = load(file, _stage(file, header).type(), axis or "").content
    shrunk = save_figure(draw(content, on_axis(linear=_linear(header))), figure, wanted)
    print_message(f"{figure} written")
    if remark := letters_remark(shrunk, figure.name, wanted):
        print_message(remark)


def show_directory(folder: Path, *, as_json: bool = False) -> None:
    """Print what a run directory holds: a line of each artifact, and the answer. Raises InputError where it holds none
    of them, or a damaged one."""
    headers = {stage: read_headers(file) for stage in STAGES.values() if (file := folder / stage.output).is_file()}
    if not headers:
        raise InputError("there is no artifact in this directory", where=str(folder), hint="name one made by `run`")
    lines = {stage: _sentence(stage, folder / stage.output, tuple(found)) for stage, found in headers.items()}
    page = folder / REPORT.output
    stamp = stamp_of(page.read_text(encoding="utf-8", errors="replace")) if page.is_file() else None
    if as_json:
        entries = {
            stage.name: by_axis.document({axis: _document(header) for axis, header in found.items()})
            for stage, found in headers.items()
        }
        results = {stage.name: lines[stage] for stage in headers}
        summary = None if stamp is None else stamp.summary
        print_json({"out": str(folder), "artifacts": entries, "results": results, "summary": summary})
        return
    rows = [(s.name, s.output, _made(found.values()), lines[s]) for s, found in headers.items()]
    if stamp is not None:
        rows.append((REPORT.name, REPORT.output, "", "its answer is below"))
    answer = "" if stamp is None else stamp.summary
    print_tables([Table(str(folder), ("stage", "file", "made", "result"), tuple(rows), answer)])


def _made(headers: Iterable[ArtifactHeader]) -> str:
    """When the last part of an artifact was made, to the minute."""
    return max(header.provenance.created for header in headers)[:16].replace("T", " ")


def _sentence(stage: Stage, file: Path, axes: Sequence[str]) -> str:
    """What came of a stage, empty where there is nothing to state."""
    found = {axis: load(file, stage.type(), axis) for axis in axes}
    linear = {axis: _linear(one.header) for axis, one in found.items()}
    return "; ".join(by_axis.sentences(stage.view(), {axis: one.content for axis, one in found.items()}, linear))


def _linear(header: ArtifactHeader) -> bool:
    """Whether the axis slides."""
    return parse(header.provenance.configuration).robot.linear


def _stage(file: Path, header: ArtifactHeader) -> Stage:
    """The stage that made an artifact. Raises InputError where there is none of its name."""
    name = header.provenance.stage
    if name not in STAGES:
        raise InputError(f'made by a stage "{name}" that this version does not know', where=str(file))
    return STAGES[name]


def _document(header: ArtifactHeader) -> dict[str, Json]:
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
        ("holds", STAGES[made.stage].heading),
        ("made by", f"{made.command}, version {made.version}"),
        ("on", made.created),
        ("seed", "-" if made.seed is None else str(made.seed)),
        ("from", "; ".join(f"{name} {digest[:12]}" for name, digest in made.inputs.items()) or "the configuration"),
        ("content", header.digest[:12]),
        ("with", ", ".join(f"{name} {version}" for name, version in made.environment.items())),
    ]
    return Table("Provenance", ("", ""), tuple(facts), "the configuration itself: --json")
