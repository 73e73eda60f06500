"""The tuning of noise levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class LevelSettings:
    """sweeps : of whitening and fitting, at most. settled : relative change of a level at which they end. skipped :
    lowest frequencies of a record, which first states and parameters shape, where their columns are not given.
    crossings : how many frequencies, below which the torque's noise prevails, the first sweep tries. corner_step :
    factor from one corner of the red noise to the next; fine_step : the same in a mean over the corners. reach, scales
    : decades on either side of the likeliest level of the torque's noise, and how many levels in them, over which its
    mean is taken. full : leverage from which a frequency tells nothing. band : relative width of the bands over which
    spectra are averaged. unlikely : factor by which the mean square of the innovations is off 1 where levels are not
    the likeliest, and are sought from another start. left_out : share of belief in the least likely levels that a mean
    over them leaves out.
    clip : robust standard deviations beyond which an innovation counts no more than there, so that bursts, as a model
    that reverses at the wrong time leaves them, do not pass for noise; infinite, and all count. bands, lines, slack :
    into how many parts the highest octave of a torque is cut at most, how many frequencies each has at least, and the
    factor on what the speed leaves there, which allows for its scatter in a short record."""

    sweeps: int = 8
    settled: float = 0.02
    skipped: int = 4
    crossings: int = 7
    corner_step: float = 3.0
    fine_step: float = 1.5
    reach: float = 3.0
    scales: int = 37
    full: float = 0.8
    band: float = 0.03
    unlikely: float = 1.5
    left_out: float = 0.02
    clip: float = np.inf
    bands: int = 8
    lines: int = 8
    slack: float = 2.0


SETTINGS = LevelSettings()
MEDIAN, SMALLEST = 0.455, 1e-240  # of a squared standard normal; a variance that stands for none, and has an inverse
