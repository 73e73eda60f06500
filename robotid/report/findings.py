"""What a run has found so far: the contents of its artifacts, as far as there are any."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.diagnosis.results import Diagnosis, Event
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension.results import Extension
from robotid.model.units import on_axis, unit_of
from robotid.report.evidence.results import Evidence
from robotid.signals.frf import Frf
from robotid.signals.quality import Recordings
from robotid.signals.record import usable_horizon
from robotid.signals.reference import Excitation
from robotid.validation.results import Validation

CLEAN = 0.5  # of the noise: a misfit below it shows nowhere


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """All that a report is made of, None where a stage has not run. linear : the axis slides. horizon : length [s] of
    the pieces in which fits are asked to simulate, None: whole records, or what the data ask for. estimate_states :
    whether the first states of a record are found by least squares. evidence : what figures show beside all this."""

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
    estimate_states: bool = True
    evidence: Evidence = field(default_factory=Evidence)

    @property
    def pieces(self) -> float | None:
        """Length [s] of the pieces in which a diagnosis and an extension simulate, None: whole records."""
        if self.horizon is not None:
            return self.horizon
        fit = None if self.fits is None else self.fits.models[self.fits.best].horizon
        chosen = fit if self.diagnosis is None else self.diagnosis.horizon or fit
        return usable_horizon(chosen, () if self.recordings is None else self.recordings.records)

    @property
    def extension_that_adds(self) -> Extension | None:
        """The extension, where it adds anything to the model."""
        return self.extension if self.extension is not None and self.extension.added else None

    @property
    def frfs(self) -> tuple[Frf, ...]:
        """The measured frequency responses."""
        if self.validation is not None and self.validation.frfs:
            return self.validation.frfs
        return self.flex.frfs if self.flex is not None else ()

    def is_clean(self, record: str) -> bool:
        """Whether nothing of a record is left to explain."""
        misfit = None if self.diagnosis is None else self.diagnosis.records.get(record)
        return misfit is not None and misfit.misfit < CLEAN * misfit.noise_floor

    def events_of(self, record: str) -> tuple[Event, ...]:
        """What the diagnosis found to have happened once in a record."""
        return () if self.diagnosis is None else tuple(e for e in self.diagnosis.events if e.record == record)

    @property
    def unit_of_output(self) -> str:
        """What the residual of a fit is counted in."""
        output = "speed" if self.fits is None else self.fits.models[self.fits.best].output
        return unit_of(output, linear=self.linear)

    def samples_of(self, record: str) -> int:
        """How many samples a record has, 0 where it is not known."""
        return next((len(r) for r in self.recordings.records if r.name == record), 0) if self.recordings else 0

    def units(self, unit: str) -> str:
        """What the unit of a turning axis is called here."""
        return on_axis(linear=self.linear)(unit)
