"""Whitening: a filter after which a residual of pure noise is white with unit variance.

Three noises make a residual: white on the measured output, white on the recorded torque, and red on the torque, a
first-order autoregression; the joint shapes the last two. The filter is the innovations form of the Kalman predictor of
their sum (Ljung 1999, section 4.3): what is new in each sample. White noise on a recorded torque is a random walk in a
simulated angle, and nothing but its innovations can be tested.

White noise of an angle is blue in a speed that is derived from it, and zero at frequency zero, so that no innovations
form of its own is stable. What is new in a difference is what is new in the angle: the speed is taken back to the angle
and whitened as such. The constants that a difference has lost are projected out, whatever they were.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from scipy.linalg import LinAlgError, solve_discrete_are

from robotid.estimate.noise.response import TorqueResponse
from robotid.estimate.noise.settings import SMALLEST
from robotid.model.array import Array
from robotid.signals.derivation import Derivation, without

RIDGE = 1e-10  # of the torque's noise, on every state: keeps the Riccati equation's solution unique
UNSEEN = 1e-20  # of what the torque's noise adds in a sample: an output's own that is less is lost to rounding


@dataclass(frozen=True, slots=True)
class NoiseLevels:
    """Variances of the noises that make a residual.

    output : of what the sensor shows, in its unit squared, which is the angle where a speed is derived from it;
    torque : of the torque's white noise [Nm2]; red : of the torque's red noise [Nm2]; corner [rad/s] : of the latter's
    spectrum, which is flat below it.
    """

    output: float
    torque: float = 0.0
    red: float = 0.0
    corner: float = 1.0

    def pole(self, sampling_time: float) -> float:
        """Coefficient of the autoregression of the red noise."""
        return float(np.exp(-self.corner * sampling_time))


@dataclass(frozen=True, slots=True, eq=False)
class InnovationsFilter:
    """From a residual to its innovations over their standard deviation.

    sections (s, 6) : of the second order, of a filter of what the sensor shows; derivation : by which the residual's
    speed comes from an angle, which is then what the sensor shows. excess : by how much more energy these noises show
    than the response that shapes the filter lets pass, for which it allows.
    """

    sections: Array
    levels: NoiseLevels
    derivation: Derivation | None = None
    excess: float = 1.0

    def allowing_for(self, excess: float) -> InnovationsFilter:
        """The filter that allows for so much energy."""
        sections = self.sections.copy()
        sections[0, :3] *= np.sqrt(self.excess / excess)
        return replace(self, sections=sections, excess=excess)

    def __call__(self, signals: Array) -> Array:
        """Signals (..., n), whitened."""
        if self.derivation is None:
            return self._filtered(signals)
        return without(self._lost(signals), self._filtered(self.derivation.angle(signals)))

    def _lost(self, signals: Array) -> Array:
        """What the innovations may hold of the constants that signals (..., n) do not show, (k, n)."""
        assert self.derivation is not None
        return self._filtered(self.derivation.lost(signals.shape[-1]))

    def _filtered(self, signals: Array) -> Array:
        """The innovations of what the sensor shows, (..., n)."""
        if self.levels.torque + self.levels.red == 0.0:
            return np.asarray(self.sections[0, 0] * signals)
        # SciPy cannot read sections that may not be written to, as they come from another process
        return np.asarray(scipy.signal.sosfilt(self.sections.copy(), signals, axis=-1))

    def transposed(self, signals: Array) -> Array:
        """The adjoint of the filter: from the last sample to the first. signals (..., n) -> the same shape."""
        if self.derivation is None:
            return np.asarray(self._filtered(signals[..., ::-1])[..., ::-1])
        left = without(self._lost(signals), signals)
        return self.derivation.angle_adjoint(self._filtered(left[..., ::-1])[..., ::-1])

    def squared(self, omega: Array) -> Array:
        """Squared magnitude from what the sensor shows. omega (n,) [rad per sample] -> (n,)."""
        return np.asarray(np.abs(scipy.signal.sosfreqz(self.sections, np.asarray(omega))[1]) ** 2)

    def output_noise(self, derivation: Derivation | None) -> float:
        """Variance of the same noise where a speed comes by another derivation, None : where it is measured."""
        if (derivation is None) == (self.derivation is None):
            return self.levels.output
        return self.output_variance / (1.0 if derivation is None else derivation.gain)

    @property
    def at_once(self) -> float:
        """By what a sample counts in its own innovation."""
        return float(abs(self.sections[:, 0].prod() / self.sections[:, 3].prod()))

    @property
    def output_variance(self) -> float:
        """Variance of the output's own noise, in the output's unit squared."""
        return self.levels.output * (1.0 if self.derivation is None else self.derivation.gain)


def innovations_filter(response: TorqueResponse, levels: NoiseLevels) -> InnovationsFilter:
    """The whitening filter of a noise. An output without any has as much as is lost beside the torque's to rounding.

    Where the Riccati equation has no solution to working precision the torque's noise is left out.
    """
    of_the_torque = (levels.torque + levels.red) * float(response.b[response.row]) ** 2
    levels = replace(levels, output=max(levels.output, UNSEEN * of_the_torque, SMALLEST))
    white, derivation = np.array([[1.0 / np.sqrt(levels.output), 0.0, 0.0, 1.0, 0.0, 0.0]]), response.derivation
    if levels.torque + levels.red <= 0.0:
        return InnovationsFilter(white, levels, derivation)
    F, Q, C = _state_space(response, levels)
    try:
        P = solve_discrete_are(F.T, C.T, Q / levels.output, np.eye(1)) * levels.output
    except (LinAlgError, ValueError):
        return InnovationsFilter(white, NoiseLevels(levels.output), derivation)
    variance = float((C @ P @ C.T)[0, 0]) + levels.output
    gain = F @ P @ C.T / variance
    zeros, poles = (np.asarray(np.linalg.eigvals(M), dtype=np.complex128) for M in (F, F - gain @ C))
    sections: Any = scipy.signal.zpk2sos  # its types know no complex zeros
    return InnovationsFilter(np.asarray(sections(zeros, poles, 1.0 / np.sqrt(variance))), levels, derivation)


def _state_space(response: TorqueResponse, levels: NoiseLevels) -> tuple[Array, Array, Array]:
    """Transition F, covariance Q of its noise, and output C of the joint with the red noise as a further state."""
    d, red = len(response.b), levels.red > 0.0
    F, Q, C = np.zeros((d + red, d + red)), np.zeros((d + red, d + red)), np.zeros((1, d + red))
    F[:d, :d], C[0, response.row] = response.A, 1.0
    Q[:d, :d] = levels.torque * np.outer(response.b, response.b)
    spread = levels.torque
    if red:
        pole = levels.pole(response.sampling_time)
        F[:d, d], F[d, d], Q[d, d] = response.b, pole, levels.red * (1.0 - pole**2)
        spread += levels.red * (1.0 - pole)
    Q[:d, :d] += RIDGE * spread * np.diag(response.b**2)
    return F, Q, C
