"""The joint of the tests: two masses, a gear between them, and laws of torque that can be added to it.

Every law is a plain function of numbers, in SI and radians. Motor laws are torques absorbed on the motor's side of the
gear, arm laws those on the arm's. Direction s is +1 or -1: a law that depends on it is dry, and at rest anything
between its values for either direction can be absorbed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

MotorLaw = Callable[[int, float, float, float, float, float], float]
"""(s, dphi_m, phi_m, phi_a, gear_torque, t) -> absorbed torque [Nm]."""
ArmLaw = Callable[[int, float, float], float]
"""(s, dphi_a, phi_a) -> absorbed torque [Nm]."""
GearLaw = Callable[[float, float], float]
"""(twist, its rate) -> torque [Nm] that the gear carries, at the arm."""
Mesh = Callable[[float], tuple[float, float]]
"""phi_m -> offset of the twist [rad], and its slope."""


@dataclass(frozen=True, slots=True)
class Memory:
    """A law with states z of its own, zero at rest.

    rate : (z, dphi_m, rate of the twist, phi_a, dphi_a) -> dz/dt; torque : (z, dz/dt) -> absorbed torque at `port`,
    which is motor, gear or arm.
    """

    port: str
    rate: Callable[[Sequence[float], float, float, float, float], list[float]]
    torque: Callable[[Sequence[float], Sequence[float]], float]
    states: int = 1


@dataclass(frozen=True, slots=True)
class Machine:
    """ratio : phi_a / phi_m of the rigid gear; inertias [kg m2]; gap [rad] : half the play between the teeth."""

    ratio: float
    motor_inertia: float
    arm_inertia: float
    motor: tuple[MotorLaw, ...] = ()
    gear: tuple[GearLaw, ...] = ()
    arm: tuple[ArmLaw, ...] = ()
    memory: tuple[Memory, ...] = ()
    gap: float = 0.0
    mesh: Mesh | None = None

    def with_motor(self, law: MotorLaw) -> Machine:
        """The same with one more torque on the motor."""
        return replace(self, motor=(*self.motor, law))

    def with_gear(self, law: GearLaw) -> Machine:
        """The same with one more torque in the gear."""
        return replace(self, gear=(*self.gear, law))

    def with_arm(self, law: ArmLaw) -> Machine:
        """The same with one more torque on the arm."""
        return replace(self, arm=(*self.arm, law))

    def with_memory(self, memory: Memory) -> Machine:
        """The same with one more law that remembers."""
        return replace(self, memory=(*self.memory, memory))
