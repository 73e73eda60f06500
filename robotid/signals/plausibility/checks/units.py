"""Units and sides of the gear against sizes that machines have."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np

from robotid.numerals import plain
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.settings import CHECK
from robotid.signals.quality import quantum

MIN_COUNTS = 100  # a revolution, of a motor's encoder
ROUND_COUNTS = tuple(k * 10**p for k in (1, 1.25, 1.5, 2, 2.5, 3.6, 4, 5, 7.2, 8) for p in (2, 3, 4, 5)) + tuple(
    2**k for k in range(7, 27)
)
"""Steps a revolution that encoders have."""
SAME_COUNTS = 2e-4  # relative deviation from them
SURE_BITS, SURE_SAME = 10, 1e-5  # of an encoder whose steps are those of a power of two without doubt
CONVERTER_RANGES = (20.0, 10.0, 5.0)  # V from end to end
CONVERTER_BITS = (10, 12, 14, 16)


@check(
    unless=(
        "torque_copy",
        "torque_unrelated",
        "torque_follows",
        "torque_sign",
        "angle_counts",
        "sampling_size",
        "speed_exchanged",
        "speed_scale",
    )
)
def inertia_size(evidence: Evidence) -> Iterator[Remark]:
    """The inertia that torque and motion ask for is one that no motor carries."""
    found, axis = evidence.regression.inertia, evidence.axis
    if axis.linear or found.ratio < CHECK.sure:
        return
    geared = axis.gear_ratio is not None and abs(axis.gear_ratio) < CHECK.geared
    if geared and found.value > CHECK.max_motor_inertia:
        assert axis.gear_ratio is not None
        ratio = abs(axis.gear_ratio)
        yield Remark(
            "fatal",
            f"the inertia at the motor would be {plain(found.value)} kg m2, behind a gear of 1/{1 / ratio:.4g}",
            "every parameter is wrong by the same factor as the torque or the angle",
            f"torque in Nmm: tau_m: {{name: ..., unit: mNm}} ({plain(found.value / 1e3, 2)} kg m2); angle of the arm"
            f" instead of the motor: phi_m: {{name: ..., scale: {1 / axis.gear_ratio:.6g}}}"
            f" ({plain(found.value * ratio, 2)} kg m2)",
        )
    elif found.value > CHECK.max_motor_inertia and fastest_turn(evidence) > CHECK.fast:
        yield Remark(
            "warning",
            f"an inertia of {plain(found.value)} kg m2 would turn at up to {plain(fastest_turn(evidence))} rad/s",
            "every parameter is wrong by the same factor as the torque or the angle",
            "give the units of tau_m and phi_m, such as tau_m: {name: ..., unit: mNm}",
        )
    elif found.value < CHECK.min_inertia:
        yield Remark(
            "warning",
            f"the inertia would be {plain(found.value)} kg m2, less than that of the smallest motors",
            "every parameter is wrong by the same factor as the torque or the angle",
            "give the units of tau_m and phi_m, such as tau_m: {name: ..., unit: kNm} or phi_m: {name: ..., unit: deg}",
        )


@check(unless=("speed_scale",))
def angle_counts(evidence: Evidence) -> Iterator[Remark]:
    """The angle is in whole numbers, as the counts of an encoder are."""
    angle, axis = evidence.record.phi_m, evidence.axis
    if not np.array_equal(angle, np.rint(angle)) or np.ptp(angle) < MIN_COUNTS:
        return
    unit = evidence.units["angle"]
    yield Remark(
        "fatal",
        f"the angle is in whole numbers, over {plain(float(np.ptp(angle)), 6)} of them: counts rather than {unit}",
        "every angle, speed and inertia is wrong by the counts of a revolution",
        f"phi_m: {{name: ..., unit: counts, scale: ...}}, with the {unit} per count"
        f"{'' if axis.linear else ', 2 pi over the counts of a revolution'}",
    )


@check(unless=("angle_counts", "speed_scale"))
def angle_unit(evidence: Evidence) -> Iterator[Remark]:
    """The steps of the encoder fit a revolution of 360 rather than one of 2 pi."""
    step = evidence.report.quantum
    if evidence.axis.linear or not step or not evidence.report.reversals:
        return
    for counts, unit in ((360.0 / step, "deg"), (1.0 / step, "rev")):
        # in gear_ratio times a revolution, round counts say nothing
        if _round(counts) and not _round(2 * pi / step) and counts > 2 * pi / step / 60:
            yield Remark(
                "fatal" if unit == "deg" and _sure_counts(counts) else "warning",
                f"the encoder has {round(counts)} steps to {'360' if unit == 'deg' else 1}, and"
                f" {2 * pi / step:.6g} to 2 pi: the angle seems to be in {unit}",
                f"every angle and speed is wrong by a factor of {57.3 if unit == 'deg' else 6.28}",
                f"phi_m: {{name: ..., unit: {unit}}}",
            )
            return


def _sure_counts(counts: float) -> bool:
    """Whether no chance makes such counts: a power of two, met within few parts in a million."""
    bits = round(np.log2(counts))
    return bool(bits >= SURE_BITS and abs(counts / 2.0**bits - 1.0) < SURE_SAME)


def _round(counts: float) -> bool:
    return counts >= MIN_COUNTS and any(abs(counts / known - 1) < SAME_COUNTS for known in ROUND_COUNTS)


def fastest_turn(evidence: Evidence) -> float:
    """Largest speed [rad/s], as a mean over a few samples, so that a coarse encoder's steps do not count."""
    angle, width = evidence.record.phi_m, max(1, len(evidence.record) // 200)
    return float(np.abs(angle[width:] - angle[:-width]).max()) / (width * evidence.record.sampling_time)


@check(unless=("angle_counts", "angle_unit", "speed_scale"))
def speed_size(evidence: Evidence) -> Iterator[Remark]:
    """The motor or the arm would turn faster than machines do."""
    axis = evidence.axis
    if axis.linear:
        return
    fastest = fastest_turn(evidence)
    ratio = abs(axis.gear_ratio) if axis.gear_ratio is not None else 0.0
    if fastest > CHECK.max_motor_speed or ratio * fastest > CHECK.max_arm_speed:
        behind = f", and the arm at {plain(ratio * fastest)} rad/s" if ratio else ""
        surely = max(fastest / CHECK.max_motor_speed, ratio * fastest / CHECK.max_arm_speed) > CHECK.impossible
        yield Remark(
            "fatal" if surely else "warning",
            f"the motor would turn at {plain(fastest)} rad/s ({plain(fastest * 30 / pi)} rpm){behind}",
            "an angle in degrees makes every speed 57 times too large, and inertia and viscous friction too small",
            "give the unit of the angle, phi_m: {name: ..., unit: deg}, or that of time, t: {name: ..., unit: ms}",
        )


@check(
    unless=(
        "torque_copy",
        "torque_unrelated",
        "angle_counts",
        "angle_unit",
        "speed_size",
        "speed_exchanged",
        "speed_scale",
    )
)
def power_size(evidence: Evidence) -> Iterator[Remark]:
    """The drive would be stronger than those of any robot."""
    record = evidence.record
    power = np.abs(record.tau_m * evidence.derived_speed)
    most = float(np.percentile(power, 95))
    if most > CHECK.max_power:
        yield Remark(
            "fatal" if most > CHECK.impossible * CHECK.max_power else "warning",
            f"torque times speed reaches {plain(most / 1e3)} kW",
            "torque or angle are in another unit than they are taken to be",
            "give the units, such as tau_m: {name: ..., unit: mNm} and phi_m: {name: ..., unit: deg}",
        )


@check(unless=("torque_copy", "torque_levels", "torque_follows", "speed_exchanged"))
def torque_volts(evidence: Evidence) -> Iterator[Remark]:
    """The torque has the steps of a converter of so many bits over so many volts."""
    torque = evidence.record.tau_m
    step = quantum(torque)
    if not step or np.abs(torque).max() > max(CONVERTER_RANGES) / 2 * 1.001:
        return
    for span in CONVERTER_RANGES:
        for bits in CONVERTER_BITS:
            if any(abs(step / (span / steps) - 1) < SAME_COUNTS for steps in (2**bits, 2**bits - 1)):
                yield Remark(
                    "warning",
                    f"the torque's steps of {step:.4g} are those of a converter of {bits} bits over {span:g} V",
                    "volts that are taken for Nm scale every inertia and friction",
                    "tau_m: {name: ..., unit: V, scale: ...}, with the Nm per volt",
                )
                return


@check()
def gear_ratio(evidence: Evidence) -> Iterator[Remark]:
    """The arm's encoder moves by another share of the motor's angle than the gear ratio states."""
    record, declared = evidence.record, evidence.axis.gear_ratio
    if record.phi_a is None or declared is None or not np.ptp(record.phi_a):
        return
    motor, arm = record.phi_m - record.phi_m.mean(), record.phi_a - record.phi_a.mean()
    found = float(motor @ arm) / float(motor @ motor)
    if abs(float(motor @ arm)) < 0.9 * float(np.linalg.norm(motor) * np.linalg.norm(arm)):
        return
    if found / declared < 0 or not 1 / CHECK.scale < found / declared < CHECK.scale:
        yield Remark(
            "fatal",
            f"the arm moves by {found:.4g} of the motor's angle, and gear_ratio is {declared:.4g}"
            f"{'; the sign differs' if found / declared < 0 else ''}",
            "stiffness and arm inertia follow from a twist that is not there",
            "correct gear_ratio, or unit, sign and scale of phi_m and phi_a",
        )
    elif abs(found / declared - 1) > CHECK.notable_scale:
        yield Remark(
            "warning",
            f"the arm moves by {found:.4g} of the motor's angle, and gear_ratio is {declared:.4g}",
            f"arm inertia and stiffness are wrong by up to {plain(200 * abs(found / declared - 1), 2)} %",
            "correct gear_ratio, or the scale of phi_a",
        )
