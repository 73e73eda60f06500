"""Tuning constants of the verdict, and of the experiments that it proposes."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True, slots=True)
class VerdictSettings:
    """When a misfit is something, and how much of it is listed."""

    max_rejected: int = 12  # effects that are listed as scored without success
    clear_misfit: float = 2.0  # noise floors: a misfit that large is something, even without a name or a shape
    partial_share: float = 0.5  # of the misfit's energy: causes that leave more explain only a part of it
    min_explained: float = 0.19  # share of the output's variance, a fit of 10 %: less, and there is no model to extend
    swamped_share: float = 0.1  # of the output's variance: errors of the torque that cause more hide what is missing
    astray_share: float = 1e-3  # of it: errors of the torque that cause more lead a simulation along another motion
    swamped_torque: float = 0.1  # of the recorded torque's root mean square: errors of it that are larger do so, too
    least_gain: float = 0.005  # % points of fit: less is a gain of 0.00, which is none
    negligible: float = 1e-6  # RMS error over the output's deviation: less is rounding, whatever its shape
    chance: float = 3.0  # standard deviations of the energy of noise: less is no misfit to have a share in
    telling: float = 25.0  # variances of the noise: energy of the difference that an experiment must make, five sigma
    speed_bandwidth: float = 10 * pi  # rad/s of the speed loop of an experiment, where none is known: 5 Hz


VERDICT = VerdictSettings()
