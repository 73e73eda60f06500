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
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.differentiate import Kinematics
from robotid.signals.record import Record
from robotid.simulation.actuator import effective_torque
from robotid.simulation.first_guess import initial_state
from robotid.simulation.trajectory import Trajectory
from robotid.validation.inverse_dynamics import required_torque


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """What an extension adds along a record. t, torque : (n,) [s], [Nm] at the motor, signed as an applied torque; nan
    where the motor sticks, as no torque moves it there. variables : what a curve may run along, (n,) each."""

    t: Array
    torque: Array
    variables: dict[str, Array]


def law_of(before: FittedModel, after: Simulated) -> Law:
    """The law that separates a model from its extension, simulated over a record. Raises NumericsError where the model
    before follows no such motion."""
    pairs = list(zip(after.pieces, after.trajectories, strict=True))
    torques = [_lacking(before, piece, trajectory) for piece, trajectory in pairs]
    moved = [variables_of(trajectory) for _, trajectory in pairs]
    return Law(
        after.t,
        np.concatenate(torques),
        {name: np.concatenate([one[name] for one in moved]) for name in moved[0]},
    )


def variables_of(trajectory: Trajectory) -> dict[str, Array]:
    """What a missing torque may be ordered by, along a simulated motion, (n,) each."""
    joint, speed = trajectory.joint, trajectory.dphi_m
    found = {
        "dphi_m": speed,
        "phi_m": trajectory.phi_m,
        "phi_m mod 2 pi": trajectory.phi_m % (2 * np.pi),
        "ddphi_m": trajectory.ddphi_m,
        "tau_m": trajectory.u,
        "t": trajectory.t,
        "reversal": since_reversal(speed, trajectory.sampling_time),
    }
    if trajectory.twist is not None:
        found |= {"twist": trajectory.twist, "phi_a": joint.ratio * trajectory.phi_m - trajectory.twist}
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
