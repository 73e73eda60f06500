"""The weight of an arm behind a gear, on an axis that is modelled as rigid and logged at its motor."""

from __future__ import annotations

from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Extreme
from robotid.model.wave import Wave


class GearedGravity(Wave):
    """Weight of an arm at its lever, for any zero of the angle, as it reaches the motor through a gear of ratio r.

    Shows itself as a slow function of motor angle, over many turns. Over an arm's motion of a few degrees it is a
    constant torque and one in proportion to the angle, and r is hardly seen. With the arm as a coordinate of its own,
    this is `gravity` at the arm.
    """

    name = "geared_gravity"
    ports = (Port.MOTOR,)
    instead_of = Port.GEAR
    swings = True
    parameters = (
        # Not zero both: there the fit could not see r.
        Parameter(
            "G",
            "Nm",
            "weight times lever at the motor, part in sin(r x)",
            guess=0.1,
            bounds=(-1e6, 1e6),
            null=0.0,
            carried=True,
        ),
        Parameter(
            "H",
            "Nm",
            "weight times lever at the motor, part in cos(r x)",
            guess=0.1,
            bounds=(-1e6, 1e6),
            null=0.0,
            carried=True,
        ),
        Parameter(
            "r",
            "1",
            "arm angle over motor angle",
            guess=0.01,
            bounds=(1e-4, 1.0),
            grid=(0.003, 0.005, 0.008, 0.012, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5),
            physical=Physical("the arm hardly turns: its weight is a constant torque", bends=0.1),
        ),
    )
    formula = "G sin(r x) + H cos(r x)"
    # Where the arm hardly turns; and a torque that is constant while the motor turns is as good an explanation.
    extremes = (
        Extreme("r", "constant_torque", {"tau0": ("H",)}),
        Extreme("r", "asymmetric_coulomb", {"dFc": ("H",)}),
    )
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.3"
    signature = "a slow function of motor angle, over many turns"
