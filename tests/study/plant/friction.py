"""Hidden effects on the motor and on the arm: dry friction, drag, torques of angle and of time.

Each takes a rig, the size of the effect and its shape, and returns the rig with the effect.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import cos, exp, sin

from study.plant.machine import Memory, MotorLaw
from study.plant.rig import RATIO, Rig

Shape = Mapping[str, float]


def more_viscous(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, Fv=size))


def more_coulomb(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, Fc=size))


def arm_viscous(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, extra=rig.extra.with_arm(lambda s, v, phi_a: size * v))


def arm_coulomb(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, extra=rig.extra.with_arm(lambda s, v, phi_a: size * s))


def stribeck(rig: Rig, size: float, shape: Shape) -> Rig:
    vs = shape["vs"]
    return _motor(rig, lambda s, v, *_: size * exp(-((v / vs) ** 2)) * s)


def asymmetric_coulomb(rig: Rig, size: float, _: Shape) -> Rig:
    return _motor(rig, lambda s, *_: size)


def asymmetric_viscous(rig: Rig, size: float, _: Shape) -> Rig:
    return _motor(rig, lambda s, v, *_: size * abs(v))


def quadratic_friction(rig: Rig, size: float, _: Shape) -> Rig:
    return _motor(rig, lambda s, v, *_: size * v * abs(v))


def power_friction(rig: Rig, size: float, shape: Shape) -> Rig:
    alpha = shape["alpha"]
    return _motor(rig, lambda s, v, *_: size * abs(v) ** alpha * s)


def load_friction(rig: Rig, size: float, _: Shape) -> Rig:
    return _motor(rig, lambda s, v, phi_m, phi_a, carried, t: size * RATIO * abs(carried) * s)


def position_friction(rig: Rig, size: float, shape: Shape) -> Rig:
    n, A, B = shape["n"], size * cos(shape["phase"]), size * sin(shape["phase"])
    return _motor(rig, lambda s, v, phi_m, *_: (A * sin(n * phi_m) + B * cos(n * phi_m)) * s)


def thermal_friction(rig: Rig, size: float, shape: Shape) -> Rig:
    T, Fc, Fv = shape["T"], rig.base.Fc, rig.base.Fv
    return _motor(rig, lambda s, v, phi_m, phi_a, carried, t: size * exp(-t / T) * (Fc * s + Fv * v))


def presliding(rig: Rig, size: float, shape: Shape) -> Rig:
    """Bristles that bend by `size` [rad] before they slip, in place of the jump of Coulomb friction (LuGre). s1 [s] :
    damping of the bristles over their stiffness."""
    Fc, s1 = rig.base.Fc, shape["s1"]
    stiffness = Fc / size

    def rate(z: Sequence[float], dphi_m: float, slip: float, phi_a: float, dphi_a: float) -> list[float]:
        return [dphi_m - stiffness * abs(dphi_m) * z[0] / Fc]

    bristles = Memory("motor", rate, lambda z, dz: stiffness * (z[0] + s1 * dz[0]))
    return replace(rig, base=replace(rig.base, Fc=0.0), extra=rig.extra.with_memory(bristles))


def constant_torque(rig: Rig, size: float, _: Shape) -> Rig:
    return _motor(rig, lambda s, *_: size)


def cogging(rig: Rig, size: float, shape: Shape) -> Rig:
    n, A, B = shape["n"], size * cos(shape["phase"]), size * sin(shape["phase"])
    return _motor(rig, lambda s, v, phi_m, *_: A * sin(n * phi_m) + B * cos(n * phi_m))


def gravity(rig: Rig, size: float, shape: Shape) -> Rig:
    G, H = size * cos(shape["phase"]), size * sin(shape["phase"])
    return replace(rig, extra=rig.extra.with_arm(lambda s, v, phi_a: G * sin(phi_a) + H * cos(phi_a)))


def _motor(rig: Rig, law: MotorLaw) -> Rig:
    return replace(rig, extra=rig.extra.with_motor(law))
