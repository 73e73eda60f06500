"""What validation finds out, model by model and record by record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from robotid.catalogue import assemble
from robotid.display import Displayed
from robotid.errors import RobotidError
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.frf import Frf
from robotid.signals.record import Quantity, Role
from robotid.signals.trace import Trace

CONFIDENCE = 0.99  # of the tests of a residual

Verdict = Literal["seen", "weak", "unseen", "fixed"]


@dataclass(frozen=True, slots=True, eq=False)
class ResidualTest:
    """Residual tests (Ljung 1999, section 16.6).

    autocorrelation (lags,) at lags 1 to LAGS samples; all of them are within +- band at 99 % if the residual is white.
    crosscorrelation (2 LAGS + 1,) of the residual at t with the torque at t - lag, lags -LAGS to LAGS; all at positive
    lags are within +- cross_band at 99 % if independent. Negative lags show feedback, and do not count. p values : of
    the largest correlation among those that count, so that a p below 0.01 is one outside the band and the other way
    round. white_part : standard deviation of a white noise as dense as the residual is in the upper half of its
    spectrum; coloured_part : of what the residual holds beyond it.
    """

    autocorrelation: Array = field(metadata={"shape": ("lags",), "may_be_empty": True, "finite": True})
    band: float = field(metadata={"least": 0.0})
    crosscorrelation: Array = field(metadata={"shape": ("both ways",), "may_be_empty": True, "finite": True})
    cross_band: float = field(metadata={"least": 0.0})
    whiteness_p: float
    independence_p: float
    white_part: float = field(metadata={"unit": "rad/s or rad", "least": 0.0})
    coloured_part: float = field(metadata={"unit": "rad/s or rad", "least": 0.0})

    @property
    def white(self) -> bool:
        """No pattern in time at 99 %."""
        return self.whiteness_p >= 1 - CONFIDENCE

    @property
    def independent(self) -> bool:
        """Nothing that the torque explains at 99 %."""
        return self.independence_p >= 1 - CONFIDENCE

    @property
    def undecided(self) -> bool:
        """Whether the record is too short for its residual: no correlation with the torque could be too large."""
        return self.cross_band >= 1.0

    @property
    def verdict(self) -> str:
        """In words."""
        if self.undecided:
            colour = "white" if self.white else "coloured"
            return f"{colour}; whether it follows the torque, so few independent stretches cannot tell"
        if self.white and self.independent:
            return "white, and no sign of the torque: nothing is left to explain"
        if self.independent:
            return "coloured, though not by the torque at these lags: noise with a memory, or what the model lacks"
        return "follows the torque: the model lacks something"


@dataclass(frozen=True, slots=True)
class Identifiability:
    """How well the records of a fit see one parameter.

    relative_std : robust standard deviation over the value, None for a value of zero. cosine : of its Jacobian column
    with the span of the others, first states included. torque_share, largest_share : of its effect at its port, RMS
    and where it is largest, None for a channel. why : the reasons in words.
    """

    name: str
    verdict: Verdict
    why: str
    relative_std: float | None = field(default=None, metadata={"unbounded": True, "least": 0.0})
    cosine: float | None = field(default=None, metadata={"least": 0.0})
    torque_share: float | None = field(default=None, metadata={"least": 0.0})
    largest_share: float | None = field(default=None, metadata={"least": 0.0})


@dataclass(frozen=True, slots=True, eq=False)
class Perturbation:
    """Change of the fit [%] of one record when one parameter at a time is perturbed, first states kept.

    names (p,) : the parameters whose value is not zero. plus, minus (p,) : with the value raised and lowered by
    percent, nan where the joint then diverges.
    """

    percent: float = field(metadata={"unit": "%", "finite": True, "least": 0.0})
    names: tuple[str, ...] = field(metadata={"shape": ("changed",)})
    plus: Array = field(metadata={"unit": "%", "shape": ("changed",)})
    minus: Array = field(metadata={"unit": "%", "shape": ("changed",)})


@dataclass(frozen=True, slots=True)
class LoopErrors:
    """Errors of the closed-loop simulation: 100 ||y - yhat|| / ||y||, and root mean squares."""

    position_percent: float = field(metadata={"unit": "%", "least": 0.0})
    speed_percent: float = field(metadata={"unit": "%", "least": 0.0})
    torque_percent: float = field(metadata={"unit": "%", "least": 0.0})
    position_rmse: float = field(metadata={"unit": "rad", "least": 0.0})
    speed_rmse: float = field(metadata={"unit": "rad/s", "least": 0.0})
    torque_rmse: float = field(metadata={"unit": "Nm", "least": 0.0})


@dataclass(frozen=True, slots=True, eq=False)
class Bode:
    """Magnitudes of a linearised model from motor torque, (n,) at all frequencies of the measured responses.

    distance : per response the RMS of the ratio to it, uncertain lines counting less.
    """

    frequency: Array = field(metadata={"unit": "Hz", "shape": ("n",), "positive": True})
    acceleration: Array = field(metadata={"unit": "rad/s2/Nm", "shape": ("n",)})
    speed: Array = field(metadata={"unit": "rad/s/Nm", "shape": ("n",)})
    distance: dict[str, float] = field(metadata={"unit": "dB", "unbounded": True, "least": 0.0})


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
    fit_percent: float = field(metadata={"unit": "%", "finite": True})
    rmse_speed: float = field(metadata={"unit": "rad/s", "finite": True, "least": 0.0})
    rmse_position: float = field(metadata={"unit": "rad", "finite": True, "least": 0.0})
    torque_error_percent: float | None = field(metadata={"unit": "%", "least": 0.0})
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

    names: tuple[str, ...] = field(metadata={"shape": ("p",)})
    units: tuple[str, ...] = field(metadata={"shape": ("p",)})
    values: Array = field(metadata={"unit_in": "units", "shape": ("p",), "finite": True})
    output: Quantity
    structure: Structure
    records: dict[str, RecordValidation]
    covariance: Array = field(metadata={"unit": "SI", "shape": ("p", "p"), "may_be_empty": True, "finite": True})
    correlation: Array = field(metadata={"shape": ("p", "p"), "may_be_empty": True, "finite": True})
    identifiability: tuple[Identifiability, ...]
    bode: Bode | None
    remarks: tuple[str, ...] = ()

    def contradictions(self) -> Iterator[str]:
        """What does not agree with its joint, as sentences: for a model that was read from a file."""
        try:
            names = assemble(self.structure, angle=self.output == "position").parameters().names
        except RobotidError as error:
            yield str(error)
        else:
            if self.names != names:
                yield f"the parameters {', '.join(self.names)} are not those of its joint"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Validation(Displayed):
    """Every model, the initial one first. frfs : the measured responses that `bode` is to be seen beside. failed : what
    stays below the thresholds of the configuration, in sentences."""

    models: dict[str, ModelValidation]
    best: str = field(metadata={"among": "models"})
    frfs: tuple[Frf, ...]
    failed: tuple[str, ...] = ()
