"""The catalogue of effects as tables and JSON, as they describe themselves."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.model.describe import Description
from robotid.model.parameters import Parameter
from robotid.numerals import number
from robotid.report.tables.table import Json, Table


def catalogue(effects: Sequence[Description]) -> tuple[Table, ...]:
    """Every effect in a row."""
    rows = tuple((d.name, ", ".join(d.ports), d.formula, d.signature) for d in effects)
    return (Table("Effects", ("effect", "acts at", "formula", "shows itself as"), rows),)


def tables(effect: Description) -> tuple[Table, ...]:
    """All that is declared of one effect."""
    facts = (
        ("torque absorbed" if effect.kind == "term" else "signal after it", effect.formula),
        ("acts at", ", ".join(effect.ports)),
        *([("reads", _companion(effect))] if effect.companion else []),
        ("shows itself as", effect.signature),
        ("source", effect.source),
    )
    columns = ("parameter", "unit", "meaning", "guess", "bounds", "vanishes at", "tried at")
    rows = tuple(map(_row, effect.parameters))
    return Table(effect.name, ("", ""), facts), Table("", columns, rows, _legend(effect))


def document(effect: Description) -> Json:
    """The `explain --json` document."""
    return {
        "effect": effect.name,
        "kind": effect.kind,
        "ports": effect.ports,
        "formula": effect.formula,
        "companion": effect.companion or None,
        "parameters": {
            p.symbol: {
                "unit": p.unit,
                "meaning": p.meaning,
                "guess": p.guess,
                "bounds": p.bounds,
                "null": p.null,
                "grid": p.grid,
                "physical": None if p.physical is None else p.physical.text,
            }
            for p in effect.parameters
        },
        "source": effect.source,
        "shows_itself_as": effect.signature,
    }


def _companion(effect: Description) -> str:
    return f"a companion w of kind {effect.companion}, written {effect.name}[NAME]"


def _row(p: Parameter) -> tuple[str, ...]:
    bounds = f"{p.bounds[0]:g} to {p.bounds[1]:g}"
    return p.symbol, p.unit, p.meaning, number(p.guess), bounds, number(p.null), ", ".join(map(number, p.grid)) or "-"


def _legend(effect: Description) -> str:
    motion = "x, v, a: position, speed and acceleration of the port; s = sgn(v); z: the effect's own states"
    shape = "tried at: a shape, unidentifiable while the effect is absent, is scored over these values"
    parts = [motion] * (effect.kind == "term") + [shape] * any(p.is_shape for p in effect.parameters)
    parts += [f"{p.symbol} of a cause: {p.physical.text}" for p in effect.parameters if p.physical is not None]
    return "\n".join(parts)
