"""What can be hidden: the effects by the names that the tool gives them, with their usual size and range of shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, pi, sin

import numpy as np

from study.plant import friction, gear, signals, unknown
from study.plant.friction import Shape
from study.plant.machine import MotorLaw
from study.plant.rig import Rig

CHANGED = "wide2"
"""The record that differs from the others."""


@dataclass(frozen=True, slots=True)
class Effect:
    """build : how it gets into a rig; size : of it, SI, that costs about five noise standard deviations.

    shapes : ranges that shape parameters are drawn from, evenly in the logarithm; whole : those that are counts.
    symbols : parameters of the tool that have the size as value ("A", "B": its parts by phase). signed : either sign.
    largest : physical limit of the size. others : parameters of the tool that follow from the size.
    """

    build: Callable[[Rig, float, Shape], Rig]
    size: float
    symbols: tuple[str, ...]
    shapes: dict[str, tuple[float, float]] = field(default_factory=dict)
    whole: tuple[str, ...] = ()
    signed: bool = False
    largest: float = np.inf
    others: Callable[[float], dict[str, float]] = lambda size: {}

    def shape(self, rng: np.random.Generator) -> dict[str, float]:
        """A shape, and a phase and sign for those that have them."""
        drawn = _evenly(self.shapes, rng)
        drawn |= {key: float(round(drawn[key])) for key in self.whole}
        sign = float(rng.choice((-1.0, 1.0))) if self.signed else 1.0
        return drawn | {"phase": float(rng.uniform(0.0, 2.0 * pi)), "sign": sign}

    def truth(self, size: float, shape: Shape) -> dict[str, float]:
        """Values of the tool's parameters by symbol."""
        parts = {"A": cos(shape["phase"]), "B": sin(shape["phase"]), "G": cos(shape["phase"]), "H": sin(shape["phase"])}
        values = {symbol: size * parts.get(symbol, 1.0) for symbol in self.symbols}
        return values | self.others(size) | {key: shape[key] for key in self.shapes}


def _evenly(ranges: dict[str, tuple[float, float]], rng: np.random.Generator) -> dict[str, float]:
    return {key: float(np.exp(rng.uniform(*np.log(span)))) for key, span in ranges.items()}


EFFECTS: dict[str, Effect] = {
    "motor.viscous": Effect(friction.more_viscous, 0.0015, ("Fv",)),
    "motor.coulomb": Effect(friction.more_coulomb, 0.013, ("Fc",)),
    "arm.viscous": Effect(friction.arm_viscous, 1500.0, ("Fv",)),
    "arm.coulomb": Effect(friction.arm_coulomb, 35.0, ("Fc",)),
    "motor.stribeck": Effect(friction.stribeck, 0.2, ("dFs",), {"vs": (0.5, 5.0)}),
    "motor.asymmetric_coulomb": Effect(friction.asymmetric_coulomb, 0.005, ("dFc",), signed=True),
    "motor.asymmetric_viscous": Effect(friction.asymmetric_viscous, 3.5e-4, ("dFv",), signed=True),
    "motor.quadratic_friction": Effect(friction.quadratic_friction, 2e-4, ("Fq",)),
    "motor.power_friction": Effect(friction.power_friction, 0.08, ("Fp",), {"alpha": (0.3, 0.7)}),
    "motor.load_friction": Effect(friction.load_friction, 0.017, ("mu",)),
    "motor.position_friction": Effect(friction.position_friction, 0.06, ("A", "B"), {"n": (0.6, 6.0)}),
    "motor.thermal_friction": Effect(friction.thermal_friction, 0.05, ("c",), {"T": (12.0, 40.0)}),
    "motor.presliding": Effect(
        friction.presliding,
        0.03,
        (),
        {"s1": (1e-3, 1e-2)},
        largest=0.3,
        others=lambda bend: {"w": 1.0, "s0": 1.0 / bend},
    ),
    "motor.constant_torque": Effect(friction.constant_torque, 0.004, ("tau0",), signed=True),
    "motor.cogging": Effect(friction.cogging, 0.035, ("A", "B"), {"n": (1.0, 24.0)}, ("n",)),
    "arm.gravity": Effect(friction.gravity, 1.0, ("G", "H")),
    "gear.cubic_spring": Effect(gear.cubic_spring, 1.5e11, ("k3",)),
    "gear.damper": Effect(gear.damper, 800.0, ("d",)),
    "gear.soft_spring": Effect(gear.soft_spring, 0.15, ("s",), {"xs": (5e-5, 4e-4)}, largest=0.95),
    "gear.backlash": Effect(gear.backlash, 1e-5, ("gap",)),
    "gear.hysteresis": Effect(gear.hysteresis, 80.0, ("kh",), {"xs": (3e-5, 3e-4)}),
    "gear.transmission_error": Effect(gear.transmission_error, 7e-6, ("A", "B"), {"n": (1.0, 6.0)}, ("n",)),
    "link.third_mass": Effect(gear.third_mass, 200.0, ("Jb",), {"wb": (35.0, 150.0), "zeta": (0.01, 0.06)}),
    "torque.torque_delay": Effect(signals.torque_delay, 1.3e-3, ("Td",)),
    "torque.torque_lag": Effect(signals.torque_lag, 1e-3, ("T",)),
    "torque.torque_gain": Effect(signals.torque_gain, 0.1, ("g",), signed=True),
    "torque.torque_saturation": Effect(signals.torque_saturation, 0.03, (), others=lambda inverse: {"c": inverse**2}),
    "angle.encoder_ripple": Effect(signals.encoder_ripple, 0.005, ("A", "B"), {"n": (1.0, 4.0)}, ("n",)),
    "speed.sensor_delay": Effect(signals.sensor_delay, 1.5e-3, ("Td",)),
    f"record_change.{CHANGED}.arm.inertia.J": Effect(signals.payload, 85.0, ("change",)),
    f"record_change.{CHANGED}.motor.coulomb.Fc": Effect(signals.warm_coulomb, 0.05, ("change",)),
    f"record_change.{CHANGED}.motor.viscous.Fv": Effect(signals.warm_viscous, 0.0025, ("change",)),
}
"""All of the tool's catalogue but inertia and spring, without which there is no joint to begin with."""


@dataclass(frozen=True, slots=True)
class Unknown:
    """An effect that the tool has no name for."""

    law: Callable[[float, Shape], MotorLaw]
    size: float
    shapes: dict[str, tuple[float, float]]

    def shape(self, rng: np.random.Generator) -> dict[str, float]:
        """A shape, evenly drawn in the logarithm."""
        return _evenly(self.shapes, rng)


UNKNOWN: dict[str, Unknown] = {
    "speed_bump": Unknown(unknown.speed_bump, 0.05, {"v0": (8.0, 20.0), "width": (1.5, 4.0)}),
    "speed_times_position": Unknown(unknown.speed_times_position, 0.02, {"v0": (10.0, 10.0), "p0": (20.0, 20.0)}),
    "tight_spot": Unknown(unknown.tight_spot, 0.2, {"p0": (0.06, 0.12), "width": (0.01, 0.03)}),
    "breathing": Unknown(unknown.breathing, 0.03, {"period": (0.8, 2.5)}),
    "grease_beyond": Unknown(unknown.grease_beyond, 0.04, {"p0": (0.04, 0.1), "v0": (10.0, 10.0)}),
}
