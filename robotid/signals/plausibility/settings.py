"""Tuning constants of the checks."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RegressionSettings:
    """How the torque is compared with the motion that it makes."""

    cutoffs: int = 6  # low-pass filters that are tried; the one at which the torque is explained best is kept
    min_periods: float = 10.0  # of the lowest cut-off in a record
    max_samples: int = 40_000  # of a record after decimation: more add nothing to a sign
    beside_companions: int = 200_000  # samples from the middle of a record: a dozen columns a companion are dear
    samples_a_column: int = 8  # least number after decimation
    blocks: int = 24  # of a record, whose scores give the standard deviations
    min_direction: float = 0.03  # singular value, relative to the largest, below which columns are indistinguishable
    max_share: float = 0.1  # of a sought combination along such a direction: more, and it is not determined
    shifts: int = 19  # of the torque against the motion, which show what an unrelated torque would explain


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """From which number on a finding is reported."""

    sure: float = 5.0  # standard deviations by which a sign must be wrong
    unexplained: float = 0.03  # share of the torque's variance: less, and the motion does not explain the torque
    chance: float = 1.5  # times what a shifted torque explains, as odds: less is chance
    weak: float = 0.5  # share of the torque's variance: less is remarked
    lone_chance: float = 2.0  # the same: less is chance, where no sign of a joint is sure
    copy: float = 1e-10  # share of a column's variance: a difference that is only rounding
    follows: float = 0.98  # share of the torque's variance that speed or angle alone explains
    same_numbers: float = 0.02  # deviation of a torque's slope over another column from 1: the same numbers
    spike: float = 50.0  # times the 99th percentile of the deviations from the neighbours' median
    spike_peak: float = 5.0  # times the 99th percentile of the torque itself
    spike_energy: float = 0.5  # share of the torque's energy in spikes: more, and the rest hardly counts
    few_levels: int = 3  # distinct values of a torque that is only switched
    same_speed: float = 0.5  # correlation with the angle's derivative: less, and the speed is another signal
    surely_same: float = 0.97  # the same: more, and it is the speed of this angle
    scale: float = 1.5  # recorded over derived speed, or its inverse, from which it is no calibration error
    notable_scale: float = 0.03  # deviation of the same from 1
    factor: float = 0.02  # relative deviation at which a known factor is recognised
    geared: float = 0.2  # gear ratio from which on a motor-side inertia is small
    max_motor_inertia: float = 1.0  # kg m2 at the motor of a geared joint: a rotor of half a tonne has that
    fast: float = 10.0  # rad/s: what has more inertia than that, and no gear, turns more slowly
    max_power: float = 1e5  # W: no robot joint has a drive of 100 kW
    max_motor_speed: float = 2500.0  # rad/s, 24,000 rpm
    impossible: float = 10.0  # times the largest power or speed, from which there is no doubt
    slow_sampling: float = 0.1  # s, unusual; ten times that shows nothing of a joint
    fast_sampling: float = 1e-6  # s, unusual
    max_arm_speed: float = 60.0  # rad/s behind a gear
    min_inertia: float = 1e-8  # kg m2: that of the smallest motors is ten times larger
    jitter: float = 0.01  # RMS deviation of a sampling interval, share of the sampling time
    much_jitter: float = 0.3  # the same, from which resampling on the stamps no longer repairs it
    missing: float = 0.001  # share of the samples that were filled in
    coarse: float = 0.1  # share of the speed's RMS that the encoder's quantum makes
    saturated: float = 0.05  # share of the samples
    still: float = 0.5  # share of the samples at rest
    repeat: float = 0.999  # correlation of two speeds that are the same motion
    turns: float = 5.0  # of another axis, behind its gear: cables break
    coldest: float = -60.0  # degC, of a gear or motor
    hottest: float = 200.0  # degC: insulation of windings fails
    late: float = 0.5  # samples of delay between torque and angle, and speed and angle, that are reported


@dataclass(frozen=True, slots=True)
class DelaySettings:
    """How the delay of a torque is found."""

    max_samples: int = 500_000  # of a record, in stretches from all over it: more tell the same
    max_shift: int = 20  # samples to either side
    samples_a_shift: int = 20  # of a record, at least
    explained: float = 0.9  # share of the torque that the motion explains: less, and the axis is not rigid
    blocks: int = 16  # of a record, whose scores give the standard deviation
    slow: float = 0.2  # of a record's RMS speed: that about which friction may differ from what it is when fast


REGRESSION = RegressionSettings()
DELAY = DelaySettings()
CHECK = CheckSettings()
