"""Records from measured files, as the configuration says."""

from __future__ import annotations

from robotid.config.columns import ColumnSettings
from robotid.config.records import RecordSettings
from robotid.model.companion import CompanionKind
from robotid.signals import measured
from robotid.signals.columns import Column
from robotid.signals.measured import CompanionColumn, Selection
from robotid.signals.quality import Report
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.sampling import Policy


def measured_records(settings: RecordSettings, table: Table, *, linear: bool) -> tuple[tuple[Record, Report], ...]:
    """One record from its file, or several where gaps have cut it. linear : a sliding axis, whose position does not
    wrap around.

    Raises ConfigError for columns that are not there, InputError for flaws that are refused, NumericsError for a record
    without excitation.
    """
    given = settings.columns.model_fields_set if settings.columns else frozenset[str]()
    chosen = Selection(
        name=settings.name,
        role=settings.role,
        use=settings.use,
        columns={signal: _column(getattr(settings.columns, signal)) for signal in given},
        sampling_time=settings.sampling_time,
        start=settings.start,
        stop=settings.stop,
        speed_delay=settings.speed_delay,
        torque_delay=settings.torque_delay,
        policy=Policy(**settings.repair.model_dump()) if settings.repair else Policy(),
        linear=linear,
        companions={
            name: CompanionColumn(CompanionKind(one.kind), _given(one)) for name, one in settings.signals.items()
        },
    )
    return measured.measured_records(chosen, table)


def _column(column: str | ColumnSettings | None) -> Column | None:
    if column is None or isinstance(column, str):
        return None if column is None else Column(column)
    return _given(column)


def _given(column: ColumnSettings) -> Column:
    return Column(column.name, column.column, column.unit, column.scale, column.offset)
