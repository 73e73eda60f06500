"""Signals that a file holds at different time stamps, brought onto those of one of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robotid.errors import InputError
from robotid.model.array import Array, Mask
from robotid.signals.columns import Column
from robotid.signals.readers.table import Table

# what a controller sets lasts until it sets it anew; a motion goes on in between
ZERO_ORDER_HOLD = ("tau_m", "ref", "disturbance")


def on_one_clock(table: Table, columns: Mapping[str, Column]) -> tuple[Table, list[str]]:
    """The table with the columns of all signals at the time stamps of one, and what was done to which.

    columns : by signal. The time stamps are those of the chosen t, or else of the angle; other signals are
    interpolated, torque and reference constant between their samples, and what lies outside of any of them is cut off.
    Raises InputError where they do not overlap, or time runs backward.
    """
    stored = {signal: table.stored(column.name) for signal, column in columns.items()}
    base = table.clocks.get(stored["t" if "t" in stored else "phi_m"])
    others = {signal: name for signal, name in stored.items() if table.clocks.get(name, base) != base}
    if base is None or not others:
        return table, []
    t, stamps = _stamps(table, base), {name: _stamps(table, table.clocks[name]) for name in others.values()}
    kept = _overlap(table, base, t, stamps)
    changed = {name: table.columns[name][kept] for name in stored.values() if table.clocks.get(name) == base}
    remarks = []
    for signal, name in others.items():
        changed[name] = _at(t[kept], stamps[name], table.columns[name], zero_order_hold=signal in ZERO_ORDER_HOLD)
        how = "held" if signal in ZERO_ORDER_HOLD else "interpolated"
        remarks.append(f"{signal} has time stamps of its own, {table.clocks[name]}: it is {how} onto {base}")
    return table.with_columns(changed), remarks


def _overlap(table: Table, base: str, t: Array, stamps: Mapping[str, Array]) -> Mask:
    """Where t lies within all others, (n,)."""
    first, last = max(other[0] for other in stamps.values()), min(other[-1] for other in stamps.values())
    kept = np.asarray((t >= first) & (t <= last))
    if kept.sum() < 2:
        what = f"{', '.join(stamps)} and {base} were not recorded at the same time"
        raise InputError(what, where=table.path, hint="name columns of one recording, with clocks that agree")
    return kept


def _stamps(table: Table, clock: str) -> Array:
    t = table.columns[clock]
    if (np.diff(t) < 0).any():
        k = int(np.argmax(np.diff(t) < 0)) + 1
        raise InputError(f"time runs backward in {clock}", where=table.where(k), hint="sort the recording")
    return t


def _at(t: Array, stamps: Array, values: Array, *, zero_order_hold: bool) -> Array:
    """A signal at other times, none of them outside of its own. values : (n,) or (n, k) at stamps (n,)."""
    k = np.clip(np.searchsorted(stamps, t, side="right") - 1, 0, len(stamps) - 1)
    if zero_order_hold:
        return values[k]
    after = np.minimum(k + 1, len(stamps) - 1)
    step = stamps[after] - stamps[k]
    share = np.divide(t - stamps[k], step, out=np.zeros_like(t), where=step > 0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[k] * (1 - share) + values[after] * share)
