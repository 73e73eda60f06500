"""Ports as selections of the coordinates: which angles and speeds move them, for one, two or three masses."""

from __future__ import annotations

from robotid.model.port import Port

Selection = tuple[tuple[int, float], ...]
"""A sum over rows: (index, factor) pairs."""


def rotates(masses: int) -> set[Port]:
    """Ports whose position is an absolute angle."""
    return {Port.MOTOR, Port.ARM, Port.TOOL} | ({Port.LINK} if masses < 3 else set())


def rigid_speed(port: Port, masses: int, r: float) -> float:
    """Speed of a port in motor speeds while all masses move together, zero at the gear."""
    return sum(c * (1.0 if j == 0 else r) for j, c in coordinates(port, masses, r))


def coordinates(port: Port, masses: int, r: float) -> Selection:
    """S: the port's speed as a sum over dq. A rigid gear makes the arm follow the motor."""
    if masses == 1:
        return ((0, 1.0 if port is Port.MOTOR else r),)
    return {
        Port.MOTOR: ((0, 1.0),),
        Port.GEAR: ((0, r), (1, -1.0)),
        Port.ARM: ((1, 1.0),),
        Port.LINK: ((1, 1.0), (2, -1.0)) if masses == 3 else ((1, 1.0),),
        Port.TOOL: ((2, 1.0),),
    }[port]


def position(port: Port, masses: int, r: float) -> Selection:
    """The port's position as a sum over the position states (twist, link twist, phi_m)."""
    if masses == 1:
        return ((0, 1.0 if port is Port.MOTOR else r),)
    angle = masses - 1
    arm = ((0, -1.0), (angle, r))
    return {
        Port.MOTOR: ((angle, 1.0),),
        Port.GEAR: ((0, 1.0),),
        Port.ARM: arm,
        Port.LINK: ((1, 1.0),) if masses == 3 else arm,
        Port.TOOL: ((0, -1.0), (1, -1.0), (angle, r)),
    }[port]
