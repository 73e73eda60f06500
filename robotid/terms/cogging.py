"""Cogging and torque ripple."""

from __future__ import annotations

from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.wave import Wave


class Cogging(Wave):
    """Torque between magnets and slots, n periods a turn.

    Shows itself as misfit periodic in the motor angle, whatever the direction.
    """

    name = "cogging"
    ports = (Port.MOTOR, Port.ARM)
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "Nm", "amplitude of the sine", guess=0.01, bounds=(-1e5, 1e5), null=0.0),
        Parameter("B", "Nm", "amplitude of the cosine", guess=0.01, bounds=(-1e5, 1e5), null=0.0),
        # One a turn and its harmonics, multiples of two to six pole pairs, least common multiples with the slots.
        Parameter(
            "n",
            "1",
            "periods a turn",
            guess=6.0,
            bounds=(0.1, 1e4),
            grid=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 18.0, 20.0, 24.0, 30.0, 36.0, 48.0, 60.0, 72.0),
            turns=True,
            physical=Physical("the motion covers too few periods", periods=3.0),
        ),
    )
    formula = "A sin(n x) + B cos(n x)"
    source = "Holtz & Springob 1996, IEEE Trans. Industrial Electronics 43(2) (torque ripple)"
    signature = "misfit periodic in the motor angle, whatever the direction"
