"""Responses between several axes, from experiments with orthogonal phases, against the matrices of a linear robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from support.coupled_axes import RATIOS, TRUTH, axes, chain

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate.notch import read_off_axes
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.frf import Complex
from robotid.signals.frf_matrix import FrfMatrix, estimate_frf_matrix, log_mean
from robotid.signals.multisine import multisine
from robotid.signals.orthogonal import orthogonal_phases
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.coupled.coupled_robot import CoupledRobot

H, PERIOD, PERIODS = 1e-3, 2.0, 3
LINES = np.arange(4, 81)  # 2 to 40 Hz
BAND = (2.0, 40.0)
LINEAR = ("motor.inertia", "motor.viscous", "gear.spring", "gear.damper", "arm.inertia")
POSE = (0.3, 1.0)
NAMES = ("a1", "a2")


def robot(noise: float = 0.0) -> CoupledRobot:
    """The two axes without dry friction, and stiff loops that keep them near their pose."""
    made = {}
    for name, one, values in zip(NAMES, axes(), TRUTH, strict=True):
        joint = assemble(Structure(LINEAR, gear_ratio=one.joint.ratio), angle=True)
        J, Fv, _, *rest = values
        theta = np.array([J, Fv, *rest])
        made[name] = replace(one, joint=joint, theta=theta, torque_noise=noise, speed_noise=10 * noise)
    return CoupledRobot(made, chain())


def experiments(seed: int, noise: float = 0.0, pose: tuple[float, float] = POSE) -> list[dict[str, Record]]:
    """Two, with orthogonal phases, of motions so small that the pose stays what it is."""
    phases = orthogonal_phases(2, len(LINES), np.random.default_rng(seed))
    samples = round(PERIOD / H)
    made = []
    for number, own in enumerate(phases):
        waves = [np.tile(multisine(LINES, np.full(len(LINES), 0.05), one, samples), PERIODS) for one in own]
        references = {
            name: Reference(name, H, wave, "speed", period=PERIOD, band=BAND)
            for name, wave in zip(NAMES, waves, strict=True)
        }
        made.append(robot(noise).record(references, 10 * seed + number, dict(zip(NAMES, pose, strict=True))))
    return made


def matrices(pose: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Mass, damping and stiffness over both motors and then both arms, twice differentiated by hand."""
    masses, damping, stiffness = np.zeros((3, 4, 4))
    masses[2:, 2:] = chain().mass(np.array(pose)[:, None])[:, :, 0]
    for k, (ratio, (J, Fv, _, k1, d, flange)) in enumerate(zip(RATIOS, TRUTH, strict=True)):
        twist = np.zeros(4)
        twist[k], twist[2 + k] = ratio, -1.0
        masses[k, k], masses[2 + k, 2 + k] = J, masses[2 + k, 2 + k] + flange
        damping += d * np.outer(twist, twist)
        damping[k, k] += Fv
        stiffness += k1 * np.outer(twist, twist)
    return masses, damping, stiffness


def analytic(frequency: Array, pose: tuple[float, float] = POSE) -> Complex:
    """From both torques to both motors' accelerations, (2, 2, n)."""
    M, D, K = matrices(pose)
    s = 2j * np.pi * frequency[:, None, None]
    return np.asarray(np.moveaxis((s**2 * np.linalg.inv(M * s**2 + D * s + K))[:, :2, :2], 0, -1))


@pytest.fixture(scope="module")
def estimated() -> FrfMatrix:
    return estimate_frf_matrix(experiments(1))


def test_phases_are_orthogonal_over_the_experiments() -> None:
    amplitudes = np.exp(1j * orthogonal_phases(3, 5, np.random.default_rng(0)))
    for line in range(5):
        matrix = amplitudes[:, :, line]
        assert matrix.conj().T @ matrix == pytest.approx(3.0 * np.eye(3), abs=1e-12)
    assert len(np.unique(np.angle(amplitudes[0]))) == 15


def test_the_matrix_is_that_of_the_linear_robot(estimated: FrfMatrix) -> None:
    expected = analytic(estimated.frequency)
    size = np.sqrt(np.abs(expected[0, 0] * expected[1, 1]))
    assert np.abs(estimated.response - expected).max(axis=(0, 1)) / size == pytest.approx(0.0, abs=0.02)
    assert estimated.axes == NAMES
    assert estimated.frequency == pytest.approx(LINES / PERIOD)
    assert np.abs(expected[0, 1]).max() > 0.2 * np.abs(expected[0, 0]).min()


def test_one_experiment_alone_would_confound_the_axes() -> None:
    """What a single axis' response is while the other one moves at the same lines, and what the pair of them is."""
    first = experiments(1)[0]
    expected = analytic(LINES / PERIOD)[0, 0]
    lines = LINES * (PERIODS - 1)
    spectra = [
        np.fft.rfft(signal[-2000 * (PERIODS - 1) :])[lines] for signal in (first["a1"].dphi_m, first["a1"].tau_m)
    ]
    single = 2j * np.pi * LINES / PERIOD * spectra[0] / spectra[1]
    assert np.median(np.abs(single - expected) / np.abs(expected)) > 0.03


def test_every_axis_shows_its_notches_while_the_other_motor_stands(estimated: FrfMatrix) -> None:
    """Where the response is least, near the roots of the arms' M and K, which damping moves a little."""
    M, _, K = matrices(POSE)
    arms = np.sqrt(scipy.linalg.eigh(K[2:, 2:], M[2:, 2:], eigvals_only=True))
    fine = np.linspace(*BAND, 4000)
    stiffness = np.linalg.inv(np.moveaxis(analytic(fine), -1, 0))
    for k, (name, arm) in enumerate(zip(NAMES, arms, strict=True)):
        notch = read_off_axes(estimated)[name].notch
        near = np.abs(2 * np.pi * fine / arm - 1.0) < 0.1
        least = 2 * np.pi * fine[near][np.argmax(np.abs(stiffness[near, k, k]))]
        assert notch == pytest.approx(least, rel=0.01)
        assert notch == pytest.approx(arm, rel=0.05)


def test_the_error_is_as_large_as_it_says() -> None:
    found = estimate_frf_matrix(experiments(2, noise=2e-4))
    ratio = np.abs(found.response - analytic(found.frequency)) / found.std
    assert 0.5 < np.sqrt(np.mean(ratio**2)) < 2.5


def test_the_mean_of_logarithms_is_the_geometric_one(estimated: FrfMatrix) -> None:
    turned = replace(estimated, response=estimated.response * 4.0 * np.exp(0.6j))
    mean = log_mean([estimated, turned])
    assert mean.response == pytest.approx(estimated.response * 2.0 * np.exp(0.3j))
    assert log_mean([estimated]) is estimated
    assert mean.std == pytest.approx(np.abs(mean.response) * np.hypot(np.log(4.0), 0.6) / 2.0)


def test_poses_and_lines_that_do_not_fit_are_refused(estimated: FrfMatrix) -> None:
    with pytest.raises(NumericsError, match="other lines"):
        log_mean([estimated, replace(estimated, frequency=estimated.frequency + 1.0)])
    one = experiments(1)[0]
    with pytest.raises(NumericsError, match="1 experiments cannot tell 2 axes apart"):
        estimate_frf_matrix([one])
    with pytest.raises(NumericsError, match="do not tell the axes apart"):
        estimate_frf_matrix([one, one])
