"""Every effect of the catalogue can be configured at every place where it may act, and survives the round trip."""

from __future__ import annotations

import pytest

from robotid.catalogue import assemble
from robotid.channels import CHANNELS
from robotid.config.load import parse, resolved
from robotid.model.channel import Channel
from robotid.model.port import Port
from robotid.model.structure import Structure
from robotid.model.term import Term
from robotid.terms import TERMS

PLACES = [(str(port), name) for name, term in TERMS.items() for port in term.ports]
PLACES += [(str(signal), name) for name, channel in CHANNELS.items() for signal in channel.signals]


def text(place: str, effect: str) -> str:
    model = {"motor": ["inertia"], "gear": ["spring"], "arm": ["inertia"]}
    if place == "tool":
        model |= {"link": ["spring"], "tool": ["inertia"]}
    listed, companion = model.setdefault(place, []), kind(effect).companion
    written = f'"{effect}[other]"' if companion else effect
    if written not in listed:
        listed.append(written)
    lines = "".join(f"    {port}: [{', '.join(effects)}]\n" for port, effects in model.items())
    signals = f", signals: {{other: {{name: column, kind: {companion}}}}}" if companion else ""
    records = f"records:\n  - {{name: day1, file: day1.csv{signals}}}\n"
    return f"robot:\n  name: axis\n  gear_ratio: 0.01\n  model:\n{lines}{records}"


def kind(effect: str) -> Term | Channel:
    return TERMS.get(effect) or CHANNELS[effect]


def dotted(place: str, effect: str) -> str:
    return f"{place}.{effect}[other]" if kind(effect).companion else f"{place}.{effect}"


@pytest.mark.parametrize(("place", "effect"), PLACES)
def test_round_trip(place: str, effect: str) -> None:
    config = parse(text(place, effect))
    assert parse(resolved(config)) == config
    structure = config.structure()
    assert dotted(place, effect) in (*structure.terms, *structure.channels)
    assert assemble(structure).names


@pytest.mark.parametrize(("place", "effect"), PLACES)
def test_every_parameter_takes_settings(place: str, effect: str) -> None:
    base = text(place, effect)
    for p in kind(effect).parameters:
        name = f"{dotted(place, effect)}.{p.symbol}"
        config = parse(base, overrides=[f"robot.parameters.{name}.guess={p.guess!r}"])
        assert config.robot.parameters[name].guess == p.guess


def test_the_structure_has_the_order_of_the_ports() -> None:
    config = parse(
        "robot:\n  name: a\n  gear_ratio: 0.01\n"
        "  model: {torque: [torque_lag], arm: [inertia], gear: [damper, spring], motor: [coulomb, inertia]}\n"
        "records: [{name: day1, file: day1.csv}]\n"
    )
    terms = ("motor.coulomb", "motor.inertia", "gear.damper", "gear.spring", "arm.inertia")
    assert config.structure() == Structure(terms, ("torque.torque_lag",), 0.01, linear=False)
    assert [t.split(".")[0] for t in terms] == sorted((t.split(".")[0] for t in terms), key=list(Port).index)
