"""All checks on all records."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from importlib import import_module
from pkgutil import iter_modules

from robotid.errors import NumericsError
from robotid.signals.plausibility import checks
from robotid.signals.plausibility.check import Check
from robotid.signals.plausibility.evidence import Axis, Evidence
from robotid.signals.plausibility.finding import Finding, Plausibility, Severity
from robotid.signals.quality import Recordings

GRAVITY = {"fatal": 0, "warning": 1, "note": 2}


def _discovered() -> dict[str, Check]:
    """Every check of every file, those first whose findings others wait for."""
    modules = [import_module(f"{checks.__name__}.{module.name}") for module in iter_modules(checks.__path__)]
    waiting = {one.name: one for module in modules for one in vars(module).values() if isinstance(one, Check)}
    ordered: dict[str, Check] = {}
    while waiting:
        ready = [one for one in waiting.values() if not set(one.unless) & set(waiting)]
        if not ready:
            raise TypeError(f"these checks wait for each other: {', '.join(waiting)}")
        for one in ready:
            ordered[one.name] = waiting.pop(one.name)
    return ordered


CHECKS: dict[str, Check] = _discovered()
"""Every check by name, in the order in which they are asked."""


def check_records(recordings: Recordings, axis: Axis, accepted: Collection[str] = ()) -> Plausibility:
    """Whether records make sense. accepted : names of checks whose fatal findings are known to be right."""
    fitted = [record for record in recordings.records if record.role == "estimate"]
    findings: list[Finding] = []
    for record, report in zip(recordings.records, recordings.reports, strict=True):
        others = fitted if record.role == "validate" else ()
        findings += _found(Evidence(record, report, axis, others))
    found = Plausibility(
        tuple(record.name for record in recordings.records),
        tuple(sorted(findings, key=lambda finding: GRAVITY[finding.severity])),
    )
    return found.accepting(accepted)


def _found(evidence: Evidence) -> Iterator[Finding]:
    """The findings on one record, but those that a finding as grave of another check explains."""
    found: dict[str, Severity] = {}
    for one in CHECKS.values():
        before = {found[name] for name in one.unless if name in found}
        if "fatal" in before:
            continue
        for finding in one(evidence):
            if before and finding.severity != "fatal":
                continue
            if finding.severity != "note" and found.get(one.name) != "fatal":
                found[one.name] = finding.severity
            yield finding


def refuse_meaningless(found: Plausibility, check: str, accept: str) -> None:
    """Raises NumericsError for the first finding that makes a result meaningless.

    check : what to type to see all findings; accept : how a finding is accepted, with {name} in it.
    """
    fatal = found.fatal
    if not fatal:
        return
    first: Finding = fatal[0]
    records = [finding.record for finding in fatal if finding.name == first.name]
    others = list(dict.fromkeys(finding.name for finding in fatal if finding.name != first.name))
    more = f" ({', '.join(records[1:])} alike)" if records[1:] else ""
    besides = f"; besides: {', '.join(others)}, see `{check}`" if others else ""
    raise NumericsError(
        f"{first.what}{more}, so that {first.consequence}",
        where=first.record,
        hint=f"{first.cure}; {accept.format(name=first.name)} accepts it{besides}",
    )
