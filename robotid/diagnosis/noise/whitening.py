"""Whitening: segments of records, each with a filter after which a residual of pure noise is white with unit variance.

A diagnosis fits by the noise of its sensors, white on the output and on the recorded torque, which the joint
integrates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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


def whitening(joint: Joint, theta: Array, output: Quantity, record: Record, levels: NoiseLevels) -> InnovationsFilter:
    """The filter for noises of a record. That of a derived speed is blue.

    theta : (p,) of the joint in this record, linearised beside it as it slips with its spring at rest; levels.output is
    that of the angle where the speed was derived from it. Without a torque noise, or where the Riccati equation has no
    solution, the filter only scales by the output noise.
    """
    response = torque_response(joint.along(record), theta, record.sampling_time, output, Derivation.of(record))
    return innovations_filter(response, levels)


def sensed_variance(record: Record, output: Quantity, variance: float) -> float:
    """Variance of the noise of what the sensor shows, where that of the output is known."""
    derivation = Derivation.of(record, output)
    return variance if derivation is None else variance / derivation.gain


def with_typical_noise(
    segments: Sequence[Segment], records: Sequence[Record], joint: Joint, theta: Array, output: Quantity
) -> tuple[Segment, ...]:
    """Records that served for no fit, with the typical noise of the segments that did: their own residual may hold a
    misfit. The torque's noise is the largest of these.

    theta : (p,) of the joint.
    """
    found, filters = [], [segment.whitening for segment in segments]
    loudest = max((one.levels for one in filters), key=lambda levels: levels.torque + levels.red)
    for record in records:
        derivation = Derivation.of(record, output)
        usual = float(np.median([one.output_noise(derivation) for one in filters]))
        levels = replace(loudest, output=usual)
        own = joint.in_record(theta, record.name)
        filtered = whitening(joint, own, output, record, levels)
        found.append(Segment(record, filtered.allowing_for(max(one.excess for one in filters))))
    return tuple(found)
