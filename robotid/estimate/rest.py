"""Where a motor rests: dry friction takes any torque up to its own there, and the torque tells nothing of a motion."""

from __future__ import annotations

import numpy as np

from robotid.estimate.cutoff import SAMPLES_A_PERIOD
from robotid.model.array import Mask
from robotid.signals.angle_noise import angle_noise
from robotid.signals.record import Record

AT_REST = 6.0  # standard deviations of its noise over which an angle at rest spreads


def at_rest(record: Record) -> Mask:
    """Where the angle keeps within its noise for two periods of the finest motion, (n,): a reversal passes sooner."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # late: a configuration is read without it

    noise = np.sqrt(angle_noise(record.phi_m, record.sampling_time) * 0.5 / record.sampling_time)
    samples = int(2 * SAMPLES_A_PERIOD)
    range_of = maximum_filter1d(record.phi_m, samples) - minimum_filter1d(record.phi_m, samples)
    return np.asarray(maximum_filter1d(range_of <= AT_REST * noise, samples, origin=-(1 - samples % 2)))
