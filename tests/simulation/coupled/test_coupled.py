"""Coupled axes: their body and their equations against textbook facts, their motion against another plant."""

from __future__ import annotations

import numpy as np
import pytest
from study.plant.pair_experiment import experiment
from support.coupled_axes import H, axes, chain, links, plant_axes, references

from robotid.catalogue import assemble
from robotid.model.structure import Structure
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.loop import ControlledJoint
from robotid.simulation.coupled.coupled_joints import CoupledJoints
from robotid.simulation.coupled.coupled_robot import CoupledRobot
from robotid.simulation.coupled.loop import follow
from robotid.simulation.coupled.planar_chain import Link, PlanarChain

THREE = PlanarChain([Link(20, 0.5, 0.25, 0.5), Link(10, 0.4, 0.2, 0.2), Link(3, 0.1, 0.1, 0.05)], 9.81)
STRUCTURES = (
    Structure(
        ("motor.inertia", "motor.coulomb", "gear.spring", "gear.damper", "arm.inertia", "arm.coulomb"), gear_ratio=0.01
    ),
    Structure(("motor.inertia", "motor.stribeck", "gear.spring", "arm.inertia", "gear.backlash"), gear_ratio=0.0125),
    Structure(("motor.inertia", "motor.viscous", "motor.coulomb"), gear_ratio=0.02),
)
VALUES = ((1e-3, 0.1, 2e4, 20.0, 1.0, 2.0), (1e-3, 0.1, 1.0, 1.5e4, 0.5, 1e-4), (1e-3, 2e-3, 0.2))


def test_the_torque_of_the_body_has_exact_derivatives() -> None:
    rng = np.random.default_rng(0)
    q, dq, ddq = rng.standard_normal((3, 3, 4))
    found = THREE.linearise(q, dq, ddq)
    for k in range(3):
        step = np.zeros((3, 1))
        step[k] = 1e-6
        by_angle = (THREE.torque(q + step, dq, ddq) - THREE.torque(q - step, dq, ddq)) / 2e-6
        by_speed = (THREE.torque(q, dq + step, ddq) - THREE.torque(q, dq - step, ddq)) / 2e-6
        assert found.to_angles[:, k] == pytest.approx(by_angle, abs=1e-6)
        assert found.to_speeds[:, k] == pytest.approx(by_speed, abs=1e-6)


def test_the_power_of_the_body_torque_is_the_change_of_its_energy() -> None:
    t = np.linspace(0.0, 1.0, 4001)
    sizes, rates = np.array([[0.7], [-1.1], [0.4]]), np.array([[3.0], [5.0], [4.0]])
    q, dq, ddq = sizes * np.sin(rates * t), sizes * rates * np.cos(rates * t), -sizes * rates**2 * np.sin(rates * t)
    power = (THREE.torque(q, dq, ddq) * dq).sum(axis=0)
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2) * t[1]])
    energy = THREE.energy(q, dq)
    assert work == pytest.approx(energy - energy[0], abs=1e-4)
    assert np.ptp(energy) > 10.0


def test_a_single_link_is_a_pendulum() -> None:
    link = PlanarChain([Link(2.0, 1.0, 0.6, 0.1)], 9.81)
    q = np.array([[0.0, np.pi / 3, np.pi / 2]])
    weight = 2.0 * 9.81 * 0.6 * np.cos(q)
    assert link.torque(q, np.ones((1, 3)), np.full((1, 3), 5.0)) == pytest.approx(weight + 5.0 * (0.1 + 2.0 * 0.36))


def test_the_coupled_joints_have_exact_derivatives() -> None:
    mechanism = CoupledJoints([assemble(one, angle=True) for one in STRUCTURES], THREE)
    theta, rng = np.concatenate([np.array(v) for v in VALUES]), np.random.default_rng(1)
    x, u, t = rng.standard_normal((mechanism.nx, 6)), rng.standard_normal((6, 3)), np.zeros(6)
    s = mechanism.directions(x, np.sign(x[mechanism.speeds]), t, theta)
    found = mechanism.evaluate(x, u, s, t, theta, columns=mechanism.motor_columns)
    assert found.B is not None
    scale = np.abs(found.A).max()
    for k in range(mechanism.nx):
        step = np.zeros((mechanism.nx, 1))
        step[k] = 1e-6
        ahead, back = (mechanism.evaluate(x + sign * step, u, s, t, theta).f for sign in (1, -1))
        assert found.A[:, k] == pytest.approx((ahead - back) / 2e-6, abs=1e-8 * scale)
    for k in range(3):
        push = np.zeros((1, 3))
        push[0, k] = 1e-3
        ahead, back = (mechanism.evaluate(x, u + sign * push, s, t, theta).f for sign in (1, -1))
        assert found.B[:, k] == pytest.approx((ahead - back) / 2e-3, abs=1e-6)


def test_edges_and_limits_are_where_the_joints_have_them() -> None:
    joints = [assemble(one, angle=True) for one in STRUCTURES]
    mechanism = CoupledJoints(joints, THREE)
    theta = np.concatenate([np.array(v) for v in VALUES])
    x, t = np.random.default_rng(2).standard_normal((mechanism.nx, 3)), np.zeros(3)
    s = np.sign(x[mechanism.speeds])
    own = joints[1].distances(x[mechanism.rows(1)], s[[2, 3]], t, np.array(VALUES[1]))
    assert mechanism.distances(x, s, t, theta) == pytest.approx(own)
    slopes = mechanism.distance_slopes(x, s, t, theta)
    step = np.zeros((mechanism.nx, 1))
    step[mechanism.rows(1)[0]] = 1e-6
    ahead, back = (mechanism.distances(x + sign * step, s, t, theta) for sign in (1, -1))
    assert slopes.to_states[:, mechanism.rows(1)[0]] == pytest.approx((ahead - back) / 2e-6)


def test_a_massless_link_leaves_the_first_axis_alone() -> None:
    one, two = axes()
    light = PlanarChain([Link(20.0, 0.5, 0.25, 0.5), Link(0.0, 0.4, 0.2, 0.0)])
    ref = references(600)
    coupled = follow((one, two), light, ref)
    larger = one.theta.copy()
    larger[5] += 0.5 + 20.0 * 0.25**2
    alone, torque = ControlledJoint(one.joint, larger, one.controller).follow(ref[0])
    assert coupled[0].x == pytest.approx(alone, abs=1e-6)
    assert coupled[0].torque == pytest.approx(torque, abs=1e-6)


@pytest.mark.parametrize(("gravity", "pose"), [(0.0, (0.0, 0.0)), (0.0, (0.5, -1.2)), (9.81, (1.2, 0.4))])
def test_agrees_with_the_plant_of_the_tests(gravity: float, pose: tuple[float, float]) -> None:
    """To within what a motor at rest gains in a sampling interval: only at its end does the simulator let it go."""
    ref = references(500)
    ours = follow(axes(), chain(gravity), ref, pose=pose)
    theirs = experiment(plant_axes(), links(gravity), (ref[0].ref, ref[1].ref), H, 0, pose, substeps=30)
    for run, other, robot in zip(ours, theirs, axes(), strict=True):
        joint = robot.joint
        errors = run.x[joint.motor_speed] - other.speed
        assert np.abs(errors).max() < 0.03
        assert np.median(np.abs(errors)) < 1e-4
        assert run.torque == pytest.approx(other.torque, abs=2e-3)
        assert run.x[joint.motor_speed + 1] == pytest.approx(other.arm_speed, abs=1e-4)
        assert np.ptp(other.arm_speed) > 0.1


def test_the_fallback_agrees_with_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    ref = references(20)
    usual = follow(axes(), chain(), ref)
    integrate = "robotid.simulation.coupled.loop.integrate"
    monkeypatch.setattr(integrate, lambda loop, x0, fallback: fallback(0, loop.intervals, x0))
    for run, again in zip(usual, follow(axes(), chain(), ref), strict=True):
        assert again.torque == pytest.approx(run.torque, abs=1e-4)


def test_a_record_has_the_angles_of_the_others_as_companions() -> None:
    one, two = axes(speed_noise=0.01, seed=3)
    robot = CoupledRobot({"a1": one, "a2": two}, chain())
    ref = dict(zip(("a1", "a2"), references(200), strict=True))
    records, again, other = robot.record(ref, 0), robot.record(ref, 0), robot.record(ref, 1, {"a2": 0.5})
    assert list(records["a1"].companions) == ["a2", "tau_a2"]
    assert records["a1"].companions["tau_a2"].values == pytest.approx(records["a2"].tau_m)
    assert records["a1"].companions["a2"].values == pytest.approx(two.joint.ratio * records["a2"].phi_m)
    assert np.array_equal(records["a2"].tau_m, again["a2"].tau_m)
    assert not np.array_equal(records["a2"].dphi_m, other["a2"].dphi_m)
    assert other["a2"].phi_m[0] == pytest.approx(0.5 / two.joint.ratio)


def test_a_controller_of_position_begins_at_its_reference() -> None:
    one, two = axes()
    position = Controller("position", kp=0.05, kpos=10.0)
    held = [ControlledJoint(robot.joint, robot.theta, position) for robot in (one, two)]
    ref = [Reference("held", H, np.full(100, 20.0 + k), "position") for k in range(2)]
    for run, joint, wanted in zip(follow(held, chain(), ref), (one.joint, two.joint), (20.0, 21.0), strict=True):
        assert run.x[joint.motor_angle] == pytest.approx(wanted)
