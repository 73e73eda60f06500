"""A trajectory at the measured angle: there the torques of the machine acted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory


def with_angle(trajectory: Trajectory) -> Trajectory:
    """The same trajectory of a joint that keeps its angle among its states."""
    joint = trajectory.joint
    if joint.keeps_angle:
        return trajectory
    return replace(
        trajectory,
        joint=joint.with_more(angle=True),
        x=np.insert(trajectory.x, joint.motor_speed, trajectory.phi_m, axis=0),
    )


def as_measured(trajectory: Trajectory, record: Record) -> Trajectory:
    """The same trajectory at the measured angle, while a simulated angle drifts with all that the model lacks."""
    kept = with_angle(trajectory)
    x = kept.x.copy()
    x[kept.joint.motor_angle] = record.phi_m
    return replace(kept, x=x, phi_m=record.phi_m)
