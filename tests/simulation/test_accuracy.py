"""The simulator against integrators that share nothing with it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.extended_joint import open_loop
from support.fine_steps import Hidden, fine_steps
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH, references

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate


def record_of(u: Array, speed: Array) -> Record:
    return Record("r", "estimate", "both", SAMPLING_TIME, u, np.cumsum(speed) * SAMPLING_TIME, speed)


def torques() -> list[Array]:
    """Open-loop torques that move the joint roughly as the paper's sets do, reversals and standstill included."""
    total = TRUTH["motor.inertia.J"] + RATIO**2 * TRUTH["arm.inertia.J"]
    made = []
    for ref in references():
        smooth = np.convolve(ref, np.ones(40) / 40, mode="same")
        acceleration = np.gradient(smooth, SAMPLING_TIME)
        made.append(total * np.clip(acceleration, -150, 150) + 0.013 * smooth + 0.644 * np.tanh(smooth / 0.5))
    return made


@pytest.mark.parametrize("number", [0, 1, 2])
def test_dry_friction_agrees_with_a_set_valued_reference(number: int) -> None:
    u = torques()[number]
    speed = fine_steps(u, SAMPLING_TIME, Hidden(), substeps=160)
    joint = assemble(STRUCTURE)
    simulated = simulate(joint, joint.parameters().with_values(TRUTH).values, record_of(u, speed), x0=np.zeros(3))
    assert simulated.fallback_windows == ()
    assert np.sqrt(np.mean((simulated.dphi_m - speed) ** 2)) <= 0.0005


HARD = {
    "gear.backlash": ({"gap": 2e-5}, Hidden(gap=2e-5)),
    "gear.soft_spring": ({"s": 0.5, "xs": 2e-5}, Hidden(soft=0.5, soft_within=2e-5)),
    "gear.transmission_error": ({"A": 1e-5, "B": 0.0, "n": 2.0}, Hidden(error=1e-5, error_periods=2.0)),
    "gear.hysteresis": ({"kh": 80.0, "xs": 3e-5}, Hidden(slip_torque=80.0, slip_twist=3e-5)),
    "motor.load_friction": ({"mu": 0.05}, Hidden(load=0.05)),
    "motor.thermal_friction": ({"c": 0.3, "T": 0.5}, Hidden(warm_up=0.3, warm_up_time=0.5)),
    "motor.presliding": ({"w": 1.0, "s0": 30.0, "s1": 1e-3}, Hidden(bristles=30.0, bristle_damping=1e-3)),
}


@cache
def without_effect() -> Array:
    return fine_steps(open_loop(1500).tau_m, SAMPLING_TIME, Hidden())


@pytest.mark.parametrize("effect", HARD)
def test_what_is_hard_to_simulate_agrees_with_small_steps(effect: str) -> None:
    own, hidden = HARD[effect]
    record, joint = open_loop(1500), assemble(STRUCTURE.extended(effect))
    theta = joint.parameters().with_values(TRUTH | {f"{effect}.{k}": v for k, v in own.items()}).values
    expected = fine_steps(record.tau_m, SAMPLING_TIME, hidden)
    error = simulate(joint, theta, record, np.zeros(joint.nx)).dphi_m - expected
    assert np.linalg.norm(error) < 0.03 * np.linalg.norm(expected - without_effect())


def test_a_stuck_motor_does_not_move_at_all() -> None:
    t = np.arange(2000) * SAMPLING_TIME
    u = 0.6 * np.sin(2 * np.pi * 3 * t)
    joint = assemble(STRUCTURE)
    simulated = simulate(joint, joint.parameters().with_values(TRUTH).values, record_of(u, 0 * u), x0=np.zeros(3))
    assert np.all(simulated.dphi_m == 0.0)


def test_smooth_models_agree_with_lsoda_at_tight_tolerance() -> None:
    structure = Structure(tuple(t for t in STRUCTURE.terms if t != "motor.coulomb"), gear_ratio=RATIO)
    joint = assemble(structure)
    theta = joint.parameters().with_values({k: v for k, v in TRUTH.items() if "coulomb" not in k}).values
    jm, fv, k1, k3, d, ja = theta
    t = np.arange(1500) * SAMPLING_TIME
    u = 3 * np.sin(2 * np.pi * 1.3 * t) + 2 * np.sin(2 * np.pi * 7 * t + 1)

    def rate(x: Array, torque: float) -> list[float]:
        slip = RATIO * x[1] - x[2]
        gear = k1 * x[0] + k3 * x[0] ** 3 + d * slip
        return [slip, (torque - fv * x[1] - RATIO * gear) / jm, gear / ja]

    x = [np.zeros(3)]
    for torque in u[:-1]:
        step = solve_ivp(lambda _, y, q=torque: rate(y, q), (0, SAMPLING_TIME), x[-1], "LSODA", rtol=1e-11, atol=1e-13)
        x.append(step.y[:, -1])
    simulated = simulate(joint, theta, record_of(u, 0 * u), x0=np.zeros(3))
    assert np.abs(simulated.x - np.array(x).T).max(axis=1) == pytest.approx(np.zeros(3), abs=1e-6)
