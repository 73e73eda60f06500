"""Hidden effects in the gear and behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, sin

from study.plant.friction import Shape
from study.plant.machine import Memory
from study.plant.rig import Rig


def cubic_spring(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, k3=size))


def damper(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, d=size))


def soft_spring(rig: Rig, size: float, shape: Shape) -> Rig:
    """Within xs a share `size` of the stiffness is missing."""
    xs, lost = shape["xs"], -size * rig.base.k1
    return replace(rig, extra=rig.extra.with_gear(lambda x, dx: lost * (-xs if x < -xs else xs if x > xs else x)))


def backlash(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, extra=replace(rig.extra, gap=size))


def hysteresis(rig: Rig, size: float, shape: Shape) -> Rig:
    """Bouc-Wen: z within [-1, 1] follows the twist over xs and then slips."""
    per_twist = 1.0 / shape["xs"]

    def rate(z: Sequence[float], dphi_m: float, slip: float, phi_a: float, dphi_a: float) -> list[float]:
        return [(slip - abs(slip) * abs(z[0]) * z[0]) * per_twist]

    return replace(rig, extra=rig.extra.with_memory(Memory("gear", rate, lambda z, dz: size * z[0])))


def transmission_error(rig: Rig, size: float, shape: Shape) -> Rig:
    """The teeth are ahead by A sin(n phi_m) + B cos(n phi_m): the lever of the motor varies with it (virtual work)."""
    n, A, B = shape["n"], size * cos(shape["phase"]), size * sin(shape["phase"])

    def mesh(phi_m: float) -> tuple[float, float]:
        sine, cosine = sin(n * phi_m), cos(n * phi_m)
        return A * sine + B * cosine, n * (A * cosine - B * sine)

    return replace(rig, extra=replace(rig.extra, mesh=mesh))


def third_mass(rig: Rig, size: float, shape: Shape) -> Rig:
    """A tool of inertia `size` behind a link; z : its angle and speed."""
    w, damping = shape["wb"], 2.0 * shape["zeta"] * shape["wb"]

    def rate(z: Sequence[float], dphi_m: float, slip: float, phi_a: float, dphi_a: float) -> list[float]:
        return [z[1], w * w * (phi_a - z[0]) + damping * (dphi_a - z[1])]

    return replace(rig, extra=rig.extra.with_memory(Memory("arm", rate, lambda z, dz: size * dz[1], 2)))
