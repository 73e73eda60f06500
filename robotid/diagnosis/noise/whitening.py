"""Whitening: segments of records, each with a filter after which a residual of pure noise is white with unit variance.

A diagnosis fits by the noise of its sensors, white on the output and on the recorded torque, which the joint
integrates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.whitening import InnovationsFilter, NoiseLevels, innovations_filter
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.derivation import Derivation
from robotid.signals.record import Quantity, Record


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A segment of a record, with the filter that whitens what noise leaves in its residual."""

    record: Record
    whitening: InnovationsFilter

    def energy(self, residual: Array) -> float:
        """Energy of a residual (n,), in variances of the noise."""
        white = self.whitening(residual)
        return float(white @ white)


UNIT_WHITENING = InnovationsFilter(np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]]), NoiseLevels(1.0))
"""The filter of an output noise of unit variance, which changes nothing: before the noise is known."""


def whitening(
    joint: Joint, theta: Array, output: Quantity, record: Record, levels: tuple[float, float]
) -> InnovationsFilter:
    """The filter for white noises of a record's output and torque of these variances. That of a derived speed is blue.

    theta : (p,) of the joint, linearised beside the record as it slips with its spring at rest. Without a torque noise,
    or where the Riccati equation has no solution, the filter only scales by the output noise.
    """
    response = torque_response(joint.along(record), theta, record.sampling_time, output, Derivation.of(record))
    variance, torque = levels
    sensed = variance if response.derivation is None else variance / response.derivation.gain
    return innovations_filter(response, NoiseLevels(sensed, torque))
