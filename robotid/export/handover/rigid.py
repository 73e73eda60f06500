"""A flexible joint as a rigid one: everything beyond the gear moves with the motor."""

from __future__ import annotations

from collections.abc import Mapping

from robotid.export.handover.elements import Element, elements
from robotid.export.handover.handed_model import HandedModel
from robotid.model.port import Port
from robotid.model.structure import Structure

QUANTITIES = ("inertia", "damping", "friction")


def as_rigid(model: HandedModel, omitted: Mapping[str, str]) -> HandedModel:
    """The model of inertia, damping and dry friction at the motor alone: all effects but the omitted ones added up."""
    total, terms = Element(Port.MOTOR), dict[str, str]()
    for name, one in elements(model).items():
        # an inertia that hangs elastically stays, and moves with what it hangs on
        inertia = sum(hung.inertia for hung in one.hung)
        if name in omitted:
            one = Element(one.port)
        lever = model.joint.rigid_speed(one.port)
        parts = ((one.inertia + inertia) * lever**2, one.damping * lever**2, one.friction * abs(lever))
        total += Element(Port.MOTOR, inertia=parts[0], damping=parts[1], friction=parts[2])
        parameters = [p.rpartition(".")[2] for p in model.joint.names if p.startswith(f"{name}.")]
        for quantity, part in zip(QUANTITIES, parts, strict=True):
            if part and len(parameters) == 1:
                terms.setdefault(quantity, f"{Port.MOTOR}.{name.partition('.')[2]}.{parameters[0]}")
    values = {name: float(getattr(total, quantity)) for quantity, name in terms.items()}
    effects = tuple(name.rpartition(".")[0] for name in values)
    before = model.fit.structure
    return model.with_structure(Structure(effects, (), before.gear_ratio, before.linear), values)
