"""A tool behind an elastic link."""

from __future__ import annotations

from robotid.model.hung_mass import HungMass
from robotid.model.parameters import Parameter
from robotid.model.port import Port


class ThirdMass(HungMass):
    """Inertia of a tool that hangs on the arm by a spring and damper of its own.

    Spring and damper are given by the frequency and damping ratio of the tool with the arm locked, k = Jb wb^2 and
    d = 2 zeta wb Jb: so the effect vanishes with Jb, yet the tool's motion, and with it the score of Jb, exists.
    Shows itself as a second resonance.
    """

    name = "third_mass"
    ports = (Port.LINK,)
    parameters = (
        # Not zero: there the fit could see neither wb nor zeta.
        Parameter("Jb", "kg m2", "moment of inertia of the tool", guess=100.0, bounds=(0.0, 1e8), null=0.0),
        Parameter(
            "wb",
            "rad/s",
            "frequency of the tool with the arm locked",
            guess=70.0,
            bounds=(0.1, 1e5),
            grid=(20.0, 28.0, 40.0, 57.0, 80.0, 113.0, 160.0, 226.0, 320.0),
            rings=True,
        ),
        Parameter("zeta", "1", "damping ratio of the link", guess=0.05, bounds=(0.0, 1.0), grid=(0.02, 0.1)),
    )
    formula = "Jb dz1/dt with dz0/dt = v - z1, dz1/dt = wb^2 z0 + 2 zeta wb (v - z1)"
    source = "Wernholt & Gunnarsson 2005, section 6.3"
    signature = "a second resonance"
