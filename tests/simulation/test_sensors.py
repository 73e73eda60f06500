"""What sensors show of a motion: its derivatives are exact, and the virtual robot shows the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.channels import CHANNELS
from robotid.model.array import Array
from robotid.model.delay import delayed
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.differentiate import central_difference
from robotid.signals.record import OPERATORS, Record, SpeedOrigin
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.sensors import sensor_columns, sensor_signals
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

ON_SENSORS = [f"{s}.{c.name}" for c in CHANNELS.values() for s in c.signals if s in ("angle", "speed")]
T = np.arange(1200) * SAMPLING_TIME
U = 2.0 * np.sin(2 * np.pi * 4 * T) + 0.7
RECORD = Record("r", "estimate", "both", SAMPLING_TIME, U, 0 * U + 0.3, 0 * U)

on_sensors = pytest.mark.parametrize("effect", ON_SENSORS)


def values(joint: Joint) -> Array:
    """The paper's joint, and channels where they show: a delay off whole samples."""
    declared = joint.parameters()
    given = {
        n: TRUTH.get(n, 1.3e-3 if n.endswith("Td") else v) for n, v in zip(joint.names, declared.values, strict=True)
    }
    return declared.with_values(given).values


def signals(trajectory: Trajectory) -> Array:
    """Angle and speed as the sensors show them, (2, n)."""
    t = trajectory
    return np.array(sensor_signals(t.joint, t.theta, t.sampling_time, t.phi_m, t.dphi_m, t.speed_origin))


@pytest.mark.parametrize("origin", ["sensor", *OPERATORS])
@on_sensors
def test_derivatives_are_those_of_differences(effect: str, origin: SpeedOrigin) -> None:
    record = replace(RECORD, speed_origin=origin)
    joint = assemble(STRUCTURE.extended(effect), angle=True)
    theta, columns = values(joint), range(len(joint.names))
    trajectory = simulate(joint, theta, record)
    rows = (joint.motor_angle, joint.motor_speed)
    found = np.array(sensor_columns(trajectory, columns, *sensitivities(trajectory, record, columns, rows)))
    for k in columns:
        step = 1e-5 * theta[k] * (np.arange(len(theta)) == k)
        ahead, behind = (signals(simulate(joint, theta + s * step, record, guess=trajectory.x)) for s in (1, -1))
        expected = (ahead - behind) / (2 * step[k])
        for row in (0, 1):
            assert found[row, k] == pytest.approx(expected[row], abs=2e-5 * np.abs(expected[row]).max() + 1e-9)


def test_first_states_act_through_a_rippling_encoder() -> None:
    joint = assemble(STRUCTURE.extended("angle.encoder_ripple"))
    theta, angle = values(joint), joint.motor_angle
    x0 = simulate(joint, theta, RECORD).x[:, 0]
    trajectory = simulate(joint, theta, RECORD, x0)
    inner = sensitivities(trajectory, RECORD, (), (angle, joint.motor_speed), range(joint.nx))
    found = np.array(sensor_columns(trajectory, (), *inner))
    step = 1e-4 * (np.arange(joint.nx) == angle)
    ahead, behind = (signals(simulate(joint, theta, RECORD, x0 + s * step, trajectory.x)) for s in (1, -1))
    assert found[:, angle] == pytest.approx((ahead - behind) / 2e-4, abs=1e-6)
    assert np.abs(found[1, angle]).max() > 1e-3


def test_a_joint_with_a_channel_on_its_angle_keeps_the_angle() -> None:
    assert assemble(STRUCTURE.extended("angle.encoder_ripple")).keeps_angle
    assert not assemble(STRUCTURE.extended("speed.sensor_delay")).keeps_angle


def test_speed_is_the_derivative_of_the_angle_that_is_shown() -> None:
    joint = assemble(STRUCTURE.extended("angle.encoder_ripple"))
    phi, dphi = signals(simulate(joint, values(joint), RECORD))
    assert dphi[1:-1] == pytest.approx((phi[2:] - phi[:-2]) / (2 * SAMPLING_TIME), abs=2e-3)


def test_channels_act_in_the_order_of_the_structure() -> None:
    both = Structure(("motor.inertia",), ("angle.sensor_delay", "angle.encoder_ripple"))
    joint = assemble(both)
    theta = joint.parameters().with_values(
        {"angle.sensor_delay.Td": 1e-3, "angle.encoder_ripple.A": 0.1, "angle.encoder_ripple.B": 0.0}
    )
    angle = np.linspace(0.0, 9.0, 50)
    late = CHANNELS["sensor_delay"].apply(angle, SAMPLING_TIME, [1e-3])
    phi, _ = sensor_signals(joint, theta.values, SAMPLING_TIME, angle, 0 * angle)
    assert phi == pytest.approx(late + 0.1 * np.sin(late), abs=1e-12)


@on_sensors
def test_the_virtual_robot_shows_and_sees_what_its_sensors_show(effect: str) -> None:
    joint = assemble(STRUCTURE.extended(effect), angle=True)
    theta, controller = values(joint), Controller("speed", kp=0.5, ki=5.0)
    reference = Reference("r", SAMPLING_TIME, 10.0 + 5 * np.sin(2 * np.pi * 6 * T[:600]), "speed")
    record = VirtualRobot(joint, theta, controller).record(reference, 0)
    x, torque = VirtualRobot(joint, theta, controller).follow(reference)
    phi_m, dphi_m = x[joint.motor_states]
    phi, dphi = sensor_signals(joint, theta, SAMPLING_TIME, phi_m, dphi_m)
    assert np.array_equal(record.phi_m, phi)
    assert np.array_equal(record.dphi_m, dphi)
    distorted = np.abs(dphi - dphi_m).max() if effect.startswith("speed") else np.abs(phi - phi_m).max()
    assert distorted > 1e-4
    error = reference.ref - dphi
    integral = np.concatenate([[0.0], np.cumsum(error)[:-1]]) * SAMPLING_TIME
    assert torque == pytest.approx(controller.kp * error + controller.ki * integral, abs=1e-6)


def test_a_derived_speed_is_simulated_by_the_same_operator() -> None:
    joint = assemble(STRUCTURE.extended("angle.encoder_ripple").extended("speed.sensor_delay"))
    trajectory = simulate(joint, values(joint), replace(RECORD, speed_origin="central difference"))
    angle, speed = signals(trajectory)
    derived, late = central_difference(angle, SAMPLING_TIME), values(joint)[joint.names.index("speed.sensor_delay.Td")]
    assert speed == pytest.approx(delayed(derived, late / SAMPLING_TIME)[0])
    assert np.abs(speed - trajectory.dphi_m).max() > 1e-3
