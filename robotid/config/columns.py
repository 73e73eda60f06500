"""Which column of a measured file is what, and what to do about its flaws."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from robotid.config.section import Finite, Section


class ColumnSettings(Section):
    """One signal: scale * recorded + offset, in the unit.

    name : of the column, dotted inside structs; column : of a matrix, counted from 0; unit : absent, as the file says.
    """

    name: str
    column: Annotated[int, Field(ge=0)] | None = None
    unit: str | None = None
    scale: Finite = 1.0
    offset: Finite = 0.0


class ColumnsSettings(Section):
    """Columns by signal, a name or more. A signal left out is found by its name; null says that there is none."""

    t: str | ColumnSettings | None = None
    tau_m: str | ColumnSettings | None = None
    phi_m: str | ColumnSettings | None = None
    dphi_m: str | ColumnSettings | None = None
    phi_a: str | ColumnSettings | None = None
    ref: str | ColumnSettings | None = None


class RepairSettings(Section):
    """Flaws of a recording. Every repair is said; absent: a few samples are mended, more are refused."""

    gaps: Literal["refuse", "interpolate"] | None = None
    nan: Literal["refuse", "interpolate"] | None = None
    duplicates: Literal["refuse", "drop"] | None = None
    wrap: Literal["refuse", "unwrap"] | None = None
