"""What an extension comes to: the model before and after, on every record."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.diagnosis.results import Event, Rejected, Tone
from robotid.display import Displayed
from robotid.estimate.result import FitResult
from robotid.signals.record import Quantity, Role
from robotid.signals.trace import Trace


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """A model on one record. used : whether it was fitted to it."""

    role: Role
    used: bool
    fit_percent: float = field(metadata={"unit": "%", "finite": True})
    rmse: float = field(metadata={"unit": "rad/s or rad", "finite": True, "least": 0.0})
    trace: Trace


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Extension(Displayed):
    """The model before and after: scores by record, Bayesian information criteria on the records of the fit, and the
    fit that came after. added : the effects by which it was extended. dropped : causes that lost their worth in the
    final refit. late, late_within : by how much the torque was recorded late, as of `Diagnosis`, events : what happened
    once, tones : in the torque and not in the motion; all are taken out of the records before both models are scored.
    """

    model: str
    output: Quantity
    unit: str
    model_before: tuple[str, ...]
    model_after: tuple[str, ...]
    added: tuple[str, ...]
    before: dict[str, Score]
    after: dict[str, Score]
    bic_before: float = field(metadata={"unbounded": True})
    bic_after: float = field(metadata={"unbounded": True})
    fit: FitResult
    dropped: tuple[Rejected, ...]
    late: float = field(default=0.0, metadata={"unit": "s", "finite": True})
    late_within: float = field(default=0.5, metadata={"unit": "sampling intervals", "least": 0.0})
    events: tuple[Event, ...] = ()
    tones: tuple[Tone, ...] = ()

    def events_of(self, record: str) -> tuple[Event, ...]:
        """What was taken out of a record before it was scored, in the order in which they were found."""
        return tuple(event for event in self.events if event.record == record)
