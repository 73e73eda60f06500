"""What diagnosis finds out: how much is wrong, where, why, and what the cause cannot be told from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from robotid.diagnosis.misfit.curve import Curve
from robotid.display import Displayed
from robotid.estimate.result import Estimate
from robotid.signals.record import Quantity, Role
from robotid.signals.trace import Trace

Verdict = Literal["clean", "named", "unknown", "not explained"]


@dataclass(frozen=True, slots=True, eq=False)
class Misfit:
    """A model on one record against the noise.

    noise_floor : the smallest RMS error that any model could have here; misfit : the RMS error of this one beyond it,
    root of the difference of squares; both in the unit of the output. explained_after : share of the misfit's energy
    that all causes together remove.
    """

    role: Role
    fit_percent: float = field(metadata={"unit": "%"})
    rmse: float = field(metadata={"unit": "rad/s or rad"})
    noise_floor: float = field(metadata={"unit": "rad/s or rad"})
    misfit: float = field(metadata={"unit": "rad/s or rad"})
    explained_after: float


@dataclass(frozen=True, slots=True)
class Separation:
    """An experiment that tells two causes apart. excite : the block of a record, as JSON, which is YAML as well.

    ratio : RMS difference of the two models' outputs over the noise; against : the effect it tells from the first.
    """

    against: str
    excite: str
    ratio: float


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """An effect that the model lacks.

    explained : share of the misfit's energy above the noise floor that it removes. heldout_gain : of fit, on records
    or blocks that did not serve to fit it. twins : what these data cannot tell from it, itself first.
    """

    effect: str
    parameters: tuple[Estimate, ...]
    explained: float
    heldout_gain: float = field(metadata={"unit": "% points"})
    p_value: float
    twins: tuple[str, ...]
    separation: Separation | None


@dataclass(frozen=True, slots=True, eq=False)
class Rejected:
    """An effect that was tried, and why it is not a cause. heldout_gain is nan where no refit was worth it."""

    effect: str
    explained: float
    heldout_gain: float = field(metadata={"unit": "% points"})
    why: str


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Diagnosis(Displayed):
    """The verdict on one fitted model.

    noise_floor, misfit, remaining : RMS over the records of the fit, in the unit of the output; remaining is the misfit
    that the causes leave. records : by name. missing : the missing torque [Nm] of each record: its measured part is
    what the residual asks for, its simulated part what the causes supply. curves : where the missing torque sits, best
    ordered first. shape : the curve of what no cause explains, its order the share of the misfit.
    refitted : all parameters of the model with its causes, by name, to start from.
    """

    verdict: Verdict
    model: str
    output: Quantity
    unit: str
    noise_floor: float = field(metadata={"unit_in": "unit"})
    misfit: float = field(metadata={"unit_in": "unit"})
    remaining: float = field(metadata={"unit_in": "unit"})
    records: dict[str, Misfit]
    causes: tuple[Cause, ...]
    rejected: tuple[Rejected, ...]
    curves: tuple[Curve, ...]
    missing: dict[str, Trace]
    residuals: dict[str, Trace]
    shape: Curve | None
    remarks: tuple[str, ...] = ()
    refitted: dict[str, float] = field(default_factory=dict, metadata={"unit": "SI"})
