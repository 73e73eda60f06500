"""One experiment: the machine under its own sampled controller, and what a recorder would have kept of it."""

from __future__ import annotations

from collections.abc import Sequence
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
    """Signals (n,) as recorded at times t (n,) [s], and the states (n,) that no recorder sees."""

    sampling_time: float
    t: Array
    torque: Array
    angle: Array
    speed: Array
    states: tuple[State, ...]


def experiment(
    rig: Rig,
    loop: Loop,
    ref: Array,
    sampling_time: float,
    seed: int,
    substeps: int = SUBSTEPS,
    offsets: Sequence[int] = (),
) -> Recording:
    """Follow a reference speed (n,) [rad/s] from rest. offsets (n,) : substeps after the controller's instants at which
    the recorder takes its samples; none, and it takes them at those instants."""
    machine, sensor = rig.machine(), rig.sensor
    rng = np.random.default_rng(seed)
    n, dt = len(ref), sampling_time / substeps
    speed_noise = (loop.speed_noise * rng.standard_normal(n)).tolist()
    step, acting, line = stepper(machine), rig.drive.started(dt, substeps), sensor.line(dt)
    y, integral = at_rest(machine), 0.0
    states, torque, angle, speed = [], [], [], []
    line.append(0.0)
    late = list(offsets) or [0] * n
    for wanted, noise, taken in zip(ref.tolist(), speed_noise, late, strict=True):
        error = wanted - (line[0] + noise)
        torque.append(loop.kp * error + loop.ki * integral)
        integral += sampling_time * error
        for k, u in enumerate(acting(torque[-1])):
            if k == taken:
                states.append(y)
                angle.append(sensor.angle(y.phi_m))
                speed.append(line[0] + noise)
            y = step(y, u, dt)
            line.append(sensor.speed(y.phi_m, y.dphi_m))
    noisy = np.array(torque) + loop.torque_noise * rng.standard_normal(n)
    t = np.arange(n) * sampling_time + np.array(late) * dt
    return Recording(sampling_time, t, noisy, np.array(angle), np.array(speed), tuple(states))
