"""Weight of what hangs on two axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term


class PoseGravity(Term):
    """Weight of links whose direction another axis decides as well, for any zero of both angles.

    Two axes that are parallel turn the link by the sum of their angles, or by the difference where they count in
    opposite directions (n = -1). Where this axis does not change the link's slope, the other's angle alone counts
    (n = 0).
    Shows itself as misfit that follows the pose of another axis, also at rest.
    """

    name = "pose_gravity"
    ports = (Port.ARM, Port.MOTOR)
    companion = CompanionKind.ANGLE
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "Nm", "weight times lever, part in the sine", guess=1.0, bounds=(-1e6, 1e6), null=0.0),
        Parameter("B", "Nm", "weight times lever, part in the cosine", guess=1.0, bounds=(-1e6, 1e6), null=0.0),
        Parameter(
            "n", "1", "turns of this axis that count", 1.0, bounds=(-1.0, 1.0), grid=(-1.0, 0.0, 1.0), estimated=False
        ),
    )
    formula = "A sin(w + n x) + B cos(w + n x)"
    source = "Siciliano, Sciavicco, Villani & Oriolo 2009, Robotics, section 7.3 (two-link arm)"
    signature = "misfit that follows the pose of another axis, also at rest"

    def torque(self, m: Motion, p: Sequence[float]) -> Array:
        A, B, n = p
        return np.asarray(A * np.sin(m.w + n * m.x) + B * np.cos(m.w + n * m.x))

    def partials(self, m: Motion, p: Sequence[float]) -> Partials:
        A, B, n = p
        sine, cosine = np.sin(m.w + n * m.x), np.cos(m.w + n * m.x)
        slope = A * cosine - B * sine
        return Partials(x=n * slope, theta=(sine, cosine, m.x * slope))
