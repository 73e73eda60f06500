"""Which column of a measured file is what, which part of it is used, and what to do about its flaws."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from robotid.config.section import Finite, Section


def _not_zero(scale: float) -> float:
    if scale == 0:
        raise ValueError("a scale of zero leaves nothing of the signal")
    return scale


def _position(name: Any) -> Any:
    return str(name) if isinstance(name, int) and not isinstance(name, bool) and name >= 0 else name


ColumnName = Annotated[str, BeforeValidator(_position)]
"""The name of a column, or its position, counted from 0."""


class ColumnSettings(Section):
    """One signal: scale * recorded + offset, in the unit.

    name : of the column, dotted inside structs, or its position in the file, counted from 0; column : of a matrix,
    counted from 0; unit : absent, as the file says. scale : how much of the SI unit one of volts, amperes, percent or
    counts is, which need one. offset : is added last.
    """

    name: ColumnName
    column: Annotated[int, Field(ge=0)] | None = None
    unit: str | None = None
    scale: Annotated[Finite, AfterValidator(_not_zero)] | None = None
    offset: Finite = 0.0


class CompanionSettings(ColumnSettings):
    """A further signal that may explain the joint: a column as any other, and its kind.

    kind : angle (of another axis), temperature (kept in degC), torque (that acts beside the motor's), voltage (of the
    supply), inertia (of the axis, as it changes with the pose) or drive (the torque of another axis, for robot.body).
    """

    kind: Literal["angle", "temperature", "torque", "voltage", "inertia", "drive"]


class ColumnsSettings(Section):
    """Columns by signal, a name or more. A signal left out is found by its name; null says that there is none.

    t : time. tau_m : torque of the motor. phi_m : angle of the motor. dphi_m : speed of the motor. phi_a : angle of the
    arm, behind the gear. ref : set point. disturbance : the part of tau_m that the controller did not command.
    """

    t: ColumnName | ColumnSettings | None = None
    tau_m: ColumnName | ColumnSettings | None = None
    phi_m: ColumnName | ColumnSettings | None = None
    dphi_m: ColumnName | ColumnSettings | None = None
    phi_a: ColumnName | ColumnSettings | None = None
    ref: ColumnName | ColumnSettings | None = None
    disturbance: ColumnName | ColumnSettings | None = None


class RepairSettings(Section):
    """Flaws of a recording. Every repair is reported; absent: a few samples are repaired, more are refused.

    gaps : samples that are missing. nan : samples that are no numbers. duplicates : samples that were written twice.
    wrap : an angle that starts anew after each revolution.
    """

    gaps: Literal["refuse", "interpolate"] | None = None
    nan: Literal["refuse", "interpolate"] | None = None
    duplicates: Literal["refuse", "drop"] | None = None
    wrap: Literal["refuse", "unwrap"] | None = None
