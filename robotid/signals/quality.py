"""What was read: size, sampling, flaws, ranges, resolution, excitation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from robotid.body.results import BodyResult
from robotid.errors import InputError, NumericsError
from robotid.model.array import Array
from robotid.numerals import plain
from robotid.signals.differentiate import bandwidth
from robotid.signals.record import LARGEST, Record
from robotid.signals.repair import RepairedSignals

MIN_SAMPLES = 50  # samples of a record
SMALLEST = 1e-15  # [Nm, rad, rad/s] of what a sensor of a machine shows
MAX_QUANTA = 12  # quanta that the shortest step of a fast motion may be


@dataclass(frozen=True, slots=True)
class Report:
    """One record as it was found. jitter : largest deviation of a sampling interval, share of the sampling time.

    missing, duplicated, not_finite, wraps : samples repaired. quantum : of the motor angle, 0 where none shows.
    saturation : share of samples at the largest or smallest torque. reversals : of the motor. still : share of samples
    at rest. torque_bandwidth : 95 % of the torque's energy is below.
    """

    name: str
    source: str
    samples: int
    sampling_time: float = field(metadata={"unit": "s"})
    jitter: float
    jitter_rms: float
    missing: int
    duplicated: int
    not_finite: int
    wraps: int
    torque_range: tuple[float, float] = field(metadata={"unit": "Nm"})
    angle_range: tuple[float, float] = field(metadata={"unit": "rad"})
    speed_range: tuple[float, float] = field(metadata={"unit": "rad/s"})
    quantum: float = field(metadata={"unit": "rad"})
    saturation: float
    torque_rms: float = field(metadata={"unit": "Nm"})
    reversals: int
    still: float
    torque_bandwidth: float = field(metadata={"unit": "Hz"})
    remarks: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Length of the record [s]."""
        return self.samples * self.sampling_time


@dataclass(frozen=True, slots=True)
class Recordings:
    """All records of a configuration, and a report on each. body : of the robot, where its description is given."""

    records: tuple[Record, ...]
    reports: tuple[Report, ...] = ()
    body: BodyResult | None = None

    def contradictions(self) -> Iterator[str]:
        """What does not belong together, as sentences: for records that were read from a file."""
        names = [record.name for record in self.records]
        if len(set(names)) < len(names):
            yield "two records have the same name"
        if [report.name for report in self.reports] != names:
            yield "the reports are not those of its records"

    def __getitem__(self, name: str) -> Record:
        return next(record for record in self.records if record.name == name)

    def of(self, names: Iterable[str]) -> tuple[Record, ...]:
        """The records of these names, and for a name that gaps have cut, its pieces."""
        wanted = tuple(names)
        return tuple(r for name in wanted for r in self.records if name in (r.name, r.experiment))


def inspect(
    record: Record, source: str, repaired: RepairedSignals | None = None, remarks: tuple[str, ...] = ()
) -> Report:
    """Report on a record. Raises InputError for too short a record, NumericsError for one without excitation."""
    if len(record) < MIN_SAMPLES:
        what = f"a record of {len(record)} samples is too short, the least is {MIN_SAMPLES}"
        raise InputError(what, where=source, hint="record longer")
    step = quantum(record.phi_m if repaired is None or repaired.angle is None else repaired.angle)
    _excited(record, source, step)
    v = record.dphi_m
    fastest = float(np.abs(v).max())
    moving = np.sign(v[np.abs(v) > 0.02 * fastest])
    saturated = saturation(record.tau_m)
    return Report(
        name=record.name,
        source=source,
        samples=len(record),
        sampling_time=record.sampling_time,
        jitter=repaired.grid.jitter if repaired else 0.0,
        jitter_rms=repaired.grid.jitter_rms if repaired else 0.0,
        missing=repaired.grid.missing if repaired else 0,
        duplicated=repaired.duplicated if repaired else 0,
        not_finite=repaired.not_finite if repaired else 0,
        wraps=repaired.wraps if repaired else 0,
        torque_range=_range(record.tau_m),
        angle_range=_range(record.phi_m),
        speed_range=_range(v),
        quantum=step,
        saturation=saturated,
        torque_rms=float(np.sqrt(np.mean(record.tau_m**2))),
        reversals=int(np.sum(np.diff(moving) != 0)),
        still=float(np.mean(np.abs(v) <= 1e-3 * fastest)),
        torque_bandwidth=bandwidth(record.tau_m, record.sampling_time, 0.95),
        remarks=(*remarks, *_flaws(record, saturated)),
    )


def _excited(record: Record, source: str, step: float) -> None:
    """Raises NumericsError where the torque is constant or the motor stands."""
    what = ""
    sizes = {name: float(np.abs(getattr(record, name)).max()) for name in ("tau_m", "phi_m", "dphi_m")}
    if absurd := [name for name, size in sizes.items() if size and not SMALLEST < size < LARGEST]:
        what = f"{absurd[0]} reaches {plain(sizes[absurd[0]])}, which no sensor of a machine does"
    elif np.ptp(record.tau_m) == 0.0:
        what = "the torque never changes"
    elif np.ptp(record.phi_m) == 0.0:
        what = "the motor never moves"
    elif np.ptp(record.phi_m) < 3.5 * step:
        what = f"the motor moves by {round(np.ptp(record.phi_m) / step)} of its encoder's steps and no more"
    if what:
        raise NumericsError(what, where=source, hint="record a motion that excites the joint, or check the columns")


def _flaws(record: Record, saturated: float) -> tuple[str, ...]:
    """What a person should check before believing the record."""
    found = []
    if saturated:
        found.append(
            f"the torque sits at its largest or smallest value in {plain(100 * saturated, 2)} % of the samples:"
            " saturated?"
        )
    k = jump(record.phi_m)
    if k is not None:
        size = abs(float(record.phi_m[k] - record.phi_m[k - 1]))
        found.append(
            f"phi_m jumps by {plain(size)} within a sample at {k * record.sampling_time:.6g} s, unlike its neighbours"
        )
    if record.sampling_time > 0.1 or record.sampling_time < 1e-6:
        found.append(f"a sampling time of {record.sampling_time:g} s is unusual: is the unit of time right?")
    return tuple(found)


def _range(signal: Array) -> tuple[float, float]:
    return float(signal.min()), float(signal.max())


def quantum(angle: Array) -> float:
    """Resolution of an angle (n,): the smallest step, where all steps are multiples of it; 0 where none shows."""
    steps = np.abs(np.diff(angle))
    floor = 1e-8 * float(np.ptp(angle))  # below it, single precision shows rather than an encoder
    steps = steps[steps > floor]
    if not len(steps):
        return 0.0
    least = float(np.median(steps[steps < 1.5 * steps.min()]))
    candidates = (_refined(steps, least / k) for k in range(1, MAX_QUANTA + 1))
    return next((q for q in candidates if float(np.percentile(_off(steps, q), 95)) < 0.05), 0.0)


def _refined(steps: Array, quantum: float) -> float:
    """The quantum that ever longer steps are multiples of, by least squares: together they tell it well even if written
    with few digits."""
    for reach in (8, 32, 128):
        near = steps[steps < reach * quantum]
        counts = np.rint(near / quantum)
        quantum = float(counts @ near / (counts @ counts)) if counts.any() else quantum
    return quantum


def _off(steps: Array, quantum: float) -> Array:
    """Distance of the shorter steps to the nearest multiple, in quanta."""
    short = steps[steps <= max(128 * quantum, float(steps.min()))] / quantum
    return np.abs(short - np.rint(short))


def saturation(torque: Array) -> float:
    """Share of samples that sit at the extremes of a torque, 0 where they are only touched. torque : (n,)."""
    most, least = torque.max(), torque.min()
    at = (torque == most) | (torque == least)
    long = at[1:] & at[:-1]
    return float(at.mean()) if long.sum() > 5 else 0.0


def jump(angle: Array) -> int | None:
    """First sample to which an angle jumps as no motor can: by far more than in the samples around. angle : (n,)."""
    steps = np.abs(np.diff(angle))
    usual = np.percentile(steps, 99)
    around = np.maximum(steps[:-2], steps[2:])
    wild = np.flatnonzero((steps[1:-1] > 10 * around) & (steps[1:-1] > 10 * usual))
    return int(wild[0]) + 2 if len(wild) else None
