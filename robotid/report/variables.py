"""The variables that a missing torque runs along, in words."""

from __future__ import annotations

from robotid.diagnosis.misfit.curve import BY_DIRECTION, IN_PROPORTION, Curve

VARIABLES = {
    "dphi_m": "motor speed",
    "phi_m": "motor angle",
    "phi_m mod 2 pi": "motor angle within a turn",
    "phi_a": "arm angle",
    "twist": "gear twist",
    "dtwist": "rate of gear twist",
    "ddphi_m": "motor acceleration",
    "tau_m": "motor torque",
    "t": "time",
    "reversal": "time since reversal",
    "record": "record",
    "frequency": "frequency",
}
PROPORTION = {"dphi_m": "speed", "ddphi_m": "acceleration", "twist": "gear twist", "tau_m": "torque"}
"""Of what a torque is counted in proportion to, in words."""
UNITS = {"dphi_m": "rad/s", "ddphi_m": "rad/s2", "twist": "rad", "tau_m": "Nm"}
"""Of these variables on a turning axis."""
MIN_SHARE = 0.05  # of the variance that a variable accounts for, from which there is something to see


def variable_of(curve: Curve) -> str:
    """What a curve runs along, in words for a turning axis; the name of a companion."""
    name = curve.along.partition(",")[0]
    if name.startswith("companion["):
        return name.removeprefix("companion[").removesuffix("]")
    return VARIABLES.get(name, name)


def ordering_of(curve: Curve) -> str:
    """What a torque follows that a curve orders, in words: "follows the gear twist best, counted along the motion"."""
    counting = counting_of(curve)
    return f"follows the {variable_of(curve)} best{f', counted {counting}' if counting else ''}"


def counting_of(curve: Curve) -> str:
    """How a curve counts the torque, in words; empty where it takes the torque as it is."""
    _, _, counted = curve.along.partition(",")
    if counted in IN_PROPORTION:
        return f"in proportion to {PROPORTION[IN_PROPORTION[counted]]}"
    return "along the motion" if counted == BY_DIRECTION else ""
