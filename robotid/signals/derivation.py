"""A speed that was derived from an angle, as a linear operator: what it does to noise, and what of the angle is left.

A difference loses next to nothing of an angle: from a backward difference it comes back but for a constant, from a
central one but for one constant of the even samples and one of the odd. Instead of the blue noise of such a speed,
whose spectrum is zero at frequency zero (and at the Nyquist frequency), one may therefore take the noise of the angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from robotid.model.array import Array
from robotid.signals.record import OPERATORS, Quantity, Record, SpeedOrigin


@dataclass(frozen=True, slots=True)
class Derivation:
    """How a speed comes from an angle that is sampled every sampling_time [s]."""

    origin: SpeedOrigin
    sampling_time: float

    @classmethod
    def of(cls, record: Record, output: Quantity = "speed") -> Derivation | None:
        """That of an output of a record; None where it was measured, as an angle always is."""
        derived = output == "speed" and record.speed_is_derived
        return cls(record.speed_origin, record.sampling_time) if derived else None

    def speed(self, angle: Array) -> Array:
        """The derived speed. angle (..., n) -> (..., n)."""
        return OPERATORS[self.origin](angle, self.sampling_time)

    def speed_adjoint(self, weights: Array) -> Array:
        """The adjoint of `speed`: weights (..., n) of the speeds -> those of the angles, (..., n)."""
        h, found = self.sampling_time, np.zeros(weights.shape)
        if self.origin == "backward difference":
            found[..., 1:] += weights[..., 1:] / h
            found[..., :-1] -= weights[..., 1:] / h
            found[..., 1] += weights[..., 0] / h
            found[..., 0] -= weights[..., 0] / h
            return found
        inner = weights[..., 1:-1] / (2 * h)
        found[..., 2:] += inner
        found[..., :-2] -= inner
        ends = np.array([3.0, -4.0, 1.0]) / (2 * h)
        found[..., :3] -= weights[..., :1] * ends
        found[..., -3:] += weights[..., -1:] * ends[::-1]
        return found

    def angle(self, speed: Array) -> Array:
        """The angle that a derived speed comes from, but for what is `lost`. speed (..., n) -> (..., n).

        The speeds at the ends, which are derived in another way, are left out.
        """
        found, taps = np.zeros(speed.shape), self._taps
        if self.origin == "backward difference":
            found[..., 1:] = lfilter([1.0], taps, speed[..., 1:])
        else:
            found[..., 2:] = lfilter([1.0], taps, speed[..., 1:-1])
        return found

    def angle_adjoint(self, weights: Array) -> Array:
        """The adjoint of `angle`: weights (..., n) of the angles -> those of the speeds, (..., n)."""
        found, taps = np.zeros(weights.shape), self._taps
        if self.origin == "backward difference":
            found[..., 1:] = lfilter([1.0], taps, weights[..., :0:-1])[..., ::-1]
        else:
            found[..., 1:-1] = lfilter([1.0], taps, weights[..., :1:-1])[..., ::-1]
        return found

    def centred_angle(self, speed: Array) -> Array:
        """The same with nothing in it of what is lost."""
        return without(self.lost(speed.shape[-1]), self.angle(speed))

    def lost(self, n: int) -> Array:
        """The angles (k, n) of which the inner speeds show nothing."""
        if self.origin == "backward difference":
            return np.ones((1, n))
        return np.stack([np.arange(n) % 2 == 0, np.arange(n) % 2 == 1]).astype(np.float64)

    def squared(self, omega: Array) -> Array:
        """Squared magnitude from the angle to the speed [1/s2]. omega (n,) [rad per sample] -> (n,)."""
        turned = np.exp(-1j * np.outer(omega, np.arange(len(self._taps))))
        return np.asarray(np.abs(turned @ self._taps) ** 2)

    @property
    def gain(self) -> float:
        """Variance of the speed for white noise of unit variance in the angle [1/s2]."""
        return float(np.sum(self._taps**2))

    @property
    def _taps(self) -> Array:
        """Coefficients of the inner samples."""
        backward = self.origin == "backward difference"
        return (
            np.array([1.0, -1.0]) / self.sampling_time if backward else np.array([0.5, 0.0, -0.5]) / self.sampling_time
        )


def without(lost: Array, signals: Array) -> Array:
    """Signals (..., n) less all that signals lost (k, n) could have added to them."""
    basis = np.linalg.qr(lost.T)[0]
    return np.asarray(signals - (signals @ basis) @ basis.T)
