"""The command status: which artifacts are fresh, stale or absent, and why."""

from __future__ import annotations

from datetime import UTC, datetime

from robotid.cli.closing import next_command
from robotid.cli.console import print_json, print_tables
from robotid.numerals import duration
from robotid.pipeline.execute import status
from robotid.pipeline.freshness import StageStatus
from robotid.pipeline.run import Runs
from robotid.report.tables import by_axis
from robotid.report.tables.table import Table

STATES = {"fresh": "green", "stale": "yellow", "absent": "dim"}


def show_status(run: Runs, *, as_json: bool = False) -> None:
    """Print one row a stage, of several axes a row an axis of it, and the command to type next."""
    found = status(run)
    if as_json:
        documents = {a: {"stages": {s.stage: _entry(s) for s in found if s.axis == a}} for a in run.axes}
        print_json({"out": str(run.out), **by_axis.document(documents)})
        return
    axis = ("axis",) * run.several
    rows = tuple((s.stage, *((s.axis,) * run.several), s.state.value, s.why, _age(s), str(s.file)) for s in found)
    columns = ("stage", *axis, "state", "why", "made", "file")
    print_tables([Table("", columns, rows, f"next: {next_command(run, found)}", STATES)])


def _entry(s: StageStatus) -> dict[str, str | None]:
    made = s.header.provenance.created if s.header is not None else None
    return {"state": s.state.value, "why": s.why, "file": str(s.file), "made": made}


def _age(s: StageStatus) -> str:
    if s.header is None:
        return ""
    seconds = (datetime.now(UTC) - datetime.fromisoformat(s.header.provenance.created)).total_seconds()
    return f"{duration(max(0.0, seconds))} ago" if seconds < 86400 else s.header.provenance.created[:10]
