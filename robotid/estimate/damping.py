"""Steps of the iteration of Levenberg and Marquardt, as long as they are worth.

A step without gain is followed by one that is shorter by as much as its rise of the cost tells. Damping sets a length
only where it exceeds what the columns know of a direction, so the length is what is chosen, and the damping follows
from it (More 1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.estimate.residual import Linearisation
from robotid.model.array import Array, Mask

MIN_DAMPING, MAX_DAMPING = 1e-14, 1e10  # of columns of unit norm
SHORTEST, LONGEST = 0.1, 0.5  # length of the next step relative to one without gain (Dennis & Schnabel 1996)
LENGTH_TOLERANCE = 0.05  # relative, of a damped step: where the cost is lowest is an estimate


def lowest_along(slope: float, rise: float) -> float:
    """Share of a refused step at which a parabola with this slope at its start, and this rise of the cost at its end,
    is lowest."""
    return float(np.clip(-0.5 * slope / max(rise - slope, 1e-300), SHORTEST, LONGEST))


def damped_step(at: Linearisation, active: Mask, damping: float) -> Array:
    """The Levenberg-Marquardt step of the unknowns that no bound stops, (m,)."""
    return DampedSteps.of(at, active).at(damping)


@dataclass(frozen=True, slots=True, eq=False)
class DampedSteps:
    """The Levenberg-Marquardt steps from a linearisation, for any damping, from one singular value decomposition.

    free (m,) : the unknowns that move; scale (f,) : lengths of their columns; directions (f, f) : in rows, of unknowns
    times scale; values, descent (f,) : squared singular value and negative gradient along each.
    """

    free: Mask
    scale: Array
    directions: Array
    values: Array
    descent: Array

    @classmethod
    def of(cls, at: Linearisation, active: Mask) -> DampedSteps:
        """active (m,) : the unknowns that a bound stops."""
        scale = np.linalg.norm(at.factor, axis=0)
        free = ~active & (scale > 0)
        scale = scale[free]
        _, values, directions = np.linalg.svd(at.factor[:, free] / scale, full_matrices=False)
        return cls(free, scale, directions, values**2, directions @ (-at.gradient[free] / scale))

    def at(self, damping: float) -> Array:
        """The step of this damping, (m,)."""
        step = np.zeros(len(self.free))
        step[self.free] = self.directions.T @ (self.descent / (self.values + damping)) / self.scale
        return step

    def damping_of(self, share: float, damping: float) -> float:
        """The damping of a step that has this share of the length, in scaled unknowns, of the step of another damping.

        Newton's iteration on the inverse of the length, which is concave: it comes from below (Hebden 1973; More 1978).
        """
        goal = share * float(np.linalg.norm(self.descent / (self.values + damping)))
        while damping < MAX_DAMPING:
            along = self.descent / (self.values + damping)
            length = float(np.linalg.norm(along))
            if length <= (1.0 + LENGTH_TOLERANCE) * goal:
                break
            damping += (length / goal - 1.0) * length**2 / float(np.sum(along**2 / (self.values + damping)))
        return damping
