"""The command status: which artifacts are fresh, stale or absent, and why."""

from __future__ import annotations

from robotid.cli.console import Table, print_json, print_tables
from robotid.stages.pipeline import Run, StageStatus, status


def show_status(run: Run, *, as_json: bool = False) -> None:
    """Print one row a stage."""
    found = status(run)
    if as_json:
        print_json({"out": str(run.out), "stages": {s.stage: _entry(s) for s in found}})
        return
    rows = tuple((s.stage, s.state.value, s.why, _made(s), str(s.file)) for s in found)
    print_tables([Table("", ("stage", "state", "why", "made", "file"), rows)])


def _entry(s: StageStatus) -> dict[str, str | None]:
    made = s.label.provenance.created if s.label is not None else None
    return {"state": s.state.value, "why": s.why, "file": str(s.file), "made": made}


def _made(s: StageStatus) -> str:
    return s.label.provenance.created if s.label is not None else ""
