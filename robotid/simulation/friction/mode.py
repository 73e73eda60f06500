"""Slipping one way, slipping the other, or sticking: the mode in which a step begins.

Coulomb friction is set-valued, sgn(0) = [-1, 1]: a coordinate at rest stays there while the friction that this needs
is within its level, and slips where the other forces exceed it (Filippov 1988).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index, Mask, taken
from robotid.simulation.friction.step import StepInputs


@dataclass(slots=True, eq=False)
class FrictionMode:
    """The mode of n steps.

    s : (nv + edges, n) directions of motion, then the sides of all edges; sticking : (nv, n) coordinates that friction
    keeps at rest, None where there are none.
    """

    s: Array
    sticking: Mask | None

    def take(self, where: Index | slice) -> FrictionMode:
        """The mode of the steps at these indices."""
        return FrictionMode(taken(self.s, where), None if self.sticking is None else taken(self.sticking, where))


def friction_mode(inputs: StepInputs, x: Array, sides: Array | None = None) -> FrictionMode:
    """The mode that the forces demand at states x (nx, n), where the steps start. sides : (edges, n), where they are
    known already."""
    joint = inputs.joint
    s = np.sign(x[joint.speeds])
    s = joint.directions(x, s, inputs.t, inputs.theta) if sides is None else np.concatenate([s, sides])
    sticking = np.zeros((joint.masses, s.shape[1]), dtype=bool)
    for j in joint.dry:
        still = np.flatnonzero(s[j] == 0.0)
        if still.size:
            s[j, still], sticking[j, still] = _break_away(inputs, x, s, j, still)
    return FrictionMode(s, sticking if sticking.any() else None)


def _break_away(inputs: StepInputs, x: Array, s: Array, j: int, still: Index) -> tuple[Array, Mask]:
    """Direction in which coordinate j starts to slip, and whether it sticks instead, (m,) each, at the m steps `still`
    that begin at rest: it slips where the force overcomes the friction against that very direction."""
    twice, both = np.tile(still, 2), np.repeat([1.0, -1.0], still.size)
    trial = taken(s, twice)
    trial[j] = both
    acting = taken(x, twice), inputs.u[twice], trial, inputs.t[twice], inputs.theta
    force = inputs.joint.force(*acting, inputs.linear)[j]
    ahead, back = np.split(force, 2)
    return np.where(ahead > 0.0, 1.0, np.where(back < 0.0, -1.0, 0.0)), (ahead <= 0.0) & (back >= 0.0)
