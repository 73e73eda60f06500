"""Derivatives of a trajectory against central differences of whole simulations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.signals.record import Record
from robotid.simulation.newton.chunked_responses import MANY
from robotid.simulation.sensitivities import force_gradient, sensitivities, torque_gradient
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

N = 3000
T = np.arange(N) * SAMPLING_TIME
U = 1.5 * np.sin(2 * np.pi * 4 * T)  # reversals and standstill
RECORD = Record("r", "estimate", "both", SAMPLING_TIME, U, 0 * U, 0 * U)
JOINT = assemble(STRUCTURE)
THETA = JOINT.parameters().with_values(TRUTH).values
START = np.array([1e-5, 2.0, 0.01])


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return simulate(JOINT, THETA, RECORD, x0=START)


@pytest.fixture(scope="module")
def derivatives(trajectory: Trajectory) -> np.ndarray:
    return sensitivities(trajectory, RECORD, range(len(THETA)), (0, 1, 2), (0, 1, 2))


def test_the_record_has_reversals_and_standstill(trajectory: Trajectory) -> None:
    assert np.sum(np.diff(np.sign(trajectory.dphi_m)) != 0) > 5
    assert np.sum(trajectory.dphi_m == 0.0) > 5


@pytest.mark.parametrize("k", range(7), ids=list(TRUTH))
def test_to_parameters(k: int, trajectory: Trajectory, derivatives: np.ndarray) -> None:
    step = np.zeros(len(THETA))
    step[k] = 1e-5 * THETA[k]
    plus, minus = (simulate(JOINT, THETA + s * step, RECORD, START, trajectory.x).x for s in (1, -1))
    expected = (plus - minus) / (2 * step[k])
    for row in range(3):
        assert derivatives[row, k] == pytest.approx(expected[row], abs=1e-5 * np.abs(expected[row]).max())


@pytest.mark.parametrize("k", range(3))
def test_to_initial_states(k: int, trajectory: Trajectory, derivatives: np.ndarray) -> None:
    step = np.zeros(3)
    step[k] = 1e-6 * max(1e-3, abs(START[k]))
    plus, minus = (simulate(JOINT, THETA, RECORD, START + s * step, trajectory.x).x for s in (1, -1))
    expected = (plus - minus) / (2 * step[k])
    for row in range(3):
        assert derivatives[row, 7 + k] == pytest.approx(expected[row], abs=1e-5 * np.abs(expected[row]).max())


def test_a_parameter_and_its_difference_in_this_record_count_alike(derivatives: np.ndarray) -> None:
    joint = assemble(STRUCTURE.extended("record_change.r.motor.coulomb.Fc").extended("record_change.q.gear.damper.d"))
    theta = np.append(THETA, [0.0, 0.0])
    both = sensitivities(simulate(joint, theta, RECORD, START), RECORD, range(9), (0, 1, 2))
    assert both[:, :7] == pytest.approx(derivatives[:, :7], rel=1e-9)
    assert np.array_equal(both[:, 7], both[:, 2])
    assert not both[:, 8].any()


@pytest.mark.parametrize("row", range(3))
def test_the_gradient_to_forces_is_the_adjoint_of_the_sensitivities(row: int, trajectory: Trajectory) -> None:
    rng = np.random.default_rng(1)
    weights, forces = rng.standard_normal(N), rng.standard_normal((2, 1, N))
    forward = sensitivities(trajectory, RECORD, (), (row,), (), forces)[0, 0]
    back = force_gradient(trajectory, row, weights)
    assert float(np.sum(back * forces[:, 0])) == pytest.approx(float(weights @ forward), rel=1e-9)


def test_to_the_torque_of_every_interval(trajectory: Trajectory) -> None:
    rng = np.random.default_rng(4)
    weights, error = rng.standard_normal((2, N)), 1e-7 * rng.standard_normal(N)
    back = torque_gradient(trajectory, JOINT.motor_speed, weights)
    plus, minus = (
        simulate(JOINT, THETA, replace(RECORD, tau_m=U + s * error), START, trajectory.x).x[JOINT.motor_speed]
        for s in (1, -1)
    )
    assert back @ error == pytest.approx(weights @ (plus - minus) / 2, rel=1e-4)
    held = np.flatnonzero((trajectory.dphi_m[:-1] == 0.0) & (trajectory.dphi_m[1:] == 0.0))
    assert len(held)
    assert not back[:, held].any()


@pytest.mark.parametrize("rows", [(1,), (0, 1, 2)])
def test_many_forces_at_once_do_what_few_do(
    rows: tuple[int, ...], trajectory: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotid.simulation.sensitivities.BLOCK", 700)
    forces = np.random.default_rng(8).standard_normal((2, MANY + 5, N))
    few = [
        sensitivities(trajectory, RECORD, (0, 3), rows, (1,), forces[:, part])
        for part in (slice(0, 10), slice(10, MANY + 5))
    ]
    many = sensitivities(trajectory, RECORD, (0, 3), rows, (1,), forces)
    alone = np.concatenate([few[0], few[1][:, 3:]], axis=1)
    scale = np.abs(alone).max(axis=2, keepdims=True)
    assert many / scale == pytest.approx(alone / scale, abs=1e-11)
