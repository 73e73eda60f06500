"""What noise leaves of a joint that is not linear, by simulations with drawn errors of the torque.

An error of the torque shifts the instants at which a motor reverses and rests, and leaves a burst there that the linear
response of a joint that slips does not know.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from robotid.diagnosis.noise.settings import NOISE
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.estimate.residual import observed
from robotid.model.array import Array
from robotid.signals.derivation import Derivation
from robotid.signals.record import Quantity
from robotid.simulation.simulate import simulate

SEED = 20051


def drawn_residuals(one: SimulatedSegment, levels: NoiseLevels, output: Quantity, times: int = 1) -> list[Array]:
    """Residuals (n,) that noise of these levels makes of a simulated segment, `NOISE.draws` of them, or so many times
    as many; fewer where the joint cannot be simulated under such errors.

    levels.output is that of the angle where the record's speed was derived from it.
    """
    rng, found, derivation = np.random.default_rng(SEED), list[Array](), Derivation.of(one.record, output)
    for _ in range(times * NOISE.draws):
        error = _torque_error(rng, levels, len(one.record), one.record.sampling_time)
        sensed = np.sqrt(levels.output) * rng.standard_normal(len(one.record))
        try:
            moved = _moved(one, error, output)
        except NumericsError:
            continue
        found.append(moved + (sensed if derivation is None else derivation.speed(sensed)))
    return found


def _torque_error(rng: np.random.Generator, levels: NoiseLevels, samples: int, sampling_time: float) -> Array:
    """White and red errors of the torque [Nm], (n,), the red ones from their stationary distribution on."""
    white = np.sqrt(levels.torque) * rng.standard_normal(samples)
    if levels.red <= 0.0:
        return np.asarray(white)
    pole, drive = levels.pole(sampling_time), np.sqrt(levels.red) * rng.standard_normal(samples)
    drive[1:] *= np.sqrt(1.0 - pole**2)
    return np.asarray(white + lfilter([1.0], [1.0, -pole], drive))


def _moved(one: SimulatedSegment, error: Array, output: Quantity) -> Array:
    """How far errors of the torque (n,) move the output of a segment, (n,). Raises NumericsError."""
    before = one.trajectory
    record = replace(one.record, tau_m=one.record.tau_m + error)
    most = max(NOISE.failed_windows, 2 * before.failed_windows)
    after = simulate(before.joint, before.theta, record, before.x[:, 0], before.x, max_failed_windows=most)
    return observed(after, output) - observed(before, output)
