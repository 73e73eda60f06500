"""Every effect that a model could lack, over the grids of its shapes, ready to be scored."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf

from robotid.channels import CHANNELS
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.parameters import Parameter
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure, change
from robotid.model.term import Term
from robotid.signals.record import Quantity
from robotid.terms import TERMS


@dataclass(frozen=True, slots=True)
class Difference:
    """A parameter of the joint that is another in one record."""

    record: str
    column: int
    parameters: tuple[Parameter, ...]


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect at its null. values : its parameters, shapes at one point of their grids."""

    name: str
    place: Port | Signal | None
    effect: Term | Channel | Difference
    values: tuple[float, ...]

    @property
    def scored(self) -> tuple[int, ...]:
        """Indices of the parameters that make it appear."""
        return tuple(k for k, p in enumerate(self.effect.parameters) if p.null is not None)

    def at(self, k: int, value: float) -> Candidate:
        """The candidate with another value of its parameter k."""
        return replace(self, values=(*self.values[:k], value, *self.values[k + 1 :]))


def candidates(structure: Structure, output: Quantity, skip: Collection[str] = ()) -> tuple[Candidate, ...]:
    """All effects of the catalogue that the structure lacks, each at its usual place; elsewhere once it is there.

    skip : effects, with or without their place, that are out of the question.
    """
    present = {*structure.terms, *structure.channels}
    found: list[Candidate] = []
    everything: list[tuple[Term | Channel, Sequence[Port | Signal]]] = [*_terms(structure), *_channels(output)]
    for effect, places in everything:
        place = next((p for p in places if f"{p}.{effect.name}" not in present), None)
        name = f"{place}.{effect.name}"
        wanted = not {name, effect.name} & set(skip) and any(p.null is not None for p in effect.parameters)
        if place is not None and wanted:
            found += [Candidate(name, place, effect, values) for values in _grid(effect)]
    return tuple(found)


def differences(joint: Joint, columns: Sequence[int], records: Sequence[str]) -> tuple[Candidate, ...]:
    """Every fitted parameter of a term, shapes apart, as different in each record. columns : indices into theta."""
    found = []
    for record in records:
        for k in columns:
            name = change(record, joint.names[k])
            if k < joint.n_theta and not joint.declared[k].is_shape and name not in joint.names:
                declared = replace(joint.declared[k], bounds=(-inf, inf), null=0.0)
                found.append(Candidate(name, None, Difference(record, k, (declared,)), (0.0,)))
    return tuple(found)


def _terms(structure: Structure) -> Iterator[tuple[Term, list[Port]]]:
    places = {Port(name.split(".")[0]) for name in structure.terms}
    if Port.GEAR not in places:
        places = {Port.MOTOR}
    for term in TERMS.values():
        hung = {Port.LINK} if term.ports[0] is Port.LINK and Port.GEAR in places else set()
        yield term, [port for port in term.ports if port in places | hung]


def _channels(output: Quantity) -> Iterator[tuple[Channel, list[Signal]]]:
    sensors = {Signal.TORQUE, Signal.ANGLE} | ({Signal.SPEED} if output == "speed" else set())
    for channel in CHANNELS.values():
        yield channel, [signal for signal in channel.signals if signal in sensors]


def _grid(effect: Term | Channel) -> Iterator[tuple[float, ...]]:
    """The nulls, with the shapes at every point of their grids."""
    yield from product(*(p.grid if p.is_shape else (p.guess if p.null is None else p.null,) for p in effect.parameters))
