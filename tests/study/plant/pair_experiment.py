"""One experiment on two axes at once, each under its own sampled controller, as a recorder would have kept it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from study.plant.drive import Sensor
from study.plant.experiment import Loop
from study.plant.machine import Machine
from study.plant.two_axes import Links, posed, stepper

Array = NDArray[np.float64]

SUBSTEPS = 10
"""Steps of the integrator in a sampling interval."""


@dataclass(frozen=True, slots=True)
class Axis:
    """machine : its arm inertia is that of the flange alone; loop : its controller and the noise of its recording."""

    machine: Machine
    loop: Loop
    sensor: Sensor = field(default_factory=Sensor)


@dataclass(frozen=True, slots=True)
class AxisRecording:
    """Signals (n,) as recorded: torque [Nm], angle [rad] and speed [rad/s] of the motor; arm (n,) [rad] and its speed
    [rad/s], which no recorder sees."""

    torque: Array
    angle: Array
    speed: Array
    arm: Array
    arm_speed: Array


def experiment(
    axes: tuple[Axis, Axis],
    links: Links,
    refs: tuple[Array, Array],
    sampling_time: float,
    seed: int,
    pose: tuple[float, float] = (0.0, 0.0),
    substeps: int = SUBSTEPS,
) -> tuple[AxisRecording, AxisRecording]:
    """Follow two reference speeds (n,) [rad/s] of the motors, from rest with the arms at pose [rad]."""
    rng = np.random.default_rng(seed)
    n, dt = len(refs[0]), sampling_time / substeps
    noises = [(axis.loop.speed_noise * rng.standard_normal(n)).tolist() for axis in axes]
    machines = (axes[0].machine, axes[1].machine)
    step, y = stepper(machines, links), posed(machines, *pose)
    integrals = [0.0, 0.0]
    kept: tuple[list[tuple[float, ...]], ...] = ([], [])
    for k in range(n):
        torques = []
        for i, (axis, side) in enumerate(zip(axes, y[:2], strict=True)):
            speed = side.dphi_m + noises[i][k]
            error = refs[i][k] - speed
            torque = axis.loop.kp * error + axis.loop.ki * integrals[i]
            integrals[i] += sampling_time * error
            torques.append(torque)
            kept[i].append((torque, axis.sensor.angle(side.phi_m), speed, side.phi_a, side.dphi_a))
        for _ in range(substeps):
            y = step(y, torques[0], torques[1], dt)
    made = [AxisRecording(*np.array(one).T) for one in kept]
    noisy = [
        replace(one, torque=one.torque + axis.loop.torque_noise * rng.standard_normal(n))
        for one, axis in zip(made, axes, strict=True)
    ]
    return noisy[0], noisy[1]
