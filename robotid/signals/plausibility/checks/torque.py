"""The torque against the motion that it makes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from robotid.model.array import Array
from robotid.numerals import plain
from robotid.signals.plausibility.check import Remark, check
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.regression import POSITION, VISCOUS, TorqueRegression, explained_share
from robotid.signals.plausibility.relation import odds
from robotid.signals.plausibility.settings import CHECK, DELAY

RECORDED = {"phi_m": "the motor angle", "dphi_m": "the motor speed", "phi_a": "the arm angle", "ref": "the reference"}
CURE = "name the column of the torque under columns: tau_m"
BY_CHANCE = "inertia and friction are what chance makes of them"
NOTHING = "the record holds no torque, and whatever is fitted follows from a column that was named twice"


@check()
def torque_copy(evidence: Evidence) -> Iterator[Remark]:
    """The torque is another recorded column, but for scale and offset."""
    record = evidence.record
    acceleration = np.gradient(evidence.derived_speed, record.sampling_time)
    if _is_copy(record.tau_m, record.t):
        yield Remark("fatal", "the torque grows as evenly as time does", NOTHING, CURE)
        return
    difference = np.gradient(record.dphi_m)
    if _is_copy(record.tau_m, difference) and not _oscillates(record.dphi_m, np.gradient(difference)):
        yield Remark(
            "fatal", "the torque is the derivative of the motor speed, but for scale and offset", NOTHING, CURE
        )
        return
    for signal, meaning in RECORDED.items():
        values = getattr(record, signal)
        # a pure oscillation makes every torque of an inertia a multiple of the angle
        if values is None or not _is_copy(record.tau_m, values) or _oscillates(values, acceleration):
            continue
        yield Remark("fatal", f"the torque is a copy of {meaning} ({signal}), but for scale and offset", NOTHING, CURE)
        return


def _is_copy(torque: Array, other: Array) -> bool:
    inner = slice(2, -2)  # a derivative is another one at the ends of a record
    return bool(1.0 - _share_of(other[inner], torque[inner]) <= CHECK.copy)


def _share_of(other: Array, torque: Array) -> float:
    """Share of a torque's variance (n,) that a constant and one other signal (n,) explain."""
    if not np.ptp(other):
        return 0.0
    return explained_share(np.vstack([np.ones_like(other), other - other.mean()]), torque)


def _oscillates(values: Array, acceleration: Array) -> bool:
    inner = slice(2, -2)
    columns = np.vstack([np.ones_like(values), acceleration])[:, inner]
    return explained_share(columns, values[inner]) > 0.99


@check(unless=("torque_copy", "speed_exchanged"))
def torque_spikes(evidence: Evidence) -> Iterator[Remark]:
    """Single samples of the torque are far off their neighbours."""
    torque = evidence.record.tau_m
    off = np.abs(torque - scipy.signal.medfilt(torque, 5))[2:-2]
    usual, size = np.percentile(off, 99), np.percentile(np.abs(torque), 99)
    wild = 2 + np.flatnonzero((off > CHECK.spike * usual) & (off > CHECK.spike_peak * size))
    if not len(wild):
        return
    worst = int(wild[np.argmax(np.abs(torque[wild]))])
    energy = float(np.sum(torque[wild] ** 2) / np.sum(torque**2))
    many = f"{len(wild)} samples of the torque stand" if len(wild) > 1 else "a sample of the torque stands"
    peak = f"{plain(float(torque[worst]))} {evidence.units['torque']} at {worst * evidence.record.sampling_time:.4g} s"
    yield Remark(
        "fatal" if energy > CHECK.spike_energy else "warning",
        f"{many} alone: {peak}, where 99 % of all are below {plain(float(size))}",
        "a fit explains these samples rather than the motion",
        "cut the record by start and stop, or remove these lines from the file",
    )


@check(unless=("torque_copy", "torque_spikes", "speed_exchanged"))
def torque_follows(evidence: Evidence) -> Iterator[Remark]:
    """The torque follows speed or angle alone, and shows no inertia.

    As far as the regression sees them: above its cut-off either may be noise.
    """
    found = evidence.regression
    if found.inertia.ratio > CHECK.sure:
        return
    torque, columns = evidence.clearest.torque, evidence.clearest.columns
    for values, meaning in ((columns[VISCOUS], "speed"), (columns[POSITION], "angle")):
        unit = evidence.units[meaning]
        share = _share_of(values, torque)
        if share < CHECK.follows or (meaning == "angle" and found.friction_power.ratio > CHECK.sure):
            continue
        slope = float(np.polyfit(values, torque, 1)[0])
        same = abs(slope - 1.0) < CHECK.same_numbers
        yield Remark(
            "fatal" if same else "warning",
            f"the torque is {plain(slope)} {evidence.units['torque']} per {unit} of the {meaning}, which explains"
            f" {plain(100 * share)} % of it, and shows no inertia{': the same numbers' if same else ''}",
            f"where the column is another recording of the {meaning}, no parameter means anything",
            CURE,
        )
        return


@check(unless=("torque_copy", "torque_spikes", "torque_follows", "torque_elsewhere", "speed_exchanged"))
def torque_unrelated(evidence: Evidence) -> Iterator[Remark]:
    """The motion explains the torque no better than one that was shifted in time.

    That of a rigid axis or of a joint with a spring: no torque of a joint that rings is unrelated to its motion.
    """
    found, belongs = evidence.regression, evidence.regression.relation
    share = belongs.explained
    whose = "the torque" if found.left == 1.0 else "what companions leave of the torque"
    explained = f"{plain(100 * share, 2)} % of {whose}"
    if (exchanged := _exchanged_share(evidence)) is not None:
        yield Remark(
            "fatal",
            f"the motion explains {plain(100 * evidence.clearest.share, 2)} % of {whose}, and"
            f" {plain(100 * exchanged)} % where the columns of torque and angle are exchanged",
            BY_CHANCE,
            "exchange the columns of tau_m and phi_m",
        )
        return
    if not belongs.is_determined:
        yield Remark(
            "warning",
            "the record is too short, or its torque too slow, to tell whether torque and motion belong together",
            "the torque of another recording would not be noticed",
            "record a longer motion, or one of more frequencies",
        )
        return
    signs, chance = _signs(found), _hardly_above_chance(found)
    # one sine wave explains most of every shift of another of its period
    periodic = np.abs(signs).max() < CHECK.sure and CHECK.lone_chance * belongs.by_chance >= 1.0
    if periodic and not chance and share > CHECK.follows:
        yield Remark(
            "warning",
            f"the motion explains {explained}, and {plain(100 * belongs.by_chance, 2)} % of a torque that is shifted in"
            " time: it hardly has more than one frequency",
            "neither inertia and friction nor whether torque and motion belong together can be found from it",
            "record a motion of many frequencies, such as robotid excite makes",
        )
    elif _is_chance(found):
        yield Remark(
            "fatal",
            f"the motion explains {explained}, and {plain(100 * belongs.by_chance, 2)} % of a torque that is shifted in"
            f" time{'; the torque is white noise' if found.white else ''}",
            BY_CHANCE,
            "name the columns of one recording under columns: tau_m and phi_m",
        )
    elif found.left * (1.0 - share) > 1.0 - CHECK.weak:
        yield Remark(
            "warning",
            f"the motion explains {explained}",
            "the rest is noise or comes from elsewhere, and parameters take part of it",
            "check the columns, and record a motion that takes more torque",
        )


def _exchanged_share(evidence: Evidence) -> float | None:
    """Share of the torque that a rigid axis explains where torque and angle are exchanged; None where they are not."""
    if evidence.regression.inertia.ratio > CHECK.sure:
        return None
    regression, share = evidence.exchanged
    better = share > CHECK.follows and odds(share) > CHECK.lone_chance * odds(evidence.clearest.share)
    return share if better and regression.inertia.ratio > CHECK.sure else None


def _signs(found: TorqueRegression) -> Array:
    """Inertia and friction's power in standard deviations, (2,)."""
    return np.array([found.inertia.ratio, found.friction_power.ratio])


def _hardly_above_chance(found: TorqueRegression) -> bool:
    """Whether the motion explains little, and of a shifted torque nearly as much."""
    belongs = found.relation
    return belongs.explained < CHECK.weak and (
        belongs.explained < CHECK.unexplained or belongs.above_chance < CHECK.chance
    )


def _is_chance(found: TorqueRegression) -> bool:
    """Whether what the motion explains of the torque may be chance: it is little, or shows no joint."""
    if not found.relation.is_determined:
        return False
    return not found.stands_out or _hardly_above_chance(found)


@check(unless=("torque_copy", "speed_exchanged"))
def torque_levels(evidence: Evidence) -> Iterator[Remark]:
    """The torque takes two or three values only."""
    torque = evidence.record.tau_m
    levels = np.unique(torque[: min(len(torque), 100_000)])
    if len(levels) <= CHECK.few_levels:
        listed = ", ".join(f"{plain(level)}" for level in levels)
        yield Remark(
            "warning",
            f"the torque takes {len(levels)} values only: {listed} {evidence.units['torque']}",
            "it is a command that is switched, or a flag, and what the drive made of it is not in the record",
            "name the column of the measured torque under columns: tau_m",
        )


@check(unless=("torque_copy", "torque_unrelated", "torque_follows", "speed_exchanged"))
def torque_sign(evidence: Evidence) -> Iterator[Remark]:
    """The torque takes power from a joint that can only absorb it (passivity), or drives it backwards.

    What companions leave is no evidence against the sign of a torque that has the right one as a whole.
    """
    found, whole = evidence.regression, evidence.regression_alone
    inertia, power = found.inertia.ratio, found.friction_power.ratio
    right = max(inertia, power, whole.inertia.ratio, whole.friction_power.ratio) > CHECK.sure
    if not right and min(inertia, power) < -CHECK.sure:
        parts = []
        if inertia < -CHECK.sure:
            parts.append(f"an inertia of {plain(found.inertia.value)} {evidence.units['inertia']}{_sure(inertia)}")
        if power < -CHECK.sure:
            parts.append(f"friction that supplies {plain(-found.friction_power.value)} W{_sure(power)}")
        yield Remark(
            "fatal",
            f"torque and motion ask for {' and '.join(parts)}: one of them has the wrong sign",
            "no joint is like that, and its simulation diverges",
            "give tau_m a negative scale, tau_m: {name: ..., scale: -1}; or phi_m, if that is the one",
        )
    elif inertia > CHECK.sure and power < -CHECK.sure:
        late = found.delay
        much = f"; the angle is {plain(1e3 * late.value, 2)} ms late against it" if late.ratio > CHECK.sure else ""
        yield Remark(
            "warning",
            f"friction supplies {plain(-found.friction_power.value)} W{_sure(power)}, while the inertia is"
            f" positive{much}",
            "a delay between torque and angle passes for negative friction",
            "record both with one clock, or add the effect sensor_delay to the model",
        )


@check(unless=("torque_copy", "torque_spikes", "torque_follows", "speed_exchanged"))
def angle_is_speed(evidence: Evidence) -> Iterator[Remark]:
    """The motion explains the torque surely better where the column of the angle is taken for the speed."""
    rival = evidence.angle_as_speed
    if rival is None or min(rival.inertia.ratio, rival.gain.ratio) < CHECK.sure:
        return
    yield Remark(
        "fatal",
        f"the motion explains all but {plain(100 * (1.0 - rival.recorded), 2)} % of the torque, and all but"
        f" {plain(100 * (1.0 - rival.explained), 2)} % where the column of the angle is taken for a speed",
        "viscous friction takes the place of the inertia, and nothing takes that of dry friction",
        "name the column of the motor's angle under columns: phi_m, or integrate the speed first",
    )


@check(unless=("torque_copy", "torque_spikes", "torque_follows", "speed_exchanged", "angle_is_speed"))
def torque_elsewhere(evidence: Evidence) -> Iterator[Remark]:
    """The motion explains the torque of another time surely better than that of its own."""
    rival, h, chance = evidence.torque_shifted, evidence.record.sampling_time, _is_chance(evidence.regression)
    if rival is None or rival.explained < DELAY.explained:
        return
    if abs(rival.shift) <= DELAY.max_shift * h and not chance:
        return  # a delay, and read to a fraction of a sample
    if min(rival.inertia.ratio, rival.gain.ratio) < CHECK.sure:
        return
    when = "later" if rival.shift > 0.0 else "earlier"
    yield Remark(
        "fatal" if chance or rival.recorded < DELAY.explained else "warning",
        f"the motion explains {plain(100 * rival.recorded)} % of the torque, and"
        f" {plain(100 * rival.explained)} % of that which is {plain(abs(rival.shift))} s {when} in the file",
        "torque and motion of different times are compared",
        f"set torque_delay: {rival.shift:.4g} of the record, or join the files by their times",
    )


@check(
    unless=(
        "torque_copy",
        "torque_spikes",
        "torque_follows",
        "torque_unrelated",
        "torque_levels",
        "torque_sign",
        "torque_elsewhere",
        "speed_exchanged",
    )
)
def torque_late(evidence: Evidence) -> Iterator[Remark]:
    """The torque was recorded later or earlier than the motion that it makes."""
    found, h = evidence.torque_delay, evidence.record.sampling_time
    if abs(found.value) < CHECK.late * h or abs(found.ratio) < CHECK.sure:
        return
    where = "late" if found.value > 0.0 else "early"
    yield Remark(
        "warning",
        f"the torque is {plain(1e3 * abs(found.value), 2)} ms ({plain(abs(found.value) / h, 2)} samples) {where}"
        " against the motion that it makes",
        "a delay passes for friction, or for a torque that lags",
        f"set torque_delay: {found.value:.2g} of the record, or record both by one device",
    )


def _sure(ratio: float) -> str:
    """How sure a sign is, as part of a sentence."""
    return f" ({plain(abs(ratio), 2)} standard deviations from zero)" if np.isfinite(ratio) else ""
