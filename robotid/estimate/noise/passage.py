"""How errors of the recorded torque show along a simulated motion.

While dry friction holds a motor an error of its torque shows nothing, and at each reversal what it has done so far
lasts or is lost. A joint that slips all the time (`response`) knows neither: beside a slow error it would leave a good
part of what shows at higher frequencies to a white noise of the torque that is not there. The motion is therefore taken
as it was simulated, linear about every sample (Filippov 1988 at the reversals).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.signal.windows import hann

from robotid.estimate.noise.lines import Innovations, Residual
from robotid.estimate.noise.passed import PassedNoise
from robotid.estimate.noise.settings import SETTINGS, LevelSettings
from robotid.estimate.noise.whitening import InnovationsFilter
from robotid.model.array import Array, Index
from robotid.signals.record import Quantity
from robotid.simulation.sensitivities import LinearisedSteps, linearised, torque_gradient
from robotid.simulation.trajectory import Trajectory

PER_OCTAVE = 4  # bands in which the spectra of torque and output are averaged
NARROW = 4  # lines of a band at least, or it is one
AT_ONCE = 4_000_000  # samples of probes in memory


@dataclass(frozen=True, slots=True, eq=False)
class TorquePassage:
    """From the torque of every sample to the output at every sample, or to the angle that a speed is derived from.

    row : the state that is shown; summed : whether the angle is the sum of this state, by trapezoids. steps : of the
    trajectory, linearised, where they are kept.
    """

    trajectory: Trajectory
    row: int
    summed: bool = False
    steps: tuple[LinearisedSteps, ...] | None = None

    @classmethod
    def of(cls, trajectory: Trajectory, output: Quantity, *, derived: bool) -> TorquePassage:
        """derived : whether the output is a speed that comes from the angle."""
        joint = trajectory.joint
        if derived and joint.keeps_angle:
            return cls(trajectory, joint.motor_angle)
        return cls(trajectory, joint.output_row(output), summed=derived)

    def adjoint(self, weights: Array) -> Array:
        """What weights (m, n) of the shown samples make of the torque of each sample, (m, n)."""
        if self.summed:
            later = np.cumsum(weights[:, ::-1], axis=1)[:, ::-1]
            weights = np.zeros(weights.shape)
            weights[:, 1:] += later[:, 1:]
            weights[:, :-1] += later[:, 1:]
            weights *= self.trajectory.sampling_time / 2
        return torque_gradient(self.trajectory, self.row, weights, self.steps)

    def kept(self) -> TorquePassage:
        """The same with its steps, for several adjoint solves: nx (nx + 1) numbers a sample."""
        return self if self.steps is not None else replace(self, steps=tuple(linearised(self.trajectory)))

    def part(self, at: slice) -> TorquePassage:
        """That of these samples alone."""
        if at == slice(0, len(self.trajectory.u)):
            return self
        return TorquePassage(self.trajectory.part(at), self.row, self.summed)


def passed_noise(
    one: Residual, whiten: InnovationsFilter, passage: TorquePassage, settings: LevelSettings = SETTINGS
) -> PassedNoise | None:
    """What of the torque's noise shows along the motion of a residual, None where it grows beyond all numbers.

    The mean power of a band is the sum over all samples of the squared response of its lines, by one adjoint solve for
    all of them: from line to line their phases advance by all angles of a circle (Schroeder 1970), so that what two
    neighbours have in common cancels.
    """
    n, passage = len(one.signal), passage.kept()
    innovations = Innovations.of(one, whiten, settings)
    number = np.round(innovations.omega * n / (2 * np.pi)).astype(np.intp)
    edges = _octave_parts(n // 2)
    upper = edges[1:][np.diff(np.searchsorted(number, edges)) > 0]
    bands = np.searchsorted(upper - 1, number)
    inner = np.unique(np.append(0, _octave_parts(n)))  # lines of the padded spectrum of the torque
    shown = np.zeros((len(upper), len(inner) - 1))
    step, taper = max(1, AT_ONCE // (2 * n)), hann(n + 2)[1:-1]
    taper /= np.sqrt(np.mean(taper**2))
    for first in range(0, len(upper), step):
        chosen = range(first, min(first + step, len(upper)))
        probes = taper * np.concatenate([_probes(number[bands == k], n) for k in chosen])
        probes -= (probes @ innovations.basis.T) @ innovations.basis
        weights = whiten.transposed(probes)
        if one.response.derivation is not None:
            weights = one.response.derivation.speed_adjoint(weights)
        with np.errstate(over="ignore", invalid="ignore"):  # of a motion that is unstable
            power = np.abs(scipy.fft.rfft(passage.adjoint(weights), 2 * n)) ** 2 / n
        power[:, [0, -1]] /= 2.0
        shown[first : chosen.stop] = np.add.reduceat(power, inner[:-1], axis=1).reshape(len(chosen), 2, -1).mean(axis=1)
    if not np.isfinite(shown).all():
        return None
    middle = np.pi / n * np.maximum(0.5, (inner[:-1] + inner[1:] - 1) / 2)
    slipping = innovations.gain * one.response.squared(innovations.omega)
    return PassedNoise(
        one.response.sampling_time, 2 * np.pi * (upper - 0.5) / n, shown, middle, innovations.omega, slipping
    )


def _octave_parts(lines: int) -> Array:
    """First lines of single lines from line 1, of bands of a constant relative width, and one beyond the last line."""
    narrow = int(NARROW / (2.0 ** (1 / PER_OCTAVE) - 1.0))
    count = int(np.log2(max(lines, 1)) * PER_OCTAVE) + 2
    wide = np.round(2.0 ** (np.arange(count) / PER_OCTAVE)).astype(np.intp)
    edges = np.union1d(np.arange(1, narrow + 1), wide[wide > narrow])
    return np.append(edges[edges <= lines], lines + 1)


def _probes(lines: Index, n: int) -> Array:
    """Two signals (2, n) a quarter of a turn apart, whose products with a signal under a taper have as mean square the
    mean power of that at these lines."""
    m = len(lines)
    spectrum = np.zeros(n // 2 + 1, dtype=np.complex128)
    spectrum[lines] = np.exp(1j * np.cumsum(np.pi / 2 + 2 * np.pi * np.arange(m) / max(1, m - 1)))
    spectra = np.stack([spectrum, 1j * spectrum])
    return np.asarray(scipy.fft.irfft(spectra, n) * np.sqrt(n / (2.0 * m)))
