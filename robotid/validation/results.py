"""What validation finds out, model by model and record by record."""

from __future__ import annotations

from dataclasses import dataclass, field

from robotid.display import Displayed
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.frf import Frf
from robotid.signals.record import Quantity, Role
from robotid.signals.trace import Trace
from robotid.validation.bode import Bode
from robotid.validation.closed_loop import LoopErrors
from robotid.validation.identifiability import Identifiability
from robotid.validation.perturbation import Perturbation
from robotid.validation.residual_tests import ResidualTest


@dataclass(frozen=True, slots=True, eq=False)
class RecordValidation:
    """One model on one record.

    used : whether the model was fitted to the record. fit_percent : eq. (15), of the quantity that the fit compared.
    rmse_speed, rmse_position : of the open-loop simulation. torque_error_percent : of inverse dynamics, None where
    the torque is constant. closed_loop : None where controller or reference is unknown. perturbation : of the
    best model, empty for the others. remarks : what could not be done, or was done with licence.
    """

    role: Role
    used: bool
    fit_percent: float = field(metadata={"unit": "%"})
    rmse_speed: float = field(metadata={"unit": "rad/s"})
    rmse_position: float = field(metadata={"unit": "rad"})
    torque_error_percent: float | None = field(metadata={"unit": "%"})
    closed_loop: LoopErrors | None
    residual: ResidualTest
    perturbation: Perturbation
    trace: Trace
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ModelValidation:
    """One model. records : by name, those on which it could be simulated. values (p,) : of its parameters.

    covariance (robust) and correlation : (p, p), empty for a model that was not fitted, as is identifiability.
    remarks : records on which the simulation diverges.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array = field(metadata={"unit_in": "units"})
    output: Quantity
    structure: Structure
    records: dict[str, RecordValidation]
    covariance: Array = field(metadata={"unit": "SI"})
    correlation: Array
    identifiability: tuple[Identifiability, ...]
    bode: Bode | None
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Validation(Displayed):
    """Every model, the initial one first. frfs : the measured responses that `bode` is to be seen beside. failed : what
    stays below the thresholds of the configuration, in sentences."""

    models: dict[str, ModelValidation]
    best: str
    frfs: tuple[Frf, ...]
    failed: tuple[str, ...] = ()
