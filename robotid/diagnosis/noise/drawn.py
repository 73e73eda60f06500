"""What noise leaves of a joint that is not linear, by simulations with drawn errors of the torque.

An error of the torque shifts the instants at which a motor reverses and rests, and leaves a burst there that the linear
response of a joint that slips does not know.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
from robotid.simulation.simulate import Start, simulate_under

SEED = 20051


def drawn_residuals(one: SimulatedSegment, levels: NoiseLevels, output: Quantity, times: int = 1) -> list[Array]:
    """Residuals (n,) that noise of these levels makes of a simulated segment, `NOISE.draws` of them, or so many times
    as many; fewer where the joint cannot be simulated under such errors.

    levels.output is that of the angle where the record's speed was derived from it.
    """
    rng, samples, derivation = np.random.default_rng(SEED), len(one.record), Derivation.of(one.record, output)
    errors, sensed = list[Array](), list[Array]()
    for _ in range(times * NOISE.draws):
        errors.append(_torque_error(rng, levels, samples, one.record.sampling_time))
        noise = np.sqrt(levels.output) * rng.standard_normal(samples)
        sensed.append(noise if derivation is None else derivation.speed(noise))
    try:
        pairs = zip(_moved(one, errors, output), sensed, strict=True)
        return [moved + noise for moved, noise in pairs if moved is not None]
    except NumericsError:
        return []


def _torque_error(rng: np.random.Generator, levels: NoiseLevels, samples: int, sampling_time: float) -> Array:
    """White and red errors of the torque [Nm], (n,), the red ones from their stationary distribution on."""
    white = np.sqrt(levels.torque) * rng.standard_normal(samples)
    if levels.red <= 0.0:
        return np.asarray(white)
    pole, drive = levels.pole(sampling_time), np.sqrt(levels.red) * rng.standard_normal(samples)
    drive[1:] *= np.sqrt(1.0 - pole**2)
    return np.asarray(white + lfilter([1.0], [1.0, -pole], drive))


def _moved(one: SimulatedSegment, errors: Sequence[Array], output: Quantity) -> Iterator[Array | None]:
    """How far each of several errors of the torque (n,) moves the output of a segment, (n,); None where the joint
    cannot be simulated under it."""
    before = one.trajectory
    torques, start = [one.record.tau_m + error for error in errors], Start(before.x[:, 0], before.x)
    most, known = max(NOISE.failed_windows, 2 * before.failed_windows), observed(before, output)
    for after in simulate_under(torques, before.joint, before.theta, one.record, start, most):
        yield None if after is None else observed(after, output) - known
