"""The frequency responses of a flexible joint's records, dry friction taken off and realisations averaged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.estimate.cutoff import finest, noise_limit
from robotid.estimate.regressor import moving
from robotid.estimate.rest import at_rest
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Motion
from robotid.signals.differentiate import central_difference, low_pass
from robotid.signals.frf import Frf, combine, estimate_frf
from robotid.signals.record import Record

LINES = 10.0  # of a record, below which no noise limit is sought
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
        frfs = tuple(_response(joint, parameters, record, band, window) for record in group)
        together = len(frfs) > 1 and all(np.array_equal(f.frequency, frfs[0].frequency) for f in frfs)
        if together:
            found.append(Response(combine("+".join(r.name for r in group), frfs), group))
        else:
            found += [Response(frf, (record,)) for frf, record in zip(frfs, group, strict=True)]
    return tuple(found)


def _response(
    joint: Joint, parameters: Parameters, record: Record, band: tuple[float, float] | None, window: float | None
) -> Frf:
    limit = _noisy_from(record)
    torque = record.tau_m - _nonlinear_torque(joint, parameters, record, limit)
    return estimate_frf(record, band, window, torque, highest=limit)


def _noisy_from(record: Record) -> float:
    """Frequency [Hz] above which the motion is lost in the noise of the angle, infinite where the sampling tells of
    none. Of such noise a controller makes torque, and the response is then that of the controller, upside down."""
    highest = finest(record.sampling_time)
    limit = noise_limit(record, min(LINES / record.duration, highest), highest)
    return limit if limit < highest else np.inf


def _direction(record: Record, limit: float) -> Array:
    """Direction of a motion by its angle, (n,), zero where it rests. limit : from where the angle is noisy [Hz]."""
    h = record.sampling_time
    angle = low_pass(record.phi_m, h, min(limit, finest(h)))
    return np.where(at_rest(record), 0.0, np.sign(central_difference(angle, h)))


def nonlinear_torque(joint: Joint, parameters: Parameters, record: Record) -> Array:
    """Torque of the nonlinear effects that move with the rigid joint: dry friction, gravity, cogging [Nm], (n,).

    Where the motor may rest, for its speed is no more than the noise of the angle makes of it, dry friction takes of
    the recorded torque what it can.
    """
    return _nonlinear_torque(joint, parameters, record, _noisy_from(record))


def _nonlinear_torque(joint: Joint, parameters: Parameters, record: Record, limit: float) -> Array:
    """The same. limit : from where the angle is noisy [Hz]."""
    direction = _direction(record, limit)
    rests = direction == 0.0
    if not rests.any():
        return _along(joint, parameters, record, direction)
    ways = [_along(joint, parameters, record, np.where(rests, s, direction)) for s in (-1.0, 1.0)]
    return np.where(rests, np.clip(record.tau_m, np.minimum(*ways), np.maximum(*ways)), ways[0])


def _along(joint: Joint, parameters: Parameters, record: Record, direction: Array) -> Array:
    """The same in directions (n,)."""
    torque, zero = np.zeros(len(record)), np.zeros(len(record))
    for place, factor in moving(joint):
        if not place.term.linear:
            x, v = factor * record.phi_m, factor * record.dphi_m
            motion = Motion(x, v, zero, np.sign(factor) * direction, record.t, np.zeros((0, len(record))))
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
