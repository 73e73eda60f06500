"""What of the torque's noise shows along a motion, beside what would where the joint slips all the time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array, Index


@dataclass(frozen=True, slots=True, eq=False)
class PassedNoise:
    """Powers in bands of frequencies [rad per sample], the same for every noise of the torque.

    upper (b,) : edges of the bands in which the output is seen. shown (b, k) : mean power in them by noise that has the
    density one in a band of the torque's own spectrum and none elsewhere; omega (k,) : in the middle of these bands.
    lines (f,), slipping (f,) : frequencies, and what white noise of unit variance would show there if the joint slipped
    all the time. most : factor beyond which none counts.
    """

    sampling_time: float
    upper: Array
    shown: Array
    omega: Array
    lines: Array
    slipping: Array
    most: float = np.inf

    def factors(self, corners: Array, omega: Array) -> Array:
        """By how much more, or less, shows at frequencies (f,) of white noise, and of red noises of these corners
        [rad/s], (1 + corners, f)."""
        h, ones = self.sampling_time, np.ones((1, 1))
        inputs = np.vstack([ones.repeat(len(self.omega), 1), red_spectra(corners, h, self.omega)])
        spectra = np.vstack([ones.repeat(len(self.lines), 1), red_spectra(corners, h, self.lines)])
        bands = self._bands(self.lines)
        count = np.maximum(np.bincount(bands, minlength=len(self.upper)), 1)
        still = np.stack([np.bincount(bands, one, len(self.upper)) / count for one in spectra * self.slipping])
        found = np.divide(inputs @ self.shown.T, still, out=np.ones(still.shape), where=still > 0.0)
        return np.asarray(np.minimum(found, self.most)[:, self._bands(omega)])

    def _bands(self, omega: Array) -> Index:
        return np.minimum(np.searchsorted(self.upper, omega), len(self.upper) - 1)


def red_spectra(corners: Array, sampling_time: float, omega: Array) -> Array:
    """Spectra (corners, f) of red noises of unit variance at frequencies omega (f,) [rad per sample]."""
    poles = np.exp(-corners * sampling_time)[:, None]
    return np.asarray((1.0 - poles**2) / np.abs(1.0 - poles * np.exp(-1j * omega)) ** 2)
