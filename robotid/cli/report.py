"""The report of a run: a page of all that it has found so far, and its figures as files."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from robotid.artifacts.store import ELSEWHERE
from robotid.files import atomic_write, touch
from robotid.interrupt import check
from robotid.pipeline.execute import FORCED, FRESH, Outcome
from robotid.pipeline.report_page import Material, gather, page_file, page_stamp, source_of, why_made
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.table import REPORT, STAGES
from robotid.progress import Begun, Log, Progress
from robotid.report.origin import Origin
from robotid.report.save import Size, check_format, letters_remark, save_figure
from robotid.report.stamp import Report

if TYPE_CHECKING:
    from robotid.report.page import StageTables


@dataclass(frozen=True, slots=True)
class FigureFiles:
    """Where figures are written, as what, and how large; size None: as each is drawn."""

    folder: Path
    form: str = "pdf"
    size: Size | None = None


def make_report(
    run: Runs,
    *,
    force: bool = False,
    dry_run: bool = False,
    log: Log | None = None,
    figures: FigureFiles | None = None,
) -> Outcome:
    """Write the page of a run unless the one there shows just this, and its figures where they are asked for.

    Raises InputError where no stage has run, ConfigError for a format that cannot be drawn.
    """
    if figures is not None:
        check_format(figures.form, "--format")
    material, file, begin = gather(run), page_file(run), time.perf_counter()
    why = why_made(material) or (FORCED if force else "")
    if dry_run:
        return Outcome(REPORT.name, file, False, why or FRESH)
    if log is not None:
        log(Begun(REPORT.name))
    if why:
        atomic_write(file, _page(material), hint=ELSEWHERE)
    else:
        touch(file)  # make compares times
    written, remarks = ((), ()) if figures is None else _write_figures(material, figures, log)
    stamp = page_stamp(run)
    assert stamp is not None
    content = Report(file, stamp.summary, material.stages, dict(material.left_out), written, remarks)
    return Outcome(REPORT.name, file, bool(why), why or FRESH, time.perf_counter() - begin, lambda: content)


def _page(material: Material) -> str:
    from robotid.report.page import AxisPage, page, robot_page
    from robotid.report.tables import by_axis

    run = material.run
    parts = {
        axis: AxisPage(found, _tables(run.axes[axis], material, axis)) for axis, found in material.findings.items()
    }
    sources = [
        source_of(f"{stage}{axis and f', axis {axis}'}", STAGES[stage].output, header)
        for axis, headers in material.fresh.items()
        for stage, header in headers.items()
    ]
    origin = Origin(material.digest, material.configuration, tuple(sources), material.left_out)
    title = run.loaded.config.report.title
    if run.several:
        common = [
            table
            for name, content in next(iter(material.contents.values())).items()
            for table in by_axis.of_robot(STAGES[name].view(), content)
        ]
        return robot_page(parts, origin, title or str(run.loaded.robot["robot"]["name"]), common)
    return page(parts[""].findings, parts[""].stages, origin, title)


def _tables(run: Run, material: Material, axis: str) -> tuple[StageTables, ...]:
    from robotid.report.page import StageTables
    from robotid.report.tables import by_axis
    from robotid.report.tables.sliding import in_units_of_axis

    in_units = partial(in_units_of_axis, linear=run.loaded.config.robot.linear)
    views = {name: STAGES[name].view() for name in material.contents[axis]}
    return tuple(
        StageTables(
            STAGES[name].heading,
            tuple(map(in_units, by_axis.of_axis(views[name], content) if run.several else views[name].tables(content))),
        )
        for name, content in material.contents[axis].items()
    )


def _write_figures(
    material: Material, wanted: FigureFiles, log: Log | None
) -> tuple[tuple[Path, ...], tuple[str, ...]]:
    """The files, and remarks on them."""
    from robotid.report.sections import figure_specs

    every = [
        replace(spec, name=f"{axis}-{spec.name}" if axis else spec.name)
        for axis, findings in material.findings.items()
        for spec in figure_specs(findings)
    ]
    files = tuple(wanted.folder / f"{spec.name}.{wanted.form}" for spec in every)
    shrunk = dict[str, float]()
    for k, (spec, file) in enumerate(zip(every, files, strict=True)):
        check()
        if log is not None:
            log(Progress(spec.name, k, len(every)))
        shrunk[spec.name] = save_figure(spec.draw(), file, wanted.size)
    found = [letters_remark(shrunk[name], name, wanted.size) for name in sorted(shrunk, key=lambda n: shrunk[n])]
    small = [remark for remark in found if remark]
    more = f"; so are those of {len(small) - 1} more, less so" if len(small) > 1 else ""
    return files, tuple(f"{remark}{more}" for remark in small[:1])
