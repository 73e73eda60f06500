"""The declaration of an effect as data, ready for a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.term import Term


@dataclass(frozen=True, slots=True)
class Description:
    """An effect in words. ports : where it may act, the usual place first; the signals of a channel. companion : the
    kind of the recorded signal that it reads, empty where it reads none."""

    name: str
    kind: Literal["term", "channel"]
    ports: tuple[str, ...]
    formula: str
    parameters: tuple[Parameter, ...]
    source: str
    signature: str
    companion: str = ""


def describe(effect: Term | Channel) -> Description:
    """The declaration of an effect as data."""
    is_term = isinstance(effect, Term)
    return Description(
        name=effect.name,
        kind="term" if is_term else "channel",
        ports=tuple(map(str, effect.ports if isinstance(effect, Term) else effect.signals)),
        formula=effect.formula,
        parameters=effect.parameters,
        source=effect.source,
        signature=effect.signature,
        companion=effect.companion or "",
    )
