"""How a recording may differ from the white-noise study's: what real logs do, one thing at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Literal

import numpy as np
from scipy.signal import lfilter

from study.plant.experiment import SUBSTEPS, Array, Recording
from study.plant.machine import MotorLaw
from study.plant.rig import Rig

RIPPLES = 6.0  # of the torque constant, in a turn of the motor


@dataclass(frozen=True, slots=True)
class Condition:
    """every : sampling intervals of the study that one of this recording takes, controller included. counts : of the
    encoder, the study's where None. logs_speed : whether the speed is recorded. jitter : of the recorder's clock, share
    of the interval by which a sample may be early or late. louder : factor on both noises. error, pole : standard
    deviation [Nm] and coefficient per millisecond of a coloured error of the recorded torque; a pole of one is a random
    walk that reaches that size over a second. ripple : of the torque constant, share. drift : of dry friction, relative
    standard deviation of a slow random course. held_out : whether records are held out, and on which motion.
    """

    every: int = 1
    counts: int | None = None
    logs_speed: bool = True
    jitter: float = 0.0
    louder: float = 1.0
    error: float = 0.0
    pole: float = 0.0
    ripple: float = 0.0
    drift: float = 0.0
    held_out: Literal["other", "none", "same"] = "other"

    def of(self, rig: Rig, rng: np.random.Generator) -> Rig:
        """The machine under this condition."""
        if self.counts is not None:
            rig = replace(rig, sensor=replace(rig.sensor, counts=self.counts))
        if self.drift:
            rig = replace(rig, extra=rig.extra.with_motor(_wandering(self.drift * rig.base.Fc, rng)))
        return rig

    def offsets(self, n: int, rng: np.random.Generator) -> Sequence[int]:
        """Steps of the integrator, after the controller's instant, at which each sample is taken."""
        most = round(self.jitter * SUBSTEPS * self.every)
        return (most + rng.integers(-most, most + 1, n)).tolist() if most else [0] * n

    def recorded(self, made: Recording, rng: np.random.Generator) -> Recording:
        """The recording with the errors of its torque."""
        torque = made.torque + coloured(len(made.torque), made.sampling_time, self.error, self.pole, rng)
        if self.ripple:
            phase = rng.uniform(0.0, 2.0 * pi)
            torque = torque * (1.0 + self.ripple * np.sin(RIPPLES * made.angle + phase))
        return replace(made, torque=torque)


CONDITIONS: dict[str, Condition] = {
    "white noise": Condition(),
    "4 ms": Condition(every=4),
    "4096 counts": Condition(counts=4096, logs_speed=False),
    "angle alone": Condition(counts=2**18, logs_speed=False),
    "angle alone at 4 ms": Condition(every=4, counts=2**18, logs_speed=False),
    "jitter of 10 %": Condition(jitter=0.1),
    "five times the noise": Condition(louder=5.0),
    "torque error AR 0.9": Condition(error=0.02, pole=0.9),
    "torque error AR 0.99": Condition(error=0.02, pole=0.99),
    "torque error a random walk": Condition(error=0.02, pole=1.0),
    "torque ripple of 2 %": Condition(ripple=0.02),
    "friction that drifts": Condition(drift=0.01),
    "no held-out record": Condition(held_out="none"),
    "held-out record with the fit's motion": Condition(held_out="same"),
}


def coloured(n: int, sampling_time: float, size: float, pole: float, rng: np.random.Generator) -> Array:
    """A first-order autoregression (n,) of standard deviation `size`, its pole given for a millisecond."""
    if size == 0.0:
        return np.zeros(n)
    if pole == 1.0:
        return np.asarray(size * np.sqrt(sampling_time) * np.cumsum(rng.standard_normal(n)))
    a = pole ** (sampling_time / 1e-3)
    lead = int(np.ceil(5.0 / (1.0 - a)))
    drive = np.sqrt(1.0 - a * a) * rng.standard_normal(n + lead)
    return np.asarray(size * lfilter([1.0], [1.0, -a], drive)[lead:])


def _wandering(size: float, rng: np.random.Generator) -> MotorLaw:
    """Dry friction that wanders about its mean with a memory of two seconds [Nm]."""
    step, memory, span = 0.01, 2.0, 20.0
    course = coloured(round(span / step), step, size, float(np.exp(-1e-3 / memory)), rng).tolist()
    return lambda s, v, phi_m, phi_a, carried, t: course[min(int(t / step), len(course) - 1)] * s
