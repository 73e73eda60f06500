"""Which effect a name means."""

from __future__ import annotations

from robotid.catalogue import EFFECTS
from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.model.channel import Channel
from robotid.model.companion import companion_of
from robotid.model.describe import describe
from robotid.model.term import Term


def effect_named(name: str) -> Term | Channel:
    """The effect that a name means: `coulomb`, `arm.coulomb`, `arm.coulomb.Fc` or `arm.coupling[q2]`. Raises
    ConfigError where there is none, or where it does not act there."""
    words = companion_of(name)[0].split(".")
    place, effect = (words[0], words[1]) if len(words) > 1 else ("", words[0])
    if effect not in EFFECTS:
        hint = suggest(effect, EFFECTS, many=0) or "`robotid explain` lists them all"
        raise ConfigError(f'there is no effect "{effect}"', where="explain", hint=hint)
    ports = describe(EFFECTS[effect]).ports
    if place and place not in ports:
        raise ConfigError(f"{effect} does not act at {place}", where="explain", hint=f"it acts at {', '.join(ports)}")
    return EFFECTS[effect]
