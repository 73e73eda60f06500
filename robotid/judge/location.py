"""Where a misfit sits: the missing torque along the variables of the motion."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The missing torque in bins of one variable.

    along : "dphi_m", "phi_m", "phi_a", "twist", "ddphi_m", "tau_m", "t", "frequency", "reversal" (time since the last
    reversal) or "record". x, missing_torque, spread, count : (bins,) centre, mean, standard deviation within, samples.
    order : share of the missing torque's variance that the curve explains on samples that did not make it. factor :
    "sgn(dphi_m)" or "dphi_m" where the torque is the curve times that.
    """

    along: str
    unit: str
    x: Array = field(metadata={"unit_in": "unit"})
    missing_torque: Array = field(metadata={"unit_in": "torque_unit"})
    spread: Array = field(metadata={"unit_in": "torque_unit"})
    count: Array
    order: float
    factor: str = ""
    torque_unit: str = "Nm"
