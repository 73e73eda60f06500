"""The recorded speed against the derivative of the recorded angle."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np

from robotid.numerals import plain
from robotid.signals.plausibility.alignment import align_speed
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.settings import CHECK
from robotid.signals.speed_check import speed_lag

DERIVE = "write dphi_m: null under columns to derive it from the angle"


@check()
def speed_empty(evidence: Evidence) -> Iterator[Remark]:
    """The recorded speed never changes while the motor moves."""
    v = evidence.record.dphi_m
    if np.ptp(v) == 0.0:
        yield Remark(
            "fatal",
            f"the speed is {plain(v[0])} {evidence.units['speed']} in every sample, while the angle moves",
            "a fit of the speed has nothing to compare with",
            DERIVE,
        )


@check(unless=("speed_empty", "torque_copy"))
def speed_exchanged(evidence: Evidence) -> Iterator[Remark]:
    """The speed is no derivative of the angle, and with two columns exchanged it is."""
    record = evidence.record
    if evidence.speed_is_derived or abs(evidence.speed_alignment.correlation) > CHECK.surely_same:
        return
    for exchanged in (("tau_m", "dphi_m"), ("phi_m", "dphi_m"), ("tau_m", "phi_m")):
        columns = {name: name for name in ("tau_m", "phi_m", "dphi_m")} | dict([exchanged, exchanged[::-1]])
        angle, speed = columns["phi_m"], columns["dphi_m"]
        found = align_speed(getattr(record, angle), getattr(record, speed), record.sampling_time)
        if found.correlation > CHECK.surely_same and abs(found.scale - 1.0) < CHECK.notable_scale:
            yield Remark(
                "fatal",
                f"{speed} is the derivative of {angle} (correlation {found.correlation:.3f}), and dphi_m is not that of"
                " phi_m",
                "nothing that is fitted to exchanged columns means anything",
                f"exchange the columns of {exchanged[0]} and {exchanged[1]}",
            )
            return


@check(unless=("speed_empty", "speed_exchanged"))
def speed_unrelated(evidence: Evidence) -> Iterator[Remark]:
    """The recorded speed has little to do with the derivative of the angle."""
    if evidence.speed_is_derived:
        return
    correlation = abs(evidence.speed_alignment.correlation)
    if correlation < CHECK.same_speed:
        yield Remark(
            "fatal",
            f"the speed and the derivative of the angle correlate by {correlation:.2f} only",
            "the fit compares with a signal that this motion did not make",
            f"name the column of the motor's speed, or {DERIVE}",
        )


@check(unless=("speed_empty", "speed_exchanged", "speed_unrelated"))
def speed_sign(evidence: Evidence) -> Iterator[Remark]:
    """The recorded speed has the other sign than the derivative of the angle."""
    if not evidence.speed_is_derived and evidence.speed_alignment.correlation < 0:
        scale = evidence.speed_alignment.scale
        yield Remark(
            "fatal",
            f"the speed is {plain(scale)} times the derivative of the angle: one of them has the wrong sign",
            "simulated and measured speed run against each other, and inertia and friction come out negative",
            f"give dphi_m a negative scale, dphi_m: {{name: ..., scale: -1}}, or {DERIVE}",
        )


@check(unless=("speed_empty", "speed_exchanged", "speed_unrelated"))
def speed_scale(evidence: Evidence) -> Iterator[Remark]:
    """The recorded speed is another multiple of the derivative of the angle than one."""
    if evidence.speed_is_derived:
        return
    scale = abs(evidence.speed_alignment.scale)
    meaning = known_factor(scale, evidence.axis.gear_ratio)
    if scale > CHECK.scale or scale < 1 / CHECK.scale:
        yield Remark(
            "fatal",
            f"the speed is {plain(scale)} times the derivative of the angle{meaning}",
            "the fit compares speeds of different units",
            f"give the unit or scale of the one that is wrong, or {DERIVE}",
        )
    elif abs(scale - 1) > CHECK.notable_scale:
        yield Remark(
            "warning",
            f"the speed is {plain(scale)} times the derivative of the angle",
            f"inertia and friction are wrong by up to {plain(100 * abs(scale - 1), 2)} %",
            f"correct the scale of the one that is wrong, or {DERIVE}",
        )


def known_factor(scale: float, gear_ratio: float | None) -> str:
    """What a factor between two speeds usually means, as part of a sentence, or nothing."""
    known = {180 / pi: "degrees against radians", 30 / pi: "rpm against rad/s", 6.0: "rpm against degrees a second"}
    known |= {
        2 * pi: "revolutions against radians",
        1e3: "milliseconds against seconds",
        60.0: "minutes or revolutions",
    }
    if gear_ratio:
        known |= {1 / abs(gear_ratio): "motor against arm, by the gear ratio"}
    counts = 2 * pi / scale if scale < 1 else 2 * pi * scale
    if counts > 500 and abs(counts / round(counts) - 1) < 1e-4 and round(counts) % 4 == 0:
        known |= {counts / (2 * pi): f"{round(counts)} counts a revolution against radians"}
    for factor, meaning in known.items():
        if any(abs(scale / one - 1) < CHECK.factor for one in (factor, 1 / factor)):
            return f": {meaning}"
    return ""


@check(unless=("speed_empty", "speed_exchanged", "speed_unrelated", "speed_sign", "speed_scale"))
def speed_delay(evidence: Evidence) -> Iterator[Remark]:
    """The recorded speed is late or early against the derivative of the angle."""
    record = evidence.record
    if evidence.speed_is_derived:
        return
    lag = speed_lag(record.phi_m, record.dphi_m, record.sampling_time)
    if abs(lag) > CHECK.late:
        yield Remark(
            "warning",
            f"the speed is {abs(lag):.1f} samples {'late' if lag > 0 else 'early'} against the derivative of the angle",
            "a delay passes for friction or for a torque that lags",
            f"set speed_delay: {round(lag)} of the record, or {DERIVE}",
        )
