"""What a reference would make the joint do, if it were followed to the letter, and whether the joint may."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.signals.differentiate import Kinematics
from robotid.signals.reference import Reference

Torque = Callable[[Kinematics], Array]
"""Torque [Nm] that a motion takes, (n,)."""

ROUNDING = 1e-9  # of the differences and integrals, in parts of a limit

_SMOOTHER = "lower amplitude or peak, give a square wave a rise time, or raise limits"
_HINTS = {
    "speed": "lower amplitude or peak, or raise limits.speed",
    "acceleration": f"{_SMOOTHER}.acceleration",
    "position": "lower amplitude or peak, shorten the period, or raise limits.position",
    "torque": f"{_SMOOTHER}.torque",
}
_UNITS = {"speed": "rad/s", "acceleration": "rad/s2", "position": "rad", "torque": "Nm"}
_SLIDING_UNITS = {"speed": "m/s", "acceleration": "m/s2", "position": "m", "torque": "N"}


@dataclass(frozen=True, slots=True)
class Limits:
    """What the joint may do on the motor side: speed [rad/s], acceleration [rad/s2], position [rad], torque [Nm].

    None : anything. The position of a speed reference counts from its start.
    """

    speed: float | None = None
    acceleration: float | None = None
    position: float | None = None
    torque: float | None = None


def motion(reference: Reference) -> Kinematics:
    """Motor motion that follows the reference from rest; backward differences, trapezoidal integral, each (n,).

    A step takes one sample, so its acceleration is large but finite.
    """
    ref, h = reference.ref, reference.sampling_time
    if reference.kind == "position":
        position, speed = ref, np.diff(ref, prepend=ref[0]) / h
    else:
        position, speed = np.concatenate([[0.0], np.cumsum(0.5 * h * (ref[1:] + ref[:-1]))]), ref
    return Kinematics(position, speed, np.diff(speed, prepend=0.0) / h)


def check_limits(reference: Reference, limits: Limits, torque: Torque | None = None, *, sliding: bool = False) -> None:
    """Raise ConfigError for the first quantity that goes beyond its limit.

    torque : needed for a limit of torque. sliding : of an axis in m and N.
    """
    followed = motion(reference)
    units = _SLIDING_UNITS if sliding else _UNITS
    for quantity, unit in units.items():
        limit = getattr(limits, quantity)
        if limit is None:
            continue
        if quantity == "torque":
            assert torque is not None
            reached = np.abs(torque(followed))
        else:
            reached = np.abs(getattr(followed, quantity))
        most = float(reached.max())
        if most > limit * (1 + ROUNDING):
            first = int(np.argmax(reached >= most * (1 - ROUNDING))) * reference.sampling_time
            raise ConfigError(
                f"the {quantity} reaches {most:.4g} {unit} at {first:.4g} s, the limit is {limit:.4g} {unit}",
                where=reference.name,
                hint=_HINTS[quantity],
            )
