"""The command explain: the catalogue of effects, told by the effects themselves."""

from __future__ import annotations

from robotid.channels import CHANNELS
from robotid.cli.console import print_json, print_tables
from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.model.channel import Channel
from robotid.model.describe import Description, describe
from robotid.model.parameters import Parameter
from robotid.model.term import Term
from robotid.report.tables.table import Json, Table, number
from robotid.terms import TERMS

EFFECTS: dict[str, Term | Channel] = {**TERMS, **CHANNELS}


def list_effects(*, as_json: bool = False) -> None:
    """Print every effect in a line."""
    known = [describe(effect) for effect in EFFECTS.values()]
    if as_json:
        print_json({d.name: _document(d) for d in known})
        return
    rows = tuple((d.name, ", ".join(d.ports), d.formula, d.signature) for d in known)
    print_tables([Table("Effects", ("effect", "acts at", "formula", "shows itself as"), rows)])


def explain_effect(name: str, *, as_json: bool = False) -> None:
    """Print all that is declared of one effect: `coulomb`, `arm.coulomb` or `arm.coulomb.Fc`. Raises ConfigError."""
    told = describe(EFFECTS[_effect(name)])
    if as_json:
        print_json(_document(told))
        return
    facts = (
        ("torque absorbed" if told.kind == "term" else "signal after it", told.formula),
        ("acts at", ", ".join(told.ports)),
        ("shows itself as", told.signature),
        ("source", told.source),
    )
    columns = ("parameter", "unit", "meaning", "guess", "bounds", "vanishes at", "tried at")
    rows = tuple(map(_row, told.parameters))
    print_tables([Table(told.name, ("", ""), facts), Table("", columns, rows, _legend(told))])


def _effect(name: str) -> str:
    """The effect that a dotted name means, at a place where it may act."""
    words = name.split(".")
    place, effect = (words[0], words[1]) if len(words) > 1 else ("", words[0])
    if effect not in EFFECTS:
        hint = suggest(effect, EFFECTS, many=0) or "`robotid explain` lists them all"
        raise ConfigError(f'there is no effect "{effect}"', where="explain", hint=hint)
    ports = describe(EFFECTS[effect]).ports
    if place and place not in ports:
        raise ConfigError(f"{effect} does not act at {place}", where="explain", hint=f"it acts at {', '.join(ports)}")
    return effect


def _row(p: Parameter) -> tuple[str, ...]:
    bounds = f"{p.bounds[0]:g} to {p.bounds[1]:g}"
    return p.symbol, p.unit, p.meaning, number(p.guess), bounds, number(p.null), ", ".join(map(number, p.grid)) or "-"


def _legend(told: Description) -> str:
    motion = "x, v, a: position, speed and acceleration of the port; s = sgn(v); z: the effect's own states"
    shape = "tried at: a shape, unidentifiable while the effect is absent, is scored over these values"
    parts = [motion] * (told.kind == "term") + [shape] * any(p.is_shape for p in told.parameters)
    return "\n".join(parts)


def _document(told: Description) -> Json:
    return {
        "effect": told.name,
        "kind": told.kind,
        "ports": told.ports,
        "formula": told.formula,
        "parameters": {
            p.symbol: {
                "unit": p.unit,
                "meaning": p.meaning,
                "guess": p.guess,
                "bounds": p.bounds,
                "null": p.null,
                "grid": p.grid,
            }
            for p in told.parameters
        },
        "source": told.source,
        "shows_itself_as": told.signature,
    }
