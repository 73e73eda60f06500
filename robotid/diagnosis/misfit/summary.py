"""The misfit of a model: the missing torque of every record, and what orders it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.misfit.location import locate
from robotid.diagnosis.misfit.missing_torque import MissingTorque, missing_torque
from robotid.diagnosis.misfit.settings import MISFIT
from robotid.diagnosis.noise.noise_floor import Noise, noise_levels
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.model.units import on_axis
from robotid.parallel import each
from robotid.signals.record import Quantity
from robotid.signals.trace import Trace, downsampled


@dataclass(frozen=True, slots=True, eq=False)
class MisfitLocation:
    """Where a model is wrong.

    floors : noise floor by record, in the unit of the output; missing : the missing torque by record, and what
    causes supply of it [Nm]; twist [rad] : of a flexible joint's gear at the same times; curves : along every variable,
    what orders it best first.
    """

    floors: dict[str, float]
    missing: dict[str, Trace]
    twist: dict[str, Array]
    curves: tuple[Curve, ...]


def locate_misfit(
    before: Sequence[SimulatedSegment],
    after: Sequence[SimulatedSegment],
    output: Quantity,
    known: Mapping[str, Noise] | None = None,
) -> MisfitLocation:
    """The misfit of simulated segments against the noise, as a torque, and along the variables of the motion.

    after : the same segments, or some of them, once the causes are there; where there is less misfit to hide it, the
    noise shows better. known : the noise by record, where it is known; else it is read off the spectrum.
    """
    if known is None:
        noises_after = noise_levels(after, output) if after else ()
        behind = {_key(segment): noise for segment, noise in zip(after, noises_after, strict=True)}
        pairs = zip(before, noise_levels(before, output), strict=True)
        noises = tuple(behind.get(_key(one), noise) for one, noise in pairs)
        floors = limited_floors(_record_floors(before, noises))
    else:
        noises, noises_after = (tuple(known[one.record.name] for one in part) for part in (before, after))
        floors = _record_floors(before, noises)
    missing = _missing([*before, *after], [*noises, *noises_after], output)
    found = [one for one in missing[: len(before)] if one is not None]
    left = _torques(one for one in missing[len(before) :] if one is not None)
    traces = {name: _trace(name, found, left) for name in _torques(found)}
    return MisfitLocation(
        floors=floors,
        missing=traces,
        twist={name: _twist(name, found, trace.t) for name, trace in traces.items() if _flexible(name, found)},
        curves=locate(found) if found else (),
    )


def _key(segment: SimulatedSegment) -> tuple[str, float]:
    """What distinguishes a segment of a record from all others."""
    return segment.record.name, segment.record.begin


def _record_floors(segments: Sequence[SimulatedSegment], noises: Sequence[Noise]) -> dict[str, float]:
    """RMS of the noise floors of each record's segments."""
    floors: dict[str, list[float]] = {}
    for segment, noise in zip(segments, noises, strict=True):
        floors.setdefault(segment.record.name, []).append(noise.floor)
    return {name: float(np.sqrt(np.mean(np.square(found)))) for name, found in floors.items()}


def limited_floors(floors: dict[str, float]) -> dict[str, float]:
    """Noise floors by record, none far above the quietest: the same sensors made all records."""
    least = min(floors.values())
    return {name: min(floor, MISFIT.max_floor_ratio * least) for name, floor in floors.items()}


def _missing(
    segments: Sequence[SimulatedSegment], noises: Sequence[Noise], output: Quantity
) -> list[MissingTorque | None]:
    """Of each segment, None where no torque makes the model follow the measurement."""
    samples = sum(len(one.residual) for one in segments) // max(1, len(segments))
    return each(_missing_of, output, list(zip(segments, noises, strict=True)), samples=samples)


def _missing_of(output: Quantity, item: tuple[SimulatedSegment, Noise]) -> MissingTorque | None:
    segment, noise = item
    try:
        return missing_torque(segment, output, noise.output, noise.torque)
    except NumericsError:
        return None


def _torques(found: Iterable[MissingTorque]) -> dict[str, Array]:
    """Missing torque by record, (n,)."""
    parts: dict[str, list[Array]] = {}
    for one in found:
        parts.setdefault(one.segment.record.name, []).append(one.torque)
    return {name: np.concatenate(torques) for name, torques in parts.items()}


def _flexible(name: str, found: Sequence[MissingTorque]) -> bool:
    return all(one.segment.trajectory.joint.masses > 1 for one in found if one.segment.record.name == name)


def _twist(name: str, found: Sequence[MissingTorque], times: Array) -> Array:
    """The twist of the gear under the missing torque, at some of a record's times (n,), (n,)."""
    own = [one for one in found if one.segment.record.name == name]
    t = np.concatenate([one.segment.record.t for one in own])
    return np.asarray(np.concatenate([one.x[0] for one in own])[np.searchsorted(t, times)])


def _trace(name: str, found: Sequence[MissingTorque], left: dict[str, Array]) -> Trace:
    """The missing torque of one record over time, and what of it is no longer left."""
    own = [one for one in found if one.segment.record.name == name]
    t = np.concatenate([one.segment.record.t for one in own])
    torque = _torques(own)[name]
    supplied = torque - left[name] if name in left and len(left[name]) == len(torque) else np.zeros(len(torque))
    linear = any(one.segment.trajectory.joint.structure.linear for one in own)
    return downsampled(t, torque, supplied, on_axis(linear=linear)("Nm"))
