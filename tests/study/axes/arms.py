"""A drawn robot of two axes, its experiments, and what friction does beside the Coulomb law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import cos, exp, pi, sin

import numpy as np
from numpy.typing import NDArray

from study.plant.experiment import Loop
from study.plant.machine import GearLaw, Machine, MotorLaw
from study.plant.pair_experiment import Axis, AxisRecording, experiment
from study.plant.references import triangle
from study.plant.two_axes import Links

Array = NDArray[np.float64]

SAMPLING_TIME = 2e-3
SUBSTEPS = 8
RATIOS = (1 / 100, 1 / 80)
SPREAD = 0.2  # of every parameter, and of the amplitudes
TEMPERATURE_NOISE = 0.05  # degC
REFERENCE_TEMPERATURE = 30.0  # degC, at which friction is what the drawn parameters say


@dataclass(frozen=True, slots=True)
class Joint:
    """SI, motor side for friction; flange : the arm's inertia besides the links."""

    motor_inertia: float
    Fv: float
    Fc: float
    k: float
    d: float
    flange: float

    def drawn(self, rng: np.random.Generator) -> Joint:
        """Every parameter within its spread."""
        names = ("motor_inertia", "Fv", "Fc", "k", "d", "flange")
        return Joint(**{name: getattr(self, name) * _factor(rng) for name in names})


JOINTS = (Joint(1e-3, 2e-3, 0.2, 2e4, 30.0, 1.0), Joint(6e-4, 1e-3, 0.15, 2e5, 20.0, 0.3))
"""The second gear is stiff: what it twists is in no record, and the first axis feels it near that gear's resonance."""
LINKS = Links(20.0, 0.5, 0.25, 0.5, 10.0, 0.2, 0.2)
LOOPS = (Loop(0.05, 0.5), Loop(0.03, 0.3))
NOISES = ((4e-4, 0.02), (3e-4, 0.025))  # of torque [Nm] and speed [rad/s]


@dataclass(frozen=True, slots=True)
class Wave:
    """The motion of one axis: amplitude [rad/s] and period [s] of a triangle, highest frequency [Hz] of the sines."""

    amplitude: float
    period: float
    highest: float


WAVES = (Wave(50.0, 4.0, 12.0), Wave(70.0, 3.0, 5.0))


@dataclass(frozen=True, slots=True)
class Plan:
    """One record: reference speeds (n,) [rad/s] of both motors, pose of the arms at its start [rad], temperature (n,)
    [degC]."""

    name: str
    role: str
    use: str
    refs: tuple[Array, Array]
    pose: tuple[float, float]
    temperature: Array


@dataclass(frozen=True, slots=True)
class Extra:
    """Friction of the first axis beside its Coulomb and viscous friction.

    name : of the effect, "temperature" for what that does, empty for none; size in SI, motor side; shape : of the
    effect.
    """

    name: str = ""
    size: float = 0.0
    shape: Mapping[str, float] | None = None

    def law(self, joint: Joint, temperature: Array) -> MotorLaw:
        """The torque on the motor."""
        size, shape = self.size, self.shape or {}
        if self.name == "stribeck":
            return lambda s, v, *_: size * exp(-((v / shape["vs"]) ** 2)) * s
        if self.name == "asymmetric_coulomb":
            return lambda *_: size
        if self.name == "quadratic_friction":
            return lambda s, v, *_: size * v * abs(v)
        if self.name == "position_friction":
            n, phase = shape["n"], shape["phase"]
            return lambda s, v, phi_m, *_: size * (cos(phase) * sin(n * phi_m) + sin(phase) * cos(n * phi_m)) * s
        warmer, last = (temperature - REFERENCE_TEMPERATURE).tolist(), len(temperature) - 1
        Fc, Fv = joint.Fc, joint.Fv
        return lambda s, v, phi_m, phi_a, carried, t: (
            size * warmer[min(int(t / SAMPLING_TIME), last)] * (Fc * s + Fv * v)
        )


@dataclass(frozen=True, slots=True)
class Arms:
    """A robot without anything hidden, its records, and the seed of their noise."""

    joints: tuple[Joint, Joint]
    links: Links
    noises: tuple[tuple[float, float], ...]
    plans: tuple[Plan, ...]
    seed: int

    def record(self, number: int, extra: Extra) -> tuple[AxisRecording, AxisRecording]:
        """Both axes on one of the plans."""
        plan = self.plans[number]
        axes = []
        for k, (joint, loop, (torque, speed)) in enumerate(zip(self.joints, LOOPS, self.noises, strict=True)):
            laws = (_rubbing(joint),)
            if extra.name and k == 0:
                laws = (*laws, extra.law(joint, plan.temperature))
            machine = Machine(RATIOS[k], joint.motor_inertia, joint.flange, motor=laws, gear=(_teeth(joint),))
            axes.append(Axis(machine, replace(loop, torque_noise=torque, speed_noise=speed)))
        pair = axes[0], axes[1]
        return experiment(pair, self.links, plan.refs, SAMPLING_TIME, self.seed + number, plan.pose, SUBSTEPS)

    def measured_temperature(self, number: int) -> Array:
        """The temperature of a record as recorded, (n,) [degC]."""
        rng, true = np.random.default_rng([self.seed, number]), self.plans[number].temperature
        return np.asarray(true + TEMPERATURE_NOISE * rng.standard_normal(len(true)))


def _rubbing(joint: Joint) -> MotorLaw:
    return lambda s, v, *_: joint.Fc * s + joint.Fv * v


def _teeth(joint: Joint) -> GearLaw:
    return lambda x, dx: joint.k * x + joint.d * dx


def draw(rng: np.random.Generator) -> Arms:
    """Everything within its spread; every record begins in a pose and at a temperature of its own."""
    joints = JOINTS[0].drawn(rng), JOINTS[1].drawn(rng)
    links = Links(*(getattr(LINKS, name) * _factor(rng) for name in ("m1", "l1", "c1", "I1", "m2", "c2", "I2")))
    noises = tuple((torque * _factor(rng), speed * _factor(rng)) for torque, speed in NOISES)
    seed = int(rng.integers(2**31))
    shapes = (
        ("slow", "estimate", "rigid", 0.0, 8.0),
        ("wide1", "estimate", "flex", 8.0, 5.0),
        ("wide2", "estimate", "flex", 14.0, 5.0),
        ("check_slow", "validate", "both", 0.0, 6.0),
        ("check", "validate", "both", 10.0, 5.0),
    )
    plans = []
    for name, role, use, peak, duration in shapes:
        refs = tuple(_reference(rng, wave, peak, duration) for wave in WAVES)
        pose = float(rng.uniform(-0.6, 0.6)), float(rng.uniform(0.6, 1.4) * rng.choice((-1.0, 1.0)))
        plans.append(Plan(name, role, use, (refs[0], refs[1]), pose, _warming(rng, len(refs[0]))))
    return Arms(joints, links, noises, tuple(plans), seed)


def _reference(rng: np.random.Generator, wave: Wave, peak: float, duration: float) -> Array:
    """A triangle that turns the arm through its range, the other way round in half of the draws, and sines on it."""
    period = round(wave.period * _factor(rng), 1)
    turning = rng.choice((-1.0, 1.0)) * triangle(wave.amplitude * _factor(rng), period, duration, SAMPLING_TIME)
    if not peak:
        return np.asarray(turning)
    t, lines = np.arange(len(turning)) * SAMPLING_TIME, np.arange(round(duration), round(wave.highest * duration) + 1)
    phases = rng.uniform(0.0, 2.0 * pi, len(lines))
    sines = np.cos(2.0 * pi * np.outer(t, lines) / duration + phases).sum(axis=1)
    return np.asarray(turning + peak * _factor(rng) * sines / np.abs(sines).max())


def _warming(rng: np.random.Generator, samples: int) -> Array:
    """A temperature that creeps up from one of its own, (samples,) [degC]."""
    t = np.arange(samples) * SAMPLING_TIME
    return np.asarray(rng.uniform(22.0, 38.0) + rng.uniform(1.0, 3.0) * (1.0 - np.exp(-t / rng.uniform(3.0, 8.0))))


def _factor(rng: np.random.Generator) -> float:
    return float(rng.uniform(1.0 - SPREAD, 1.0 + SPREAD))
