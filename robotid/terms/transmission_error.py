"""Transmission error of a gear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.parameters import Parameter
from robotid.model.physical import Physical
from robotid.model.port import Port
from robotid.model.term import Motion, MotionTransform, Partials


class TransmissionError(MotionTransform):
    """The output of the gear is not where its ratio says: an offset of the twist with n periods a turn of the motor.

    It acts through the spring and the damper on both sides: on the motor by the changing lever, too.
    Shows itself as misfit periodic in the motor angle that grows with the stiffness and excites the resonance.
    """

    name = "transmission_error"
    ports = (Port.GEAR,)
    parameters = (
        # Not zero both: there the fit could not see n.
        Parameter("A", "rad", "amplitude of the sine", guess=1e-5, bounds=(-0.1, 0.1), null=0.0),
        Parameter("B", "rad", "amplitude of the cosine", guess=1e-5, bounds=(-0.1, 0.1), null=0.0),
        Parameter(
            "n",
            "1",
            "periods a turn of the motor",
            guess=2.0,
            bounds=(1e-3, 1e4),
            grid=(0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0),
            turns=True,
            physical=Physical("the motion covers too few periods", periods=3.0),
        ),
    )
    formula = "springs see x + A sin(n phi_m) + B cos(n phi_m), dampers its rate, the motor the lever that so changes"
    source = "Tuttle & Seering 1996, IEEE Trans. Robotics and Automation 12(3) (kinematic error of harmonic drives)"
    signature = "misfit periodic in the motor angle that grows with the stiffness and excites the resonance"
    watches = Port.MOTOR
    follows = True

    def transform(self, m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
        offset, slope, _ = _error(m, p)
        return m.x + offset, m.v + slope * m.vw, m.s

    def transform_partials(self, m: Motion, p: Sequence[float]) -> tuple[Partials, Partials, Partials]:
        n = p[2]
        sine, cosine = np.sin(n * m.xw), np.cos(n * m.xw)
        _, slope, bow = _error(m, p)
        x = Partials(x=1.0, xw=slope, theta=(sine, cosine, m.xw * slope / n))
        v = Partials(
            v=1.0,
            xw=bow * m.vw,
            vw=slope,
            theta=(n * cosine * m.vw, -n * sine * m.vw, (slope + m.xw * bow) / n * m.vw),
        )
        return x, v, Partials(s=1.0, theta=(0.0, 0.0, 0.0))


def _error(m: Motion, p: Sequence[float]) -> tuple[Array, Array, Array]:
    """The offset, and its first and second derivative to the motor angle, (n,) each."""
    A, B, n = p
    sine, cosine = np.sin(n * m.xw), np.cos(n * m.xw)
    offset = A * sine + B * cosine
    return offset, n * (A * cosine - B * sine), -n * n * offset
