"""Parametric fit of the linear joint to a frequency response: eq. (13) with damping, and any number of masses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from robotid.model.array import Array, Complex
from robotid.model.joint import Joint
from robotid.model.linear import linearise
from robotid.model.term import Role
from robotid.signals.frf import Frf

FLOOR = 0.01  # relative error of a response that no noise explains: what is nonlinear
MOST_EVALUATIONS = 200


@dataclass(frozen=True, slots=True, eq=False)
class ResponseFit:
    """values and relative standard deviations by dotted name; misfit : rms of the weighted residual, about 1 where the
    linear joint explains the response."""

    values: dict[str, float]
    relative_std: dict[str, float]
    misfit: float


def linear_part(joint: Joint) -> Joint:
    """The joint without what is not linear, and without channels."""
    terms = [(port, term) for port, term in joint.terms if term.linear]
    names = tuple(f"{port}.{term.name}" for port, term in terms)
    return Joint(replace(joint.structure, terms=names, channels=(), changes=()), terms)


def linear_response(joint: Joint, theta: Array, omega: Array) -> Complex:
    """Response from motor torque to motor acceleration at rest, forwards. theta (p,), omega (n,) [rad/s] -> (n,)."""
    return linearise(joint, theta).response(omega)


def total_inertia(joint: Joint, values: Mapping[str, float]) -> float:
    """Inertia of all masses in `values` (by dotted name) moving together, on the motor side [kg m2]."""
    masses = joint.playing(Role.MASS)
    return sum(joint.rigid_speed(place.port) ** 2 * values[name] for name, place in masses.items() if name in values)


def fit_response(
    joint: Joint,
    frf: Frf,
    fixed: Mapping[str, float],
    starts: Iterable[Mapping[str, float]],
    total: tuple[float, float],
) -> ResponseFit:
    """Fit a linear joint's positive parameters to a response, from each of the starts; the best counts.

    fixed : parameters that keep their value. total : rigid inertia on the motor side and its standard deviation. Errors
    are those of the logarithm, weighted by the response's own error, and outliers count less.
    """
    free = [name for name in joint.names if name not in fixed]
    weight = 1.0 / np.hypot(frf.std / np.abs(frf.response), FLOOR)
    tightness = 1.0 / np.hypot(total[1] / total[0], FLOOR)

    def values(logarithms: Array) -> dict[str, float]:
        return dict(fixed) | dict(zip(free, np.exp(logarithms).tolist(), strict=True))

    def residual(logarithms: Array) -> Array:
        now = values(logarithms)
        theta = np.array([now[name] for name in joint.names])
        with np.errstate(all="ignore"):  # a step into nowhere is nan, and is taken back
            error = weight * np.log(linear_response(joint, theta, frf.omega) / frf.response)
        return np.concatenate([error.real, error.imag, [tightness * np.log(total_inertia(joint, now) / total[0])]])

    solutions = [
        least_squares(
            residual,
            np.log([start[name] for name in free]),
            partial(_forward_differences, residual),
            bounds=(-30.0, 50.0),
            loss="soft_l1",
            x_scale="jac",
            max_nfev=MOST_EVALUATIONS,
        )
        for start in starts
    ]
    best = min(solutions, key=lambda s: float(s.cost))
    misfit = float(np.sqrt(2 * best.cost / max(1, len(best.fun) - len(free))))
    jacobian = np.asarray(best.jac, dtype=np.float64)
    std = max(1.0, misfit) * _standard_deviations(jacobian)
    return ResponseFit(values(best.x), dict(zip(free, std.tolist(), strict=True)), misfit)


def _forward_differences(residual: Callable[[Array], Array], x: Array) -> Array:
    """Derivatives (n, m) of a residual (n,) at x (m,), zero where there is none: beside the last masses that floating
    point tells apart, what is bound a little more stiffly changes nothing."""
    here, steps = residual(x), np.sqrt(np.finfo(float).eps) * np.maximum(1.0, np.abs(x))
    with np.errstate(invalid="ignore"):
        found = [(residual(x + step) - here) / step.max() for step in np.diag(steps)]
    return np.asarray(np.nan_to_num(np.stack(found, axis=1), nan=0.0, posinf=0.0, neginf=0.0))


def _standard_deviations(jacobian: Array) -> Array:
    """Of parameters behind a Jacobian (n, m) of residuals of unit variance, (m,); beyond all bounds in a direction that
    changes nothing."""
    _, values, directions = np.linalg.svd(jacobian, full_matrices=False)
    least = np.finfo(float).eps * values.max(initial=np.finfo(float).tiny)
    return np.asarray(np.linalg.norm(directions / np.maximum(values, least)[:, None], axis=0))
