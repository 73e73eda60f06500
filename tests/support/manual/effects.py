"""The catalogue of effects for the manual, as the effects declare themselves."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.channels import CHANNELS
from robotid.model.channel import Channel
from robotid.model.describe import Description, describe
from robotid.model.parameters import Parameter
from robotid.model.term import Term
from robotid.numerals import number
from robotid.terms import TERMS
from support.manual.markdown import table

TORQUES, SIGNALS = "torque that it absorbs", "signal after it"
COLUMNS = ("parameter", "unit", "meaning", "guess", "bounds", "null", "tried at")


def catalogue() -> str:
    """All effects in two tables: torques, then signals."""
    return f"{_overview('acts at', TORQUES, TERMS.values())}\n\n{_overview('acts on', SIGNALS, CHANNELS.values())}"


def details() -> str:
    """A section for every effect: equation, place, source and the table of its parameters."""
    return "\n\n".join(_section(describe(effect)) for effect in (*TERMS.values(), *CHANNELS.values()))


def _overview(place: str, formula: str, effects: Iterable[Term | Channel]) -> str:
    rows = (_row(describe(effect)) for effect in effects)
    return table(("effect", place, formula, "shows itself as", "source"), rows)


def _row(told: Description) -> tuple[str, ...]:
    return f"[`{told.name}`](#{told.name})", ", ".join(told.ports), f"`{told.formula}`", told.signature, told.source


def _section(told: Description) -> str:
    what = TORQUES if told.kind == "term" else SIGNALS
    lines = [
        f"### {told.name}",
        f"- {what[0].upper()}{what[1:]}: `{told.formula}`",
        f"- Acts {'at' if told.kind == 'term' else 'on'}: {', '.join(told.ports)}",
        *([f"- Reads: a companion `w` of kind {told.companion}, `{told.name}[NAME]`"] if told.companion else []),
        f"- Shows itself as: {told.signature}",
        f"- Source: {told.source}",
    ]
    return "\n".join([lines[0], "", *lines[1:], "", table(COLUMNS, map(_parameter, told.parameters))])


def _parameter(p: Parameter) -> tuple[str, ...]:
    bounds = f"{p.bounds[0]:g} to {p.bounds[1]:g}"
    tried = ", ".join(map(number, p.grid)) or "-"
    return f"`{p.symbol}`", p.unit, p.meaning, number(p.guess), bounds, number(p.null), tried
