"""The records by which models are compared: those that are fitted, those that validate, and the noise of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robotid.diagnosis.noise.noise_estimate import TorqueErrors
from robotid.diagnosis.noise.whitening import Segment
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.signals.record import Quantity


@dataclass(frozen=True, slots=True, eq=False)
class EvaluationData:
    """Segments to be fitted and segments that validate, each with its whitening.

    output : the quantity that is compared; estimate_states : whether first states are found by the fit or taken as
    measured. noise_reached : all known effects and free curves together leave no more than the noise of the sensors;
    torque_errors : which errors of the torque are part of the noise.
    """

    fitted: tuple[Segment, ...]
    validation: tuple[Segment, ...]
    output: Quantity
    estimate_states: bool
    noise_reached: bool
    torque_errors: TorqueErrors

    @property
    def samples(self) -> int:
        """Of the fitted segments."""
        return _samples(self.fitted)

    @property
    def validation_samples(self) -> int:
        """Of the validation segments."""
        return _samples(self.validation)

    def fitted_energy(self, simulated: Sequence[SimulatedSegment]) -> float:
        """Energy of the residuals of all fitted segments, in variances of the noise as it is here."""
        return sum(segment.energy(one.residual) for segment, one in zip(self.fitted, simulated, strict=True))

    def energy(self, fitted: Sequence[SimulatedSegment], validation: Sequence[SimulatedSegment]) -> float:
        """The same of all segments."""
        return self.fitted_energy(fitted) + self.validation_energy(validation)

    def validation_energy(self, validation: Sequence[SimulatedSegment]) -> float:
        """The same of the segments that were held out."""
        return sum(segment.energy(one.residual) for segment, one in zip(self.validation, validation, strict=True))


def _samples(segments: Iterable[Segment]) -> int:
    return sum(len(segment.record) for segment in segments)
