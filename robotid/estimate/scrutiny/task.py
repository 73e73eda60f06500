"""What is fitted, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from robotid.errors import NumericsError
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import FitResult
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.progress import Iteration
from robotid.signals.record import Record


@dataclass(frozen=True, slots=True, eq=False)
class FitTask:
    """What is fitted: the arguments of `fit_model`. found : what the initialisation found, also of parameters for which
    another start was given. left_out : starts that it found and does not trust."""

    name: str
    joint: Joint
    parameters: Parameters
    records: Sequence[Record]
    options: FitOptions
    log: Callable[[Iteration], None] | None = None
    found: Mapping[str, float] = field(default_factory=dict)
    left_out: tuple[Parameters, ...] = ()

    def fit(self) -> FitResult:
        """The fit of `fit_model`, and its errors."""
        return fit_model(self.name, self.joint, self.parameters, self.records, self.options, self.log)

    def attempt(self) -> FitResult | None:
        """The fit, None where the records cannot be simulated."""
        try:
            return self.fit()
        except NumericsError:
            return None

    def with_options(self, **changes: Any) -> FitTask:
        """The same with other options."""
        return replace(self, options=replace(self.options, **changes))


@dataclass(frozen=True, slots=True, eq=False)
class ScrutinisedFit:
    """A fit, and the one from the same start with a constant torque free, which the model does not have; None where
    that is not far better, or not asked for. The name of the latter is that of the fit and OFFSET_SUFFIX."""

    fit: FitResult
    with_offset: FitResult | None = None


def noted(found: ScrutinisedFit, note: str) -> ScrutinisedFit:
    """The same with one remark more."""
    return replace(found, fit=replace(found.fit, remarks=(*found.fit.remarks, note)))
