"""Where a fitted model is wrong: the missing torque of every record, and what orders it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.misfit.location import Curve, locate
from robotid.diagnosis.misfit.missing_torque import MissingTorque, missing_torque
from robotid.diagnosis.noise.noise_floor import Noise, noise_levels
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.model.units import on_axis
from robotid.signals.record import Quantity, Record
from robotid.signals.trace import Trace, thinned
from robotid.simulation.trajectory import Trajectory

MOST = 1.5  # of the quietest record's floor: more is misfit that passes for noise


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    """floors : noise floor by record; missing : the missing torque by record, thinned, and what causes supply of it;
    curves : along everything, what orders it best first."""

    floors: dict[str, float]
    missing: dict[str, Trace]
    curves: tuple[Curve, ...]


def locate_misfit(before: Sequence[SimulatedSegment], after: Sequence[SimulatedSegment], output: Quantity) -> Where:
    """The misfit of simulated records in noise, torque, and along the variables of the motion.

    after : the same records, or some of them, once the causes are there; where there is less misfit to hide it, the
    noise shows better.
    """
    later = noise_levels(after, output) if after else ()
    behind = {_piece(segment): noise for segment, noise in zip(after, later, strict=True)}
    noises = [behind.get(_piece(c), n) for c, n in zip(before, noise_levels(before, output), strict=True)]
    floors: dict[str, list[float]] = {}
    for segment, noise in zip(before, noises, strict=True):
        floors.setdefault(segment.record.name, []).append(noise.floor)
    levels = {name: float(np.sqrt(np.mean(np.square(found)))) for name, found in floors.items()}
    found = list(_missing(before, noises, output))
    left = _torques(_missing(after, later, output))
    return Where(
        floors={name: min(level, MOST * min(levels.values())) for name, level in levels.items()},
        missing={name: _trace(name, found, left) for name in _torques(found)},
        curves=locate(found) if found else (),
    )


def _piece(segment: SimulatedSegment) -> tuple[str, float]:
    """What tells a piece of a record from all others."""
    return segment.record.name, segment.record.begin


def _missing(
    segments: Sequence[SimulatedSegment], noises: Sequence[Noise], output: Quantity
) -> Iterator[tuple[Trajectory, Record, MissingTorque]]:
    """Those records in which some torque makes the model follow the measurement."""
    for one, noise in zip(segments, noises, strict=True):
        try:
            found = missing_torque(one.trajectory, one.record, one.residual, output, noise.output, noise.torque)
        except NumericsError:
            continue
        yield one.trajectory, one.record, found


def _torques(found: Iterable[tuple[Trajectory, Record, MissingTorque]]) -> dict[str, Array]:
    """Missing torque by record, (n,)."""
    parts: dict[str, list[Array]] = {}
    for _, record, missing in found:
        parts.setdefault(record.name, []).append(missing.torque)
    return {name: np.concatenate(torques) for name, torques in parts.items()}


def _trace(name: str, found: Sequence[tuple[Trajectory, Record, MissingTorque]], left: dict[str, Array]) -> Trace:
    t = np.concatenate([record.t for _, record, _ in found if record.name == name])
    torque = _torques(found)[name]
    supplied = torque - left[name] if name in left and len(left[name]) == len(torque) else np.zeros(len(torque))
    linear = any(trajectory.joint.structure.linear for trajectory, _, _ in found)
    return thinned(t, torque, supplied, on_axis(linear=linear)("Nm"))
