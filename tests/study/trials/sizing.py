"""How large an effect must be to cost what is asked, found by running the plant and fitting the model without it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log, sqrt
from pathlib import Path

import numpy as np

from study.plant.experiment import Recording
from study.trials.case import Case
from study.trials.tool import Fitted, fit
from robotid.errors import RobotidError

NOISE_AND_TORQUE = 1.02  # noise floor over the noise of the recorded speed: that of the torque adds a little
CLOSE = 1.2  # ratio of the cost to what is asked at which the search ends
MOST_TRIES = 4
STEPS = (0.2, 5.0)  # largest factors from one size to the next


@dataclass(frozen=True, slots=True)
class Sized:
    """A case whose hidden effect has the size that was asked for, and the model fitted without the effect.

    cost : RMS misfit of that model beyond the noise on held-out records, in noise standard deviations.
    """

    case: Case
    records: dict[str, Recording]
    base: Fitted
    cost: float


def cost(rmse: float, floor: float) -> float:
    """RMS misfit beyond the noise, in noise standard deviations. rmse, floor [rad/s]."""
    return sqrt(max(0.0, (rmse / floor) ** 2 - 1.0))


def floor(case: Case) -> float:
    """RMS error that the true model would have, or so [rad/s]."""
    return NOISE_AND_TORQUE * case.draw.loop.speed_noise


def sized(make: Callable[[float], Case], start: float, largest: float, target: float, folder: Path) -> Sized:
    """A case of about the target cost, by the secant rule on logarithms. Raises RobotidError where the model without
    the effect cannot be fitted however small the effect."""
    size, found, seen = start, None, list[tuple[float, float]]()
    for _ in range(MOST_TRIES):
        size = min(size, largest)
        try:
            found = _tried(make(size), folder / f"size{len(seen)}")
        except RobotidError:
            if len(seen) == MOST_TRIES - 1:
                raise
            seen.append((size, np.inf))
            size *= 0.5
            continue
        seen.append((size, found.cost))
        if 1 / CLOSE < found.cost / target < CLOSE or (size >= largest and found.cost < target):
            break
        size *= float(np.clip((target / max(found.cost, 0.1)) ** (1.0 / _power(seen)), *STEPS))
    assert found is not None
    return found


def _tried(case: Case, folder: Path) -> Sized:
    records = case.write(folder)
    fitted = fit(folder / "base.yaml")
    return Sized(case, records, fitted, cost(fitted.rmse, floor(case)))


def _power(seen: list[tuple[float, float]]) -> float:
    """How the cost grows with the size: with its first power, until two sizes show it."""
    known = [(log(size), log(max(value, 0.1))) for size, value in seen if np.isfinite(value)][-2:]
    if len(known) < 2 or known[0][0] == known[1][0]:
        return 1.0
    return float(np.clip((known[1][1] - known[0][1]) / (known[1][0] - known[0][0]), 0.5, 3.0))
