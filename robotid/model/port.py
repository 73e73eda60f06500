"""Where an effect touches the joint: a port is a selection of the coordinates (phi_m, phi_a, phi_b)."""

from __future__ import annotations

from enum import StrEnum


class Port(StrEnum):
    """A place on the joint, by the coordinate it moves with."""

    MOTOR = "motor"  # phi_m
    GEAR = "gear"  # the twist, r phi_m - phi_a
    ARM = "arm"  # phi_a
    LINK = "link"  # phi_a - phi_b; phi_b rests at zero until a tool carries inertia
    TOOL = "tool"  # phi_b


GROUNDED = (Port.MOTOR, Port.ARM, Port.TOOL)
"""Ports whose motion is that of one coordinate: what acts there acts against ground."""


class Signal(StrEnum):
    """What a channel acts on."""

    TORQUE = "torque"
    ANGLE = "angle"
    SPEED = "speed"
