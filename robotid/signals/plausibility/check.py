"""How a check is declared."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.finding import Finding, Severity

Examine = Callable[[Evidence], Iterator["Remark"]]


@dataclass(frozen=True, slots=True)
class Remark:
    """A finding before it is given its check's name and its record's."""

    severity: Severity
    what: str
    consequence: str
    cure: str


@dataclass(frozen=True, slots=True)
class Check:
    """One check. summary : what it asks, one line; unless : checks whose findings, a warning or graver, already explain
    what this one would report, if that is no graver."""

    name: str
    summary: str
    examine: Examine
    unless: tuple[str, ...] = ()

    def __call__(self, evidence: Evidence) -> Iterator[Finding]:
        """Its findings on a record."""
        for remark in self.examine(evidence):
            yield Finding(
                self.name, evidence.record.name, remark.severity, remark.what, remark.consequence, remark.cure
            )


def check(*, unless: tuple[str, ...] = ()) -> Callable[[Examine], Check]:
    """Make a function the check of its name; the first line of its docstring is the summary."""

    def declared(examine: Examine) -> Check:
        name = getattr(examine, "__name__")  # noqa: B009
        return Check(name, (examine.__doc__ or "").strip().partition("\n")[0], examine, unless)

    return declared
