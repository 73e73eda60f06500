"""The first step: rigid-body parameters and friction by linear least squares, eq. (10)-(12) of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robotid.display import Displayed
from robotid.errors import NumericsError
from robotid.estimate.linear_regression import Block, Solution, relative_error, solve, too_few
from robotid.estimate.regressor import Merged, Regression, merge, regress
from robotid.estimate.result import Estimate
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Role
from robotid.signals.differentiate import AUTOMATIC, ParallelFilter, bandwidth
from robotid.signals.record import Record

CUTOFF_CANDIDATES = 8  # tried for a flexible joint
MIN_PERIODS = 10.0  # of the lowest of them, in a record


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RigidResult(Displayed):
    """Step 1. parameters : a sum of parameters that only act together is called joint.effect.symbol, on the motor side.

    covariance : (p, p), for white residuals. torque_error_percent : 100 ||tau - tau_hat|| / ||tau|| a record, both
    filtered. cutoff : a record. guesses : by dotted name of the model, a sum shared out among its members.
    """

    parameters: tuple[Estimate, ...]
    covariance: Array = field(metadata={"unit": "SI"})
    condition_number: float
    torque_error_percent: dict[str, float] = field(metadata={"unit": "%"})
    cutoff: dict[str, float] = field(metadata={"unit": "Hz"})
    guesses: dict[str, float] = field(metadata={"unit": "SI"})
    remarks: tuple[str, ...]

    def __getitem__(self, name: str) -> Estimate:
        return next(p for p in self.parameters if p.name == name)


def fit_rigid(
    joint: Joint,
    parameters: Parameters,
    records: Sequence[Record],
    parallel: ParallelFilter = AUTOMATIC,
) -> RigidResult:
    """Least squares of the motor torque on the rigid motion of all records.

    parameters : those that are free are estimated, the others keep their value. parallel : without a cut-off,
    `choose_cutoff` finds one for each record. Raises NumericsError where the records do not determine the parameters.
    """
    if not records:
        raise NumericsError("no record serves the rigid initialisation", where="init_rigid", hint="give one use: rigid")
    filters = [_chosen(joint, parameters, record, parallel) for record in records]
    regressions = [regress(joint, parameters, *pair) for pair in zip(records, filters, strict=True)]
    unknowns = merge(regressions)
    if not unknowns:
        return _nothing_to_estimate()
    solution = solve([u.name for u in unknowns], [Block(_columns(unknowns, g), g.tau) for g in regressions])
    return RigidResult(
        parameters=_estimates(joint, parameters, unknowns, solution),
        covariance=solution.covariance,
        condition_number=solution.condition_number,
        torque_error_percent={
            record.name: relative_error(residual, g.torque)
            for record, residual, g in zip(records, solution.residuals, regressions, strict=True)
        },
        cutoff={record.name: f.cutoff or 0.0 for record, f in zip(records, filters, strict=True)},
        guesses=_share_out(joint, unknowns, solution.theta),
        remarks=_remarks(joint, unknowns),
    )


def _chosen(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> ParallelFilter:
    """The filter of one record."""
    return parallel if parallel.cutoff else parallel.at(choose_cutoff(joint, parameters, record, parallel.order))


def choose_cutoff(joint: Joint, parameters: Parameters, record: Record, order: int = 4) -> float:
    """Cut-off [Hz] of the parallel filter: 99 % of the torque's energy lies below.

    A flexible joint is rigid only well below its notch, which is not known yet: there, of several cut-offs up to
    this one, the one at which the rigid model explains the torque best. Raises NumericsError for a constant torque.
    """
    highest = bandwidth(record.tau_m, record.sampling_time)
    if highest <= 0:
        raise NumericsError("the torque is constant", where=record.name, hint="record a motion that excites the joint")
    if joint.masses == 1:
        return highest
    lowest = MIN_PERIODS / record.duration  # below it, too few samples are left
    candidates = np.geomspace(max(lowest, highest), lowest, CUTOFF_CANDIDATES).tolist()
    return float(min(candidates, key=lambda cutoff: _misfit(joint, parameters, record, ParallelFilter(cutoff, order))))


def _misfit(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> float:
    """Of the rigid model at a cut-off, infinite where too little of the record is left to fit it."""
    g = regress(joint, parameters, record, parallel)
    if too_few(g.columns):
        return np.inf
    theta = np.linalg.lstsq(g.columns.T, g.tau, rcond=None)[0]
    return float(relative_error(g.tau - theta @ g.columns, g.torque) / np.sqrt(1 - len(theta) / len(g.tau)))


def _columns(unknowns: Sequence[Merged], regression: Regression) -> Array:
    """One column an unknown, (p, n): its first member's, per unit of the sum."""
    first = [regression.names.index(u.members[0]) for u in unknowns]
    return np.asarray(regression.columns[first] / np.array([[u.ratios[0]] for u in unknowns]))


def _estimates(
    joint: Joint, parameters: Parameters, unknowns: Sequence[Merged], solution: Solution
) -> tuple[Estimate, ...]:
    std, robust = np.sqrt(np.diag(solution.covariance)), np.sqrt(np.diag(solution.covariance_robust))
    estimates = []
    for k, unknown in enumerate(unknowns):
        where = [joint.names.index(member) for member in unknown.members]
        lower, upper = (float(np.dot(unknown.ratios, bound[where])) for bound in (parameters.lower, parameters.upper))
        value = float(solution.theta[k])
        estimates.append(
            Estimate(
                name=unknown.name,
                value=value,
                unit=parameters.units[where[0]],
                std=float(std[k]),
                std_robust=float(robust[k]),
                lower=lower,
                upper=upper,
                remark=_remark(unknown, value, lower, upper, float(robust[k])),
            )
        )
    return tuple(estimates)


def _remark(unknown: Merged, value: float, lower: float, upper: float, std: float) -> str:
    remarks = []
    if len(unknown.members) > 1:
        remarks.append(f"sum of {', '.join(unknown.members)} on the motor side")
    if not lower <= value <= upper:
        remarks.append(f"outside its bounds {lower:g} to {upper:g}")
    if abs(value) < 2 * std:
        remarks.append("not distinct from zero")
    return "; ".join(remarks)


def _share_out(joint: Joint, unknowns: Sequence[Merged], theta: Array) -> dict[str, float]:
    """Values of the model's parameters. An inertia is shared equally; of a friction the first member takes all."""
    masses = joint.playing(Role.MASS)
    guesses: dict[str, float] = {}
    for unknown, value in zip(unknowns, theta, strict=True):
        equal = all(member in masses for member in unknown.members)
        for k, (member, ratio) in enumerate(zip(unknown.members, unknown.ratios, strict=True)):
            share = 1 / len(unknown.members) if equal else float(k == 0)
            guesses[member] = float(share * value / ratio)
    return guesses


def _remarks(joint: Joint, unknowns: Sequence[Merged]) -> tuple[str, ...]:
    estimated = {member for unknown in unknowns for member in unknown.members}
    left = [name for name in joint.names[: joint.n_theta] if name not in estimated]
    return (f"a rigid motion does not show {', '.join(left)}",) if left else ()


def _nothing_to_estimate() -> RigidResult:
    return RigidResult((), np.zeros((0, 0)), 1.0, {}, {}, {}, ("every parameter of the rigid motion is fixed",))
