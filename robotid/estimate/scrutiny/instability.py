"""How an error of an open simulation grows along a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.estimate.scrutiny.settings import SETTINGS
from robotid.model.array import Array
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.signals.record import SHORTEST_PIECE, Record
from robotid.simulation.first_guess import measured_guess


def growth_rate(joint: Joint, theta: Array, record: Record) -> float:
    """Mean over a measured motion of the rate [1/s] at which an error of the simulation grows, zero where it decays."""
    x = measured_guess(joint, theta, record)[:, :: max(1, len(record) // SETTINGS.points)]
    zero = np.zeros(x.shape[1])
    at = joint.evaluate(x, zero, np.sign(x[joint.speeds]), zero, theta, columns=DerivativeColumns())
    rates = np.linalg.eigvals(np.moveaxis(np.asarray(at.A), -1, 0)).real.max(axis=1)
    return float(np.mean(np.maximum(rates, 0.0)))


@dataclass(frozen=True, slots=True)
class Instability:
    """How errors of an open simulation grow. rate [1/s] : the largest of the records'; growth : factors of e over a
    whole record; horizon [s] : of pieces over which they do not grow far, None where those would be too short."""

    rate: float
    growth: float
    horizon: float | None


def instability_of(joint: Joint, parameters: Parameters, records: Sequence[Record]) -> Instability:
    """Of open simulations along measured records."""
    rates = [growth_rate(joint, parameters.values, record) for record in records]
    growth, rate = max(rate * record.duration for rate, record in zip(rates, records, strict=True)), max(rates)
    horizon = float(f"{SETTINGS.growth / rate:.1g}") if rate > 0.0 else None
    if horizon is not None and is_too_short(horizon, records):
        horizon = None
    return Instability(rate, growth, horizon)


def is_too_short(horizon: float, records: Sequence[Record]) -> bool:
    """Whether pieces of this length [s] would have too few samples in a record."""
    return any(horizon < 2 * SHORTEST_PIECE * record.sampling_time for record in records)
