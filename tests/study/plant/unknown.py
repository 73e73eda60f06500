"""Effects that are in no catalogue: torques on the motor, each a law of its own. size [Nm] is the largest, or so."""

from __future__ import annotations

from math import exp, pi, sin

from study.plant.friction import Shape
from study.plant.machine import MotorLaw


def speed_bump(size: float, shape: Shape) -> MotorLaw:
    """Friction higher around one speed: a resonating seal."""
    v0, width = shape["v0"], shape["width"]
    return lambda s, v, *_: size * exp(-(((abs(v) - v0) / width) ** 2)) * s


def speed_times_position(size: float, shape: Shape) -> MotorLaw:
    """Viscous friction that grows along the axis: a screw that is bent or dry at one end."""
    return lambda s, v, phi_m, *_: size * v * phi_m / (shape["v0"] * shape["p0"])


def tight_spot(size: float, shape: Shape) -> MotorLaw:
    """Dry friction higher at one angle of the arm: a damaged bearing."""
    p0, width = shape["p0"], shape["width"]
    return lambda s, v, phi_m, phi_a, *_: size * exp(-(((phi_a - p0) / width) ** 2)) * s


def breathing(size: float, shape: Shape) -> MotorLaw:
    """Dry friction that comes and goes with time: a pump that presses on a seal."""
    pace = pi / shape["period"]
    return lambda s, v, phi_m, phi_a, carried, t: size * sin(pace * t) ** 2 * s


def grease_beyond(size: float, shape: Shape) -> MotorLaw:
    """Viscous drag only beyond one angle of the arm, growing from there: a bellows that rubs."""
    p0 = shape["p0"]
    return lambda s, v, phi_m, phi_a, *_: size * max(0.0, phi_a - p0) * v / (0.1 * shape["v0"])
