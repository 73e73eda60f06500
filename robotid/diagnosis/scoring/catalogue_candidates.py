"""Every effect of the catalogue that a model could lack, over the grids of its shapes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import numpy as np

from robotid.catalogue import reading
from robotid.channels import CHANNELS
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.channel_candidates import SensorChannelCandidate, TorqueChannelCandidate
from robotid.diagnosis.scoring.term_candidate import TermCandidate
from robotid.model.channel import Channel
from robotid.model.companion import CompanionKind, companion_of
from robotid.model.parameters import Parameter
from robotid.model.port import Port, Signal
from robotid.model.structure import Structure
from robotid.model.term import Term
from robotid.signals.record import Quantity, Record
from robotid.terms import TERMS


def candidates(
    structure: Structure, output: Quantity, skip: Collection[str] = (), records: Sequence[Record] = ()
) -> tuple[EffectCandidate, ...]:
    """All effects of the catalogue that the structure lacks, each at its usual place; elsewhere once it is there. An
    effect that reads a companion is one for every companion of its kind that all records have.

    skip : effects, with or without their place and companion, that are out of the question. records : all of them.
    """
    companions = companions_of(records)
    present = {*structure.terms, *structure.channels}

    def lacking(effect: Term | Channel, place: Port | Signal) -> bool:
        return f"{place}.{effect.name}" not in present

    def wanted(effect: Term | Channel, place: Port | Signal) -> bool:
        plain = companion_of(effect.name)[0]
        named = {f"{place}.{effect.name}", effect.name, f"{place}.{plain}", plain}
        return not named & set(skip) and any(p.null is not None for p in effect.parameters)

    found: list[EffectCandidate] = []
    for term in _every(TERMS, companions):
        port = next((p for p in _ports(term, structure) if lacking(term, p)), None)
        if port is not None and wanted(term, port):
            found += [term_candidate(port, term, values) for values in _grid(term, companions)]
    for channel in _every(CHANNELS, companions):
        signal = next((s for s in _signals(channel, output) if lacking(channel, s)), None)
        if signal is not None and wanted(channel, signal):
            found += [channel_candidate(signal, channel, values) for values in _grid(channel, companions)]
    return tuple(found)


def term_candidate(port: Port, term: Term, values: tuple[float, ...]) -> TermCandidate:
    """A term at a port as a candidate. values : of its parameters."""
    return TermCandidate(f"{port}.{term.name}", values, port, term)


def channel_candidate(signal: Signal, channel: Channel, values: tuple[float, ...]) -> EffectCandidate:
    """A channel on a signal as a candidate: on the torque it drives the motion, elsewhere it only shows."""
    kind = TorqueChannelCandidate if signal is Signal.TORQUE else SensorChannelCandidate
    return kind(f"{signal}.{channel.name}", values, signal, channel)


def _ports(term: Term, structure: Structure) -> list[Port]:
    """The ports of a structure at which a term may act, the usual one first."""
    places = {Port(name.split(".")[0]) for name in structure.terms}
    if term.instead_of in places or (term.swings and structure.linear):
        return []
    if Port.GEAR not in places:
        places = {Port.MOTOR}
    hung = {Port.LINK} if term.ports[0] is Port.LINK and Port.GEAR in places else set()
    return [port for port in term.ports if port in places | hung]


def _signals(channel: Channel, output: Quantity) -> list[Signal]:
    """The signals on which a channel would show in the output, the usual one first."""
    shown = {Signal.TORQUE, Signal.ANGLE} | ({Signal.SPEED} if output == "speed" else set())
    return [signal for signal in channel.signals if signal in shown]


@dataclass(frozen=True, slots=True)
class CommonCompanion:
    """A companion that all records have. mean : of its value over all of them."""

    kind: CompanionKind
    mean: float


def companions_of(records: Sequence[Record]) -> dict[str, CommonCompanion]:
    """The companions that all records have, each of one kind, by name."""
    found: dict[str, CommonCompanion] = {}
    for name, first in records[0].companions.items() if records else ():
        every = [record.companions[name] for record in records if name in record.companions]
        if len(every) == len(records) and all(one.kind is first.kind for one in every):
            found[name] = CommonCompanion(first.kind, float(np.mean(np.concatenate([one.values for one in every]))))
    return found


E = TypeVar("E", bound=Term | Channel)


def _every(effects: Mapping[str, E], companions: Mapping[str, CommonCompanion]) -> Iterator[E]:
    """All effects, those that read a companion once for each of its kind."""
    for effect in effects.values():
        if effect.companion is None:
            yield effect
        else:
            yield from (reading(effect, name) for name, one in companions.items() if one.kind is effect.companion)


def _grid(effect: Term | Channel, companions: Mapping[str, CommonCompanion]) -> Iterator[tuple[float, ...]]:
    """The nulls, with the shapes at every point of their grids, and formulae about the mean of their companion."""

    def points(p: Parameter) -> tuple[float, ...]:
        if p.centres:
            return (companions[effect.companion_name].mean,)
        return p.grid if p.is_shape else (p.guess if p.null is None else p.null,)

    yield from product(*map(points, effect.parameters))
