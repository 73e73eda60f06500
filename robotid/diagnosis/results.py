"""What diagnosis finds out: how much is wrong, where, why, and what the data cannot distinguish from the cause."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import Literal

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.display import Displayed
from robotid.estimate.result import Estimate, FitResult
from robotid.model.array import Array
from robotid.signals.record import Quantity, Role
from robotid.signals.trace import Trace

Verdict = Literal["clean", "named", "partly named", "unknown", "not explained"]
EventKind = Literal["bump", "step", "drift"]
NOT_EXAMINED = "not examined: the time was up"  # why an effect that scored was rejected


@dataclass(frozen=True, slots=True, eq=False)
class Misfit:
    """A model on one record against the noise.

    noise_floor : the smallest RMS error that any model could have here; misfit : the RMS error of this one beyond it,
    root of the difference of squares; both in the unit of the output. explained_after : share of the misfit's energy
    that all causes together remove, every frequency weighed by the noise that it has.
    """

    role: Role
    fit_percent: float = field(metadata={"unit": "%", "finite": True})
    rmse: float = field(metadata={"unit": "rad/s or rad", "finite": True, "least": 0.0})
    noise_floor: float = field(metadata={"unit": "rad/s or rad", "least": 0.0})
    misfit: float = field(metadata={"unit": "rad/s or rad", "finite": True, "least": 0.0})
    explained_after: float = field(metadata={"finite": True})


@dataclass(frozen=True, slots=True)
class Separation:
    """An experiment that tells two causes apart. excite : the block of a record, as JSON, which is YAML as well.

    ratio : RMS difference of the two models' outputs over the noise; against : the effect it tells from the first.
    """

    against: str
    excite: str
    ratio: float = field(metadata={"unbounded": True, "least": 0.0})


@dataclass(frozen=True, slots=True)
class Confounded:
    """An effect whose answer on these motions is like that of a cause. correlation : share of the cause's amplitude
    that lies along it, from 0 to 1, once the fitted parameters have taken what they can."""

    effect: str
    correlation: float = field(metadata={"finite": True})


@dataclass(frozen=True, slots=True)
class Event:
    """What happened once in a record, and is no effect of the machine.

    start, end : in seconds of the record. kind : a "bump" lasts from start to end, a "step" lasts to the end of the
    record, a "drift" grows from nothing at the start of the record to its size at the end. friction : whether the
    torque opposes the motion, rather than always acts one way. torque : at the motor, signed as an applied torque, of
    friction as its increase; std : its standard deviation. p_value : of the largest event of a record without any.
    gradual : whether a bump grows to its size in its middle and fades again, by a raised cosine.
    """

    record: str
    kind: EventKind
    friction: bool
    start: float = field(metadata={"unit": "s", "finite": True})
    end: float = field(metadata={"unit": "s", "finite": True})
    torque: float = field(metadata={"unit": "Nm", "finite": True})
    std: float = field(metadata={"unit": "Nm", "unbounded": True, "least": 0.0})
    p_value: float
    gradual: bool = False


@dataclass(frozen=True, slots=True)
class Tone:
    """A tone in the recorded torque, cosine cos(2 pi frequency t) + sine sin(2 pi frequency t), which the motion does
    not show.

    start, end : first and last sample of the record, or of a stretch of it, t being the time of the record [s].
    """

    record: str
    start: float = field(metadata={"unit": "s", "finite": True})
    end: float = field(metadata={"unit": "s", "finite": True})
    frequency: float = field(metadata={"unit": "Hz", "positive": True})
    cosine: float = field(metadata={"unit": "Nm", "finite": True})
    sine: float = field(metadata={"unit": "Nm", "finite": True})

    @property
    def amplitude(self) -> float:
        """In Nm."""
        return float(np.hypot(self.cosine, self.sine))

    def at(self, t: Array) -> Array:
        """The torque [Nm] at times t [s], zero before the start and after the end, (n,) -> (n,)."""
        phase = 2 * np.pi * self.frequency * t
        found = self.cosine * np.cos(phase) + self.sine * np.sin(phase)
        return np.asarray(np.where((self.start <= t) & (t <= self.end), found, 0.0))


@dataclass(frozen=True, slots=True)
class DetectionLimit:
    """The smallest size of an effect that these records would have shown.

    symbol, unit : of the parameter that is its size; size : infinite where the effect is invisible here, because the
    fitted parameters do all that it does, or because no size that it may have would show.
    """

    effect: str
    symbol: str
    size: float = field(metadata={"unit_in": "unit", "unbounded": True, "least": 0.0})
    unit: str

    def within(self, null: float, bounds: tuple[float, float]) -> DetectionLimit:
        """The same, infinite where the parameter may not be so far from where the effect vanishes, its null."""
        largest = max(abs(bound - null) for bound in bounds)
        return self if self.size <= largest else replace(self, size=inf)


@dataclass(frozen=True, slots=True, eq=False)
class Cause:
    """An effect that the model lacks.

    explained : share of the misfit's energy above the noise floor that it removes beside the causes before it, every
    frequency weighed by the noise that it has; the shares of all causes add up to what they remove. explained_of : the
    held-out record that the share is of, where the cause is a difference of that record; empty where it is of the
    records of the fit. heldout_gain : of fit, on records held out, nan without any; gain_p_value : of no
    gain on records held out, one without any. twins : what these data cannot tell from it, itself first.
    confounded_with : what else is much like it on these motions, the most alike first. beside : the cause without which
    it does not carry over, empty where it does by itself.
    """

    effect: str
    parameters: tuple[Estimate, ...]
    explained: float = field(metadata={"finite": True})
    heldout_gain: float = field(metadata={"unit": "% points"})
    p_value: float
    twins: tuple[str, ...]
    separation: Separation | None
    confounded_with: tuple[Confounded, ...] = ()
    explained_of: str = ""
    beside: str = ""
    gain_p_value: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Rejected:
    """An effect that was tried, and why it is not a cause. heldout_gain is nan where no refit was worth it."""

    effect: str
    explained: float = field(metadata={"finite": True})
    heldout_gain: float = field(metadata={"unit": "% points"})
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class SearchOutcome:
    """What a search has found of a model, before it is known where the misfit sits: what an extension takes. All as of
    `Diagnosis`; of causes, those that a fit can have."""

    causes: tuple[Cause, ...] = ()
    refitted: dict[str, float] = field(default_factory=dict)
    events: tuple[Event, ...] = ()
    late: float = 0.0
    late_within: float = 0.5
    tones: tuple[Tone, ...] = ()
    horizon: float | None = None
    beside_shape: bool = False


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Diagnosis(Displayed):
    """The verdict on one fitted model.

    noise_floor, misfit, remaining : RMS over the records of the fit, in the unit of the output; remaining is the
    misfit that the causes leave, remaining_share their part of its energy, by the same measure as the shares of the
    causes: all of them and the remainder make one. events : what happened once, and was taken out before causes
    were sought. late : by how much the torque was recorded late, and late_within : the intervals by which a record on a
    regular clock may be, one that would be later stays as it is; tones : in the torque and not in the motion, which
    were taken out as well. limits : the smallest size of each effect of the catalogue that
    would have been seen. records : by name.
    missing : the missing torque [Nm] of each record: its measured part is what the residual asks for, its simulated
    part what the causes supply. twist [rad] : of a flexible joint's gear at the same times, as the model has it
    under that torque; no record holds it, and the curves along it run along this one. apart : held-out records that
    no parameters simulate as well as those of the fit and together with them. curves : where the missing torque
    sits, best ordered first. shape : the curve of what no cause explains, its order the share of the misfit;
    beside_shape : the causes were found beside it, and their parameters hold there. refitted : all parameters of
    the model with its causes, by name, to start from. extended : that model as the pipeline fits it, which an extension
    by all causes takes over; None where no such fit was made or none has an end. torque_errors [Nm] : standard
    deviation of the errors of the torque for which all that is left passes, zero where it is mostly noise of the
    output. horizon : of the pieces in which causes were sought where the simulation of whole records is led astray,
    None for those of the fit. is_cut_short : the time was up before the search was at its end.
    """

    verdict: Verdict
    model: str
    output: Quantity
    unit: str
    noise_floor: float = field(metadata={"unit_in": "unit", "least": 0.0})
    misfit: float = field(metadata={"unit_in": "unit", "least": 0.0})
    remaining: float = field(metadata={"unit_in": "unit", "least": 0.0})
    records: dict[str, Misfit]
    causes: tuple[Cause, ...]
    rejected: tuple[Rejected, ...]
    curves: tuple[Curve, ...]
    missing: dict[str, Trace] = field(metadata={"lengths": {"n": "n[]"}})
    residuals: dict[str, Trace]
    shape: Curve | None
    remarks: tuple[str, ...] = ()
    refitted: dict[str, float] = field(default_factory=dict, metadata={"unit": "SI", "finite": True})
    remaining_share: float = field(default=1.0, metadata={"finite": True})
    events: tuple[Event, ...] = ()
    limits: tuple[DetectionLimit, ...] = ()
    late: float = field(default=0.0, metadata={"unit": "s", "finite": True})
    late_within: float = field(default=0.5, metadata={"unit": "sampling intervals", "least": 0.0})
    twist: dict[str, Array] = field(default_factory=dict, metadata={"unit": "rad", "shape": ("n[]",), "finite": True})
    apart: tuple[str, ...] = ()
    torque_errors: float = field(default=0.0, metadata={"unit": "Nm", "least": 0.0})
    beside_shape: bool = False
    horizon: float | None = field(default=None, metadata={"unit": "s", "positive": True})
    tones: tuple[Tone, ...] = ()
    extended: FitResult | None = None
    is_cut_short: bool = False

    @property
    def is_hidden(self) -> bool:
        """Whether it is unknown because all that the model leaves may be noise, and so much that nothing would show in
        it."""
        found = bool(self.causes) or self.shape is not None or bool(self.apart) or self.is_cut_short
        return self.verdict == "unknown" and not found and self.misfit <= self.noise_floor
