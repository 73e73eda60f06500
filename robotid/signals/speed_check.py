"""Whether a recorded speed is the derivative of the recorded angle: how it was derived, its delay and its scale."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robotid.model.array import Array
from robotid.signals.differentiate import central_difference
from robotid.signals.record import OPERATORS, SpeedOrigin

SAME = 1e-6  # of the largest speed: a difference that the digits of a file make
MIN_SAMPLES = 20  # from which a speed that equals the derivative everywhere does not by chance
MAX_LAG = 20  # samples of delay that are looked for
NOTABLE_LAG = 0.3  # samples
SURE = 4.0  # standard errors by which a delay must fit better than none
CORRELATED = 0.9


def speed_origin(angle: Array, speed: Array, sampling_time: float) -> SpeedOrigin:
    """The operator by which a recorded speed was derived from the recorded angle, "sensor" where it is none of those
    that are known. (n,), (n,)."""
    if len(angle) < MIN_SAMPLES:
        return "sensor"
    for origin, operator in OPERATORS.items():
        off = np.abs(speed - operator(angle, sampling_time))[1:-1]
        if float(off.max()) <= SAME * float(np.abs(speed).max()):
            return origin
    return "sensor"


def speed_lag(angle: Array, speed: Array, sampling_time: float) -> float:
    """Samples by which a recorded speed is late against the derivative of the angle, 0.0 where it is not. (n,), (n,).

    The cross-correlation's peak, as the least squared difference over shifts, read between samples by a parabola.
    """
    n = len(angle)
    max_lag = min(MAX_LAG, n // 4)
    derived = central_difference(angle, sampling_time)[max_lag : n - max_lag]

    def squares(lag: int) -> Array:
        """Squared differences at a shift, one shift at a time in memory."""
        return np.asarray((speed[max_lag + lag : n - max_lag + lag] - derived) ** 2)

    errors = np.array([np.mean(squares(lag)) for lag in range(-max_lag, max_lag + 1)])
    best = int(np.argmin(errors))
    if best in (0, 2 * max_lag):
        return 0.0
    curvature = errors[best - 1] - 2 * errors[best] + errors[best + 1]
    lag = best - max_lag + 0.5 * float((errors[best - 1] - errors[best + 1]) / curvature) if curvature > 0 else 0.0
    return lag if abs(lag) >= NOTABLE_LAG and _better(squares, lag) else 0.0


def _better(squares: Callable[[int], Array], lag: float) -> bool:
    """Whether the lag's neighbour on the way from none fits surely better than its mirror image does. squares : of the
    differences at a shift."""
    step = max(1, round(abs(lag))) * (1 if lag > 0 else -1)
    gain = squares(-step) - squares(step)
    spread = float(np.std(gain)) / np.sqrt(len(gain))
    return bool(np.mean(gain) > SURE * spread)


def speed_scale(angle: Array, speed: Array, sampling_time: float) -> float | None:
    """Recorded speed over derivative of the angle, by least squares; None where the two do not go together. (n,), (n,).

    Means over blocks are compared, which noise and the encoder's steps hardly touch.
    """
    block = max(1, len(angle) // 400)
    count = (len(angle) - 1) // block
    travelled = np.diff(angle[: count * block + 1 : block]) / (block * sampling_time)
    mean = (0.5 * (speed[:-1] + speed[1:]))[: count * block].reshape(count, block).mean(axis=1)
    size = float(np.linalg.norm(travelled) * np.linalg.norm(mean))
    if size == 0 or abs(float(travelled @ mean)) < CORRELATED * size:
        return None
    return float(travelled @ mean) / float(travelled @ travelled)
