"""What the checks of one record share, each worked out once: derived speed, regression, alignment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from robotid.model.array import Array
from robotid.signals.differentiate import central_difference
from robotid.signals.plausibility.alignment import Alignment, align_speed
from robotid.signals.plausibility.delay import torque_delay
from robotid.signals.plausibility.regression import (
    Determined,
    FilteredMotion,
    TorqueRegression,
    clearest,
    regress_torque,
)
from robotid.signals.plausibility.rivals import Rival, angle_as_speed, torque_shifted
from robotid.signals.quality import Report
from robotid.signals.record import Record

ROUNDING = 1e-9  # of the largest speed: a difference from the derived one that is none


@dataclass(frozen=True, slots=True)
class Axis:
    """What a configuration states of the axis. gear_ratio : phi_a / phi_m, None for a rigid axis; linear : the axis
    slides (m, N, kg)."""

    gear_ratio: float | None = None
    linear: bool = False


@dataclass(frozen=True, eq=False)
class Evidence:
    """One record with its report and the axis that it is of. others : the records of the fit, for a validation record.

    The properties are worked out when a check first asks for them.
    """

    record: Record
    report: Report
    axis: Axis
    others: Sequence[Record] = ()

    @cached_property
    def derived_speed(self) -> Array:
        """Central difference of the angle [rad/s], (n,)."""
        return central_difference(self.record.phi_m, self.record.sampling_time)

    @cached_property
    def speed_is_derived(self) -> bool:
        """Whether the speed of the record comes from its angle, so that nothing can be learnt by comparing them."""
        difference = np.abs(self.record.dphi_m - self.derived_speed)[2:-2]
        return bool(np.median(difference) <= ROUNDING * float(np.abs(self.derived_speed).max()))

    @cached_property
    def speed_alignment(self) -> Alignment:
        """The recorded speed against the angle's derivative."""
        return align_speed(self.record.phi_m, self.record.dphi_m, self.record.sampling_time)

    @cached_property
    def regression(self) -> TorqueRegression:
        """The torque against the motion."""
        return self._regressed[0]

    @cached_property
    def clearest(self) -> FilteredMotion:
        """The record at the cut-off of the regression."""
        return clearest(self._regressed[1])

    @cached_property
    def regression_alone(self) -> TorqueRegression:
        """The torque against the motion, with nothing taken out for companions."""
        if self.regression.left == 1.0:
            return self.regression
        return regress_torque(replace(self.record, companions={}), self._turns)[0]

    @cached_property
    def exchanged(self) -> tuple[TorqueRegression, float]:
        """The regression with the columns of torque and angle exchanged, and the share of the one that it explains."""
        record = self.record
        regression, tried = regress_torque(replace(record, tau_m=record.phi_m, phi_m=record.tau_m), self._turns)
        return regression, clearest(tried).share

    @cached_property
    def angle_as_speed(self) -> Rival | None:
        """The record with the column of its angle taken for its speed."""
        return angle_as_speed(self._regressed[1], self._turns)

    @cached_property
    def torque_shifted(self) -> Rival | None:
        """The record with its torque moved in time to where the motion explains it best."""
        return torque_shifted(self._regressed[1])

    @cached_property
    def torque_delay(self) -> Determined:
        """By how much the torque is late against the motion [s]."""
        return torque_delay(self.record)

    @cached_property
    def _regressed(self) -> tuple[TorqueRegression, list[FilteredMotion]]:
        """The regression, and the record at all cut-offs as it takes it."""
        return regress_torque(self.record, self._turns)

    @property
    def _turns(self) -> float | None:
        """Angle of the arm for one radian of the motor, whose sine and cosine gravity follows."""
        return None if self.axis.linear else self.axis.gear_ratio or 1.0

    @property
    def units(self) -> dict[str, str]:
        """Units of torque, angle, speed and inertia on this axis."""
        if self.axis.linear:
            return {"torque": "N", "angle": "m", "speed": "m/s", "inertia": "kg"}
        return {"torque": "Nm", "angle": "rad", "speed": "rad/s", "inertia": "kg m2"}
