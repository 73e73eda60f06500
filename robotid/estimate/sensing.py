"""What a fit compares with the simulation, by what was measured."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.catalogue import assemble
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.record import Quantity, Record

OF_AN_ANGLE: Quantity = "speed"  # of records whose speed is derived from their angle: an open-loop angle drifts


def default_output(records: Iterable[Record]) -> Quantity:
    """What is compared where nothing else is asked: the speed, unless no record has one that was measured."""
    seen = tuple(records)
    return OF_AN_ANGLE if seen and all(record.speed_is_derived for record in seen) else "speed"


def joint_for(structure: Structure, output: Quantity, records: Iterable[Record]) -> Joint:
    """The joint whose output is compared with records: its angle is a state where it is the output, or where a speed is
    derived from it. Raises ConfigError for an unknown effect."""
    return assemble(structure, angle=output == "position" or any(record.speed_is_derived for record in records))
