"""What a run has found so far: the contents of its artifacts, as far as there are any."""

from __future__ import annotations

from dataclasses import dataclass

from robotid.diagnosis.results import Diagnosis
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension.results import Extension
from robotid.model.units import on_axis
from robotid.signals.quality import Recordings
from robotid.signals.reference import Excitation
from robotid.validation.results import Validation


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """All that a report is made of, None where a stage has not run. linear : the axis slides. horizon : length [s] of
    the pieces in which a fit simulates, None: whole records."""

    robot: str
    linear: bool = False
    horizon: float | None = None
    excitation: Excitation | None = None
    recordings: Recordings | None = None
    rigid: RigidResult | None = None
    flex: FlexResult | None = None
    fits: Fits | None = None
    validation: Validation | None = None
    diagnosis: Diagnosis | None = None
    extension: Extension | None = None

    def samples_of(self, record: str) -> int:
        """How many samples a record has, 0 where it is not known."""
        return next((len(r) for r in self.recordings.records if r.name == record), 0) if self.recordings else 0

    def units(self, unit: str) -> str:
        """What the unit of a turning axis is called here."""
        return on_axis(linear=self.linear)(unit)
