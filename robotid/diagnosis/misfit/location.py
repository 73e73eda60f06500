"""Where a misfit sits: the missing torque along the variables of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.misfit.bins import bin_edges
from robotid.diagnosis.misfit.curve import BY_DIRECTION, BY_SPEED, Curve
from robotid.diagnosis.misfit.missing_torque import MissingTorque
from robotid.diagnosis.misfit.settings import MISFIT
from robotid.model.array import Array, Index, Mask
from robotid.model.physical import TURN
from robotid.model.units import on_axis
from robotid.simulation.trajectory import gear_rate


@dataclass(frozen=True, slots=True, eq=False)
class OrderingVariable:
    """What a curve may run along. values (n,); signed : zero is a border; turn : they start again after one; gains :
    how the torque may be counted."""

    name: str
    unit: str
    values: Array
    signed: bool = False
    turn: bool = False
    gains: tuple[str, ...] = ("",)


@dataclass(frozen=True, slots=True, eq=False)
class MovingSamples:
    """All moving samples of all records: missing torque and speed (n,), block of each, and the variables."""

    torque: Array
    speed: Array
    block: Index
    variables: tuple[OrderingVariable, ...]


def locate(found: Sequence[MissingTorque]) -> tuple[Curve, ...]:
    """The missing torque of all records along everything, what orders it best first, the simpler variable at a tie."""
    samples = _moving_samples(found)
    curves = [_curve(samples, variable, gain) for variable in samples.variables for gain in variable.gains]
    return (*sorted(curves, key=lambda curve: -round(curve.order, 2)), _bands(found))


def _moving_samples(found: Sequence[MissingTorque]) -> MovingSamples:
    names = list(dict.fromkeys(one.segment.record.name for one in found))
    parts = [_variables(names.index(one.segment.record.name), one) for one in found]
    moving = []
    for one in found:
        speed = one.x[one.segment.trajectory.joint.motor_speed]
        moving.append(np.abs(speed) > MISFIT.standstill * np.abs(speed).max())
    kept = np.concatenate(moving)
    many = max(float(np.ptp(one.segment.record.phi_m)) for one in found) > MISFIT.min_turns * TURN
    joined = (_joined(same, kept) for same in zip(*parts, strict=True))
    return MovingSamples(
        torque=np.concatenate([one.torque for one in found])[kept],
        speed=np.concatenate([part[0].values for part in parts])[kept],
        block=np.concatenate(
            [k * MISFIT.blocks + np.arange(len(m)) * MISFIT.blocks // len(m) for k, m in enumerate(moving)]
        )[kept],
        variables=tuple(variable for variable in joined if _varies(variable) and (many or not variable.turn)),
    )


def _varies(variable: OrderingVariable) -> bool:
    known = variable.values[np.isfinite(variable.values)]
    return bool(known.size and np.ptp(known) > 0)


def _joined(parts: Sequence[OrderingVariable], kept: Mask) -> OrderingVariable:
    return replace(parts[0], values=np.concatenate([part.values for part in parts])[kept])


def _variables(number: int, one: MissingTorque) -> list[OrderingVariable]:
    """The variables of one segment, the speed first."""
    trajectory, record = one.segment.trajectory, one.segment.record
    joint, x, h = trajectory.joint, one.x, record.sampling_time
    unit = on_axis(linear=joint.structure.linear)
    speed = x[joint.motor_speed]
    both = ("", BY_DIRECTION)
    every = (*both, BY_SPEED)
    found = [
        OrderingVariable("dphi_m", unit("rad/s"), speed, signed=True),
        OrderingVariable("reversal", "s", since_reversal(speed, h), signed=True),
        OrderingVariable("phi_m", unit("rad"), record.phi_m, gains=every),
        OrderingVariable("ddphi_m", unit("rad/s2"), np.gradient(speed, h), signed=True, gains=both),
        OrderingVariable("tau_m", unit("Nm"), trajectory.u, signed=True, gains=both),
        OrderingVariable("t", "s", record.t, gains=every),
        OrderingVariable("record", "1", np.full(len(record), float(number)), gains=every),
    ]
    if not joint.structure.linear:
        found.insert(2, OrderingVariable("phi_m mod 2 pi", "rad", record.phi_m % TURN, turn=True, gains=both))
    if joint.masses > 1:
        arm = joint.ratio * record.phi_m - x[0]
        found.insert(2, OrderingVariable("phi_a", unit("rad"), arm, gains=every))
        found.insert(3, OrderingVariable("twist", unit("rad"), x[0], signed=True, gains=both))
        found.insert(4, OrderingVariable("dtwist", unit("rad/s"), gear_rate(joint, x), signed=True))
    return found


def since_reversal(speed: Array, h: float) -> Array:
    """Time since the speed last changed its sign [s], negative while moving backwards; nan before the first, (n,)."""
    n, direction = np.arange(len(speed)), np.sign(speed)
    reversals = np.flatnonzero(np.diff(direction) != 0) + 1
    since = np.concatenate([[-1], reversals])[np.searchsorted(reversals, n, side="right")]
    return np.asarray(np.where(since < 0, np.nan, direction * (n - since + 0.5) * h))


def _curve(samples: MovingSamples, variable: OrderingVariable, gain: str) -> Curve:
    """Least squares of the torque on the gain, bin by bin."""
    known = np.isfinite(variable.values)
    values, torque, block = variable.values[known], samples.torque[known], samples.block[known]
    at = float(np.sqrt(np.mean(samples.speed**2))) or 1.0
    weight = _gain(samples.speed, gain, at)[known]
    borders = _edges(variable, values)
    size = len(borders) - 1
    bins = np.clip(np.searchsorted(borders, values, side="right") - 1, 0, size - 1)
    count = np.bincount(bins, minlength=size)
    blocks = int(samples.block.max()) + 1
    where = block * size + bins
    across = np.bincount(where, weight * torque, blocks * size).reshape(blocks, size)
    own = np.bincount(where, weight**2, blocks * size).reshape(blocks, size)
    centre = np.bincount(bins, values, size) / np.maximum(count, 1)
    whole, length = across.sum(axis=0), own.sum(axis=0)
    mean = _ratio(whole, length, centre, variable.turn)
    others = (_ratio(whole - a, length - o, centre, variable.turn) for a, o in zip(across, own, strict=True))
    predicted = np.stack(list(others))[block, bins] * weight
    left = np.bincount(bins, (torque - mean[bins] * weight) ** 2, size)
    return Curve(
        along=f"{variable.name},{gain}" if gain else variable.name,
        unit=variable.unit,
        x=centre,
        missing_torque=mean,
        spread=np.sqrt(left / np.maximum(count, 1)),
        count=count.astype(np.float64),
        order=_share(torque, weight, predicted),
        at=at if gain == BY_SPEED else 1.0,
    )


def _edges(variable: OrderingVariable, values: Array) -> Array:
    if variable.name == "record":
        return np.append(np.unique(values) - 0.5, values.max() + 0.5)
    return np.linspace(0.0, TURN, MISFIT.bins_a_turn + 1) if variable.turn else bin_edges(values, variable.signed)


def _gain(speed: Array, counted: str, at: float) -> Array:
    """What a curve is to be multiplied by, (n,)."""
    if counted == BY_SPEED:
        return speed / at
    return np.sign(speed) if counted == BY_DIRECTION else np.ones(len(speed))


def _ratio(across: Array, own: Array, centre: Array, turn: bool) -> Array:
    """Mean of each bin (bins,); of one without samples, between its neighbours."""
    full = own > MISFIT.rare_share * own.max()
    if not full.any():
        return np.zeros(len(own))
    return np.asarray(np.interp(centre, centre[full], across[full] / own[full], period=TURN if turn else None))


def _share(torque: Array, weight: Array, predicted: Array) -> float:
    """Of what the gain alone leaves, one value for all bins: the variable has no merit in what it explains."""
    alike = weight * (float(weight @ torque) / (float(weight @ weight) or 1.0))
    total = float(np.sum((torque - alike) ** 2))
    rounding = (len(torque) * np.finfo(np.float64).eps) ** 2 * float(torque @ torque)
    return max(0.0, 1 - float(np.sum((torque - predicted) ** 2)) / total) if total > rounding else 0.0


def _bands(found: Sequence[MissingTorque]) -> Curve:
    """Root mean square of the missing torque in each frequency band, over all records."""
    h = min(one.segment.record.sampling_time for one in found)
    longest = max(one.segment.record.duration for one in found)
    borders = np.geomspace(1 / longest, 0.5 / h, round(MISFIT.bands_an_octave * np.log2(longest / 2 / h)) + 1)
    parts, counts = [], []
    for one in found:
        n = len(one.torque)
        power = np.abs(np.fft.rfft(one.torque - one.torque.mean())) ** 2 * 2 / n**2
        frequency = np.fft.rfftfreq(n, one.segment.record.sampling_time)
        parts.append(np.sqrt(np.histogram(frequency, borders, weights=power)[0]))
        counts.append(np.histogram(frequency, borders)[0])
    amplitude, count = np.stack(parts), np.sum(counts, axis=0)
    filled = count > 0
    return Curve(
        along="frequency",
        unit="Hz",
        x=np.sqrt(borders[1:] * borders[:-1])[filled],
        missing_torque=np.sqrt(np.mean(amplitude**2, axis=0))[filled],
        spread=np.std(amplitude, axis=0)[filled],
        count=count[filled].astype(np.float64),
        order=0.0,
    )
