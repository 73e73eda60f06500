"""A drawn machine and its experiments, everything from one seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from study.plant.conditions import CONDITIONS, Condition
from study.plant.experiment import SUBSTEPS, Array, Loop, Recording, experiment
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
    condition: Condition = CONDITIONS["white noise"]

    def record(self, rig: Rig, number: int) -> Recording:
        """The rig on one of the plans, under the condition of the recording."""
        condition, ref = self.condition, self.plans[number].ref[:: self.condition.every]
        rng = np.random.default_rng([self.seed, number])
        rig, offsets = condition.of(rig, rng), condition.offsets(len(ref), rng)
        h, substeps = SAMPLING_TIME * condition.every, SUBSTEPS * condition.every
        made = experiment(rig, self.loop, ref, h, self.seed + number, substeps, offsets)
        return condition.recorded(made, rng)

    def under(self, condition: Condition) -> Draw:
        """The same machine and experiments, recorded under a condition."""
        louder, loop = condition.louder, self.loop
        loop = replace(loop, torque_noise=louder * loop.torque_noise, speed_noise=louder * loop.speed_noise)
        fitted = tuple(plan for plan in self.plans if plan.role == "estimate")
        plans = {
            "other": self.plans,
            "none": fitted,
            "same": (*fitted, replace(fitted[-1], name="check", role="validate", use="both")),
        }
        return replace(self, loop=loop, plans=plans[condition.held_out], condition=condition)


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
