"""An iterate: unknowns and nodes together, with the least-squares problem that their linearisation makes.

With the nodes corrected to first order the residual is r + J dz. What is minimised is the merit

    1/2 |r|^2 + c |r| |d| + 1/2 |d|^2,

d the correction of the output (natural level function; Deuflhard 2011, section 3.3): the cost to be expected, how much
it may change with the next correction, c |d|, and how far the nodes are from it. All are in the unit of the cost, and
d falls quadratically where Newton's method contracts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.lifted.linearisation import Linearisation, largest_change, linearise_records, moved_nodes
from robotid.estimate.residual import Evaluation, OutputError, joined_factor
from robotid.estimate.residual import Linearisation as LeastSquares
from robotid.model.array import Array

CONTRACTION = 0.1  # size of a correction beside the one before it
WELL_CONDITIONED = 1e-4  # smallest pivot of scaled normal equations whose triangular factor is good to 1e-8


@dataclass(frozen=True, slots=True, eq=False)
class Iterate:
    """unknowns (m,); nodes (nx, n) and linearisations, one a record; cost, half the square sum of the residuals to
    be expected; defect, that of the output's corrections; factor (m, m), factor^T factor = J^T J; gradient (m,) of
    the cost; largest : change of a node, relative."""

    unknowns: Array
    nodes: tuple[Array, ...]
    parts: tuple[Linearisation, ...]
    cost: float
    defect: float
    factor: Array
    gradient: Array
    largest: float

    @property
    def linear(self) -> LeastSquares:
        """The least-squares problem that its linearisation makes."""
        return LeastSquares(Evaluation(self.unknowns, (), ()), self.factor, self.gradient, ())

    @property
    def merit(self) -> float:
        return self.cost + self.defect + 2.0 * CONTRACTION * float(np.sqrt(self.cost * self.defect))


@np.errstate(all="ignore")  # what overflows is an error below
def iterate(problem: OutputError, unknowns: Array, nodes: Sequence[Array]) -> Iterate:
    """All records linearised at their nodes (nx, n). Raises NumericsError where that is not finite."""
    m, cost, defect, largest = len(unknowns), 0.0, 0.0, 0.0
    normal, gradient, parts = np.zeros((m, m)), np.zeros(m), linearise_records(problem, unknowns, nodes)
    for x, part in zip(nodes, parts, strict=True):
        normal[np.ix_(part.where, part.where)] += part.derivatives @ part.derivatives.T
        gradient[part.where] += part.derivatives @ part.residual
        cost += 0.5 * float(part.residual @ part.residual)
        defect += 0.5 * float(part.correction @ part.correction)
        largest = max(largest, largest_change(x, part.correction_of_nodes))
    if not np.isfinite([cost, defect, *np.diag(normal)]).all():
        raise NumericsError("the linearised simulation is not finite", hint="check the parameters' guesses and bounds")
    return Iterate(unknowns, tuple(nodes), tuple(parts), cost, defect, _factor(normal, parts), gradient, largest)


def _factor(normal: Array, parts: Sequence[Linearisation]) -> Array:
    """A factor of the Jacobian: by Cholesky where that loses little, by orthogonal triangles where it does."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    try:
        factor = np.linalg.cholesky(normal / np.outer(scale, scale)).T
        if np.diag(factor).min() > WELL_CONDITIONED:
            return np.asarray(factor * scale)
    except np.linalg.LinAlgError:
        pass
    triangles = [np.asarray(np.linalg.qr(part.derivatives.T, mode="r")) for part in parts]
    return joined_factor(triangles, [part.where for part in parts])


def advanced_nodes(problem: OutputError, at: Iterate, step: Array) -> list[Array]:
    """The nodes (nx, n) of each record, corrected and moved along with a step (m,) of the unknowns."""
    pairs = zip(at.nodes, at.parts, strict=True)
    return [moved_nodes(problem, x, part.moved(step[part.where])) for x, part in pairs]
