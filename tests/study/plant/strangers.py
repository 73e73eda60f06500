"""What happens to real machines and is in no catalogue of a joint: events in time, and laws of another kind.

Each takes a rig, a size and a shape, and returns the rig with it; those of one record are built into that one only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np

from study.plant.friction import Shape
from study.plant.machine import Memory
from study.plant.rig import RATIO, Rig

EVENTFUL = "wide1"
"""The record in which an event happens."""
EDGE = 0.05  # s in which a push sets in and ends


@dataclass(frozen=True, slots=True)
class Stranger:
    """build : how it gets into a rig; size, shapes : as of `Effect`; event : it happens once, in one record."""

    build: Callable[[Rig, float, Shape], Rig]
    size: float
    shapes: dict[str, tuple[float, float]]
    event: bool = False

    def shape(self, rng: np.random.Generator) -> dict[str, float]:
        """A shape, evenly drawn in the logarithm."""
        return {key: float(np.exp(rng.uniform(*np.log(span)))) for key, span in self.shapes.items()}


def push(rig: Rig, size: float, shape: Shape) -> Rig:
    """Somebody leans on the arm for a while: `size` [Nm] at the motor."""
    begin, end = shape["begin"], shape["begin"] + shape["lasting"]

    def law(s: int, v: float, phi_m: float, phi_a: float, carried: float, t: float) -> float:
        rise = min(1.0, max(0.0, (t - begin) / EDGE), max(0.0, (end - t) / EDGE))
        return size * rise

    return replace(rig, extra=rig.extra.with_motor(law))


def friction_step(rig: Rig, size: float, shape: Shape) -> Rig:
    """Dry friction jumps by a share `size` at an instant: a seal that seats itself."""
    begin, Fc = shape["begin"], rig.base.Fc
    law = lambda s, v, phi_m, phi_a, carried, t: size * Fc * s if t > begin else 0.0  # noqa: E731
    return replace(rig, extra=rig.extra.with_motor(law))


def stiffness_by_angle(rig: Rig, size: float, shape: Shape) -> Rig:
    """The gear's stiffness follows the arm's angle, by a share `size`: an eccentric wheel."""
    k1, per_angle, phase = rig.base.k1, 2.0 * pi / shape["period"], shape["phase"]

    def rate(z: Sequence[float], dphi_m: float, slip: float, phi_a: float, dphi_a: float) -> list[float]:
        return [slip, dphi_a]

    def torque(z: Sequence[float], dz: Sequence[float]) -> float:
        return size * k1 * sin(per_angle * z[1] + phase) * z[0]

    return replace(rig, extra=rig.extra.with_memory(Memory("gear", rate, torque, 2)))


def quadratic_gear_damping(rig: Rig, size: float, _: Shape) -> Rig:
    """Damping in the gear that grows with the rate of twist, `size` [Nm s2/rad2]."""
    return replace(rig, extra=rig.extra.with_gear(lambda x, dx: size * dx * abs(dx)))


def shaken_base(rig: Rig, size: float, shape: Shape) -> Rig:
    """Another axis shakes the base: a torque on the arm, `size` [Nm] at the motor, a sine of time."""
    omega, phase, arm = 2.0 * pi * shape["frequency"], shape["phase"], size / RATIO

    def rate(z: Sequence[float], dphi_m: float, slip: float, phi_a: float, dphi_a: float) -> list[float]:
        return [1.0]

    memory = Memory("arm", rate, lambda z, dz: arm * cos(omega * z[0] + phase))
    return replace(rig, extra=rig.extra.with_memory(memory))


STRANGERS: dict[str, Stranger] = {
    "push": Stranger(push, 0.3, {"begin": (1.0, 3.0), "lasting": (0.5, 1.2)}, event=True),
    "friction_step": Stranger(friction_step, 0.25, {"begin": (1.5, 3.5)}, event=True),
    "stiffness_by_angle": Stranger(stiffness_by_angle, 0.25, {"period": (0.05, 0.2), "phase": (0.5, 5.0)}),
    "quadratic_gear_damping": Stranger(quadratic_gear_damping, 3e5, {}),
    "shaken_base": Stranger(shaken_base, 0.1, {"frequency": (1.5, 6.0), "phase": (0.5, 5.0)}),
}
