"""From names to effects and joints: the one place where structures meet the registries of effects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from robotid.channels import CHANNELS
from robotid.errors import ConfigError
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure
from robotid.model.term import Term
from robotid.terms import TERMS

EFFECTS: dict[str, Term | Channel] = {**TERMS, **CHANNELS}
"""Every effect by name."""

E = TypeVar("E")


def assemble(structure: Structure, *, angle: bool = False) -> Joint:
    """The joint a structure names. angle : keep phi_m as a state. Raises ConfigError for an unknown effect."""
    terms = [(Port(port), _find(TERMS, name)) for port, name in map(_split, structure.terms)]
    channels = [(Signal(signal), _find(CHANNELS, name)) for signal, name in map(_split, structure.channels)]
    return Joint(structure, terms, channels, angle=angle)


def _split(effect: str) -> tuple[str, str]:
    place, _, name = effect.partition(".")
    return place, name


def _find(registry: Mapping[str, E], name: str) -> E:
    if name not in registry:
        raise ConfigError(f'there is no effect "{name}"', where="robot.model", hint="`robotid explain` lists them all")
    return registry[name]
