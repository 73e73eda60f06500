"""The base machine, whose structure the tool is told, and the rig that hidden effects are built into."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from study.plant.drive import Drive, Sensor
from study.plant.machine import Machine

RATIO = 1.0 / 224.3


@dataclass(frozen=True, slots=True)
class Base:
    """Parameters of the paper's model (Wernholt & Gunnarsson 2005, Table 1, m3), SI; k3 zero for a straight spring."""

    motor_inertia: float = 0.0121
    Fv: float = 0.0130
    Fc: float = 0.644
    k1: float = 1.46e6
    d: float = 2.63e3
    arm_inertia: float = 1130.0
    k3: float = 0.0

    def drawn(self, rng: np.random.Generator, spread: float = 0.3) -> Base:
        """Every parameter within its spread."""
        return Base(*(value * rng.uniform(1.0 - spread, 1.0 + spread) for value in self.values()))

    def values(self) -> tuple[float, ...]:
        """In the order of the fields."""
        return (self.motor_inertia, self.Fv, self.Fc, self.k1, self.d, self.arm_inertia, self.k3)

    def named(self) -> dict[str, float]:
        """By the names of the tool's parameters."""
        names = ("motor.inertia.J", "motor.viscous.Fv", "motor.coulomb.Fc", "gear.spring.k1", "gear.damper.d")
        cubic = {"gear.cubic_spring.k3": self.k3} if self.k3 else {}
        return dict(zip((*names, "arm.inertia.J"), self.values(), strict=False)) | cubic


@dataclass(frozen=True, slots=True)
class Rig:
    """A base machine, what is added to it, and its drive and sensor."""

    base: Base
    extra: Machine = field(default_factory=lambda: Machine(RATIO, 0.0, 0.0))
    drive: Drive = field(default_factory=Drive)
    sensor: Sensor = field(default_factory=Sensor)

    def machine(self) -> Machine:
        """Base and additions as one."""
        b, extra = self.base, self.extra
        Fc, Fv, k1, k3, d = b.Fc, b.Fv, b.k1, b.k3, b.d

        def friction(s: int, v: float, phi_m: float, phi_a: float, carried: float, t: float) -> float:
            return Fc * s + Fv * v

        def teeth(twist: float, rate: float) -> float:
            return twist * (k1 + k3 * twist * twist) + d * rate

        return replace(
            extra,
            motor_inertia=b.motor_inertia,
            arm_inertia=b.arm_inertia,
            motor=(friction, *extra.motor),
            gear=(teeth, *extra.gear),
        )
