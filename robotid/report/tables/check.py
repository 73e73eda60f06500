"""What the checks found in the records, as a table and JSON."""

from __future__ import annotations

from robotid.report.tables.table import Json, Table
from robotid.signals.plausibility import Finding, Plausibility

SEVERITIES = {"fatal": "red", "warning": "yellow", "note": "dim", "accepted": "cyan"}


def tables(found: Plausibility) -> tuple[Table, ...]:
    """A row a finding, the gravest first."""
    rows = tuple((f.record, _severity(f), f.name, f.what, f.consequence, f.cure) for f in found.findings)
    columns = ("record", "severity", "check", "what", "consequence", "cure")
    note = "" if rows else f"nothing was found in {', '.join(found.records)}"
    return (Table("Do the records make sense?", columns, rows, note, SEVERITIES),)


def _severity(finding: Finding) -> str:
    return "accepted" if finding.accepted else finding.severity


def document(found: Plausibility) -> Json:
    """The `check --json` document."""
    return {
        "meaningful": bool(found),
        "records": found.records,
        "findings": [
            {
                "record": f.record,
                "check": f.name,
                "severity": f.severity,
                "accepted": f.accepted,
                "what": f.what,
                "consequence": f.consequence,
                "cure": f.cure,
            }
            for f in found.findings
        ],
    }


def lines(found: Plausibility) -> tuple[str, ...]:
    """A line for each warning and each mistake that was accepted."""
    kept = [f for f in found.findings if f.severity != "note"]
    return tuple(f"check: {f.record}: {f.what}; {f.cure}{' (accepted)' * f.accepted}" for f in kept)


def sentence(found: Plausibility) -> str:
    """What came of it in a line."""
    counts = {s: sum(f.severity == s and not f.accepted for f in found.findings) for s in ("fatal", "warning", "note")}
    listed = ", ".join(f"{count} {s}{'s' * (count != 1 and s != 'fatal')}" for s, count in counts.items() if count)
    return f"{len(found.records)} record{'s' * (len(found.records) != 1)} checked: {listed or 'nothing was found'}"
