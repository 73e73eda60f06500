"""The command explain: the catalogue of effects, as they describe themselves."""

from __future__ import annotations

from robotid.catalogue import EFFECTS
from robotid.cli.console import print_json, print_tables
from robotid.config.effects import effect_named
from robotid.model.describe import describe
from robotid.report.tables import effects


def list_effects(*, as_json: bool = False) -> None:
    """Print every effect in a line."""
    known = [describe(effect) for effect in EFFECTS.values()]
    if as_json:
        print_json({d.name: effects.document(d) for d in known})
    else:
        print_tables(effects.catalogue(known))


def explain_effect(name: str, *, as_json: bool = False) -> None:
    """Print all that is declared of one effect: `coulomb`, `arm.coulomb` or `arm.coulomb.Fc`. Raises ConfigError."""
    description = describe(effect_named(name))
    if as_json:
        print_json(effects.document(description))
    else:
        print_tables(effects.tables(description))
