"""From the stiffness of each record to a linear and a cubic part: eq. (14) of the paper, and equivalent linearisation.

The minimum of (14) is attenuated: a record by itself asks for k3 = 0, as its k_i came from a linear spring, and only
the difference between records pulls k3 away. The stiffness of the linear spring nearest to k1 x + k3 x^3 is
k1 + k3 sum(x^4) / sum(x^2) (equivalent linearisation, Caughey 1963); solving that over the records does not attenuate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lsim

from robotid.model.array import Array

SIGNIFICANT = 2.0  # standard deviations


@dataclass(frozen=True, slots=True)
class SpringLaw:
    """tau = k1 x + k3 x^3 by some method. k3_std : what the stiffnesses' own errors leave."""

    method: str
    k1: float = field(metadata={"unit": "Nm/rad"})
    k3: float = field(metadata={"unit": "Nm/rad3"})
    k3_std: float = field(metadata={"unit": "Nm/rad3"})

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
    return np.asarray(lsim((A, B, np.array([[1.0, 0.0]]), np.zeros((1, 1))), gear_ratio * dphi_m, t, X0=start)[1])


def published_law(twists: Sequence[Array], k: Array, k_std: Array) -> SpringLaw:
    """Eq. (14): minimise the sum over records i and samples of (k_i x - k1 x - k3 x^3)^2. twists : (n,) a record; k,
    k_std : (records,)."""
    second, fourth, sixth = (np.array([np.sum(x**p) for x in twists]) for p in (2, 4, 6))
    normal = np.array([[second.sum(), fourth.sum()], [fourth.sum(), sixth.sum()]])
    gain = _solve(normal, np.array([second, fourth]))
    return _law("eq. (14)", gain, k, k_std)


def equivalent_law(twists: Sequence[Array], k: Array, k_std: Array) -> SpringLaw:
    """Least squares of k_i = k1 + k3 sum(x^4) / sum(x^2), weighted by k_std. Two or more records."""
    regressor = np.array([[1.0, np.sum(x**4) / np.sum(x**2)] for x in twists]) / k_std[:, None]
    gain = _solve(regressor.T @ regressor, regressor.T / k_std)
    return _law("equivalent linearisation", gain, k, k_std)


def _law(method: str, gain: Array, k: Array, k_std: Array) -> SpringLaw:
    k1, k3 = gain @ k
    return SpringLaw(method, float(k1), float(k3), float(np.linalg.norm(gain[1] * k_std)))


def _solve(normal: Array, right: Array) -> Array:
    """Normal equations with unknowns of unlike size."""
    scale = np.sqrt(np.diag(normal))
    return np.asarray(np.linalg.solve(normal / np.outer(scale, scale), right / scale[:, None]) / scale[:, None])
