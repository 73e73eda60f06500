"""Where the parallel filter of step 1 cuts off: above the motion, below the noise that differentiation makes loud.

The columns of the regression are made of the recorded angle. Noise on them biases the estimate towards zero (errors in
variables), the acceleration's first of all: its noise grows with the fifth power of the cut-off.
"""

from __future__ import annotations

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.linear_regression import relative_error, too_few
from robotid.estimate.regressor import regress
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.signals.angle_noise import acceleration_noise, angle_noise
from robotid.signals.differentiate import ParallelFilter, bandwidth, decimate, differentiate
from robotid.signals.record import Record

CUTOFF_CANDIDATES = 8  # tried for a flexible joint
MIN_PERIODS = 10.0  # of the lowest of them, in a record
MAX_NOISE_SHARE = 0.05  # of the acceleration's variance: the share by which an inertia comes out too small
SAMPLES_A_PERIOD = 12.0  # of the cut-off, at least: with fewer, central differences are too small by a tenth
NOISE_STEP = 1.15  # factor from one cut-off to the next as they are tried against the noise


def choose_cutoff(joint: Joint, parameters: Parameters, record: Record, order: int = 4) -> float:
    """Cut-off [Hz] of the parallel filter: 99 % of the torque's energy lies below, or as much as the noise allows.

    A flexible joint is rigid only well below its notch, which is not known yet: there, of several cut-offs up to
    this one, the one at which the rigid model explains the torque best. Raises NumericsError for a constant torque.
    """
    highest = bandwidth(record.tau_m, record.sampling_time)
    if highest <= 0:
        raise NumericsError("the torque is constant", where=record.name, hint="record a motion that excites the joint")
    lowest = MIN_PERIODS / record.duration  # below it, too few samples are left
    highest = min(highest, noise_limit(record, min(lowest, highest), highest, order))
    if joint.masses == 1:
        return highest
    candidates = np.geomspace(max(lowest, highest), lowest, CUTOFF_CANDIDATES).tolist()
    return float(min(candidates, key=lambda cutoff: _misfit(joint, parameters, record, ParallelFilter(cutoff, order))))


def noise_limit(record: Record, lowest: float, highest: float, order: int = 4) -> float:
    """The highest cut-off [Hz] at which the acceleration is more than noise; where there is none, the best there is.

    lowest, highest [Hz] : between which it is sought.
    """
    h = record.sampling_time
    density = angle_noise(record.phi_m, h)
    highest = max(lowest, min(highest, finest(h)))
    shares = []
    cutoffs = np.geomspace(highest, lowest, 1 + int(np.ceil(np.log(highest / lowest) / np.log(NOISE_STEP)))).tolist()
    for cutoff in cutoffs:
        seen = float(np.var(_acceleration(record.phi_m, h, cutoff, order)))
        shares.append(acceleration_noise(density, cutoff) / max(seen, 1e-300))
        if shares[-1] <= MAX_NOISE_SHARE:
            return float(cutoff)
    return float(cutoffs[int(np.argmin(shares))])


def finest(sampling_time: float) -> float:
    """The highest frequency [Hz] at which central differences tell a motion."""
    return 1 / (SAMPLES_A_PERIOD * sampling_time)


def _acceleration(angle: Array, sampling_time: float, cutoff: float, order: int) -> Array:
    """As the regression sees it, without the ends that the filter spoils."""
    return decimate(differentiate(angle, sampling_time, cutoff, order).acceleration, sampling_time, cutoff, order)


def _misfit(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> float:
    """Of the rigid model at a cut-off, infinite where too little of the record is left to fit it."""
    g = regress(joint, parameters, record, parallel)
    if too_few(g.columns):
        return np.inf
    theta = np.linalg.lstsq(g.columns.T, g.tau, rcond=None)[0]
    return float(relative_error(g.tau - theta @ g.columns, g.torque) / np.sqrt(1 - len(theta) / len(g.tau)))
