"""The catalogue of effects, as the effects declare themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robotid.catalogue import EFFECTS
from robotid.config.effects import effect_named
from robotid.display import Displayed
from robotid.model.describe import Description, describe
from robotid.report.display import Columns, View, shows
from robotid.report.tables import effects
from robotid.report.tables.table import Table


@dataclass(frozen=True, slots=True, repr=False)
class Explanation(Displayed):
    """What one effect declares, or several: name, formula, places where it acts, parameters with units and bounds,
    source, and how it shows itself in a residual."""

    effects: tuple[Description, ...]


def explain(effect: str = "") -> Explanation:
    """Explain an effect of the catalogue, or list them all.

    effect : its name, perhaps with the place where it acts and a parameter: "stribeck", "motor.stribeck". Raises
    ConfigError, with the nearest name, where there is none.

    >>> import robotid as rid
    >>> rid.explain("stribeck").effects[0].formula
    'dFs exp(-(v/vs)^2) sgn(v)'
    >>> len(rid.explain().effects) > 20
    True
    >>> rid.explain("stribek")
    Traceback (most recent call last):
    ...
    robotid.errors.ConfigError: explain: there is no effect "stribek"; did you mean stribeck?
    """
    known = [effect_named(effect)] if effect else list(EFFECTS.values())
    return Explanation(tuple(map(describe, known)))


@shows(Explanation)
class ExplanationView(View[Explanation]):
    """One effect in full, several in a line each."""

    def line(self) -> str:
        found = self.content.effects
        return f"{found[0].name}, {found[0].formula}" if len(found) == 1 else f"{len(found)} effects"

    def tables(self) -> Sequence[Table]:
        found = self.content.effects
        return effects.tables(found[0]) if len(found) == 1 else effects.catalogue(found)

    def columns(self) -> Columns:
        if len(self.content.effects) > 1:
            names = ("name", "kind", "formula", "signature", "source")
            return {name: [getattr(d, name) for d in self.content.effects] for name in names}
        declared = ("symbol", "unit", "meaning", "guess", "bounds", "null")
        return {name: [getattr(p, name) for p in self.content.effects[0].parameters] for name in declared}
