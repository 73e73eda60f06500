"""The paper's joint and its three experiments, for tests: truth m3, made without robotid's simulator."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array
from robotid.model.structure import Structure

RATIO = 1 / 224.3
TERMS = (
    "motor.inertia",
    "motor.viscous",
    "motor.coulomb",
    "gear.spring",
    "gear.cubic_spring",
    "gear.damper",
    "arm.inertia",
)
STRUCTURE = Structure(TERMS, gear_ratio=RATIO)
TRUTH = {
    "motor.inertia.J": 0.0121,
    "motor.viscous.Fv": 0.0130,
    "motor.coulomb.Fc": 0.644,
    "gear.spring.k1": 1.46e6,
    "gear.cubic_spring.k3": 3.72e10,
    "gear.damper.d": 2.63e3,
    "arm.inertia.J": 1130.0,
}
SAMPLING_TIME = 5e-4


def references() -> tuple[Array, Array, Array]:
    """Reference speeds of the paper's sets 1, 2 and 3 [rad/s] at 2 kHz."""
    t1, t = np.arange(12_500) * SAMPLING_TIME, np.arange(10_000) * SAMPLING_TIME
    phase = (t1 / 5) % 1
    triangle = 40 * np.select([phase < 0.25, phase < 0.75], [4 * phase, 2 - 4 * phase], 4 * phase - 4)
    square = np.where(t < 2.5, 1.0, -1.0)
    return triangle, multisine(t, 5.0) + 8 * square, multisine(t, 10.0) + 12 * square


def multisine(t: Array, peak: float) -> Array:
    """Flat 1 to 40 Hz, period 5 s, Schroeder phases."""
    lines = np.arange(5, 201)
    phase = -np.pi * np.arange(len(lines)) * (np.arange(len(lines)) + 1) / len(lines)
    y = np.cos(2 * np.pi * 0.2 * np.outer(t, lines) + phase).sum(axis=1)
    return np.asarray(peak * y / np.abs(y).max())
