"""How a recorded speed lies against the derivative of the recorded angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array
from robotid.signals.speed_check import MAX_LAG

BLOCKS = 400  # of a record, over which speeds are averaged: the encoder's steps and noise hardly touch their means


@dataclass(frozen=True, slots=True)
class Alignment:
    """correlation : with the angle's derivative, -1 to 1, at the shift of the largest; scale : recorded over derived
    speed by least squares there."""

    correlation: float
    scale: float


def align_speed(angle: Array, speed: Array, sampling_time: float) -> Alignment:
    """A recorded speed (n,) against the derivative of the angle (n,), whichever is late by up to 20 samples."""
    n = len(angle)
    margin = min(MAX_LAG, n // 10)
    block = max(1, n // BLOCKS)
    count = (n - 2 * margin - 1) // block
    edges = margin + block * np.arange(count + 1)
    derived = np.diff(angle[edges]) / (block * sampling_time)
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    own = derived - derived.mean() if abs(derived.mean()) < 3 * derived.std() else derived
    best = Alignment(0.0, 0.0)
    for lag in range(-margin, margin + 1):
        mean = np.diff(travelled[edges + lag]) / block
        moved = mean - mean.mean() if own is not derived else mean
        size = float(np.linalg.norm(own) * np.linalg.norm(moved))
        correlation = float(own @ moved) / size if size > 0.0 else 0.0
        if abs(correlation) > abs(best.correlation):
            best = Alignment(correlation, float(own @ moved) / float(own @ own))
    return best
