"""Two flexible axes in a plane, the same numbers for the package and for the plant of the tests."""

from __future__ import annotations

import numpy as np
from study.plant.drive import Sensor
from study.plant.experiment import Loop
from study.plant.machine import GearLaw, Machine, MotorLaw
from study.plant.pair_experiment import Axis
from study.plant.two_axes import Links

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.coupled.planar_chain import Link, PlanarChain

EFFECTS = ("motor.inertia", "motor.viscous", "motor.coulomb", "gear.spring", "gear.damper", "arm.inertia")
RATIOS = (1 / 100, 1 / 80)
TRUTH = ((1e-3, 2e-3, 0.2, 3e4, 30.0, 1.0), (6e-4, 1e-3, 0.15, 1.2e4, 10.0, 0.3))
GAINS = ((0.05, 0.5), (0.03, 0.3))
H = 1e-3


def chain(gravity: float = 0.0) -> PlanarChain:
    """The body of the package."""
    return PlanarChain([Link(20.0, 0.5, 0.25, 0.5), Link(10.0, 0.4, 0.2, 0.2)], gravity)


def links(gravity: float = 0.0) -> Links:
    """The same of the tests' plant."""
    return Links(20.0, 0.5, 0.25, 0.5, 10.0, 0.2, 0.2, gravity)


def axes(speed_noise: float = 0.0, seed: int = 0) -> tuple[VirtualRobot, VirtualRobot]:
    """The axes of the package."""
    made = []
    for ratio, values, (kp, ki) in zip(RATIOS, TRUTH, GAINS, strict=True):
        joint = assemble(Structure(EFFECTS, gear_ratio=ratio), angle=True)
        controller = Controller("speed", kp, ki)
        made.append(VirtualRobot(joint, np.array(values), controller, speed_noise=speed_noise, seed=seed))
    return made[0], made[1]


class PerfectSensor(Sensor):
    """An encoder without steps."""

    def angle(self, phi_m: float) -> float:
        return phi_m


def plant_axes() -> tuple[Axis, Axis]:
    """The axes of the tests' plant."""
    made = []
    for ratio, values, (kp, ki) in zip(RATIOS, TRUTH, GAINS, strict=True):
        J, Fv, Fc, k, d, flange = values
        machine = Machine(ratio, J, flange, motor=(_rubbing(Fc, Fv),), gear=(_teeth(k, d),))
        made.append(Axis(machine, Loop(kp, ki, 0.0, 0.0), PerfectSensor()))
    return made[0], made[1]


def _rubbing(Fc: float, Fv: float) -> MotorLaw:
    return lambda s, v, *_: Fc * s + Fv * v


def _teeth(k: float, d: float) -> GearLaw:
    return lambda x, dx: k * x + d * dx


def wave(seed: int, amplitude: float, samples: int) -> Array:
    """A reference speed (samples,) [rad/s]: sines of random phase on a square wave."""
    t, rng = np.arange(samples) * H, np.random.default_rng(seed)
    sines = sum(np.cos(2 * np.pi * f * t + rng.uniform(0.0, 2 * np.pi)) for f in np.arange(1.0, 40.0, 0.8))
    return np.asarray(amplitude * (0.6 * sines / np.abs(sines).max() + np.sign(np.sin(2 * np.pi * 1.2 * t + 0.1))))


def references(samples: int) -> tuple[Reference, Reference]:
    """One for each axis."""
    one, two = (wave(seed, amplitude, samples) for seed, amplitude in ((1, 20.0), (2, 25.0)))
    return Reference("one", H, one, "speed"), Reference("two", H, two, "speed")
