"""Finding the signals of a joint among a file's columns, and turning them into SI."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from robotid.errors import ConfigError
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.signals.readers.table import CONTAINERS, Table
from robotid.signals.units import SI, UNITS, Unit, parse, unit

_ALIASES = {
    "t": """t time timestamp timestamps tout datetime date_time elapsed_time datum zeit zeitstempel uhrzeit temps
        horodatage tiempo tempo 时间 時間""",
    "tau_m": """tau_m tau torque motor_torque tau_motor moment force effort u vir drehmoment motormoment motordrehmoment
        kraft couple couple_moteur par par_motor coppia fuerza forza current motor_current strom motorstrom courant
        courant_moteur corriente corrente 力矩 扭矩 转矩 トルク""",
    "phi_m": """phi_m phi angle motor_angle pos position q qm theta enc encoder winkel motorwinkel drehwinkel
        motorposition grad angle_moteur angulo angolo posicion posizione 角度 位置""",
    "dphi_m": """dphi_m dphi omega speed velocity vel dq qd motor_speed drehzahl motordrehzahl geschwindigkeit
        winkelgeschwindigkeit vitesse vitesse_angulaire velocidad velocita 速度 角速度 转速""",
    "phi_a": "phi_a arm_angle link_angle load_angle second_encoder",
    "ref": "ref reference qg setpoint ref_pos ref_vel sollwert sollwinkel sollposition solldrehzahl consigne consigna",
    "disturbance": "disturbance torque_disturbance force_disturbance",
}
ALIASES: dict[str, tuple[str, ...]] = {signal: tuple(names.split()) for signal, names in _ALIASES.items()}
"""Names that a signal usually has, a unit at their end (time_s, angle_deg) left out."""

CURRENTS = ("current", "strom", "motorstrom", "courant", "corriente", "corrente")
"""Words that make amperes of a column whose name ends in A, or in no unit."""

NEEDED = ("tau_m", "phi_m")

QUANTITIES: dict[str, tuple[str, ...]] = {
    "t": ("time",),
    "tau_m": ("torque", "force"),
    "phi_m": ("angle", "length"),
    "dphi_m": ("angular speed", "speed"),
    "phi_a": ("angle", "length"),
    "ref": ("angle", "length", "angular speed", "speed"),
    "disturbance": ("torque", "force"),
}

COMPANIONS: dict[CompanionKind, dict[str, str]] = {
    CompanionKind.ANGLE: {"angle": "rad", "length": "m"},
    CompanionKind.TEMPERATURE: {"temperature": "degC"},
    CompanionKind.TORQUE: {"torque": "Nm", "force": "N"},
    CompanionKind.VOLTAGE: {"voltage": "V"},
    CompanionKind.INERTIA: {"inertia": "kg m2"},
    CompanionKind.DRIVE: {"torque": "Nm", "force": "N"},
    CompanionKind.DISTURBANCE: {"torque": "Nm", "force": "N"},
}
"""Quantities that a companion of each kind may be, and the units that they are kept in."""


@dataclass(frozen=True, slots=True)
class Column:
    """Which column a signal is. unit : as recorded, absent : the file's own, or SI. scale, offset : the signal is
    scale * recorded + offset, in that unit; volts, amperes, percent and counts become SI by their scale alone."""

    name: str
    column: int | None = None
    unit: str | None = None
    scale: float | None = None
    offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """A signal in SI, (n,). unit : that it was recorded in, None where nothing gives it; scale : of its column."""

    values: Array
    unit: Unit | None
    scale: float
    remark: str = ""


def _last_part(name: str) -> str:
    """What of a dotted name says what it is: logsout.torque.data -> torque."""
    for container in CONTAINERS:
        if name.lower().endswith(container):
            name = name[: -len(container)]
    return name.rsplit(".", 1)[-1]


def short(name: str) -> str:
    """The last part of a dotted name in lower case, its words joined by _: rec.MotorAngle -> motor_angle."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z][a-z])", "_", _last_part(plain))
    return re.sub(r"\W+", "_", words).strip("_").lower()


def ending(name: str) -> tuple[str, Unit | None]:
    """A short name without the unit at its end, and that unit: angle_deg -> angle, deg.

    Single letters other than s and v are no units, for phi_m and phi_a end in them; rad_s is rad/s.
    """
    words = short(name).split("_")
    if words == ["grad"]:
        return "grad", UNITS["deg"]
    written = re.fullmatch(r"(.*?[^\W_])[\s_]+([^\s_]+)", _last_part(name))
    if written and (written[2] in UNITS or "/" in written[2]) and len(written[2]) > 1 and written[2] != "min":
        # mNm would be torn apart, and the s of a unit that is unknown taken for seconds
        unit = parse(written[2])
        return (short(written[1]), unit) if unit is not None else ("_".join(words), None)
    last = next((word for word in reversed(words) if not word.isdecimal()), "")
    if any(word in CURRENTS for word in words) and last in (*CURRENTS, "a"):
        return "_".join(words[:-1] if words[-1] == "a" else words), UNITS["A"]
    for count in range(min(3, len(words) - 1), 0, -1):
        tail = "_".join(words[-count:])
        found = parse(tail) if (len(tail) > 1 or tail in "sv") and tail != "min" else None
        if found is None and count == 2 and len(words[-2]) > 1:
            found = parse("/".join(words[-2:]))
        if found is not None:
            return "_".join(words[:-count]), found
    return "_".join(words), None


def suitable(signal: str, *, linear: bool) -> dict[str, str]:
    """Quantities that a signal may be, and their SI units."""
    return {quantity: si for quantity, si in SI[linear].items() if quantity in QUANTITIES[signal]}


def find(table: Table, signal: str, *, linear: bool = False, taken: Collection[str] = ()) -> Column | None:
    """The column that bears a usual name of a signal, or None. taken : names of columns that are something else. Raises
    ConfigError where several do."""
    found = []
    for name in (one for one in table.columns if one not in taken):
        stem, unit = ending(name)
        fits = unit is not None and (unit.quantity in suitable(signal, linear=linear) or (unit.raw and signal != "t"))
        if len(table.shape(name)) == 1 and ({short(name), stem} if fits else {short(name)}) & set(ALIASES[signal]):
            found.append(name)
    exact = [name for name in found if short(name) == signal]
    if len(found) > 1 and len(exact) != 1:
        none = "" if signal in NEEDED else f", or that there is none, {signal}: null"
        hint = f"say which under columns: {signal}{none}"
        raise ConfigError(f"{' and '.join(found)} could both be {signal}", where=table.path, hint=hint)
    return Column((exact or found)[0]) if found else None


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a column is wanted for: a signal, and the quantities that it may be, with the unit that each is kept in."""

    signal: str
    allowed: Mapping[str, str]


def convert(table: Table, signal: str, column: Column, *, linear: bool = False) -> Signal:
    """A signal in SI. linear : of an axis that slides. Raises ConfigError for a column that is not there, for a unit
    that is unknown or measures something else, and for a raw unit without a scale."""
    return _converted(table, Wanted(signal, suitable(signal, linear=linear)), column)


def convert_companion(table: Table, name: str, kind: CompanionKind, column: Column) -> Signal:
    """A companion in the unit that its kind is kept in. Errors as of `convert`."""
    return _converted(table, Wanted(name, COMPANIONS[kind]), column)


def _converted(table: Table, wanted: Wanted, column: Column) -> Signal:
    values = table.pick(column.name, column.column)
    recorded, remark = _unit(table, wanted, column)
    factor = _factor(table, wanted, column, recorded)
    scale = 1.0 if column.scale is None else column.scale
    zero = 0.0 if recorded is None else recorded.zero
    if recorded is not None and recorded.raw and recorded.quantity not in wanted.allowed:
        si = " or ".join(wanted.allowed.values())
        remark = f"{wanted.signal} is {scale:g} {si} per {recorded.name} of column {column.name}"
    if (scale, column.offset, factor, zero) != (1.0, 0.0, 1.0, 0.0):
        values = np.asarray((scale * values + column.offset) * factor + zero)
    return Signal(values, recorded, scale, remark)


def _unit(table: Table, wanted: Wanted, column: Column) -> tuple[Unit | None, str]:
    """Unit of a column as configured, as the file says, or as the name ends; and a remark on it."""
    given = column.unit or table.units.get(column.name)
    if given:
        return unit(given, f"{table.path}, column {column.name}"), ""
    found = ending(column.name)[1]
    fits = found is not None and found.quantity in wanted.allowed
    if found is None or not (fits or found.raw):
        return None, ""
    return (
        found,
        ""
        if fits and found.factor == 1
        else f"{wanted.signal} is taken to be in {found.name}, as the name of column {column.name} ends",
    )


def _factor(table: Table, wanted: Wanted, column: Column, recorded: Unit | None) -> float:
    signal, allowed = wanted.signal, wanted.allowed
    if recorded is None or recorded.quantity in allowed:
        return 1.0 if recorded is None else recorded.factor
    where = f"{table.path}, column {column.name}"
    if not recorded.raw or signal == "t":
        hint = f"give its unit, such as {' or '.join(allowed.values())}, or another column"
        raise ConfigError(f"{signal} cannot be in {recorded.name}", where=where, hint=hint)
    if column.scale is None:
        si = " or ".join(allowed.values())
        constant = ", the torque constant" if recorded.quantity == "current" else ""
        hint = f"write {signal}: {{name: {column.name}, scale: ...}} with the {si} per {recorded.name}{constant}"
        raise ConfigError(f"{signal} is in {recorded.name} and needs a scale", where=where, hint=hint)
    return recorded.factor


def remark_on(signal: str, column: Column, recorded: Signal) -> str:
    """The remark on a column that was found by its name."""
    unit = f" in {recorded.unit.name}" if recorded.unit else ""
    return f"{signal} is column {column.name}{unit}, found by its name"


def missing(table: Table, signal: str) -> ConfigError:
    """What to say where a needed signal is nowhere."""
    hint = f"name it under columns: {signal}; {table.offer()}"
    if all(name.isdecimal() for name in table.columns):
        last = [*table.columns][-1]
        hint = f"the file has no names: give the position under columns, such as {signal}: 0; they are 0 to {last}"
    return ConfigError(f"no column was found for {signal}", where=table.path, hint=hint)
