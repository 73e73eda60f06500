"""Hidden effects between torque and record, between motion and record, and between records."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

from study.plant.friction import Shape
from study.plant.rig import Rig


def torque_delay(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, drive=replace(rig.drive, delay=size))


def torque_lag(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, drive=replace(rig.drive, lag=size))


def torque_gain(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, drive=replace(rig.drive, gain=size))


def torque_saturation(rig: Rig, size: float, _: Shape) -> Rig:
    """size : inverse of the torque that is never exceeded [1/Nm]."""
    return replace(rig, drive=replace(rig.drive, most=1.0 / size))


def encoder_ripple(rig: Rig, size: float, shape: Shape) -> Rig:
    A, B = size * cos(shape["phase"]), size * sin(shape["phase"])
    return replace(rig, sensor=replace(rig.sensor, sine=A, cosine=B, periods=shape["n"]))


def sensor_delay(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, sensor=replace(rig.sensor, delay=size))


def payload(rig: Rig, size: float, _: Shape) -> Rig:
    """An arm heavier by `size` [kg m2]."""
    return replace(rig, base=replace(rig.base, arm_inertia=rig.base.arm_inertia + size))


def warm_coulomb(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, Fc=rig.base.Fc - size))


def warm_viscous(rig: Rig, size: float, _: Shape) -> Rig:
    return replace(rig, base=replace(rig.base, Fv=rig.base.Fv - size))
