"""What was read: size, sampling, flaws, ranges, resolution, excitation."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robotid.errors import InputError, NumericsError
from robotid.model.array import Array
from robotid.signals.differentiate import bandwidth
from robotid.signals.record import Record
from robotid.signals.repair import Mended

FEWEST = 50  # samples of a record


@dataclass(frozen=True, slots=True)
class Report:
    """One record as it was found. jitter : largest deviation of a sampling interval, share of the sampling time.

    missing, duplicated, not_finite, wraps : samples mended. quantum : of the motor angle, 0 where none shows.
    saturation : share of samples at the largest or smallest torque. reversals : of the motor. still : share of samples
    at rest. torque_bandwidth : 99 % of the torque's energy is below.
    """

    name: str
    source: str
    samples: int
    sampling_time: float = field(metadata={"unit": "s"})
    jitter: float
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


@dataclass(frozen=True, slots=True)
class Recordings:
    """All records of a configuration, and a report on each."""

    records: tuple[Record, ...]
    reports: tuple[Report, ...] = ()

    def __getitem__(self, name: str) -> Record:
        return next(record for record in self.records if record.name == name)


def inspect(record: Record, source: str, mended: Mended | None = None, remarks: tuple[str, ...] = ()) -> Report:
    """Report on a record. Raises InputError for too short a record, NumericsError for one without excitation."""
    if len(record) < FEWEST:
        what = f"a record of {len(record)} samples is too short, the least is {FEWEST}"
        raise InputError(what, where=source, hint="record longer")
    if np.ptp(record.tau_m) == 0.0 or np.ptp(record.phi_m) == 0.0:
        what = "the torque never changes" if np.ptp(record.tau_m) == 0.0 else "the motor never moves"
        raise NumericsError(what, where=source, hint="record a motion that excites the joint, or check the columns")
    v = record.dphi_m
    still = np.abs(v) < 1e-3 * np.abs(v).max()
    moving = np.sign(v[np.abs(v) > 0.02 * np.abs(v).max()])
    return Report(
        name=record.name,
        source=source,
        samples=len(record),
        sampling_time=record.sampling_time,
        jitter=mended.jitter if mended else 0.0,
        missing=mended.missing if mended else 0,
        duplicated=mended.duplicated if mended else 0,
        not_finite=mended.not_finite if mended else 0,
        wraps=mended.wraps if mended else 0,
        torque_range=_range(record.tau_m),
        angle_range=_range(record.phi_m),
        speed_range=_range(v),
        quantum=quantum(record.phi_m),
        saturation=saturation(record.tau_m),
        torque_rms=float(np.sqrt(np.mean(record.tau_m**2))),
        reversals=int(np.sum(np.diff(moving) != 0)),
        still=float(still.mean()),
        torque_bandwidth=bandwidth(record.tau_m, record.sampling_time),
        remarks=remarks,
    )


def _range(signal: Array) -> tuple[float, float]:
    return float(signal.min()), float(signal.max())


def quantum(angle: Array) -> float:
    """Resolution of an angle (n,): the smallest step, where all steps are multiples of it; 0 where none shows."""
    steps = np.abs(np.diff(angle))
    floor = 1e-9 * float(np.abs(angle).max())
    steps = steps[steps > floor]
    if not len(steps):
        return 0.0
    least = float(np.median(steps[steps < 1.5 * steps.min()]))
    small = steps[steps < 200 * least]
    off = np.abs(small / least - np.rint(small / least))
    return least if float(np.percentile(off, 95)) < 0.05 else 0.0


def saturation(torque: Array) -> float:
    """Share of samples that sit at the extremes of a torque, 0 where they are only touched. torque : (n,)."""
    most, least = torque.max(), torque.min()
    at = (torque == most) | (torque == least)
    long = at[1:] & at[:-1]
    return float(at.mean()) if long.sum() > 5 else 0.0


def speed_lag(angle: Array, speed: Array, sampling_time: float) -> int:
    """Samples by which a recorded speed is late against the derivative of the angle. angle, speed : (n,)."""
    derived = np.gradient(angle, sampling_time)
    n, most = len(angle), 5
    errors = []
    for lag in range(-most, most + 1):
        a, b = derived[most : n - most], speed[most + lag : n - most + lag]
        errors.append(float(np.mean((a - b) ** 2)))
    best = int(np.argmin(errors)) - most
    return best if errors[best + most] < 0.5 * errors[most] else 0
