"""The frequency responses of a flexible joint's records, dry friction taken off and realisations averaged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.estimate.regressor import moving
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Motion
from robotid.signals.frf import Frf, combine, estimate_frf
from robotid.signals.record import Record

ALIKE = 0.01  # relative difference of reference RMS at which two records are realisations of one excitation


@dataclass(frozen=True, slots=True)
class ResponseOptions:
    """How responses are read. band [Hz] : where, None : the excitation's own. window [s] : length of a segment, None :
    the excitation's period. experiments : names of the records that tell several axes apart, in groups of as many as
    axes."""

    band: tuple[float, float] | None = None
    window: float | None = None
    experiments: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """A frequency response and the records, one or several realisations, behind it."""

    frf: Frf
    records: tuple[Record, ...]


def responses(
    joint: Joint,
    parameters: Parameters,
    records: Sequence[Record],
    band: tuple[float, float] | None = None,
    window: float | None = None,
) -> tuple[Response, ...]:
    """One response a record, or one for all records that are realisations of the same excitation.

    The nonlinear friction with the values of `parameters` is taken off the torque first: the rest is a linear joint's.
    """
    found = []
    for group in _realisations(records):
        frfs = tuple(estimate_frf(r, band, window, r.tau_m - nonlinear_torque(joint, parameters, r)) for r in group)
        together = len(frfs) > 1 and all(np.array_equal(f.frequency, frfs[0].frequency) for f in frfs)
        if together:
            found.append(Response(combine("+".join(r.name for r in group), frfs), group))
        else:
            found += [Response(frf, (record,)) for frf, record in zip(frfs, group, strict=True)]
    return tuple(found)


def nonlinear_torque(joint: Joint, parameters: Parameters, record: Record) -> Array:
    """Torque of the nonlinear effects that move with the rigid joint: dry friction, gravity, cogging [Nm], (n,)."""
    torque, zero = np.zeros(len(record)), np.zeros(len(record))
    for place, factor in moving(joint):
        if not place.term.linear:
            x, v = factor * record.phi_m, factor * record.dphi_m
            motion = Motion(x, v, zero, np.sign(v), record.t, np.zeros((0, len(record))))
            torque = torque + factor * place.term.torque(motion, list(parameters.values[place.at]))
    return torque


def _realisations(records: Sequence[Record]) -> Iterator[tuple[Record, ...]]:
    """Records in groups: equal period, band, length and reference RMS, yet another waveform."""
    left = list(records)
    while left:
        first = left.pop(0)
        same = [other for other in left if _one_excitation(first, other)]
        left = [other for other in left if other not in same]
        yield (first, *same)


def _one_excitation(a: Record, b: Record) -> bool:
    if a.period is None or a.ref is None or b.ref is None or len(a) != len(b):
        return False
    if (a.period, a.band, a.sampling_time) != (b.period, b.band, b.sampling_time):
        return False
    return bool(abs(np.std(a.ref) - np.std(b.ref)) <= ALIKE * np.std(a.ref))
