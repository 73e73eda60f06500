"""What errors in proportion to the recorded torque may pass for.

A measured torque errs by a gain, by ripples along the motor's angle, and from sample to sample by a share of itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from robotid.diagnosis.events.settings import EVENTS
from robotid.model.array import Array, Complex
from robotid.signals.record import Record

PARTS = 41
"""Of errors in proportion to the torque that are tried, from none to all: enough for any interval."""


@dataclass(frozen=True, slots=True, eq=False)
class TorqueErrors:
    """Integrals up to times (t,) [s] of the square of a record's torque, (t,) [Nm2 s], and of the torque times exp(i k
    angle of the motor), k from 0, (k, t) [Nm s]."""

    times: Array
    squared: Array
    rippled: Complex

    @classmethod
    def of(cls, segments: Sequence[Record]) -> TorqueErrors:
        """segments : all of a record, in order of time; the torque is held between samples, and zero between them."""
        times = np.concatenate([np.append(one.t, one.t[-1] + one.sampling_time) for one in segments])
        held = [one.sampling_time * np.pad(rippled(one), ((0, 0), (1, 0))) for one in segments]
        square = [one.sampling_time * np.append(0.0, one.tau_m**2) for one in segments]
        return cls(times, np.cumsum(np.concatenate(square)), np.cumsum(np.concatenate(held, axis=1), axis=1))

    def mean_squares(self, begin: Array, end: Array) -> Array:
        """Of errors as large as the torque between times (k,) [Nm2], (e, k): of ones that are independent from sample
        to sample, and of ones that ripple along the motor's angle, from a gain on."""

        def mean(course: Array | Complex) -> Array:
            return np.asarray(
                (np.interp(end, self.times, course) - np.interp(begin, self.times, course)) / (end - begin)
            )

        return np.stack([mean(self.squared), *(np.abs(mean(course)) ** 2 for course in self.rippled)])


def rippled(one: Record) -> Complex:
    """The torque as it would err if it rippled along the motor's angle, (k, n)."""
    turns = np.arange(EVENTS.ripples + 1)[:, None] * one.phi_m
    return np.asarray(one.tau_m * np.exp(1j * turns))


def more_by_chance(own: Array, elsewhere: Array, energies: Array, counts: Array, usual: float) -> float:
    """By how much more than `usual`, which the like have in the mean, a bump explains by chance where part of that is
    errors in proportion to the torque, and these are larger there than in the mean: the most within a 95 % interval of
    the likelihood of their kind and part, each energy being that of one normal number.

    own (e,), elsewhere (e, k) : energies of errors as large as the torque where the bump is, and the like are, of each
    kind; energies (k,) : that the like explain; counts (k,) : for how many independent ones each stands.
    """
    mean = np.maximum(elsewhere @ counts / counts.sum(), 1e-300)
    tried = np.linspace(0.0, usual - 1.0, PARTS)
    levels = usual + tried[:, None, None] * (elsewhere / mean[:, None] - 1.0)  # part, kind, window
    unlikelihood = (np.log(levels) + energies / levels) @ counts
    likely = unlikelihood <= unlikelihood.min() + chi2.isf(0.05, 1)
    return float(max(0.0, np.where(likely, tried[:, None] * (own / mean - 1.0), 0.0).max()))
