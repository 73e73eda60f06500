"""Parametric fit of the linear joint to a frequency response: eq. (13) with damping, and any number of masses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.linear import linearise
from robotid.model.structure import Structure
from robotid.signals.frf import Complex, Frf

LINEAR = ("inertia", "viscous", "spring", "damper", "third_mass")
FLOOR = 0.01  # relative error of a response that no noise explains: what is nonlinear
MOST_EVALUATIONS = 200


@dataclass(frozen=True, slots=True, eq=False)
class ResponseFit:
    """values and relative standard deviations by dotted name; misfit : rms of the weighted residual, about 1 where the
    linear joint explains the response."""

    values: dict[str, float]
    relative_std: dict[str, float]
    misfit: float


def linear_part(structure: Structure) -> Structure:
    """The joint without what is not linear."""
    terms = tuple(name for name in structure.terms if name.split(".")[1] in LINEAR)
    return Structure(terms, (), structure.gear_ratio, structure.linear)


def linear_response(joint: Joint, theta: Array, omega: Array) -> Complex:
    """Response from motor torque to motor acceleration at rest, forwards. theta (p,), omega (n,) [rad/s] -> (n,)."""
    return linearise(joint, theta).response(omega)


def total_inertia(joint: Joint, values: Mapping[str, float]) -> float:
    """Inertia of all masses moving together, on the motor side [kg m2]."""
    far = sum(values[n] for n in values if n in ("arm.inertia.J", "tool.inertia.J", "link.third_mass.Jb"))
    return values["motor.inertia.J"] + joint.ratio**2 * far


def fit_response(
    joint: Joint, frf: Frf, held: Mapping[str, float], starts: Iterable[Mapping[str, float]], total: tuple[float, float]
) -> ResponseFit:
    """Fit a linear joint's positive parameters to a response, from each of the starts; the best counts.

    held : parameters that keep their value. total : rigid inertia on the motor side and its standard deviation. Errors
    are those of the logarithm, weighted by the response's own error, and outliers count less.
    """
    free = [name for name in joint.names if name not in held]
    weight = 1.0 / np.hypot(frf.std / np.abs(frf.response), FLOOR)
    tightness = 1.0 / np.hypot(total[1] / total[0], FLOOR)

    def values(logarithms: Array) -> dict[str, float]:
        return dict(held) | dict(zip(free, np.exp(logarithms).tolist(), strict=True))

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
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * max(1.0, misfit) ** 2
    return ResponseFit(values(best.x), dict(zip(free, np.sqrt(np.diag(covariance)).tolist(), strict=True)), misfit)
