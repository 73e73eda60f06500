"""The companions of a record: whether each can explain anything, and has a size that its kind has."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.settings import CHECK


@check()
def companion_constant(evidence: Evidence) -> Iterator[Remark]:
    """A companion never changes."""
    for name, one in evidence.record.companions.items():
        if np.ptp(one.values) == 0.0:
            yield Remark(
                "warning",
                f"{name} is {one.values[0]:.4g} {one.unit} throughout",
                f"what reads {name} cannot be distinguished from what does not",
                "check the column, or record while it changes",
            )


@check()
def companion_size(evidence: Evidence) -> Iterator[Remark]:
    """A companion is larger than its kind allows."""
    for name, one in evidence.record.companions.items():
        largest = float(np.abs(one.values).max())
        if one.kind is CompanionKind.ANGLE and one.unit == "rad" and np.ptp(one.values) > 2 * pi * CHECK.turns:
            yield Remark(
                "warning",
                f"{name} moves by {np.ptp(one.values) / (2 * pi):.3g} turns",
                "effects read the angle of an axis behind its gear: before it, one turn of the axis is a hundred waves",
                "check its unit, or give the gear ratio as its scale",
            )
        if one.kind is CompanionKind.TEMPERATURE and not CHECK.coldest <= largest <= CHECK.hottest:
            yield Remark(
                "warning",
                f"{name} is up to {largest:.4g} degC",
                "no gear is so warm: friction would be read against another signal",
                "check its unit: degC, K or degF",
            )


@check()
def companion_copy(evidence: Evidence) -> Iterator[Remark]:
    """A companion repeats another signal."""
    record = evidence.record
    seen = {"phi_m": record.phi_m, "tau_m": record.tau_m}
    for name, one in record.companions.items():
        if one.kind is CompanionKind.DISTURBANCE:
            continue
        for other, values in seen.items():
            if _alike(one.values, values) > CHECK.repeat:
                yield Remark(
                    "warning",
                    f"{name} is {other} but for offset and scale",
                    f"what reads {name} cannot be distinguished from what reads {other}",
                    "check the column, or move the axes differently",
                )
        seen[name] = one.values


def _alike(one: Array, other: Array) -> float:
    """Size of the correlation of two signals, (n,) each; 0 where one is constant."""
    a, b = one - one.mean(), other - other.mean()
    length = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(a @ b)) / length if length > 0.0 else 0.0
