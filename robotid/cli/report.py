"""The report of a run: a page of all that it has found so far, and its figures as files."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from robotid.artifacts.store import Label, write_text
from robotid.cli.views import view
from robotid.cli.views.sliding import slid
from robotid.report.page import Origin, Source, page
from robotid.report.plates import plates
from robotid.report.save import check_format, save_figure
from robotid.report.summary import summary
from robotid.stages.pipeline import FORCED, FRESH, STAGES, Outcome
from robotid.stages.progress import Begun, Log, Progress
from robotid.stages.report import Material, gather, page_file, why_made
from robotid.stages.stage import Run

STAGE = "report"


@dataclass(frozen=True, slots=True)
class Report:
    """What was written. shows : stages; left_out : artifacts that are stale, and why; figures : files."""

    file: Path
    summary: str
    shows: tuple[str, ...]
    left_out: dict[str, str]
    figures: tuple[Path, ...]


def make_report(
    run: Run,
    *,
    force: bool = False,
    dry_run: bool = False,
    log: Log | None = None,
    figures: Path | None = None,
    form: str = "pdf",
) -> Outcome:
    """Write the page of a run unless the one there shows just this, and its figures into a folder where one is given.

    Raises InputError where no stage has run, ConfigError for a format that cannot be drawn.
    """
    check_format(form, "--format")
    material, file, begin = gather(run), page_file(run), time.perf_counter()
    why = why_made(material) or (FORCED if force else "")
    if dry_run:
        return Outcome(STAGE, file, False, why or FRESH)
    if log is not None:
        log(Begun(STAGE))
    if why:
        write_text(file, _page(material))
    else:
        file.touch()  # make asks by time
    written = () if figures is None else _write_figures(material, figures, form, log)
    told = summary(material.findings())
    content = Report(file, told, tuple(material.fresh), dict(material.left_out), written)
    return Outcome(STAGE, file, bool(why), why or FRESH, time.perf_counter() - begin, content)


def _page(material: Material) -> str:
    loaded = material.run.loaded
    linear = loaded.config.robot.linear
    tables = {
        stage: [slid(table, linear=linear) for table in view(stage).tables(content)]
        for stage, content in material.contents.items()
    }
    sources = tuple(_source(stage, label) for stage, label in material.fresh.items())
    origin = Origin(material.stamp, loaded.resolved_text(), sources, material.left_out)
    return page(material.findings(), tables, origin, loaded.config.report.title)


def _source(stage: str, label: Label) -> Source:
    made = label.provenance
    return Source(
        stage=stage,
        file=STAGES[stage].output,
        command=made.command,
        version=made.version,
        created=made.created,
        digest=label.digest,
        inputs=made.inputs,
        seed=made.seed,
        environment=made.environment,
    )


def _write_figures(material: Material, folder: Path, form: str, log: Log | None) -> tuple[Path, ...]:
    folder.mkdir(parents=True, exist_ok=True)
    every = plates(material.findings())
    files = tuple(folder / f"{plate.name}.{form}" for plate in every)
    for k, (plate, file) in enumerate(zip(every, files, strict=True)):
        if log is not None:
            log(Progress(plate.name, k, len(every)))
        save_figure(plate.draw(), file)
    return files
