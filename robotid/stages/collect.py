"""Stage collect: records from the virtual robot or from measured files, all alike from here on."""

from __future__ import annotations

from collections.abc import Mapping

from robotid.config.schema import Config
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings, Report, inspect
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.reference import Excitation
from robotid.stages.ingestion.measured import measured_record
from robotid.stages.ingestion.virtual import virtual_records, virtual_robot


def collect(settings: Config, excitation: Excitation, files: Mapping[str, Table], log: Log | None = None) -> Recordings:
    """All records of the configuration, in its order. files : the table of each record that names a file. log is told
    of each record.

    Raises what the configuration or the files are wrong with: ConfigError, InputError, NumericsError.
    """
    records: list[Record] = []
    reports: list[Report] = []
    plant = virtual_robot(settings) if any(r.excite is not None for r in settings.records) else None
    for k, wanted in enumerate(settings.records):
        if log is not None:
            log(Progress(wanted.name, k, len(settings.records)))
        if plant is not None and wanted.excite is not None:
            made = virtual_records(plant, wanted, excitation, len(records))
            records += made
            reports += [inspect(record, "virtual robot") for record in made]
        else:
            record, report = measured_record(wanted, files[wanted.name], linear=settings.robot.linear)
            records.append(record)
            reports.append(report)
    return Recordings(tuple(records), tuple(reports))
