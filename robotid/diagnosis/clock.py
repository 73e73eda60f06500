"""The torque of an irregular log, put where it acts.

Stamps that vary are those of a recorder with a clock of its own. It reads the torque of the controller's last cycle,
which began up to an interval before, so that all torques may be recorded late by some part of an interval, or early by
as much as the stamps vary. No cause in the machine is to be sought for that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.scoring.candidate import columns_of
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.numerals import plain
from robotid.signals.record import Record
from robotid.signals.torque_steps import moved

DELAY = "torque.torque_delay"


@dataclass(frozen=True, slots=True)
class RecordedLate:
    """By how much the torque of irregular logs is recorded late [s], early where negative."""

    late: float = 0.0

    def corrected(self, record: Record) -> Record:
        """An irregular record with its torque where it acts; another as it is."""
        if record.torque_steps is None or self.late == 0.0:
            return record
        torque, steps = moved(record.tau_m, record.torque_steps, -self.late / record.sampling_time)
        return replace(record, tau_m=torque, torque_steps=steps)

    @property
    def remark(self) -> str:
        """In a sentence."""
        way = "late" if self.late > 0.0 else "early"
        return (
            f"the sampling intervals vary, and the torque is recorded {plain(1e3 * abs(self.late), 2)} ms {way}:"
            f" moved by as much before causes were sought (in all stages: torque_delay: {self.late:.3g} in the records)"
        )


def recorded_late(evidence: Evidence, criteria: Criteria) -> RecordedLate:
    """By how much the torque of the irregular logs is late; not at all where it is not significantly, by more than a
    clock explains, or where the model has a delay of its own. Raises NumericsError where the model cannot be
    simulated."""
    records = [run.record for run in evidence.fitted]
    clocks = [(one.sampling_time, one.torque_steps.spread) for one in records if one.torque_steps is not None]
    if not clocks or DELAY in criteria.skip:
        return RecordedLate()
    state = first_state(evidence, criteria)
    places = zip(state.scan.candidates, columns_of(state.scan.candidates), strict=True)
    at = next((at for one, at in places if one.name == DELAY), None)
    if at is None:
        return RecordedLate()
    regression = project(state.scan.scans).beside_fitted(at)
    late, std = -float(regression.estimate()[-1]), float(np.sqrt(regression.covariance()[-1, -1]))
    explained = (-interval * spread <= late <= interval for interval, spread in clocks)
    certain = abs(late) > ACCEPTANCE.amplitude_sigma * std
    return RecordedLate(late if certain and all(explained) else 0.0)
