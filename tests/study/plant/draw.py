"""A drawn machine and its experiments, everything from one seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from study.plant.experiment import Array, Loop, Recording, experiment
from study.plant.references import multisine, square, triangle
from study.plant.rig import Base, Rig

SAMPLING_TIME = 1e-3
CUBIC = 3.72e10  # Nm/rad3, of the machines whose spring hardens
CUBIC_SHARE = 1 / 3


@dataclass(frozen=True, slots=True)
class Plan:
    """One record: its role in the tool's configuration, and the reference speed (n,) [rad/s]."""

    name: str
    role: str
    use: str
    ref: Array


@dataclass(frozen=True, slots=True)
class Draw:
    """A machine without hidden effect, its loop, its records, and the seed of their noise."""

    base: Base
    loop: Loop
    plans: tuple[Plan, ...]
    seed: int

    def record(self, rig: Rig, number: int) -> Recording:
        """The rig on one of the plans."""
        ref = self.plans[number].ref
        return experiment(rig, self.loop, ref, SAMPLING_TIME, self.seed + number)


def draw(rng: np.random.Generator) -> Draw:
    """Base within 30 % of the paper's machine, amplitudes within 15 %, noise within 30 %."""
    base = Base(k3=CUBIC if rng.random() < CUBIC_SHARE else 0.0).drawn(rng)
    loop = Loop(torque_noise=0.005 * rng.uniform(0.7, 1.3), speed_noise=0.02 * rng.uniform(0.7, 1.3))
    seed = int(rng.integers(2**31))
    plans = (
        Plan("slow", "estimate", "rigid", _triangle(rng, 40.0, 4.0, 6.0)),
        Plan("wide1", "estimate", "flex", _wide(rng, 5.0, 8.0, 5.0)),
        Plan("wide2", "estimate", "flex", _wide(rng, 10.0, 12.0, 5.0)),
        Plan("check_slow", "validate", "both", _triangle(rng, 28.0, 3.0, 4.5)),
        Plan("check", "validate", "both", _wide(rng, 7.5, 10.0, 4.0)),
    )
    return Draw(base, loop, plans, seed)


def _triangle(rng: np.random.Generator, amplitude: float, period: float, duration: float) -> Array:
    return triangle(amplitude * rng.uniform(0.85, 1.15), period, duration, SAMPLING_TIME)


def _wide(rng: np.random.Generator, peak: float, level: float, period: float) -> Array:
    """A multisine on a square wave, which keeps static friction out of most of it."""
    seed = int(rng.integers(2**31))
    sines = multisine(peak * rng.uniform(0.85, 1.15), period, period, SAMPLING_TIME, seed)
    return sines + square(level * rng.uniform(0.85, 1.15), period, period, SAMPLING_TIME)
