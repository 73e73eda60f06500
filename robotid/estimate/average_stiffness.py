"""From the stiffness of each record to a linear and a nonlinear part: eq. (14), and equivalent linearisation.

The law is k1 x + k3 g(x), where the shape g of the nonlinear part is x^3 for a cubic spring. The minimum of (14) is
attenuated: a record by itself asks for k3 = 0, as its k_i came from a linear spring, and only the difference between
records pulls k3 away. The stiffness of the linear spring nearest to the law is k1 + k3 sum(x g) / sum(x^2) (equivalent
linearisation, Caughey 1963); solving that over the records does not attenuate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from robotid.model.array import Array

SIGNIFICANT = 2.0  # standard deviations


@dataclass(frozen=True, slots=True)
class SpringLaw:
    """tau = k1 x + k3 g(x) by some method. k3_std : what the stiffnesses' own errors leave."""

    method: str
    k1: float = field(metadata={"unit": "Nm/rad", "finite": True})
    k3: float = field(metadata={"unit": "Nm/rad3", "finite": True})
    k3_std: float = field(metadata={"unit": "Nm/rad3", "unbounded": True, "least": 0.0})

    @property
    def stiffens(self) -> bool:
        """Whether the records show that stiffness rises with amplitude."""
        return self.k3 > SIGNIFICANT * self.k3_std


def simulate_twist(dphi_m: Array, sampling_time: float, gear_ratio: float, k: float, d: float, Ja: float) -> Array:
    """Twist [rad] of a linear spring whose motor end moves as measured, (n,) [rad/s] -> (n,).

    dx/dt = r dphi_m - w, Ja dw/dt = k x + d (r dphi_m - w), starting untwisted. The measured motion carries whatever
    friction there is, so no friction model is needed.
    """
    A = np.array([[0.0, -1.0], [k / Ja, -d / Ja]])
    B = np.array([[1.0], [d / Ja]])
    t = np.arange(len(dphi_m)) * sampling_time
    start = np.array([0.0, gear_ratio * dphi_m[0]])
    return np.asarray(
        scipy.signal.lsim((A, B, np.array([[1.0, 0.0]]), np.zeros((1, 1))), gear_ratio * dphi_m, t, X0=start)[1]
    )


def published_law(twists: Sequence[Array], shapes: Sequence[Array], k: Array, k_std: Array) -> SpringLaw:
    """Eq. (14): minimise the sum over records i and samples of (k_i x - k1 x - k3 g)^2.

    twists : x, (n,) a record; shapes : g(x), (n,) a record; k, k_std : (records,).
    """
    pairs = list(zip(twists, shapes, strict=True))
    square, mixed, shape = np.array([[x @ x, x @ g, g @ g] for x, g in pairs]).T
    normal = np.array([[square.sum(), mixed.sum()], [mixed.sum(), shape.sum()]])
    gain = _solve(normal, np.array([square, mixed]))
    return _law("least squares of the spring torque", gain, k, k_std)


def equivalent_law(twists: Sequence[Array], shapes: Sequence[Array], k: Array, k_std: Array) -> SpringLaw:
    """Least squares of k_i = k1 + k3 sum(x g) / sum(x^2), weighted by k_std. Arguments as of `published_law`, of two or
    more records."""
    pairs = zip(twists, shapes, strict=True)
    regressor = np.array([[1.0, np.sum(x * g) / np.sum(x**2)] for x, g in pairs]) / k_std[:, None]
    gain = _solve(regressor.T @ regressor, regressor.T / k_std)
    return _law("equivalent linearisation", gain, k, k_std)


def _law(method: str, gain: Array, k: Array, k_std: Array) -> SpringLaw:
    k1, k3 = gain @ k
    return SpringLaw(method, float(k1), float(k3), float(np.linalg.norm(gain[1] * k_std)))


def _solve(normal: Array, right: Array) -> Array:
    """Normal equations with unknowns of unlike size."""
    scale = np.sqrt(np.diag(normal))
    return np.asarray(np.linalg.solve(normal / np.outer(scale, scale), right / scale[:, None]) / scale[:, None])
