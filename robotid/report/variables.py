"""The variables that a missing torque runs along, in words."""

from __future__ import annotations

from robotid.diagnosis.misfit.curve import BY_DIRECTION, BY_SPEED, Curve

VARIABLES = {
    "dphi_m": "motor speed",
    "phi_m": "motor angle",
    "phi_m mod 2 pi": "motor angle within a turn",
    "phi_a": "arm angle",
    "twist": "gear twist",
    "ddphi_m": "motor acceleration",
    "tau_m": "motor torque",
    "t": "time",
    "reversal": "time since reversal",
    "record": "record",
    "frequency": "frequency",
}
COUNTED = {"": "", BY_DIRECTION: "along the motion", BY_SPEED: "in proportion to speed"}
MIN_SHARE = 0.05  # of the variance that a variable accounts for, from which there is something to see


def variable_of(curve: Curve) -> str:
    """What a curve runs along, in words for a turning axis; the name of a companion."""
    name = curve.along.partition(",")[0]
    if name.startswith("companion["):
        return name.removeprefix("companion[").removesuffix("]")
    return VARIABLES.get(name, name)


def counting_of(curve: Curve) -> str:
    """How a curve counts the torque, in words; empty where it takes the torque as it is."""
    return COUNTED.get(curve.along.partition(",")[2], "")
