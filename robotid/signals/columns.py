"""Finding the signals of a joint among a file's columns."""

from __future__ import annotations

from dataclasses import dataclass

from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.signals.readers.table import Table
from robotid.signals.units import factor

ALIASES: dict[str, tuple[str, ...]] = {
    "t": ("t", "time", "time_s", "timestamp", "zeit"),
    "tau_m": ("tau_m", "tau", "torque", "motor_torque", "torque_nm", "tau_motor", "moment", "force", "u", "vir"),
    "phi_m": ("phi_m", "phi", "angle", "motor_angle", "pos", "position", "q", "qm", "theta", "enc", "encoder"),
    "dphi_m": ("dphi_m", "dphi", "omega", "speed", "velocity", "vel", "dq", "qd", "motor_speed"),
    "phi_a": ("phi_a", "arm_angle", "link_angle", "load_angle", "second_encoder"),
    "ref": ("ref", "reference", "qg", "setpoint", "ref_pos", "ref_vel"),
}
NEEDED = ("tau_m", "phi_m")


@dataclass(frozen=True, slots=True)
class Column:
    """Which column a signal is: value in SI = (scale * recorded + offset) * factor of the unit."""

    name: str
    column: int | None = None
    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0


def find(table: Table, signal: str) -> Column | None:
    """The column that bears a usual name of a signal, or None. Raises ConfigError where several do."""
    names = [(name.lower().rsplit(".", 1)[-1], name) for name, values in table.columns.items() if values.ndim == 1]
    exact = [name for short, name in names if short == signal]
    found = exact or [name for short, name in names if short in ALIASES[signal]]
    if len(found) > 1:
        what = f"{' and '.join(found)} could both be {signal}"
        raise ConfigError(what, where=table.path, hint=f"say which under columns: {signal}")
    return Column(found[0]) if found else None


def convert(table: Table, signal: str, column: Column) -> tuple[Array, float]:
    """A signal in SI (n,), and the size of one revolution of it after scaling [rad]."""
    unit = column.unit or table.units.get(column.name, "")
    to_si = factor(unit, f"{table.path}, column {column.name}")
    values = table.pick(column.name, column.column)
    return (column.scale * values + column.offset) * to_si, abs(column.scale)


def missing(table: Table, signal: str) -> ConfigError:
    """What to say where a needed signal is nowhere."""
    hint = f"name it under columns: {signal}; {table.offer()}"
    return ConfigError(f"no column was found for {signal}", where=table.path, hint=hint)
