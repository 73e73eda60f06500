"""Tuning constants of the misfit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MisfitSettings:
    """How finely a missing torque is sought, and along what it is shown."""

    coarse_powers: tuple[float, ...] = (-8.0, -6.0, -4.0, -2.0)  # of ten: steps of the torque, of the largest, a sample
    fine_powers: tuple[float, ...] = (-0.6, 0.0, 0.6)  # of ten, about the best step so far
    max_sweeps: int = 2  # of linearisation: the second hardly moves the torque
    telling_evidence: float = 1.0  # a logarithm: a sweep that gains less is the last
    small_residual: float = 1.5  # over the noise: with less, the simulated motion is as good as the measured one
    least_noise: float = 1e-9  # of the output's largest value: with less the numbers say nothing
    max_floor_ratio: float = 1.5  # of the quietest record's noise floor: more is misfit that passes for noise
    excerpt: int = 5_000  # samples that show how much the torque changes
    bins: int = 14  # of each kind of spacing: 20 to 40 in all, as many as a figure shows
    least_bin_share: float = 1 / 400  # of the samples, in every bin
    finest_bin: float = 0.01  # of the largest value: the finest bin beside zero
    standstill: float = 1e-3  # of the largest speed: where friction locks the motor, no torque is seen
    min_turns: float = 2.0  # of the motor, before what repeats every turn shows
    bins_a_turn: int = 36  # every ten degrees
    blocks: int = 20  # of a record, predicted one by one from all the others
    rare_share: float = 1e-3  # of the fullest bin: too little to make a mean of
    bands_an_octave: int = 2


MISFIT = MisfitSettings()
