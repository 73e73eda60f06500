"""The command status: which artifacts are fresh, stale or absent, and why."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from robotid.cli.closing import next_command
from robotid.cli.console import print_json, print_tables
from robotid.numerals import duration
from robotid.pipeline.execute import status
from robotid.pipeline.freshness import StageStatus, State
from robotid.pipeline.report_page import is_current
from robotid.pipeline.run import Runs
from robotid.pipeline.table import REPORT
from robotid.report.tables import by_axis
from robotid.report.tables.table import Table

STATES = {"fresh": "green", "stale": "yellow", "absent": "dim"}


def show_status(run: Runs, *, as_json: bool = False) -> None:
    """Print one row a stage, of several axes a row an axis of it, and the command to type next."""
    found = status(run)
    report = _report(run, found)
    if as_json:
        documents = {a: {"stages": {s.stage: _entry(s) for s in found if s.axis == a}} for a in run.axes}
        print_json({"out": str(run.out), **by_axis.document(documents), REPORT.name: report.document})
        return
    axis = ("axis",) * run.several
    rows = [(s.stage, *((s.axis,) * run.several), s.state.value, s.why, _age(s), str(s.file)) for s in found]
    page = (report.state.value, report.why, report.made, str(report.file))
    rows.append((REPORT.name, *(("",) * run.several), *page))
    columns = ("stage", *axis, "state", "why", "made", "file")
    print_tables([Table("", columns, tuple(rows), f"next: {next_command(run, found)}", STATES)])


@dataclass(frozen=True, slots=True)
class ReportStatus:
    """The state of the page. made : how long ago."""

    file: Path
    state: State
    why: str = ""
    made: str = ""

    @property
    def document(self) -> dict[str, str]:
        """As JSON."""
        return {"state": self.state.value, "why": self.why, "file": str(self.file)}


def _report(run: Runs, found: Sequence[StageStatus]) -> ReportStatus:
    file = run.file(REPORT)
    if not file.is_file():
        return ReportStatus(file, State.ABSENT)
    made = f"{duration(max(0.0, time.time() - file.stat().st_mtime))} ago"
    if is_current(run, found):
        return ReportStatus(file, State.FRESH, made=made)
    return ReportStatus(file, State.STALE, "what it shows has changed", made)


def _entry(s: StageStatus) -> dict[str, str | None]:
    made = s.header.provenance.created if s.header is not None else None
    return {"state": s.state.value, "why": s.why, "file": str(s.file), "made": made}


def _age(s: StageStatus) -> str:
    if s.header is None:
        return ""
    seconds = (datetime.now(UTC) - datetime.fromisoformat(s.header.provenance.created)).total_seconds()
    return f"{duration(max(0.0, seconds))} ago" if seconds < 86400 else s.header.provenance.created[:10]
