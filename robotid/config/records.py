"""The records section: experiments to make on the virtual robot, or measured files to read."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_serializer, model_validator

from robotid.config.columns import ColumnsSettings, CompanionSettings, RepairSettings
from robotid.config.excitation import ExcitationSettings
from robotid.config.section import Finite, Name, NonNegative, Positive, Section
from robotid.model.companion import drive_of


class RecordSettings(Section):
    """One experiment, of the virtual robot or of a file.

    name : of the record. excite : the reference that the virtual robot follows. file : relative to the configuration,
    several joined by time. repair : what is done about flaws of the file. role : estimate, or validate to be held out
    of every fit. use : which initialisation it serves, by default both. columns : which column of the file is what,
    absent: found by name. signals : companions by name, further columns that effects may read. sampling_time [s] :
    instead of a time column. start, stop [s] : the part of the file that is used, counted from its first sample.
    speed_delay [samples] : by which the recorded speed is late. torque_delay [s] : by which the recorded torque is late
    against the motion. pose [rad] : where the arms of a virtual robot of several axes are at the start, by axis,
    absent: at zero. others : what its other axes follow, by axis; a robot with several axes fills them in.
    """

    name: Name
    role: Literal["estimate", "validate"] = "estimate"
    use: Literal["rigid", "flex", "both"] = "both"
    excite: ExcitationSettings | None = None
    file: str | Annotated[tuple[str, ...], Field(min_length=2)] | None = None
    columns: ColumnsSettings | None = None
    signals: dict[Name, CompanionSettings] = {}
    sampling_time: Positive | None = None
    repair: RepairSettings | None = None
    start: NonNegative | None = None
    stop: Positive | None = None
    speed_delay: int = 0
    torque_delay: float = 0.0
    pose: dict[Name, Finite] = {}
    others: dict[Name, ExcitationSettings] = {}

    @property
    def kinds(self) -> dict[str, str]:
        """The kind of each companion: of a file's signals, or of what a virtual robot shows of its other axes."""
        shown = dict.fromkeys(self.others, "angle") | {drive_of(name): "drive" for name in self.others}
        return shown | {name: one.kind for name, one in self.signals.items()}

    @property
    def files(self) -> tuple[str, ...]:
        """The measured files, none of a record that excites."""
        return () if self.file is None else (self.file,) if isinstance(self.file, str) else self.file

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the records that come of it: name, and for further realisations name_r2, name_r3."""
        count = 1 if self.excite is None else self.excite.realisations
        return (self.name, *(f"{self.name}_r{k}" for k in range(2, count + 1)))

    @field_serializer("columns")
    def _as_written(self, columns: ColumnsSettings | None) -> dict[str, Any] | None:
        """A signal that is null differs from one that is left out."""
        return None if columns is None else columns.model_dump(mode="json", exclude_unset=True)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.excite is None) == (self.file is None):
            raise ValueError("a record needs either excite or file" + ("" if self.file is None else ", not both"))
        for key in ("columns", "signals", "sampling_time", "repair", "start", "stop", "speed_delay", "torque_delay"):
            if self.excite is not None and getattr(self, key):
                raise ValueError(f"{key} belongs to a record with a file")
        for key in ("pose", "others"):
            if self.file is not None and getattr(self, key):
                raise ValueError(f"{key} belongs to a record that excites")
        for name in self.signals:
            if name in ColumnsSettings.model_fields:
                raise ValueError(f"{name} is the name of a column of the joint itself; give the companion another one")
        if self.start is not None and self.stop is not None and self.start >= self.stop:
            raise ValueError(f"nothing lies between start {self.start:g} s and stop {self.stop:g} s")
        return self
