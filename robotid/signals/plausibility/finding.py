"""What a check reports: one finding a line, and all findings on a set of records."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal

from robotid.display import Displayed

Severity = Literal["note", "warning", "fatal"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that a check found in one record.

    name : of the check; severity : "note" is worth knowing, "warning" makes a result worse, "fatal" makes it
    meaningless. what : the mistake with its number; consequence : what it does to the result; cure : the setting that
    removes it. accepted : a fatal finding that the user has declared to be right.
    """

    name: str
    record: str
    severity: Severity
    what: str
    consequence: str
    cure: str
    accepted: bool = False

    @property
    def stops(self) -> bool:
        """Whether nothing should be fitted to the record."""
        return self.severity == "fatal" and not self.accepted


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plausibility(Displayed):
    """All findings on records, the gravest first. records : names of those that were checked."""

    records: tuple[str, ...]
    findings: tuple[Finding, ...]

    def __bool__(self) -> bool:
        """Whether a fit to these records means something."""
        return not self.fatal

    @property
    def fatal(self) -> tuple[Finding, ...]:
        """The findings that make a result meaningless and were not accepted."""
        return tuple(finding for finding in self.findings if finding.stops)

    def accepting(self, names: Collection[str]) -> Plausibility:
        """With the fatal findings of these checks known to be right, and no others."""
        marked = (replace(f, accepted=f.severity == "fatal" and f.name in names) for f in self.findings)
        return replace(self, findings=tuple(marked))

    def named(self, name: str) -> tuple[Finding, ...]:
        """The findings of one check."""
        return tuple(finding for finding in self.findings if finding.name == name)
