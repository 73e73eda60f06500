"""The first step: rigid-body parameters and friction by linear least squares, eq. (10)-(12) of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robotid.display import Displayed
from robotid.errors import NumericsError
from robotid.estimate.cutoff import choose_cutoff
from robotid.estimate.linear_regression import Block, Limits, Solution, relative_error, solve, solve_within
from robotid.estimate.regressor import FilteredRecord, Merged, Regression, merge, regress, regress_on
from robotid.estimate.result import Estimate
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.term import Role
from robotid.signals.differentiate import AUTOMATIC, ParallelFilter
from robotid.signals.record import Record

DISTINCT = 2.0  # standard deviations from zero


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RigidResult(Displayed):
    """Step 1. parameters : a sum of parameters that only act together is called joint.effect.symbol, on the motor side.

    covariance : (p, p), for white residuals. torque_error_percent : 100 ||tau - tau_hat|| / ||tau|| a record, both
    filtered. cutoff : a record. guesses : by dotted name of the model, a sum shared out among its members; where an
    estimate is outside its bounds, those of the least squares within them. What reads a companion and is not distinct
    from zero has none.
    """

    parameters: tuple[Estimate, ...] = field(metadata={"shape": ("p",)})
    covariance: Array = field(metadata={"unit": "SI", "shape": ("p", "p")})
    condition_number: float = field(metadata={"unbounded": True, "least": 0.0})
    torque_error_percent: dict[str, float] = field(metadata={"unit": "%", "finite": True, "least": 0.0})
    cutoff: dict[str, float] = field(metadata={"unit": "Hz", "finite": True, "least": 0.0})
    guesses: dict[str, float] = field(metadata={"unit": "SI", "finite": True})
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
    filters = [_chosen(joint, parameters, record, parallel) for record in records]
    regressions = [regress(joint, parameters, *pair) for pair in zip(records, filters, strict=True)]
    return _fitted(joint, parameters, [record.name for record in records], filters, regressions)


def fit_rigid_on(filtered: Sequence[FilteredRecord], joint: Joint, parameters: Parameters) -> RigidResult:
    """The same of records on which several models are fitted, through filters whose cut-off is known."""
    regressions = [regress_on(one, joint, parameters) for one in filtered]
    names, filters = [one.record.name for one in filtered], [one.parallel for one in filtered]
    return _fitted(joint, parameters, names, filters, regressions)


def _fitted(
    joint: Joint,
    parameters: Parameters,
    names: Sequence[str],
    filters: Sequence[ParallelFilter],
    regressions: list[Regression],
) -> RigidResult:
    """Least squares of the regressions of records of these names through these filters."""
    if not names:
        raise NumericsError("no record serves the rigid initialisation", where="init_rigid", hint="give one use: rigid")
    unknowns = merge(regressions)
    if not unknowns:
        return _nothing_to_estimate()
    blocks = [Block(_columns(unknowns, g), g.tau) for g in regressions]
    solution = solve([u.name for u in unknowns], blocks)
    limits = _limits(joint, parameters, unknowns)
    guesses = _share_out(joint, unknowns, solve_within(blocks, solution, limits))
    for name in _doubtful(joint, unknowns, solution):
        del guesses[name]
    return RigidResult(
        parameters=_estimates(joint, parameters, unknowns, limits, solution),
        covariance=solution.covariance,
        condition_number=solution.condition_number,
        torque_error_percent={
            name: relative_error(residual, g.torque)
            for name, residual, g in zip(names, solution.residuals, regressions, strict=True)
        },
        cutoff={name: f.cutoff or 0.0 for name, f in zip(names, filters, strict=True)},
        guesses=guesses,
        remarks=_remarks(joint, unknowns),
    )


def torque_error(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> float:
    """100 ||tau - tau_hat|| / ||tau|| [%] of given parameters along the measured motion, both torques filtered."""
    own = parameters.with_values(joint.in_record(parameters.values, record.name))
    left = regress(joint, own.all_fixed, record, parallel)
    return relative_error(left.tau, left.torque)


def _chosen(joint: Joint, parameters: Parameters, record: Record, parallel: ParallelFilter) -> ParallelFilter:
    """The filter of one record."""
    return parallel if parallel.cutoff else parallel.at(choose_cutoff(joint, parameters, record, parallel.order))


def _columns(unknowns: Sequence[Merged], regression: Regression) -> Array:
    """One column an unknown, (p, n): its first member's, per unit of the sum."""
    first = [regression.names.index(u.members[0]) for u in unknowns]
    return np.asarray(regression.columns[first] / np.array([[u.ratios[0]] for u in unknowns]))


def _limits(joint: Joint, parameters: Parameters, unknowns: Sequence[Merged]) -> Limits:
    """Bounds of the unknowns, a sum's made of those of its members."""
    members = [[joint.names.index(member) for member in unknown.members] for unknown in unknowns]
    lower, upper = (
        np.array([np.dot(unknown.ratios, bound[where]) for unknown, where in zip(unknowns, members, strict=True)])
        for bound in (parameters.lower, parameters.upper)
    )
    return Limits(lower, upper)


def _estimates(
    joint: Joint,
    parameters: Parameters,
    unknowns: Sequence[Merged],
    limits: Limits,
    solution: Solution,
) -> tuple[Estimate, ...]:
    std, robust = np.sqrt(np.diag(solution.covariance)), np.sqrt(np.diag(solution.covariance_robust))
    estimates = []
    for k, unknown in enumerate(unknowns):
        lower, upper, value = float(limits.lower[k]), float(limits.upper[k]), float(solution.theta[k])
        estimates.append(
            Estimate(
                name=unknown.name,
                value=value,
                unit=parameters.units[joint.names.index(unknown.members[0])],
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
    if abs(value) < DISTINCT * std:
        remarks.append("not distinct from zero")
    return "; ".join(remarks)


def _doubtful(joint: Joint, unknowns: Sequence[Merged], solution: Solution) -> list[str]:
    """Parameters of effects that read a companion, not distinct from zero: a motion that does not tell an inertia which
    another axis changes may make it so large that in some pose the whole is negative, where no fit can start."""
    std = np.sqrt(np.diag(solution.covariance_robust))
    reading = {n for place in joint.placed if place.term.companion_name for n in joint.names[place.at]}
    doubtful = np.abs(solution.theta) < DISTINCT * std
    return [m for u, doubt in zip(unknowns, doubtful, strict=True) if doubt for m in u.members if m in reading]


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
