"""The same problem on every k-th sample, where that shows the motion as well: its first iterations cost a k-th."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.estimate.residual import OutputError
from robotid.model.array import Array
from robotid.signals.record import OPERATORS, Record


@dataclass(frozen=True, slots=True)
class CoarseLimits:
    """When a coarse grid will do.

    factors : of the sampling time, the first that will do is taken. samples : that must be left of each record.
    energy : share of a signal's energy that may lie above the highest frequency that the coarse grid shows.
    """

    factors: tuple[int, ...] = (8, 4, 2)
    samples: int = 500
    energy: float = 0.02


LIMITS = CoarseLimits()


def coarse_factor(problem: OutputError, limits: CoarseLimits = LIMITS) -> int:
    """How many intervals of the records one interval of a coarse grid may span, 1 where there is none."""
    if problem.whiten:  # the filters belong to the records' own sampling time
        return 1
    for factor in limits.factors:
        if all(_shows(record, problem, factor, limits) for record in problem.records):
            return factor
    return 1


def _shows(record: Record, problem: OutputError, factor: int, limits: CoarseLimits) -> bool:
    if len(record) < factor * limits.samples:
        return False
    measured = record.phi_m if problem.output == "position" else record.dphi_m
    return max(_hidden(record.tau_m, factor), _hidden(measured, factor)) <= limits.energy


def _hidden(signal: Array, factor: int) -> float:
    """Share of a signal's energy above the highest frequency of a grid this much coarser."""
    taper = np.hanning(len(signal))
    spectrum = np.abs(np.fft.rfft((signal - signal.mean()) * taper)) ** 2
    total = float(spectrum.sum())
    return float(spectrum[len(spectrum) // factor :].sum()) / total if total > 0.0 else 0.0


def coarsened(problem: OutputError, factor: int) -> OutputError:
    """The problem on every factor-th sample, the torque its mean between them; its cost is of the same size."""
    records = tuple(_coarse(record, factor) for record in problem.records)
    return replace(problem, records=records, weights=problem.weights * np.sqrt(factor))


def _coarse(record: Record, factor: int) -> Record:
    intervals = (len(record) - 1) // factor
    torque = record.tau_m[: intervals * factor].reshape(intervals, factor).mean(axis=1)
    nodes = coarse_nodes(len(record), factor)
    angle, speed, h = record.phi_m[nodes], record.dphi_m[nodes], record.sampling_time * factor
    return replace(
        record,
        sampling_time=h,
        tau_m=np.append(torque, record.tau_m[intervals * factor]),
        phi_m=angle,
        dphi_m=OPERATORS[record.speed_origin](angle, h) if record.speed_is_derived else speed,
        phi_a=None,
        ref=None,
        period=None,
        torque_steps=None,
        companions={name: one.piece(0, nodes.stop, factor) for name, one in record.companions.items()},
    )


def coarse_nodes(samples: int, factor: int) -> slice:
    """Of so many samples, those of a grid this much coarser."""
    return slice(0, (samples - 1) // factor * factor + 1, factor)


def refined(x: Array, factor: int, samples: int) -> Array:
    """Nodes (nx, n) of a coarse grid at all samples, (nx, samples), linear in between, the last ones held."""
    at = np.arange(samples) / factor
    return np.stack([np.interp(at, np.arange(x.shape[1]), row) for row in x])
