"""What came of watching."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Watched = Literal["unchanged", "changed", "not explained"]


@dataclass(frozen=True, slots=True)
class ParameterShift:
    """A parameter that is another in a log: its value in the accepted model, the change, and its standard deviation."""

    parameter: str
    unit: str
    before: float
    shift: float
    std: float


@dataclass(frozen=True, slots=True)
class WatchedLog:
    """A model on one log.

    state : "changed" where other parameters explain what is new, "not explained" where none do. p_value : of the log
    being as those of the fit, corrected for the number of logs and tests; p_parameters : of no parameter being another;
    p_residual : of the residual being no larger than on the records of the fit. fit_percent : eq. (15), and
    usual_percent, the mean on those records. residual_ratio : energy of the residual over that on those records, every
    frequency weighed by its noise. change : of one parameter that explains it best, None where nothing has changed or
    no single one does; twins : parameters that explain it as well, itself first.
    """

    record: str
    state: Watched
    p_value: float
    p_parameters: float
    p_residual: float
    fit_percent: float
    usual_percent: float
    residual_ratio: float
    change: ParameterShift | None = None
    twins: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WatchResult:
    """A model on new logs. model : its name; records : those of its fit; level : of significance of all logs
    together."""

    model: str
    records: tuple[str, ...]
    level: float
    logs: tuple[WatchedLog, ...]
    remarks: tuple[str, ...] = ()

    @property
    def alarm(self) -> bool:
        """Whether the model is no longer right on one of the logs."""
        return any(log.state != "unchanged" for log in self.logs)
