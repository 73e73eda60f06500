"""What an estimation returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from robotid.catalogue import assemble
from robotid.display import Displayed
from robotid.errors import RobotidError
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.record import Quantity


class End(StrEnum):
    """How an iterative fit ended; the value is the sentence a person reads."""

    CONVERGED = "converged"
    STALLED = (
        "stalled: no step lowers the cost any further, yet the gradient has not vanished, as at kinks of dry friction"
    )
    ITERATIONS = "stopped at the largest number of iterations"
    INTERRUPTED = "interrupted: this is the last iterate"


@dataclass(frozen=True, slots=True)
class Estimate:
    """One parameter with its uncertainty.

    std : standard deviation for white residuals; std_robust : for residuals as coloured as they are; both nan when
    the parameter was not estimated. remark : what a person should know ("fixed", "at its lower bound",
    "unidentifiable ...").
    """

    name: str
    value: float = field(metadata={"unit_in": "unit", "finite": True})
    unit: str
    std: float = field(metadata={"unit_in": "unit", "unbounded": True, "least": 0.0})
    std_robust: float = field(metadata={"unit_in": "unit", "unbounded": True, "least": 0.0})
    lower: float = field(metadata={"unit_in": "unit", "unbounded": True})
    upper: float = field(metadata={"unit_in": "unit", "unbounded": True})
    fixed: bool = False
    remark: str = ""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FitResult(Displayed):
    """A model fitted to a combination of records.

    covariance, covariance_robust : (p, p) over all parameters in order, zero where fixed. initial_states : record
    name to (nx,) in the joint's state order. noise_std : per record, in the unit of the output. cost : (iterations +
    1,). fit_percent : per record of the fit, eq. (15). remarks : what makes the fit doubtful. start : values from which
    it started, by parameter. horizon : of the pieces that the data made a fit take, and of any that
    an extension took. keeps_angle : the motor's angle is a state of its joint.
    """

    name: str
    records: tuple[str, ...]
    output: Quantity
    structure: Structure
    parameters: tuple[Estimate, ...] = field(metadata={"shape": ("p",)})
    covariance: Array = field(metadata={"unit": "SI", "shape": ("p", "p"), "finite": True})
    covariance_robust: Array = field(metadata={"unit": "SI", "shape": ("p", "p"), "finite": True})
    initial_states: dict[str, Array] = field(metadata={"unit": "SI", "shape": ("states",), "finite": True})
    noise_std: dict[str, float] = field(metadata={"unit": "rad/s or rad", "finite": True, "least": 0.0})
    fit_percent: dict[str, float] = field(metadata={"unit": "%", "finite": True})
    cost: Array = field(metadata={"shape": ("costs",), "finite": True, "least": 0.0})
    iterations: int = field(metadata={"least": 0.0})
    end: End
    seconds: float = field(metadata={"unit": "s", "finite": True, "least": 0.0})
    remarks: tuple[str, ...] = field(default=(), kw_only=True)
    start: dict[str, float] = field(default_factory=dict, kw_only=True, metadata={"unit": "SI", "finite": True})
    horizon: float | None = field(default=None, kw_only=True, metadata={"unit": "s", "positive": True})
    keeps_angle: bool = field(default=False, kw_only=True)

    @property
    def converged(self) -> bool:
        return self.end is End.CONVERGED

    @property
    def misfit(self) -> float:
        """Geometric mean of the records' residuals, in the unit of the output."""
        return float(np.exp(np.mean(np.log(np.maximum(list(self.noise_std.values()), 1e-300)))))

    def contradictions(self) -> Iterator[str]:
        """What does not agree with its records and its joint, as sentences: for a result that was read from a file."""
        if set(self.records) != set(self.fit_percent):
            yield f"the fits of {self.name} are not those of its records"
        if any((np.diag(matrix) < 0.0).any() for matrix in (self.covariance, self.covariance_robust)):
            yield f"a variance of {self.name} is negative"
        try:
            joint = assemble(self.structure, angle=self.keeps_angle or self.output == "position")
        except RobotidError as error:
            yield str(error)
            return
        if tuple(p.name for p in self.parameters) != joint.parameters().names:
            yield f"the parameters of {self.name} are not those of its joint"
        if any(len(state) != joint.nx for state in self.initial_states.values()):
            yield f"the first states of {self.name} are not those of its joint"

    def __getitem__(self, name: str) -> Estimate:
        return next(p for p in self.parameters if p.name == name)


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Every model of a configuration, and the name of the one that later stages use."""

    models: dict[str, FitResult] = field(metadata={"keys": "name"})
    best: str = field(metadata={"among": "models"})

    @property
    def interrupted(self) -> bool:
        """Whether the keyboard ended it, so that it must not count as done."""
        return any(model.end is End.INTERRUPTED for model in self.models.values())
