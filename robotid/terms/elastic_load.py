"""A load behind an elastic gear, on an axis that is modelled as rigid."""

from __future__ import annotations

from robotid.model.hung_mass import HungMass
from robotid.model.parameters import Parameter
from robotid.model.port import Port


class ElasticLoad(HungMass):
    """The flexibility of an axis without a gear in its model: a part of the inertia hangs on the motor elastically.

    Shows itself as a notch and a resonance in the motor's response to torque. Stiffness and damping are given by the
    frequency and damping ratio of the load with the motor locked, k = J w^2 and d = 2 zeta w J, as seen at the motor; w
    is the notch. So the effect vanishes with J, and an axis that is rigid has none. With the arm as a coordinate of its
    own, springs that are not linear, and friction and weight behind the gear, can be added: spring and damper at the
    gear, inertia at the arm.
    """

    name = "elastic_load"
    ports = (Port.MOTOR,)
    instead_of = Port.GEAR
    parameters = (
        # Not zero: there the fit could see neither w nor zeta.
        Parameter(
            "J", "kg m2", "moment of inertia of the load, seen at the motor", guess=0.01, bounds=(0.0, 1e8), null=0.0
        ),
        Parameter(
            "w",
            "rad/s",
            "frequency of the load with the motor locked",
            guess=70.0,
            bounds=(0.1, 1e5),
            grid=(5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0, 57.0, 80.0, 113.0, 160.0, 226.0, 320.0, 453.0, 640.0),
            rings=True,
        ),
        Parameter("zeta", "1", "damping ratio of the load", guess=0.05, bounds=(0.0, 1.0), grid=(0.02, 0.1)),
    )
    formula = "J dz1/dt with dz0/dt = v - z1, dz1/dt = w^2 z0 + 2 zeta w (v - z1)"
    source = "two-mass model; Wernholt & Gunnarsson 2005, section 3"
    signature = "a notch and a resonance in the motor's response to torque"
