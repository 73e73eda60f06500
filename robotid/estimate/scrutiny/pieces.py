"""Fits over pieces of the records, where whole ones add up what is missing or run away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.residual import TRIAL_PATIENCE, measured_output, observed
from robotid.estimate.result import End, FitResult
from robotid.estimate.scrutiny.doubts import doubts, worse_torque
from robotid.estimate.scrutiny.instability import instability_of, is_too_short
from robotid.estimate.scrutiny.settings import SETTINGS
from robotid.estimate.scrutiny.task import FitTask
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity, Record
from robotid.simulation.simulate import simulate


def hopeless_as_whole(task: FitTask) -> FitResult | None:
    """The fit over pieces where an open simulation is unstable, and even with what they find one of whole records ends
    farther from some than rest would: no fit of these would come to an end soon, or near. None where that is not so."""
    if task.options.horizon is not None:
        return None
    found = _over_stable_pieces(task, "no simulation of whole records stays near them")
    if found is None or found.end is End.INTERRUPTED:
        return found
    theta = task.parameters.with_values({p.name: p.value for p in found.parameters}).values
    near = (_stays_near(task.joint, theta, record, task.options.output) for record in task.records)
    return None if all(near) else found


def in_pieces(first: FitResult, task: FitTask) -> FitResult | None:
    """The fit over pieces in which an error cannot grow far, where an open simulation is unstable and they serve."""
    return _over_stable_pieces(task, f"the fit of whole records is {min(first.fit_percent.values()):.1f} %")


def _over_stable_pieces(task: FitTask, whole: str) -> FitResult | None:
    """The fit over pieces in which an error cannot grow far; None where it does not in whole records, or the fit is
    poor. whole : why these are not fitted, in words."""
    instability = instability_of(task.joint, task.parameters, task.records)
    horizon = instability.horizon if instability.growth >= SETTINGS.unstable else None
    if horizon is None:
        return None
    found = task.with_options(horizon=horizon).attempt()
    if found is None or min(found.fit_percent.values()) < SETTINGS.poor_fit:
        return None
    remark = (
        f"an error of the open simulation grows by a factor of e in {1 / instability.rate:.2g} s on this motion, and"
        f" {whole}: fitted, validated and diagnosed in pieces of {horizon:g} s"
    )
    return as_cut(found, horizon, remark, task)


def in_shorter_pieces(first: FitResult, task: FitTask) -> FitResult | None:
    """The fit over pieces in which it meets the torque as its start does, where a poor one of whole records does not;
    None where none serve, or are not needed.

    On a motion that little damps, an open simulation adds up what is missing, and parameters that keep it near the
    record may be far from those that move the joint.
    """

    def contradicts(fit: FitResult) -> bool:
        values = np.array([p.value for p in fit.parameters])
        return any(worse_torque(task.joint, task.parameters, values, task.records))

    poor = min(first.fit_percent.values()) < SETTINGS.poor_fit
    if task.options.horizon is not None or not poor or not contradicts(first):
        return None
    duration = min(record.duration for record in task.records)
    for count in SETTINGS.pieces:
        horizon = float(f"{duration / count:.1g}")
        found = None if is_too_short(horizon, task.records) else task.with_options(horizon=horizon).attempt()
        if found is not None and not contradicts(found):
            remark = (
                f"in pieces of {horizon:g} s the fit meets the torque as its start does, and of whole records it does"
                " not: fitted, validated and diagnosed in such pieces"
            )
            return as_cut(found, horizon, remark, task)
    return None


def as_cut(fit: FitResult, horizon: float, remark: str, task: FitTask) -> FitResult:
    """A fit over pieces of this length [s], with what speaks against it and why it was made so."""
    return replace(fit, horizon=horizon, remarks=(*doubts(fit, task.joint, task.parameters, task.records), remark))


def _stays_near(joint: Joint, theta: Array, record: Record, output: Quantity) -> bool:
    """Whether an open simulation of a whole record, from its measured first state, is nearer to it than rest is."""
    try:
        trajectory = simulate(joint, theta, record, max_failed_windows=TRIAL_PATIENCE)
    except NumericsError:
        return False
    return fit_percent(measured_output(record, output), observed(trajectory, output)) > 0.0
