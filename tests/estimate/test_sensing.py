"""Records of an angle alone: the simulation passes the operator by which the speed was derived."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.residual import OutputError, observed, state_weights
from robotid.estimate.result import FitResult
from robotid.estimate.sensing import joint_for
from robotid.model.structure import Structure
from robotid.signals.record import Quantity, Record, SpeedOrigin
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate

AXIS = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUTH = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.6}
SLOW, FAST = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0), (0.5, 1.0, 3.0, 40.0)


def angle_only(sampling_time: float, counts: int, lines: tuple[float, ...], *, loop_noise: float = 0.0) -> Record:
    """Four seconds of an axis under speed control, of which torque and angle are recorded. counts : of its encoder a
    turn, 0 without one; loop_noise [rad/s] : of the speed that the controller sees."""
    joint = assemble(AXIS, angle=True)
    t = np.arange(round(4.0 / sampling_time)) * sampling_time
    phase = np.random.default_rng(1).uniform(0, 2 * np.pi, len(lines))
    wave = np.sin(2 * np.pi * np.outer(t, lines) + phase).sum(axis=1) - np.sin(phase).sum()
    reference = Reference("log", sampling_time, 40.0 * wave / np.abs(wave).max(), "speed")
    truth = joint.parameters().with_values(TRUTH).values
    quantum = 2 * np.pi / counts if counts else 0.0
    robot = VirtualRobot(joint, truth, Controller("speed", 0.5, 5.0), quantum, 0.0, loop_noise, seed=3)
    record = robot.record(reference, 0)
    return Record.from_arrays(record.tau_m, record.phi_m, sampling_time, name="log")


def fitted(record: Record, output: Quantity) -> FitResult:
    joint = joint_for(AXIS, output, (record,))
    start = joint.parameters().with_values({name: 1.2 * value for name, value in TRUTH.items()})
    return fit_model("m", joint, start, (record,), FitOptions(output=output))


@pytest.mark.parametrize("output", ["speed", "position"])
@pytest.mark.parametrize(
    "record",
    [
        angle_only(0.004, 2**18, FAST),
        angle_only(0.0005, 2**18, SLOW, loop_noise=0.3),
        angle_only(0.0005, 4096, SLOW),
    ],
    ids=["4 ms, 40 Hz", "noise in the loop", "4096 counts"],
)
def test_an_angle_alone_gives_the_truth_within_its_deviations(record: Record, output: Quantity) -> None:
    found = fitted(record, output)
    for name, value in TRUTH.items():
        assert 3 * found[name].std_robust < 0.01 * value
        # an axis that reverses twice within an interval is simulated to some 1e-5 of its parameters
        assert abs(found[name].value - value) < 3 * found[name].std_robust + 1e-4 * value


def test_the_operator_leaves_no_misfit() -> None:
    record = angle_only(0.004, 0, FAST)
    found = fitted(record, "speed")
    assert found.noise_std["log"] < 1e-6
    measured = replace(record, speed_origin="sensor")  # what a simulated speed differs from the derived one by
    assert fitted(measured, "speed").noise_std["log"] > 0.1


def test_without_the_angle_as_a_state_the_speed_is_summed_up() -> None:
    record = angle_only(0.004, 0, FAST)
    joint = assemble(AXIS)
    start = joint.parameters().with_values(TRUTH)
    assert not joint.keeps_angle
    problem = OutputError(joint, start, (record,), "speed", np.ones(1))
    at = problem.evaluate(problem.start())
    assert float(np.std(at.residuals[0])) < 0.1  # reversals within an interval, where a trapezoid is not exact
    found, step = problem.jacobian(at, 0).values, 1e-5
    for k in range(len(problem.columns)):
        ahead, behind = (
            problem.evaluate(at.unknowns + s * step * at.unknowns * (np.arange(len(at.unknowns)) == k)).residuals[0]
            for s in (1, -1)
        )
        expected = (ahead - behind) / (2 * step * at.unknowns[k])
        assert np.median(np.abs(found[k] - expected)) < 1e-3 * np.abs(expected).max()


def test_pieces_are_compared_with_the_speed_derived_in_each() -> None:
    record = angle_only(0.004, 0, FAST)
    run = simulate_record(fitted_model(fitted(record, "speed")), record, horizon=1.0)
    assert len(run.pieces) == 4
    assert float(np.abs(run.measured("speed") - run.signal("speed")).max()) < 1e-3


@pytest.mark.parametrize("origin", ["sensor", "central difference", "backward difference"])
@pytest.mark.parametrize("output", ["speed", "position"])
def test_weights_of_the_output_are_weights_of_a_state(output: Quantity, origin: SpeedOrigin) -> None:
    record = replace(angle_only(0.004, 0, FAST), speed_origin=origin)
    joint = assemble(AXIS, angle=True)
    theta, x0 = joint.parameters().with_values(TRUTH).values, np.array([0.0, 3.0])
    trajectory, weights = simulate(joint, theta, record, x0), np.random.default_rng(4).standard_normal(len(record))
    row, of_state = state_weights(trajectory, output, weights)
    assert of_state @ trajectory.x[row] == pytest.approx(weights @ observed(trajectory, output), rel=1e-6)


def test_the_angle_is_a_state_where_it_or_its_derivative_is_compared() -> None:
    derived = angle_only(0.004, 0, FAST)
    sensed = replace(derived, speed_origin="sensor")
    assert joint_for(AXIS, "speed", [sensed, derived]).keeps_angle
    assert joint_for(AXIS, "position", [sensed]).keeps_angle
    assert not joint_for(AXIS, "speed", [sensed]).keeps_angle
