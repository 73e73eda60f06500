"""The command compare: runs side by side, and what differs significantly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robotid import __version__
from robotid.artifacts.provenance import digest
from robotid.artifacts.store import read_header
from robotid.cli.console import print_json, print_message, print_tables
from robotid.files import atomic_write
from robotid.numerals import capitalised
from robotid.pipeline.compare import compare_runs
from robotid.pipeline.report_page import source_of
from robotid.pipeline.table import FIT
from robotid.report import comparison
from robotid.report.comparison import RunComparison
from robotid.report.origin import Origin
from robotid.report.tables.sliding import in_units_of_axis
from robotid.report.tables.table import Table


@dataclass(frozen=True, slots=True)
class Compared:
    """What is compared of runs: a model, an axis, the extended models. page : a file to write a page of it into."""

    model: str | None = None
    axis: str = ""
    page: Path | None = None
    extended: bool = False


def compare(folders: Sequence[Path], what: Compared, *, as_json: bool = False) -> None:
    """Print how runs compare, and write a page of it where one is asked for. Raises as `compare_runs` does."""
    found, page = compare_runs(folders, what.model, what.axis, extended=what.extended), what.page
    tables = tuple(in_units_of_axis(table, linear=found.linear) for table in comparison.tables(found))
    if page is not None:
        atomic_write(page, _page(found, tables, folders, what.axis))
    if as_json:
        print_json(comparison.document(found))
    else:
        print_tables(tables)
        print_message(comparison.sentence(found))
    if page is not None:
        print_message(f"{page} written")


def _page(found: RunComparison, tables: tuple[Table, ...], folders: Sequence[Path], axis: str) -> str:
    from robotid.report.page import Head, PageSection, StageTables, rendered

    headers = (read_header(folder / FIT.output, axis) for folder in folders)
    sources = tuple(source_of(name, FIT.output, header) for name, header in zip(found.runs, headers, strict=True))
    stamp = digest("\n".join([__version__, *(one.digest for one in sources)]).encode())
    text = capitalised(comparison.sentence(found))
    title = " and ".join(found.runs) if len(found.runs) == 2 else f"{len(found.runs)} runs"
    head = Head(title, f"{text}. " + " ".join(f"{remark}." for remark in found.remarks))
    sections = [PageSection("Parameters", "", tuple(comparison.figures(found)))]
    return rendered(head, sections, (StageTables("Comparison", tables),), Origin(stamp, "", sources, {}))
