"""From names to effects and joints: the one place where structures meet the registries of effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any, TypeVar

from robotid.channels import CHANNELS
from robotid.errors import ConfigError
from robotid.model.channel import Channel
from robotid.model.companion import companion_of
from robotid.model.joint import Joint
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure
from robotid.model.term import Term
from robotid.terms import TERMS

EFFECTS: dict[str, Term | Channel] = {**TERMS, **CHANNELS}
"""Every effect by name."""

E = TypeVar("E", bound=Term | Channel)


def assemble(structure: Structure, *, angle: bool = False) -> Joint:
    """The joint a structure names. angle : keep phi_m as a state. Raises ConfigError for an unknown effect."""
    terms = [(Port(port), _find(TERMS, name)) for port, name in map(_split, structure.terms)]
    channels = [(Signal(signal), _find(CHANNELS, name)) for signal, name in map(_split, structure.channels)]
    return Joint(structure, terms, channels, angle=angle)


def with_effect(structure: Structure, effect: str) -> Structure:
    """The same joint with one effect more, by its dotted name; beside records, at the recorded angle where the torque
    of the effect depends on the motor's angle."""
    extended = structure.extended(effect)
    if extended.recorded_angle or len(extended.terms) == len(structure.terms):
        return extended
    return replace(extended, recorded_angle=assemble(replace(extended, changes=())).turning[-1])


def is_late(effect: str) -> bool:
    """Whether an effect, by its dotted name, only makes a signal late."""
    return getattr(EFFECTS.get(effect.rpartition(".")[2]), "is_late", False)


def _split(effect: str) -> tuple[str, str]:
    place, _, name = effect.partition(".")
    return place, name


def _find(registry: Mapping[str, E], name: str) -> E:
    effect, companion = companion_of(name)
    if effect not in registry:
        hint = "`robotid explain` lists them all"
        raise ConfigError(f'there is no effect "{effect}"', where="robot.model", hint=hint)
    found = registry[effect]
    if (found.companion is None) == bool(companion):
        what, where, hint = _misread(found, companion)
        raise ConfigError(what, where=where, hint=hint)
    return reading(found, companion) if companion else found


def reading(effect: E, companion: str) -> E:
    """An effect as one that reads this companion, the same object for the same names."""
    found: E = _reading(effect, companion)
    return found


@cache
def _reading(effect: Any, companion: str) -> Any:
    return effect.reading(companion)


def _misread(effect: Term | Channel, companion: str) -> tuple[str, str, str]:
    """What is wrong with a name, where, and what to write."""
    if companion:
        return f"{effect.name} reads no companion", "robot.model", f"write {effect.name}"
    hint = f"write {effect.name}[NAME], NAME one of the signals of the records whose kind is {effect.companion}"
    return f"{effect.name} reads a companion", "robot.model", hint
