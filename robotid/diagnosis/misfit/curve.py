"""The missing torque along one variable of the motion."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.model.array import Array

BY_DIRECTION, BY_SPEED, BY_ACCELERATION = " by direction", " by speed", " by acceleration"
BY_TWIST, BY_TORQUE = " by twist", " by torque"
"""How a torque is counted, after the variable and a comma."""
IN_PROPORTION = {BY_SPEED: "dphi_m", BY_ACCELERATION: "ddphi_m", BY_TWIST: "twist", BY_TORQUE: "tau_m"}
"""To which variable a torque is in proportion that is counted so."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The missing torque in bins of one variable.

    along : "dphi_m", "phi_m", "phi_m mod 2 pi", "phi_a", "twist", "dtwist" (its rate), "ddphi_m", "tau_m", "t",
    "reversal" (time since the last one, negative while moving backwards), "record" (its number, from 0) or "frequency"
    (where missing_torque is the root mean square of each band). After ", by direction" the torque is counted along the
    motion, after ", by speed", ", by acceleration", ", by twist" or ", by torque" in proportion to that, as large as it
    is where that is `at`. x, missing_torque, spread, count : (bins,) centre, mean, standard deviation within, samples.
    order : share of the missing torque's variance that the curve explains on samples that did not make it, about the
    one value, counted alike, that explains most of it in all bins; zero where it explains none.
    """

    along: str
    unit: str
    x: Array = field(metadata={"unit_in": "unit", "shape": ("bins",), "finite": True})
    missing_torque: Array = field(metadata={"unit": "Nm", "shape": ("bins",)})
    spread: Array = field(metadata={"unit": "Nm", "shape": ("bins",), "least": 0.0})
    count: Array = field(metadata={"shape": ("bins",), "least": 0.0})
    order: float = field(metadata={"finite": True})
    at: float = field(default=1.0, metadata={"finite": True})

    @property
    def needs(self) -> tuple[str, ...]:
        """The variables that the torque is ordered and counted by."""
        name, _, counted = self.along.partition(",")
        return (name, IN_PROPORTION[counted]) if counted in IN_PROPORTION else (name,)
