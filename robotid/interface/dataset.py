"""Records together: which there are, what serves the fit, what is held out of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, overload

from robotid.config.suggest import suggest
from robotid.display import Displayed
from robotid.errors import ConfigError
from robotid.report.display import Columns, View, shows
from robotid.report.figures import draw
from robotid.report.tables import collect
from robotid.report.tables.table import Table
from robotid.signals.quality import Recordings, Report, inspect
from robotid.signals.record import Record, Role

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Dataset(Sequence[Record], Displayed):
    """Records with roles, and a report on each; it cannot be changed.

    A record of role "estimate" serves the fit, one of role "validate" is held out of it. `data[0]` and `data["name"]`
    are records, `data[1:]` and `a + b` are datasets. reports : what was found and repaired in each record.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> data = rid.read(motor_log(), name="log") + rid.read(motor_log(seed=2), name="day2", role="validate")
    >>> data.names
    ('log', 'day2')
    >>> data["day2"].role
    'validate'
    """

    records: tuple[Record, ...] = ()
    reports: tuple[Report, ...] = ()

    def __post_init__(self) -> None:
        twice = [name for name, times in Counter(self.names).items() if times > 1]
        if twice:
            hint = "give one of them another: rid.read(..., name=...)"
            raise ConfigError(f'two records have the name "{twice[0]}"', where="Dataset", hint=hint)

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    @overload
    def __getitem__(self, key: int | str) -> Record: ...
    @overload
    def __getitem__(self, key: slice) -> Dataset: ...
    def __getitem__(self, key: int | str | slice) -> Record | Dataset:
        if isinstance(key, slice):
            return self.only(r.name for r in self.records[key])
        if isinstance(key, str):
            if key not in self.names:
                raise ConfigError(f'there is no record "{key}"', where="Dataset", hint=suggest(key, self.names))
            return self.records[self.names.index(key)]
        return self.records[key]

    def __add__(self, other: Record | Iterable[Record]) -> Dataset:
        more = as_dataset(other)
        return Dataset((*self.records, *more.records), (*self.reports, *more.reports))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the records."""
        return tuple(r.name for r in self.records)

    @property
    def recordings(self) -> Recordings:
        """The records as a stage hands them on."""
        return Recordings(self.records, self.reports)

    def only(self, names: Iterable[str]) -> Dataset:
        """The records of these names."""
        wanted = set(names)
        return Dataset(
            tuple(r for r in self.records if r.name in wanted), tuple(r for r in self.reports if r.name in wanted)
        )

    def of_role(self, role: Role) -> Dataset:
        """The records that serve the fit ("estimate"), or are held out of it ("validate")."""
        return self.only(r.name for r in self.records if r.role == role)

    def as_role(self, role: Role) -> Dataset:
        """The same records, all of this role."""
        return Dataset(tuple(replace(r, role=role) for r in self.records), self.reports)


def as_dataset(records: Record | Iterable[Record]) -> Dataset:
    """Records as a dataset, with a report on each that has none. Raises ConfigError for what is no record, and as
    `inspect` does."""
    if isinstance(records, Dataset):
        return records
    try:
        listed = (records,) if isinstance(records, Record) else tuple(records)
    except TypeError:
        listed = (None,)  # type: ignore[assignment]
    for one in listed:
        if not isinstance(one, Record):
            what = f"a record was expected, found {type(records if one is None else one).__name__}"
            raise ConfigError(what, hint="rid.read(...) or rid.Record.from_arrays(...) makes one")
    return Dataset(listed, tuple(inspect(r, r.name) for r in listed))


@shows(Dataset)
class DatasetView(View[Dataset]):
    """What was read."""

    def line(self) -> str:
        return ", ".join(f"{r.name} ({r.role})" for r in self.content) or "no record"

    def tables(self) -> Sequence[Table]:
        return collect.tables(self.content.recordings)

    def columns(self) -> Columns:
        r = self.content.records
        return {
            "record": [one.name for one in r],
            "role": [one.role for one in r],
            "use": [one.use for one in r],
            "samples": [len(one) for one in r],
            "sampling_time": [one.sampling_time for one in r],
            "duration": [one.duration for one in r],
        }

    def figure(self) -> Figure:
        return draw(self.content.recordings)
