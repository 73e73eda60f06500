"""The torque against the motion that it makes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robotid.model.array import Array
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.regression import explained_share
from robotid.signals.plausibility.settings import CHECK

RECORDED = {"phi_m": "the motor angle", "dphi_m": "the motor speed", "phi_a": "the arm angle", "ref": "the reference"}


@check()
def torque_copy(evidence: Evidence) -> Iterator[Remark]:
    """The torque is another recorded column, but for scale and offset."""
    record = evidence.record
    acceleration = np.gradient(evidence.derived_speed, record.sampling_time)
    for signal, meaning in RECORDED.items():
        values = getattr(record, signal)
        # a pure oscillation makes every torque of an inertia a multiple of the angle
        if values is None or not _is_copy(record.tau_m, values) or _oscillates(values, acceleration):
            continue
        yield Remark(
            "fatal",
            f"the torque is a copy of {meaning} ({signal}), but for scale and offset",
            "the record holds no torque, and whatever is fitted follows from a column that was named twice",
            "name the column of the torque under columns: tau_m",
        )
        return


def _is_copy(torque: Array, other: Array) -> bool:
    if not np.ptp(other):
        return False
    left = 1.0 - explained_share(np.vstack([np.ones_like(other), other - other.mean()]), torque)
    return bool(left <= CHECK.copy)


def _oscillates(values: Array, acceleration: Array) -> bool:
    inner = slice(2, -2)
    columns = np.vstack([np.ones_like(values), acceleration])[:, inner]
    return explained_share(columns, values[inner]) > 0.99


@check(unless=("torque_copy",))
def torque_unrelated(evidence: Evidence) -> Iterator[Remark]:
    """The motion explains the torque no better than one that was shifted in time."""
    found = evidence.regression
    share = found.explained
    if share < CHECK.weak and share < max(CHECK.unexplained, CHECK.chance * found.by_chance):
        yield Remark(
            "fatal",
            f"the motion explains {100 * share:.2g} % of the torque, and {100 * found.by_chance:.2g} % of a torque that"
            f" is shifted in time{'; the torque is white noise' if found.white else ''}",
            "inertia and friction are what chance makes of them",
            "name the columns of one recording under columns: tau_m and phi_m",
        )
    elif share < CHECK.weak:
        yield Remark(
            "warning",
            f"the motion explains {100 * share:.2g} % of the torque",
            "the rest is noise or comes from elsewhere, and parameters take part of it",
            "check the columns, and record a motion that takes more torque",
        )


@check(unless=("torque_copy",))
def torque_levels(evidence: Evidence) -> Iterator[Remark]:
    """The torque takes two or three values only."""
    torque = evidence.record.tau_m
    levels = np.unique(torque[: min(len(torque), 100_000)])
    if len(levels) <= CHECK.few_levels:
        listed = ", ".join(f"{level:.3g}" for level in levels)
        yield Remark(
            "warning",
            f"the torque takes {len(levels)} values only: {listed} {evidence.units['torque']}",
            "it is a command that is switched, or a flag, and what the drive made of it is not in the record",
            "name the column of the measured torque under columns: tau_m",
        )


@check(unless=("torque_copy", "torque_unrelated"))
def torque_sign(evidence: Evidence) -> Iterator[Remark]:
    """The torque takes power from a joint that can only absorb it (passivity), or drives it backwards."""
    found = evidence.regression
    inertia, power = found.inertia.ratio, found.friction_power.ratio
    if max(inertia, power) < CHECK.sure and min(inertia, power) < -CHECK.sure:
        parts = []
        if inertia < -CHECK.sure:
            parts.append(f"an inertia of {found.inertia.value:.3g} {evidence.units['inertia']}{_sure(inertia)}")
        if power < -CHECK.sure:
            parts.append(f"friction that supplies {-found.friction_power.value:.3g} W{_sure(power)}")
        yield Remark(
            "fatal",
            f"torque and motion ask for {' and '.join(parts)}: one of them has the wrong sign",
            "no joint is like that, and its simulation diverges",
            "give tau_m a negative scale, tau_m: {name: ..., scale: -1}; or phi_m, if that is the one",
        )
    elif inertia > CHECK.sure and power < -CHECK.sure:
        late = found.delay
        much = f"; the angle is {1e3 * late.value:.2g} ms late against it" if late.ratio > CHECK.sure else ""
        yield Remark(
            "warning",
            f"friction supplies {-found.friction_power.value:.3g} W{_sure(power)}, while the inertia is positive{much}",
            "a delay between torque and angle passes for negative friction",
            "record both with one clock, or add the effect sensor_delay to the model",
        )


def _sure(ratio: float) -> str:
    """How sure a sign is, as part of a sentence."""
    return f" ({abs(ratio):.2g} standard deviations from zero)" if np.isfinite(ratio) else ""
