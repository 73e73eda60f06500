"""The extended model as tables and JSON: before and after on every record, held-out records apart."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from robotid.extension.results import Extension, Score
from robotid.numerals import fixed, listed, number, rms, significant
from robotid.report.events import accounted_for
from robotid.report.tables.diagnose import rejected_document, rejected_table
from robotid.report.tables.estimates import estimates_document
from robotid.report.tables.table import Json, Table

EXTENDED = "extended.yaml"


def tables(extension: Extension) -> tuple[Table, ...]:
    """The models, the records of the fit, those held out, the parameters, and what was dropped."""
    return (
        _models(extension),
        *_records(extension, "Records of the fit", used=True),
        *_records(extension, "Held-out records", used=False),
        _parameters(extension),
        *rejected_table("Dropped again", extension.dropped),
    )


def brief(extension: Extension) -> tuple[Table, ...]:
    """What was gained, where anything was added."""
    return tables(extension)[:3] if extension.added else ()


def document(extension: Extension) -> Json:
    """The `extend --json` document of docs/command-line.md.

    gain : of the fit in % points, and of the RMSE, positive where it fell; heldout : the same for the records that no
    fit used.
    """
    e = extension
    return {
        "before": _scores(e.before),
        "after": _scores(e.after),
        "gain": _gains(e, [name for name in e.before if name in e.after]),
        "heldout": _gains(e, [name for name in e.before if name in e.after and not e.after[name].used]),
        "bic_before": e.bic_before,
        "bic_after": e.bic_after,
        "extended": EXTENDED,
        "model_before": e.model_before,
        "model_after": e.model_after,
        "model": e.model,
        "unit": e.unit,
        "added": e.added,
        "parameters": estimates_document(e.fit.parameters),
        "dropped": [rejected_document(one) for one in e.dropped],
        "events_accounted_for": list(dict.fromkeys(event.record for event in e.events)),
    }


def sentence(extension: Extension) -> str:
    """What was added, and what that gained, held out where anything was."""
    e = extension
    if not e.added:
        return f"nothing was added to {e.model}"
    apart = [name for name, score in e.after.items() if not score.used and name in e.before]
    names = apart or [name for name in e.after if name in e.before]
    gains = map(partial(_gain, e), names)
    pieces = "" if e.fit.horizon is None else f", in pieces of {significant(e.fit.horizon)} s"
    return f"with {', '.join(e.added)}, {e.model} simulates {'held-out ' if apart else ''}{', '.join(gains)}{pieces}"


def _gain(e: Extension, name: str) -> str:
    remark = accounted_for(e.events_of(name))
    risen = f"from {fixed(e.before[name].fit_percent)} to {fixed(e.after[name].fit_percent)} %"
    return f"{name}{remark and f' ({remark})'} {risen}"


def _scores(scores: Mapping[str, Score]) -> Json:
    return {
        "fit_percent": {name: score.fit_percent for name, score in scores.items()},
        "rmse": {name: score.rmse for name, score in scores.items()},
    }


def _gains(e: Extension, names: list[str]) -> Json:
    return {
        "fit_percent": {name: e.after[name].fit_percent - e.before[name].fit_percent for name in names},
        "rmse": {name: e.before[name].rmse - e.after[name].rmse for name in names},
    }


def _models(e: Extension) -> Table:
    facts = (
        ("added", ", ".join(e.added) or "nothing"),
        ("fit of the extended model", e.fit.end.value),
        ("BIC before", number(e.bic_before, 6)),
        ("BIC after", number(e.bic_after, 6)),
    )
    return Table(f"Extension of {e.model}", ("", ""), facts, f"the extended configuration is {EXTENDED}")


def _records(e: Extension, title: str, *, used: bool) -> tuple[Table, ...]:
    names = [name for name, score in e.after.items() if score.used is used and name in e.before]
    rows = tuple((name, *_compared(e.before[name], e.after[name])) for name in names)
    heads = ("record", "fit before [%]", "after", "gain [% points]")
    errors = (f"RMSE before [{e.unit}]", "after", "change [%]")
    eventful = {name: events for name in names if (events := e.events_of(name))}
    note = listed([f"{name}: {accounted_for(events)}" for name, events in eventful.items()])
    return (Table(title, (*heads, *errors), rows, note),) if rows else ()


def _compared(before: Score, after: Score) -> tuple[str, ...]:
    change = 100 * (after.rmse / before.rmse - 1) if before.rmse else float("nan")
    return (
        fixed(before.fit_percent),
        fixed(after.fit_percent),
        fixed(after.fit_percent - before.fit_percent),
        rms(before.rmse, 3),
        rms(after.rmse, 3),
        fixed(change, 1),
    )


def _parameters(e: Extension) -> Table:
    rows = tuple((p.name, number(p.value, 5), number(p.std_robust, 2), p.unit, p.remark) for p in e.fit.parameters)
    return Table("Parameters of the extended model", ("parameter", "value", "sd", "unit", "remark"), rows)
