"""Where a misfit sits: the missing torque along the variables of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.diagnosis.misfit.bins import edges
from robotid.diagnosis.misfit.missing_torque import MissingTorque
from robotid.model.array import Array, Index, Mask
from robotid.model.units import on_axis
from robotid.signals.record import Record
from robotid.simulation.trajectory import Trajectory

SLOW = 1e-3  # of the largest speed: where friction holds the motor, no torque is seen
TURN = 2 * np.pi
TURNS = 2  # of the motor, before what repeats every turn shows
FINE_BINS = 36  # of a turn
BLOCKS = 20  # of a record, predicted one by one from all the others
RARE = 1e-3  # of the fullest bin: too little to make a mean of
BANDS_AN_OCTAVE = 2

BY_DIRECTION, BY_SPEED = " by direction", " by speed"


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The missing torque in bins of one variable.

    along : "dphi_m", "phi_m", "phi_m mod 2 pi", "phi_a", "twist", "ddphi_m", "tau_m", "t", "reversal" (time since the
    last one, negative while moving backwards), "record" (its number, from 0) or "frequency" (where missing_torque is
    the root mean square of each band). After ", by direction" the torque is counted along the motion, after ", by
    speed" in proportion to the speed, as large as it is at the speed `at`. x, missing_torque, spread, count : (bins,)
    centre, mean, standard deviation within, samples. order : share of the missing torque's variance that the curve
    explains on samples that did not make it, zero where it explains none.
    """

    along: str
    unit: str
    x: Array = field(metadata={"unit_in": "unit"})
    missing_torque: Array = field(metadata={"unit": "Nm"})
    spread: Array = field(metadata={"unit": "Nm"})
    count: Array
    order: float
    at: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Variable:
    """What a curve may run along. values (n,); signed : zero is a border; turn : they start again after one; gains :
    how the torque may be counted."""

    name: str
    unit: str
    values: Array
    signed: bool = False
    turn: bool = False
    gains: tuple[str, ...] = ("",)


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """All moving samples of all records: missing torque and speed (n,), block of each, and the variables."""

    torque: Array
    speed: Array
    block: Index
    variables: tuple[Variable, ...]


def locate(cases: Sequence[tuple[Trajectory, Record, MissingTorque]]) -> tuple[Curve, ...]:
    """The missing torque of all records along everything, what orders it best first, the simpler variable at a tie."""
    seen = _see(cases)
    curves = [_curve(seen, variable, gain) for variable in seen.variables for gain in variable.gains]
    return (*sorted(curves, key=lambda curve: -round(curve.order, 2)), _bands(cases))


def _see(cases: Sequence[tuple[Trajectory, Record, MissingTorque]]) -> Seen:
    names = list(dict.fromkeys(record.name for _, record, _ in cases))
    parts = [_variables(names.index(case[1].name), *case) for case in cases]
    moving = []
    for trajectory, _, missing in cases:
        speed = missing.x[trajectory.joint.motor_speed]
        moving.append(np.abs(speed) > SLOW * np.abs(speed).max())
    kept = np.concatenate(moving)
    many = max(float(np.ptp(record.phi_m)) for _, record, _ in cases) > TURNS * TURN
    joined = (_joined(same, kept) for same in zip(*parts, strict=True))
    return Seen(
        torque=np.concatenate([missing.torque for _, _, missing in cases])[kept],
        speed=np.concatenate([part[0].values for part in parts])[kept],
        block=np.concatenate([k * BLOCKS + np.arange(len(m)) * BLOCKS // len(m) for k, m in enumerate(moving)])[kept],
        variables=tuple(variable for variable in joined if _varies(variable) and (many or not variable.turn)),
    )


def _varies(variable: Variable) -> bool:
    known = variable.values[np.isfinite(variable.values)]
    return bool(known.size and np.ptp(known) > 0)


def _joined(parts: Sequence[Variable], kept: Mask) -> Variable:
    return replace(parts[0], values=np.concatenate([part.values for part in parts])[kept])


def _variables(number: int, trajectory: Trajectory, record: Record, missing: MissingTorque) -> list[Variable]:
    """Of one record, the speed first."""
    joint, x, h = trajectory.joint, missing.x, record.sampling_time
    unit = on_axis(linear=joint.structure.linear)
    speed = x[joint.motor_speed]
    both = ("", BY_DIRECTION)
    every = (*both, BY_SPEED)
    found = [
        Variable("dphi_m", unit("rad/s"), speed, signed=True),
        Variable("reversal", "s", _since_reversal(speed, h), signed=True),
        Variable("phi_m", unit("rad"), record.phi_m, gains=every),
        Variable("ddphi_m", unit("rad/s2"), np.gradient(speed, h), signed=True, gains=both),
        Variable("tau_m", unit("Nm"), trajectory.u, signed=True, gains=both),
        Variable("t", "s", record.t, gains=every),
        Variable("record", "1", np.full(len(record), float(number)), gains=every),
    ]
    if not joint.structure.linear:
        found.insert(2, Variable("phi_m mod 2 pi", "rad", record.phi_m % TURN, turn=True, gains=both))
    if joint.masses > 1:
        arm = joint.ratio * record.phi_m - x[0]
        found.insert(2, Variable("phi_a", unit("rad"), arm, gains=every))
        found.insert(3, Variable("twist", unit("rad"), x[0], signed=True, gains=both))
    return found


def _since_reversal(speed: Array, h: float) -> Array:
    """Time since the speed last changed its sign [s], negative while moving backwards; nan before the first, (n,)."""
    n, direction = np.arange(len(speed)), np.sign(speed)
    turned = np.flatnonzero(np.diff(direction) != 0) + 1
    since = np.concatenate([[-1], turned])[np.searchsorted(turned, n, side="right")]
    return np.asarray(np.where(since < 0, np.nan, direction * (n - since + 0.5) * h))


def _curve(seen: Seen, variable: Variable, gain: str) -> Curve:
    """Least squares of the torque on the gain, bin by bin."""
    known = np.isfinite(variable.values)
    values, torque, block = variable.values[known], seen.torque[known], seen.block[known]
    at = float(np.sqrt(np.mean(seen.speed**2))) or 1.0
    weight = _gain(seen.speed, gain, at)[known]
    borders = _edges(variable, values)
    size = len(borders) - 1
    bins = np.clip(np.searchsorted(borders, values, side="right") - 1, 0, size - 1)
    count = np.bincount(bins, minlength=size)
    blocks = int(seen.block.max()) + 1
    where = block * size + bins
    across = np.bincount(where, weight * torque, blocks * size).reshape(blocks, size)
    own = np.bincount(where, weight**2, blocks * size).reshape(blocks, size)
    centre = np.bincount(bins, values, size) / np.maximum(count, 1)
    mean = _ratio(across.sum(axis=0), own.sum(axis=0), centre, variable.turn)
    others = (
        _ratio(across.sum(axis=0) - a, own.sum(axis=0) - o, centre, variable.turn)
        for a, o in zip(across, own, strict=True)
    )
    predicted = np.stack(list(others))[block, bins] * weight
    left = np.bincount(bins, (torque - mean[bins] * weight) ** 2, size)
    return Curve(
        along=f"{variable.name},{gain}" if gain else variable.name,
        unit=variable.unit,
        x=centre,
        missing_torque=mean,
        spread=np.sqrt(left / np.maximum(count, 1)),
        count=count.astype(np.float64),
        order=_share(torque, predicted),
        at=at if gain == BY_SPEED else 1.0,
    )


def _edges(variable: Variable, values: Array) -> Array:
    if variable.name == "record":
        return np.append(np.unique(values) - 0.5, values.max() + 0.5)
    return np.linspace(0.0, TURN, FINE_BINS + 1) if variable.turn else edges(values, variable.signed)


def _gain(speed: Array, counted: str, at: float) -> Array:
    """What a curve is to be multiplied by, (n,)."""
    if counted == BY_SPEED:
        return speed / at
    return np.sign(speed) if counted == BY_DIRECTION else np.ones(len(speed))


def _ratio(across: Array, own: Array, centre: Array, turn: bool) -> Array:
    """Mean of each bin (bins,); of one without samples, between its neighbours."""
    full = own > RARE * own.max()
    if not full.any():
        return np.zeros(len(own))
    return np.asarray(np.interp(centre, centre[full], across[full] / own[full], period=TURN if turn else None))


def _share(torque: Array, predicted: Array) -> float:
    total = float(np.sum((torque - torque.mean()) ** 2))
    return max(0.0, 1 - float(np.sum((torque - predicted) ** 2)) / total) if total > 0 else 0.0


def _bands(cases: Sequence[tuple[Trajectory, Record, MissingTorque]]) -> Curve:
    """Root mean square of the missing torque in each frequency band, over all records."""
    h = min(record.sampling_time for _, record, _ in cases)
    longest = max(record.duration for _, record, _ in cases)
    borders = np.geomspace(1 / longest, 0.5 / h, round(BANDS_AN_OCTAVE * np.log2(longest / 2 / h)) + 1)
    parts, counts = [], []
    for _, record, missing in cases:
        n = len(missing.torque)
        power = np.abs(np.fft.rfft(missing.torque - missing.torque.mean())) ** 2 * 2 / n**2
        frequency = np.fft.rfftfreq(n, record.sampling_time)
        parts.append(np.sqrt(np.histogram(frequency, borders, weights=power)[0]))
        counts.append(np.histogram(frequency, borders)[0])
    amplitude, count = np.stack(parts), np.sum(counts, axis=0)
    seen = count > 0
    return Curve(
        along="frequency",
        unit="Hz",
        x=np.sqrt(borders[1:] * borders[:-1])[seen],
        missing_torque=np.sqrt(np.mean(amplitude**2, axis=0))[seen],
        spread=np.std(amplitude, axis=0)[seen],
        count=count[seen].astype(np.float64),
        order=0.0,
    )
