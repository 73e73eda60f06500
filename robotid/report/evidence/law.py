"""The law that an extension adds, as a torque along a recorded motion.

The extended model moves as it simulates. What the model before it lacks there is the torque that it needs for this very
motion, less the torque that was applied: the added effects, and what the other parameters gave way to them. No
measured motion enters, so there is no noise in it, and nothing makes it agree with what the residual asks for but that
the law is right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.misfit.location import since_reversal
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.model.array import Array, Index
from robotid.model.joint import Joint
from robotid.model.physical import TURN
from robotid.signals.differentiate import Kinematics
from robotid.signals.record import Record
from robotid.simulation.actuator import effective_torque
from robotid.simulation.first_guess import initial_state
from robotid.simulation.trajectory import Trajectory, gear_rate
from robotid.validation.inverse_dynamics import required_torque

CLOSE = 1e-9  # s: rounding of a time


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """What an extension adds at n samples of a record. t, torque : (n,) [s], [Nm] at the motor, signed as an applied
    torque; nan where the motor sticks, as no torque moves it there. variables : what a curve may run along, (n,)
    each."""

    t: Array
    torque: Array
    variables: dict[str, Array]


def law_of(before: FittedModel, after: Simulated, times: Array) -> Law:
    """The law that separates a model from its extension, simulated over a record, at times (n,) [s] of its samples.
    Raises NumericsError where the model before follows no such motion."""
    found, first = list[Law](), 0
    at = np.clip(np.searchsorted(after.t, times - CLOSE), 0, len(after.record) - 1)
    for piece, trajectory in zip(after.pieces, after.trajectories, strict=True):
        inside = (at >= first) & (at < first + len(piece))
        here = at[inside] - first
        found.append(Law(times[inside], _lacking(before, piece, trajectory)[here], variables_of(trajectory, here)))
        first += len(piece)
    return Law(
        np.concatenate([one.t for one in found]),
        np.concatenate([one.torque for one in found]),
        {name: np.concatenate([one.variables[name] for one in found]) for name in found[0].variables},
    )


def variables_of(trajectory: Trajectory, at: Index) -> dict[str, Array]:
    """What a missing torque may be ordered by, at samples (n,) of a simulated motion, (n,) each."""
    joint, phi_m, speed = trajectory.joint, trajectory.phi_m[at], trajectory.dphi_m
    found = {
        "dphi_m": speed[at],
        "phi_m": phi_m,
        "phi_m mod 2 pi": phi_m % TURN,
        "ddphi_m": trajectory.ddphi_m[at],
        "tau_m": trajectory.u[at],
        "t": trajectory.t[at],
        "reversal": since_reversal(speed, trajectory.sampling_time)[at],
    }
    if trajectory.twist is not None:
        found |= {"dtwist": gear_rate(joint, trajectory.x)[at]}
        found |= {"twist": trajectory.twist[at], "phi_a": joint.ratio * phi_m - trajectory.twist[at]}
    return found


def _lacking(model: FittedModel, piece: Record, trajectory: Trajectory) -> Array:
    """The torque that a model lacks for a motion, (n,)."""
    joint = model.joint.along(piece)
    theta = joint.in_record(model.theta, piece.name)
    speed = trajectory.x[trajectory.joint.motor_speed]
    motion = Kinematics(trajectory.phi_m, speed, trajectory.ddphi_m)
    needed = required_torque(joint, theta, piece, motion, _same_start(joint, theta, piece, trajectory))
    applied = effective_torque(joint, theta, piece.sampling_time, piece.tau_m)
    return np.where(speed == 0.0, np.nan, needed - applied)


def _same_start(joint: Joint, theta: Array, piece: Record, trajectory: Trajectory) -> Array:
    """The first state of the extended model, as far as the other one has the same states: (nx,). From one of its own it
    would ring, and the law with it."""
    start = initial_state(joint, theta, piece)
    begins = dict(zip(trajectory.joint.state_names, trajectory.x[:, 0].tolist(), strict=True))
    for row, name in enumerate(joint.state_names):
        start[row] = begins.get(name, start[row])
    return start
