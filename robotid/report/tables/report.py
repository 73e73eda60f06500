"""What was reported, as a table and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    from robotid.report.stamp import Report


def tables(report: Report) -> tuple[Table, ...]:
    """The answer, and where the rest is."""
    figures = f"{len(report.figures)} in {report.figures[0].parent}" if report.figures else ""
    left_out = "; ".join(f"{file}: {why}" for file, why in report.left_out.items())
    facts = (("answer", report.summary), ("page", str(report.file)), ("figures", figures), ("left out", left_out))
    return (Table("Report", ("", ""), tuple(fact for fact in facts if fact[1]), "\n".join(report.remarks)),)


def document(report: Report) -> Json:
    """The `report --json` document."""
    return {
        "report": str(report.file),
        "summary": report.summary,
        "shows": report.shows,
        "left_out": report.left_out,
        "figures": [str(file) for file in report.figures],
        "remarks": report.remarks,
    }


def sentence(report: Report) -> str:
    """Where the page is."""
    return f"the report is {report.file}"
