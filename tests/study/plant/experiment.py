"""One experiment: the machine under its own sampled controller, and what a recorder would have kept of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from study.plant.motion import State, at_rest, stepper
from study.plant.rig import Rig

Array = NDArray[np.float64]

SUBSTEPS = 20
"""Steps of the integrator in a sampling interval."""


@dataclass(frozen=True, slots=True)
class Loop:
    """PI speed controller, u = kp e + ki I [Nm], and the noise of the recording: torque [Nm], speed [rad/s], white.

    The controller sees the noisy speed; the torque's noise is on the record only.
    """

    kp: float = 0.5
    ki: float = 5.0
    torque_noise: float = 0.005
    speed_noise: float = 0.02


@dataclass(frozen=True, slots=True)
class Recording:
    """Signals (n,) as recorded, and the states (n,) that no recorder sees."""

    sampling_time: float
    torque: Array
    angle: Array
    speed: Array
    states: tuple[State, ...]


def experiment(
    rig: Rig, loop: Loop, ref: Array, sampling_time: float, seed: int, substeps: int = SUBSTEPS
) -> Recording:
    """Follow a reference speed (n,) [rad/s] from rest."""
    machine, sensor = rig.machine(), rig.sensor
    rng = np.random.default_rng(seed)
    n, dt = len(ref), sampling_time / substeps
    speed_noise = (loop.speed_noise * rng.standard_normal(n)).tolist()
    step, acting, line = stepper(machine), rig.drive.started(dt, substeps), sensor.line(dt)
    y, integral = at_rest(machine), 0.0
    states, torque, angle, speed = [], [], [], []
    line.append(0.0)
    for wanted, noise in zip(ref.tolist(), speed_noise, strict=True):
        states.append(y)
        angle.append(sensor.angle(y.phi_m))
        speed.append(line[0] + noise)
        error = wanted - speed[-1]
        torque.append(loop.kp * error + loop.ki * integral)
        integral += sampling_time * error
        for u in acting(torque[-1]):
            y = step(y, u, dt)
            line.append(sensor.speed(y.phi_m, y.dphi_m))
    noisy = np.array(torque) + loop.torque_noise * rng.standard_normal(n)
    return Recording(sampling_time, noisy, np.array(angle), np.array(speed), tuple(states))
