"""What speaks against a fit: the torque of the rigid motion, the inertia of its start, the measured first speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.cutoff import choose_cutoff
from robotid.estimate.first_states import first_state_limits
from robotid.estimate.linear_response import total_inertia
from robotid.estimate.result import FitResult
from robotid.estimate.rigid import torque_error
from robotid.estimate.scrutiny.settings import SETTINGS
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Role
from robotid.model.units import unit_of
from robotid.numerals import plain
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record


def doubts(fit: FitResult, joint: Joint, start: Parameters, records: Sequence[Record]) -> Iterator[str]:
    """What speaks against a fit, a sentence each. start : the parameters from which it began."""
    values = np.array([p.value for p in fit.parameters])
    yield from worse_torque(joint, start, values, records)
    yield from _other_branch(fit, joint, start)
    begun = {record.name: record for record in reversed(records)}  # of a record in pieces, the first state of the first
    for name in fit.records:
        yield from _first_speed(fit, joint, begun[name])


def worse_torque(joint: Joint, start: Parameters, values: Array, records: Sequence[Record]) -> Iterator[str]:
    """Records whose torque parameters (p,) meet far worse than their start, a sentence each."""
    for record in records:
        try:
            parallel = ParallelFilter(choose_cutoff(joint, start, record))
        except NumericsError:
            continue
        before, after = (torque_error(joint, start.with_values(v), record, parallel) for v in (start.values, values))
        if after > SETTINGS.torque_factor * before and after > before + SETTINGS.torque_percent:
            yield (
                f"the torque of {record.name} is met to {plain(after)} % by the fit and to {plain(before)} % by its"
                " start: an error of the model went into the parameters, as it does less in short pieces (fit.horizon)"
            )


def _other_branch(fit: FitResult, joint: Joint, start: Parameters) -> Iterator[str]:
    for estimate, value in zip(fit.parameters, start.values, strict=True):
        if (
            not estimate.fixed
            and estimate.remark.startswith("at its")
            and value not in (estimate.lower, estimate.upper)
        ):
            yield f"{estimate.name} ended {estimate.remark}, {estimate.value:.3g}, from a start at {value:.3g}"
    masses = [name for name, place in joint.playing(Role.MASS).items() if not place.term.states]
    if not any(start.free[joint.names.index(name)] for name in masses):
        return
    before = total_inertia(joint, {name: start[name] for name in masses})
    after = total_inertia(joint, {name: fit[name].value for name in masses})
    if before > 0 and not 1 / SETTINGS.inertia_factor < after / before < SETTINGS.inertia_factor:
        yield f"the inertia of the fit is {plain(after / before)} times that of its start, on the motor side"


def _first_speed(fit: FitResult, joint: Joint, record: Record) -> Iterator[str]:
    """A first speed that the measurement alone keeps from going elsewhere."""
    row, measured = joint.motor_speed, float(record.dphi_m[0])
    least, most = (float(limit[row]) for limit in first_state_limits(joint, record))
    speed, margin = float(fit.initial_states[record.name][row]), SETTINGS.at_limit * (most - least)
    if most - least > 0.0 and not least + margin < speed < most - margin:
        unit = unit_of("speed", linear=joint.structure.linear)
        yield (
            f"the estimated first speed of {record.name}, {plain(speed)} {unit}, is as far from the measured one,"
            f" {plain(measured)} {unit}, as its limits allow"
        )
