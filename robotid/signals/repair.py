"""Flaws of a recording: repaired and reported where they are few, refused in one line where they are not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.sampling import Findings, Grid, distinct, few, longest_run, regular
from robotid.signals.torque_steps import TorqueSteps

MAX_STEP = 0.4  # of a turn, between samples; half a turn could be either way


@dataclass(frozen=True, slots=True, eq=False)
class RepairedSignals:
    """Signals (n,) on a regular grid, and how many samples were duplicated, not finite, or past a wrap-around.

    angle : (k,) the motor angle as it was recorded, before it was brought onto the grid; torque_steps : of a torque
    that was brought onto the grid.
    """

    signals: dict[str, Array]
    grid: Grid
    duplicated: int
    not_finite: int
    wraps: int
    remarks: tuple[str, ...]
    angle: Array | None = None
    torque_steps: TorqueSteps | None = None


def repair(
    found: Findings,
    signals: Mapping[str, Array],
    t: Array | None,
    sampling_time: float | None,
    turns: Mapping[str, tuple[float, ...]],
) -> RepairedSignals:
    """Signals as they should have been recorded.

    signals : (n,) each; t : (n,) [s] or None; turns : angles at which a signal may wrap around.
    Raises InputError where a flaw is refused.
    """
    signals, lost, bad, wraps = dict(signals), 0, 0, 0
    grid = Grid(1.0 if sampling_time is None else sampling_time, np.arange(len(found.rows), dtype=np.float64))
    if t is not None:
        t, bad = finite(found, "t", t, grid.at)
        keep = distinct(found, t, signals)
        lost = int(len(keep) - keep.sum())
        if lost:
            found, signals = replace(found, rows=found.rows[keep]), {name: s[keep] for name, s in signals.items()}
            t = t[keep]
        grid = regular(found, t, sampling_time)
    for name, values in signals.items():
        # An angle is unwrapped before anything is interpolated: halfway through a wrap-around it never was.
        unwrapped, count = unwrap(found, name, values, turns.get(name, ()))
        signals[name], holes = finite(found, name, unwrapped, grid.at)
        wraps, bad = wraps + count, bad + holes
    angle = signals.get("phi_m")
    grid = grid if angle is None else grid.settled(angle)
    steps = grid.torque_steps(signals["tau_m"]) if "tau_m" in signals else None
    return RepairedSignals(grid.fill(signals), grid, lost, bad, wraps, tuple(found.remarks), angle, steps)


def finite(found: Findings, name: str, values: Array, at: Array) -> tuple[Array, int]:
    """A signal without NaN and infinity, (n,), and how many there were. at : (n,) where its samples stand."""
    bad = ~np.isfinite(values)
    count = int(bad.sum())
    if not count:
        return values, 0
    where, longest = found.where(int(np.argmax(bad))), longest_run(bad)
    if count > len(values) // 2:
        what = f"{name} is not a number in {count} of {len(values)} samples"
        raise InputError(what, where=where, hint="record again, or name another column")
    if found.policy.nan == "refuse" or (found.policy.nan is None and not few(count, longest, len(values))):
        row = f" samples, {longest} of them in a row" if longest > 1 else " samples" if count > 1 else " sample"
        what = f"{name} is not a number in {count}{row}"
        raise InputError(what, where=where, hint="record again, or set repair: {nan: interpolate}")
    good = np.flatnonzero(~bad)
    plural = f"{count} samples that were not numbers are" if count > 1 else "1 sample that was not a number is"
    found.remarks.append(f"{name}: {plural} interpolated, the first at {where}")
    return np.interp(at, at[good], values[good]), count


def unwrap(found: Findings, name: str, values: Array, turns: tuple[float, ...]) -> tuple[Array, int]:
    """An angle that does not jump by a turn, (n,), and how often it did. nan stays."""
    good = np.flatnonzero(np.isfinite(values))
    known = values[good]
    jump = np.abs(np.diff(known))
    turn = next((turn for turn in turns if wraps_at(turn, known)), None)
    if turn is None:
        return values, 0
    wraps = jump > 0.5 * turn
    where = found.where(int(good[np.argmax(wraps) + 1]))
    if float(np.minimum(jump, np.abs(turn - jump)).max()) > MAX_STEP * turn:
        hint = "record faster, or record an angle that does not wrap around"
        raise InputError(f"{name} turns too far between samples to be unwrapped", where=where, hint=hint)
    if found.policy.wrap == "refuse":
        raise InputError(f"{name} wraps around", where=where, hint="set repair: {wrap: unwrap}")
    count = int(wraps.sum())
    plural = f"{count} wrap-arounds are" if count > 1 else "1 wrap-around is"
    found.remarks.append(f"{name}: {plural} unwrapped, the first at {where}")
    continuous = values.copy()
    continuous[good] = np.unwrap(known, period=turn)
    return continuous, count


def wraps_at(turn: float, angle: Array) -> bool:
    """Whether an angle stays within one turn and jumps from edge to edge. angle : (n,)."""
    jump = np.abs(np.diff(angle))
    wraps = jump > 0.5 * turn
    if not wraps.any() or float(np.ptp(angle)) > 1.01 * turn or wraps.all():
        return False
    usual = float(np.percentile(jump[~wraps], 99))
    return float(np.abs(turn - jump[wraps]).max()) <= max(4 * usual, 1e-3 * turn)
