"""Stage collect: records from the virtual robot or from measured files, all alike from here on."""

from __future__ import annotations

from collections.abc import Mapping

from robotid.body.identification import Identified
from robotid.config.records import RecordSettings
from robotid.config.schema import Config
from robotid.errors import ConfigError
from robotid.estimate.body import BodySetup, identify_body, with_body
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings, Report, inspect
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.reference import Excitation
from robotid.stages.ingestion.body import body_setup
from robotid.stages.ingestion.measured import measured_records
from robotid.stages.ingestion.virtual import VirtualRecords


class Common:
    """What the axes of a robot share: the motion of the virtual robot, and the body, each made by the axis that asks
    first."""

    def __init__(self) -> None:
        self.virtual = VirtualRecords()
        self._body: Identified | None = None

    def with_body(self, recordings: Recordings, setup: BodySetup) -> Recordings:
        """Records with what the body adds; it is identified once, unless the records of an axis are cut otherwise."""
        names = {record.name for record in recordings.records}
        if self._body is None or self._body.result.cutoff.keys() != names:
            self._body = identify_body(recordings, setup)
        return with_body(recordings, setup, self._body)


def collect(
    settings: Config,
    excitation: Excitation | None,
    files: Mapping[str, Table],
    log: Log | None = None,
    shared: Common | None = None,
) -> Recordings:
    """All records of the configuration, in its order. excitation : None where no record excites; files : the table of
    each record that names a file; shared : by the axes of a robot. log is called with each record. With a robot.body,
    the body is identified, and adds its companions to the records.

    Raises what the configuration or the files are wrong with: ConfigError, InputError, NumericsError.
    """
    records: list[Record] = []
    reports: list[Report] = []
    common = shared or Common()
    for k, wanted in enumerate(settings.records):
        if log is not None:
            log(Progress(wanted.name, k, len(settings.records)))
        if excitation is not None and wanted.excite is not None:
            made = common.virtual.of(settings, wanted, excitation, len(records))
            records += made
            reports += [inspect(record, "virtual robot") for record in made]
        else:
            for record, report in measured_records(wanted, files[wanted.name], linear=settings.robot.linear):
                _unique(settings, wanted, record)
                records.append(record)
                reports.append(report)
    recordings = Recordings(tuple(records), tuple(reports))
    return recordings if settings.robot.body is None else common.with_body(recordings, body_setup(settings.robot))


def _unique(settings: Config, wanted: RecordSettings, record: Record) -> None:
    """Raises ConfigError where what gaps have left of a record has the name of another, or the configuration counts on
    the whole."""
    if not record.experiment:
        return
    hint = "set repair: {gaps: interpolate}, or cut the record by start and stop"
    others = [name for one in settings.records if one.name != wanted.name for name in one.names]
    if record.name in others:
        what = f"gaps cut {wanted.name} into pieces, and {record.name} is another record"
        raise ConfigError(what, where=wanted.name, hint="rename one")
    if wanted.name in settings.robot.changes:
        what = f"gaps cut {wanted.name} into pieces, whose parameters robot.changes cannot name"
        raise ConfigError(what, where=wanted.name, hint=hint)
