"""Inertial parameters that a body can have, as near to a start as the data allow.

The ten parameters of a link are those of some mass in space if its pseudo-inertia, the second moments of its density
in homogeneous coordinates, is positive definite: four by four, linear in the parameters (Wensing, Kim & Slotine 2018).
What the data do not show keeps near the start, measured by the divergence of the two densities,

    D(J, J0) = tr(J0^-1 J) - log det(J0^-1 J) - 4 ,

which does not depend on the frame or on units, and is infinite where a body becomes impossible (Lee & Park 2018). Least
squares plus this divergence is convex in the parameters themselves: it has one minimum, which Newton's method finds.
The log-Cholesky parametrisation (Rucker & Wensing 2022) of the same problem has several.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np

from robotid.body.chain import PER_LINK
from robotid.model.array import Array

MAX_ITERATIONS = 200
DECREMENT = 1e-10  # of the cost that a full step would still save, against the cost, at which Newton's method ends
SUFFICIENT = 1e-4  # share of the predicted decrease that a step must reach
SHORTEST_STEP = 1e-12
RIDGE = 1e-12  # of the diagonal: keeps parameters that nothing shows at their place

_TRIU = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def start_weight(factor: float) -> float:
    """The weight of the divergence at which a mass that is wrong by this factor counts as one standard deviation: for a
    density of another mass D = 2 (log of the factor)^2 to second order."""
    return 1 / (4 * log(factor) ** 2)


def pseudo_inertia(parameters: Array) -> Array:
    """Pseudo-inertia of ten parameters, (..., 10) -> (..., 4, 4)."""
    return np.asarray(np.einsum("...p,pij->...ij", parameters, BASIS))


def parameters_of(pseudo: Array) -> Array:
    """Ten parameters of a pseudo-inertia, (4, 4) -> (10,)."""
    moments = pseudo[:3, :3]
    inertia = np.trace(moments) * np.eye(3) - moments
    return np.concatenate([[pseudo[3, 3]], pseudo[:3, 3], [inertia[i, j] for i, j in _TRIU]])


def is_consistent(parameters: Array) -> bool:
    """Whether some distribution of mass has these ten parameters."""
    try:
        np.linalg.cholesky(pseudo_inertia(parameters))
    except np.linalg.LinAlgError:
        return False
    return True


def body(mass: float, centre: Array, gyration: Array) -> Array:
    """Ten parameters of a mass [kg] about a centre (3,) [m] whose density has second central moments of gyration (3, 3)
    [m2] a unit of mass."""
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = mass * (gyration + np.outer(centre, centre))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_of(pseudo)


def _basis() -> Array:
    """Pseudo-inertia of a unit of each parameter, (10, 4, 4)."""
    basis = np.zeros((len(PER_LINK), 4, 4))
    basis[0, 3, 3] = 1.0
    for k in range(3):
        basis[1 + k, k, 3] = basis[1 + k, 3, k] = 1.0
    for k, (i, j) in enumerate(_TRIU):
        inertia = np.zeros((3, 3))
        inertia[i, j] = inertia[j, i] = 1.0
        basis[4 + k, :3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia
    return basis


BASIS = _basis()


@dataclass(frozen=True, slots=True, eq=False)
class LeastSquares:
    """The squared misfit x^T normal x - 2 x^T right + misfit of unknowns x (p,), in units of its variance."""

    normal: Array
    right: Array
    misfit: float


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where the unknowns are expected. bodies (k, 10) : of k links, the first 10 k unknowns; positive (m,) : of the
    unknowns after them, which must be positive, such as inertias of rotors. The others are free. body_weights (k,),
    positive_weights (m,) : of the divergences, see `start_weight`."""

    bodies: Array
    positive: Array
    body_weights: Array
    positive_weights: Array

    @property
    def pull(self) -> Array:
        """The constant part of the divergences' gradient to the bodies, (10 k,)."""
        inverse = np.linalg.inv(pseudo_inertia(self.bodies))
        each = np.einsum("kij,pji->kp", inverse, BASIS)
        return np.asarray((self.body_weights[:, None] * each).ravel())


@dataclass(frozen=True, slots=True, eq=False)
class Consistent:
    """x (p,) : the unknowns; covariance (p, p), by the curvature of the cost at the minimum; seen (p,) : the share of
    the start's variance that the data have taken away, 1 for free unknowns."""

    x: Array
    covariance: Array
    seen: Array


def minimise(problem: LeastSquares, start: Start) -> Consistent:
    """The consistent unknowns that explain the data and keep near the start.

    Newton's method with a line search; the divergence keeps every iterate inside.
    """
    x = np.concatenate([start.bodies.ravel(), start.positive])
    x = np.concatenate([x, np.zeros(len(problem.right) - len(x))])
    pull = start.pull
    cost = _cost(problem, start, pull, x)
    for _ in range(MAX_ITERATIONS):
        gradient, curvature = _slopes(problem, start, pull, x)
        step = -_solve(curvature, gradient)
        predicted = -float(gradient @ step)
        if predicted <= DECREMENT * max(1.0, abs(cost)):
            break
        length = 1.0
        while not (now := _cost(problem, start, pull, x + length * step)) <= cost - SUFFICIENT * length * predicted:
            length /= 2
            if length < SHORTEST_STEP:
                break
        else:
            x, cost = x + length * step, now
            continue
        break
    return _with_uncertainty(problem, start, pull, x)


def _with_uncertainty(problem: LeastSquares, start: Start, pull: Array, x: Array) -> Consistent:
    _, curvature = _slopes(problem, start, pull, x)
    covariance = _solve(curvature, np.eye(len(x)))
    known = start.bodies.size + len(start.positive)
    alone = LeastSquares(np.zeros_like(problem.normal), np.zeros_like(problem.right), 0.0)
    at_start = np.concatenate([start.bodies.ravel(), start.positive, x[known:]])
    before = _slopes(alone, start, pull, at_start)[1][:known, :known]
    seen = np.ones(len(x))
    if known:
        seen[:known] = 1 - np.minimum(1.0, np.diag(covariance)[:known] / np.diag(np.linalg.inv(before)))
    return Consistent(x, covariance, seen)


def _solve(matrix: Array, right: Array) -> Array:
    """The solution of a positive definite system whose unknowns differ widely in size."""
    scale = 1 / np.sqrt(np.diag(matrix))
    scaled = matrix * np.outer(scale, scale)
    rhs = right * (scale if right.ndim == 1 else scale[:, None])
    found = np.linalg.solve(scaled, rhs)
    return np.asarray(found * (scale if right.ndim == 1 else scale[:, None]))


def _split(start: Start, x: Array) -> tuple[Array, Array]:
    """Pseudo-inertias (k, 4, 4) and the ratios of the positive unknowns to their start (m,)."""
    k = start.bodies.size
    ratios = x[k : k + len(start.positive)] / start.positive
    return pseudo_inertia(x[:k].reshape(-1, len(PER_LINK))), ratios


def _cost(problem: LeastSquares, start: Start, pull: Array, x: Array) -> float:
    """Half the squared misfit plus the divergences, but for a constant; infinite where a body is impossible."""
    bodies, ratios = _split(start, x)
    if np.any(ratios <= 0):
        return np.inf
    try:
        logs = 2 * np.log(np.einsum("kii->ki", np.linalg.cholesky(bodies))).sum(axis=1)
    except np.linalg.LinAlgError:
        return np.inf
    misfit = float(x @ problem.normal @ x - 2 * problem.right @ x + problem.misfit) / 2
    of_bodies = float(pull @ x[: len(pull)] - start.body_weights @ logs)
    # Four times the divergence of a number weighs its logarithm as that of a mass.
    return misfit + of_bodies + 4 * float(start.positive_weights @ (ratios - np.log(ratios)))


def _slopes(problem: LeastSquares, start: Start, pull: Array, x: Array) -> tuple[Array, Array]:
    """Gradient (p,) and curvature (p, p) of the cost."""
    bodies, ratios = _split(start, x)
    gradient = problem.normal @ x - problem.right
    curvature = problem.normal + RIDGE * np.diag(np.diag(problem.normal) + 1.0)
    gradient[: len(pull)] += pull
    for k, (inverse, weight) in enumerate(zip(np.linalg.inv(bodies), start.body_weights, strict=True)):
        at = slice(len(PER_LINK) * k, len(PER_LINK) * (k + 1))
        turned = np.einsum("ij,pjk->pik", inverse, BASIS)
        gradient[at] -= weight * np.einsum("pii->p", turned)
        curvature[at, at] += weight * np.einsum("pij,qji->pq", turned, turned)
    at = slice(len(pull), len(pull) + len(ratios))
    diagonal = np.arange(len(x))[at]
    gradient[at] += 4 * start.positive_weights * (1 - 1 / ratios) / start.positive
    curvature[diagonal, diagonal] += 4 * start.positive_weights / (ratios * start.positive) ** 2
    return gradient, curvature
