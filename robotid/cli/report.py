"""The report of a run: a page of all that it has found so far, and its figures as files."""

from __future__ import annotations

import time
from pathlib import Path

from robotid.artifacts.store import Label, write_text
from robotid.pipeline.execute import FORCED, FRESH, Outcome
from robotid.pipeline.report_page import Material, gather, page_file, why_made
from robotid.pipeline.stage import Run
from robotid.pipeline.table import STAGES
from robotid.progress import Begun, Log, Progress
from robotid.report.figure_specs import figure_specs
from robotid.report.page import Origin, Source, page
from robotid.report.save import check_format, save_figure
from robotid.report.summary import summary
from robotid.report.tables import view
from robotid.report.tables.sliding import slid
from robotid.report.written import Report

STAGE = "report"


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
    every = figure_specs(material.findings())
    files = tuple(folder / f"{plate.name}.{form}" for plate in every)
    for k, (plate, file) in enumerate(zip(every, files, strict=True)):
        if log is not None:
            log(Progress(plate.name, k, len(every)))
        save_figure(plate.draw(), file)
    return files
