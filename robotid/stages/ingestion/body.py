"""The description of the robot's body, as the configuration gives it."""

from __future__ import annotations

from math import radians

import numpy as np

from robotid.body.chain import Chain, DhRow, chain_of_rows
from robotid.body.equations import Structure
from robotid.body.identification import Knowledge
from robotid.body.urdf import chain_of_urdf, fixed_masses
from robotid.config.body import BodySettings
from robotid.config.robot import RobotSettings
from robotid.estimate.body import AxisSignals, BodySetup


def body_setup(robot: RobotSettings) -> BodySetup:
    """What is to be identified of a body, and from which signals. Raises ConfigError for a URDF that is no chain."""
    body = robot.body
    assert body is not None
    axes = {
        name: AxisSignals(own.gear_ratio, own.angle or "", own.torque or "")
        if name != body.axis
        else AxisSignals(1.0 if robot.gear_ratio is None else robot.gear_ratio)
        for name, own in body.axes.items()
    }
    rotors = {name: J / axes[name].gear_ratio ** 2 for name, J in body.rotors.items()}
    known = Knowledge(rotors, body.mass_factor, body.given_factor)
    return BodySetup(Structure(chain_of(body), body.friction), axes, body.axis, known, body.cutoff)


def chain_of(body: BodySettings) -> Chain:
    """The chain of a body, its joints called as the axes are. Raises ConfigError for a URDF that is no chain."""
    gravity, names = np.array(body.gravity), tuple(body.axes)
    if body.dh is not None:
        angle = radians if body.unit == "deg" else float
        rows = [DhRow(r.d, r.a, angle(r.alpha), angle(r.theta), r.sign) for r in body.dh]
        return chain_of_rows(names, rows, body.convention == "distal", gravity)
    assert body.urdf is not None
    chain = chain_of_urdf(body.urdf, [body.joints.get(name, name) for name in names], gravity, "robot.body.urdf")
    chain = chain.named(names)
    return fixed_masses(chain) if body.masses == "fixed" else chain
