"""What a fit compares with the simulation, by what was measured."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.catalogue import assemble
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.record import Quantity, Record

DEFAULT_OUTPUT: Quantity = "speed"  # also where it is derived from the angle: an angle drifts in open loop


def joint_for(structure: Structure, output: Quantity, records: Iterable[Record]) -> Joint:
    """The joint whose output is compared with records: its angle is a state where it is the output, or where a speed is
    derived from it. Raises ConfigError for an unknown effect."""
    return assemble(structure, angle=output == "position" or any(record.speed_is_derived for record in records))
