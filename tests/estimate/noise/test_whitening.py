"""The whitening of a joint: what noise of its sensors leaves in a residual comes out white, with unit variance."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2
from support.extended_joint import values
from support.noise import speed_whitening
from support.paper_joint import RATIO, STRUCTURE

from robotid.catalogue import assemble
from robotid.estimate.noise.whitening import InnovationsFilter
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

SAMPLES, SAMPLING_TIME = 4096, 0.002
SETTLED = 512  # samples after which the filter has forgotten where it started
SPEED, TORQUE = 0.01, 0.02  # standard deviations of the noise [rad/s, Nm]
BANDS = 16
UNLIKELY = 1e-4  # of a band to lie outside its limits by chance
JOINTS = {
    "rigid": Structure(("motor.inertia", "motor.viscous", "motor.coulomb")),
    "flexible": STRUCTURE.without("gear.cubic_spring"),
    "undamped": Structure(("motor.inertia", "motor.viscous", "gear.spring", "arm.inertia"), gear_ratio=RATIO),
}
NOISES = {"speed": (SPEED, 0.0), "torque": (SPEED / 30, TORQUE), "both": (SPEED, TORQUE)}


@cache
def response(name: str) -> tuple[Joint, Array, Array]:
    """A joint, its parameters, and what a noise of its torque does to its speed while it slips one way, (n,)."""
    joint = assemble(JOINTS[name])
    theta = values(joint)
    still, noise = np.zeros(SAMPLES), TORQUE * np.random.default_rng(7).standard_normal(SAMPLES)
    steady = Record("r", "estimate", "both", SAMPLING_TIME, still + 1.0, still, still)
    shaken = Record("r", "estimate", "both", SAMPLING_TIME, 1.0 + noise, still, still)
    x0 = np.zeros(joint.nx)
    x0[joint.speeds] = 20.0 * np.array([1.0, RATIO])[: joint.masses]
    return joint, theta, simulate(joint, theta, shaken, x0).dphi_m - simulate(joint, theta, steady, x0).dphi_m


def whitened(name: str, noise: str) -> tuple[InnovationsFilter, Array, Array]:
    """The filter, and a residual of such noise before and after it, the transient cut off the latter."""
    joint, theta, shaken = response(name)
    speed, torque = NOISES[noise]
    residual = speed * np.random.default_rng(8).standard_normal(SAMPLES) + (shaken if torque else 0.0)
    found = speed_whitening(joint, theta, SAMPLING_TIME, (speed**2, torque**2))
    return found, residual, found(residual)[SETTLED:]


def likely(freedom: int) -> tuple[float, float]:
    """Between which a mean square of so many normal variables lies, but for UNLIKELY cases."""
    return float(chi2.ppf(UNLIKELY / 2, freedom)) / freedom, float(chi2.isf(UNLIKELY / 2, freedom)) / freedom


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("name", JOINTS)
def test_the_spectrum_is_flat_and_the_energy_that_of_the_samples(name: str, noise: str) -> None:
    _, _, signal = whitened(name, noise)
    power = np.abs(np.fft.rfft(signal)[1:-1]) ** 2 / len(signal)  # each line exponential, of mean 1
    for band in np.array_split(power, BANDS):
        low, high = likely(2 * len(band))
        assert low < band.mean() < high
    low, high = likely(len(signal))
    assert low < np.mean(signal**2) < high


@pytest.mark.parametrize("name", JOINTS)
def test_without_it_the_noise_of_the_torque_is_far_from_white(name: str) -> None:
    """Else the test above would show nothing."""
    residual = whitened(name, "torque")[1][SETTLED:]
    power = np.abs(np.fft.rfft(residual)[1:-1]) ** 2
    assert power[: len(power) // BANDS].mean() > 20 * power[-len(power) // 4 :].mean()


def test_noise_of_the_speed_alone_is_only_scaled() -> None:
    found, residual, _ = whitened("flexible", "speed")
    assert found(residual) == pytest.approx(residual / SPEED)
    assert found.levels.torque == 0.0


def test_signals_are_filtered_row_by_row() -> None:
    found, residual, _ = whitened("flexible", "both")
    rows = np.stack([residual, 2 * residual, residual[::-1]])
    assert found(rows)[1] == pytest.approx(2 * found(residual))
    assert found(rows)[2] == pytest.approx(found(residual[::-1].copy()))
