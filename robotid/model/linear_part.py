"""The part of a joint's torques that is linear in its states, summed up once for all samples.

Inertias, springs and dampers at ports whose motion nothing transforms make constant matrices at given parameters. What
is left to be evaluated sample by sample are the other terms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.geometry import Selection
from robotid.model.layout import Layout
from robotid.model.port_motion import Placed
from robotid.model.signal_matrix import Rows, of_numbers
from robotid.model.term import Motion, Partials


@dataclass(frozen=True, slots=True, eq=False)
class LinearPart:
    """Constant matrices at given parameters.

    slopes (nv rows) : of the generalised force to the states; mass (nv, nv). folded : of every place of the joint,
    whether its torque is in these matrices; others : the places whose torque is not. gain : the inverse of the mass
    matrix, None where other terms add to it; diagonal : whether that couples no coordinates.
    """

    slopes: Rows
    mass: Array
    folded: tuple[bool, ...]
    others: tuple[Placed, ...]
    gain: Rows | None
    diagonal: bool

    def force(self, x: Array, u: Array) -> list[Array | float]:
        """B u and the linear torques at states x (nx, n), one (n,) a coordinate."""
        found: list[Array | float] = []
        for j, row in enumerate(self.slopes):
            total: Array | float = u if j == 0 else 0.0
            for k, slope in row.items():
                total = total + slope * x[k]
            found.append(total)
        return found


def linear_part(layout: Layout, theta: Array) -> LinearPart:
    """The linear part at parameters theta (p,). Terms whose torque others read are none of it.

    Raises NumericsError where the joint has no mass.
    """
    reading = any(place.term.reads is not None for place in layout.placed)
    transformed = {place.port for place in layout.placed if place.transform is not None}
    slopes, mass = np.zeros((layout.masses, layout.nx)), np.zeros((layout.masses, layout.masses))
    folded = []
    for place in layout.placed:
        term, between = place.term, place.port in transformed
        plain = term.linear and not (reading or between or term.states or term.companion_name)
        d = _constant(place, theta) if plain else None
        folded.append(d is not None)
        if d is not None:
            _add(slopes, place.q, place.x, d.x)
            _add(slopes, place.q, place.v, d.v)
            _add(mass, place.q, place.q, d.a)
    others = tuple(place for place, known in zip(layout.placed, folded, strict=True) if not known)
    constant = not any(place.reads_acceleration for place in others)
    diagonal = not np.any(mass - np.diag(np.diag(mass)))
    try:
        gain = of_numbers(np.asarray(np.linalg.inv(mass))) if constant else None
    except np.linalg.LinAlgError:
        what = "a mass of the joint vanishes at these parameters"
        raise NumericsError(what, hint="check the parameters' guesses and bounds") from None
    return LinearPart(of_numbers(-slopes), mass, tuple(folded), others, gain, diagonal)


def _constant(place: Placed, theta: Array) -> Partials | None:
    """The slopes of a linear term, None where they are not the same at every sample."""
    zero = np.zeros(1)
    d = place.term.partials(Motion(zero, zero, zero, np.ones(1), zero, np.zeros((0, 1))), place.values(theta))
    constant = all(isinstance(slope, float) for slope in (d.x, d.v, d.a)) and d.s == 0.0 and d.tau == 0.0
    return d if constant else None


def _add(matrix: Array, levers: Selection, along: Selection, slope: Array | float) -> None:
    """Add a torque with this slope along one selection, acting by levers, to a matrix in place."""
    for j, lever in levers:
        for k, part in along:
            matrix[j, k] += lever * part * float(slope)
