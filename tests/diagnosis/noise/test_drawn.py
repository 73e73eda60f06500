"""Noise through a joint whose motor reverses and rests, where no linear response tells what it leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from robotid.catalogue import assemble
from robotid.diagnosis.noise import drawn
from robotid.diagnosis.noise.colour import coloured_noise
from robotid.diagnosis.noise.drawn import drawn_residuals
from robotid.diagnosis.noise.settings import NOISE
from robotid.estimate.fitted_model import SimulatedSegment, simulated_segment
from robotid.estimate.noise.information import are_explained, is_explained
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

STEP, SAMPLES, SPEED_NOISE, SIZE, POLE = 1e-3, 8000, 0.01, 0.02, 0.99
STRUCTURE = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUTH = {"motor.inertia.J": 2e-3, "motor.viscous.Fv": 0.004, "motor.coulomb.Fc": 0.3}


def red(rng: np.random.Generator) -> Array:
    drive = rng.standard_normal(SAMPLES + 2000)
    return np.asarray(SIZE * lfilter([np.sqrt(1 - POLE**2)], [1.0, -POLE], drive)[2000:])


def resting(seed: int, missing: float = 0.0) -> SimulatedSegment:
    """An axis that rests in its dry friction five times a second, simulated by its true parameters under a torque that
    was recorded with red errors. missing : dry friction that its model lacks [Nm]."""
    joint, rng, t = assemble(STRUCTURE), np.random.default_rng(seed), STEP * np.arange(SAMPLES)
    theta, acting = joint.parameters().with_values(TRUTH).values, 0.5 * np.sin(2 * np.pi * 2.5 * t)
    true = theta + missing * np.array([name == "motor.coulomb.Fc" for name in joint.names])
    record = Record("r", "estimate", "both", STEP, acting, 0.0 * t, 0.0 * t)
    speed = simulate(joint, true, record, np.zeros(1)).dphi_m + SPEED_NOISE * rng.standard_normal(SAMPLES)
    record = replace(record, dphi_m=speed, tau_m=acting + red(rng))
    return simulated_segment(record, simulate(joint, theta, record, np.zeros(1)), "speed")


def energy(signal: Array) -> float:
    return float(signal @ signal)


def test_drawn_residuals_are_as_loud_as_true_ones() -> None:
    levels = NoiseLevels(SPEED_NOISE**2, 0.0, SIZE**2, -np.log(POLE) / STEP)
    true = [energy(resting(seed).residual) for seed in range(NOISE.draws)]
    drawn = [energy(signal) for signal in drawn_residuals(resting(99), levels, "speed")]
    assert len(drawn) == NOISE.draws
    assert np.mean(drawn) == pytest.approx(np.mean(true), rel=0.3)


def test_noise_that_shifts_reversals_is_noise() -> None:
    seen = resting(1)
    found = coloured_noise([seen], [np.zeros((0, SAMPLES))], "speed")
    levels = found.segments[0].whitening.levels
    assert not is_explained(found.residuals[0], levels, tolerance=NOISE.tolerance)
    assert found.explained


def test_a_misfit_at_the_same_places_is_none() -> None:
    """A dry friction that is wrong by five times the error of the torque also shows where the motor reverses."""
    quiet, wrong = (resting(1, missing) for missing in (0.0, 5 * SIZE))
    levels = coloured_noise([quiet], [np.zeros((0, SAMPLES))], "speed").segments[0].whitening.levels
    found = coloured_noise([wrong], [np.zeros((0, SAMPLES))], "speed")

    def explained(noise: NoiseLevels) -> bool:
        def drawn_ones() -> list[tuple[Array]]:
            return [(one,) for one in drawn_residuals(wrong, noise, "speed")]

        return are_explained(found.residuals, [noise], tolerance=NOISE.tolerance, drawn=drawn_ones)

    assert not explained(levels)


def test_a_joint_that_cannot_be_simulated_explains_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn, "simulate_under", lambda torques, *_: [None for _ in torques])
    found = coloured_noise([resting(1)], [np.zeros((0, SAMPLES))], "speed")
    assert drawn_residuals(resting(1), NoiseLevels(1.0, 1.0), "speed") == []
    assert not found.explained
