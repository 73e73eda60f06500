"""Filters for noise of known size, for tests."""

from __future__ import annotations

from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.model.array import Array
from robotid.model.joint import Joint


def speed_whitening(joint: Joint, theta: Array, sampling_time: float, levels: tuple[float, float]) -> InnovationsFilter:
    """For white noises of the speed and of the torque of these variances."""
    return innovations_filter(torque_response(joint, theta, sampling_time, "speed"), NoiseLevels(*levels))
