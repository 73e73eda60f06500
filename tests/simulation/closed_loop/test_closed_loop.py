"""The virtual robot under its controller, against the same loop written out sample by sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.loop import ControlledJoint, quantise
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate

JOINT = assemble(STRUCTURE, angle=True)
THETA = JOINT.parameters().with_values(TRUTH).values
N = 400
T = np.arange(N) * SAMPLING_TIME
SPEED = Reference("r", SAMPLING_TIME, 10.0 + 5 * np.sin(2 * np.pi * 6 * T), "speed")
POSITION = Reference("p", SAMPLING_TIME, 0.5 + 10.0 * T + 0.02 * np.sin(2 * np.pi * 6 * T), "position")


def by_hand(reference: Reference, kp: float, ki: float, kpos: float, limit: float) -> tuple[Array, Array]:
    """Speed and torque of the paper's joint, moving forward all the time, one RK45 step a sample."""
    jm, fv, fc, k1, k3, d, ja = (TRUTH[k] for k in TRUTH)
    phi, integral, x = 0.0, 0.0, np.array([0.0, 1e-9, 0.0, 0.0])
    out = np.empty((2, N))
    for n in range(N):
        phi, speed = x[3], x[1]
        error = (kpos * (reference.ref[n] - phi) if reference.kind == "position" else reference.ref[n]) - speed
        wanted = kp * error + ki * integral
        u = min(limit, max(-limit, wanted))
        out[:, n] = speed, u
        integral += SAMPLING_TIME * error if abs(wanted) < limit else 0.0

        def rate(_: float, y: Array, u: float = u) -> list[float]:
            slip = RATIO * y[1] - y[2]
            gear = k1 * y[0] + k3 * y[0] ** 3 + d * slip
            return [slip, (u - fv * y[1] - fc - RATIO * gear) / jm, gear / ja, y[1]]

        x = solve_ivp(rate, (0, SAMPLING_TIME), x, rtol=1e-9, atol=1e-12).y[:, -1]
    return out[0], out[1]


@pytest.mark.parametrize(
    ("reference", "controller"),
    [
        (SPEED, Controller("speed", kp=0.5, ki=5.0)),
        (SPEED, Controller("speed", kp=0.5, ki=5.0, limit=3.0)),
        (POSITION, Controller("position", kp=0.5, kpos=20.0)),
    ],
    ids=["speed", "saturated", "position"],
)
def test_agrees_with_stepping_sample_by_sample(reference: Reference, controller: Controller) -> None:
    x, torque = ControlledJoint(JOINT, THETA, controller).follow(reference, x0=np.zeros(JOINT.nx))
    speed, expected = by_hand(reference, controller.kp, controller.ki, controller.kpos, controller.limit)
    assert x[JOINT.motor_speed] == pytest.approx(speed, abs=2e-4)
    assert torque == pytest.approx(expected, abs=2e-4)
    assert np.abs(torque).max() <= controller.limit


def test_noise_is_drawn_by_seed_and_record_number() -> None:
    plant = VirtualRobot(JOINT, THETA, Controller("speed", 0.5, 5.0), 1e-4, 0.01, 0.02, seed=3)
    first, again, other = plant.record(SPEED, 0), plant.record(SPEED, 0), plant.record(SPEED, 1)
    assert np.array_equal(first.tau_m, again.tau_m)
    assert not np.array_equal(first.tau_m, other.tau_m)
    reseeded = replace(plant, seed=4).record(SPEED, 0)
    assert not np.array_equal(first.dphi_m, reseeded.dphi_m)


def test_the_controller_sees_the_noisy_speed() -> None:
    quiet = VirtualRobot(JOINT, THETA, Controller("speed", 0.5, 5.0))
    loud = replace(quiet, speed_noise=0.1)
    assert np.std(np.diff(loud.record(SPEED, 0).tau_m, 2)) > 3 * np.std(np.diff(quiet.record(SPEED, 0).tau_m, 2))


def test_the_encoder_shows_multiples_of_its_quantum() -> None:
    quantum = 1e-3
    angle = VirtualRobot(JOINT, THETA, Controller("position", kp=0.5, kpos=20.0), quantum).record(POSITION, 0).phi_m
    assert angle / quantum == pytest.approx(np.rint(angle / quantum), abs=1e-9)
    assert np.array_equal(quantise(angle, 0.0), angle)


def test_channels_on_the_torque_act_inside_the_loop() -> None:
    lagging = assemble(STRUCTURE.extended("torque.torque_lag"), angle=True)
    theta = lagging.parameters().with_values({**TRUTH, "torque.torque_lag.T": 0.002}).values
    slow, command = ControlledJoint(lagging, theta, Controller("speed", 0.5, 5.0)).follow(SPEED)
    fast, _ = ControlledJoint(JOINT, THETA, Controller("speed", 0.5, 5.0)).follow(SPEED)
    assert np.abs(slow[lagging.motor_speed] - fast[JOINT.motor_speed]).max() > 0.05
    record = VirtualRobot(lagging, theta, Controller("speed", 0.5, 5.0)).record(SPEED, 0)
    alone = simulate(lagging, theta, record, x0=np.zeros(lagging.nx))
    assert alone.dphi_m == pytest.approx(slow[lagging.motor_speed], abs=1e-4)
    assert record.tau_m == pytest.approx(command)
