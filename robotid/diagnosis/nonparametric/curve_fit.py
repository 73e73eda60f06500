"""Free curves fitted to what a model leaves: which variable orders it best, and how much of it a curve explains.

The shape is a piecewise linear curve, each of its knots a column through the joint as those of candidates are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linprog

from robotid.diagnosis.misfit.curve import IN_PROPORTION, Curve
from robotid.diagnosis.nonparametric.basis import (
    Basis,
    Variable,
    applied,
    at_measured_speed,
    basis_along,
    basis_at,
    variables,
)
from robotid.diagnosis.nonparametric.curve_course import can_act_in_time, refit_beside_course
from robotid.diagnosis.nonparametric.curve_term import FreeCurve, can_act, refit_with_curve
from robotid.diagnosis.nonparametric.settings import CURVES
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, decrease
from robotid.diagnosis.scoring.projection import Projected, beyond, project
from robotid.diagnosis.scoring.scan import scan, scans
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class FittedCurve:
    """A free curve that was fitted to what a model leaves.

    energy : of the whitened residuals that it explains on the fitted segments, in variances of the noise; values (k,)
    : at the knots, as fitted [Nm], or what the variable counts; moved (p,) : how far the fitted parameters go with it;
    decrease : of the whitened squared error of every sample of the segments that validate, (n,) each, none before they
    were simulated with it.
    """

    basis: Basis
    curve: Curve
    energy: float
    values: Array
    moved: Array
    decrease: tuple[Array, ...] = ()

    @property
    def variable(self) -> Variable:
        """Along which it lies."""
        return self.basis.variable

    @property
    def validation_energy(self) -> float:
        """Energy that it explains on the segments that validate."""
        return float(sum(one.sum() for one in self.decrease))


def fit_curves(model: RefittedModel, data: EvaluationData) -> list[FittedCurve]:
    """The curves that explain most of what a model leaves, best first; all variables are compared coarsely before."""
    motions = _measured_motions(model)
    coarse = _along(motions, model, data, variables(motions[0]))
    finalists = [one.variable for one in coarse[: CURVES.finalists]]
    return _along(motions, model, data, finalists, CURVES.fine_knots)


def fit_acting_along(variable: Variable, model: RefittedModel, data: EvaluationData) -> FittedCurve:
    """The curve along a variable as it is once it acts."""
    return fit_acting(_along(_measured_motions(model), model, data, [variable], CURVES.fine_knots)[0], model, data)


def fit_acting(curve: FittedCurve, model: RefittedModel, data: EvaluationData) -> FittedCurve:
    """The curve as it is once it acts: what is still left asks for changes of it, and the validation segments are
    simulated with it. Where it cannot act, or that only does harm, the first fit stays. A curve that can be no term
    acts in time, along the motion as it was measured."""
    as_term = can_act(curve.variable, model.joint)
    if not as_term and not can_act_in_time(curve.variable):
        return _validated(curve, model)
    best, _ = _acting(curve, model, data, in_time=not as_term)
    return best or _validated(curve, model)


def refit_beside(curve: FittedCurve, model: RefittedModel, data: EvaluationData) -> RefittedModel | None:
    """The model refitted beside the curve as a torque in time, among the companions of its records; None where it
    cannot be, or that only does harm."""
    return _acting(curve, model, data, in_time=True)[1] if can_act_in_time(curve.variable) else None


def _acting(
    curve: FittedCurve, model: RefittedModel, data: EvaluationData, *, in_time: bool
) -> tuple[FittedCurve | None, RefittedModel | None]:
    """The curve that explains most as it acts, as a term or in time, and the model refitted beside it."""
    best, beside, now, after, held = None, None, curve, model, data
    for _ in range(CURVES.max_sweeps):
        try:
            if in_time:
                after, held = refit_beside_course(after, held, now.basis, now.values, now.moved)
            else:
                term = FreeCurve(now.variable, now.basis.knots, now.values)
                after = refit_with_curve(model.joint, after, data, term, now.moved)
        except NumericsError:
            break
        explained = model.energy - after.energy
        gained = explained - (0.0 if best is None else best.energy)
        if gained <= 0.0:
            break
        best = replace(now, energy=explained, decrease=tuple(map(decrease, model.validation, after.validation)))
        beside = after
        if gained < CURVES.settled_gain * explained:
            break
        basis = basis_at(now.basis.knots, _measured_motions(after), now.variable)
        again = _fit(after, held, [basis], now.values)
        if not again:
            break
        now = again[0]
    return best, beside


def free_forces(segment: SimulatedSegment) -> Array:
    """Generalised forces (nv, k, n) of coarse curves along all variables of a segment."""
    motion = at_measured_speed(segment.trajectory, segment.record)
    bases = [basis_along((motion,), variable, coarse_knots(variable)) for variable in variables(motion)]
    return np.concatenate([basis.forces[0] for basis in bases], axis=1)


def coarse_knots(variable: Variable) -> int:
    """Of a curve by which a variable is compared with others; what repeats itself in a turn does so several times, and
    would not be seen coarsely."""
    return CURVES.fine_knots[-1] if variable.turn else CURVES.coarse_knots


def _measured_motions(model: RefittedModel) -> tuple[Trajectory, ...]:
    return tuple(at_measured_speed(one.trajectory, one.record) for one in model.fitted)


def _along(
    motions: Sequence[Trajectory],
    model: RefittedModel,
    data: EvaluationData,
    chosen: Sequence[Variable],
    counts: Sequence[int] = (),
) -> list[FittedCurve]:
    """A curve along each variable, best first, of as many knots as the Bayesian information criterion asks for. counts
    : of knots, by default as of `coarse_knots`."""
    n = data.samples

    def criterion(curve: FittedCurve) -> float:
        return n * float(np.log(max(model.energy - curve.energy, 1e-9))) + len(curve.values) * float(np.log(n))

    found = _fit(model, data, [basis_along(motions, v, k) for v in chosen for k in counts or [coarse_knots(v)]])
    best: dict[Variable, FittedCurve] = {}
    for curve in sorted(found, key=criterion):
        best.setdefault(curve.variable, curve)
    return list(best.values())


def _validated(curve: FittedCurve, model: RefittedModel) -> FittedCurve:
    """The curve with what it explains on the validation segments, their first states free."""
    found = []
    for one in model.validation:
        force = applied(curve.basis, at_measured_speed(one.trajectory, one.record), curve.values)
        seen = scan(one, model.unknowns, (), force[:, None])
        signals = seen.whitened
        first, known, answer, left = signals[: seen.states], signals[seen.states : -2], signals[-2], signals[-1]
        less = left - answer - curve.moved @ known
        found.append(beyond(left, first) ** 2 - beyond(less, first) ** 2)
    return replace(curve, decrease=tuple(found))


def _fit(
    model: RefittedModel, data: EvaluationData, bases: Sequence[Basis], acting: Array | float = 0.0
) -> list[FittedCurve]:
    """Each basis by itself to the residual, all columns in one solve, best first. acting : values of the curve that
    acts already. A basis that moves nothing, as where the joint sticks throughout, has no curve."""
    if not bases:
        return []
    forces = [np.concatenate(parts, axis=1) for parts in zip(*(basis.forces for basis in bases), strict=True)]
    projected = project(scans(model.fitted, model.unknowns, (), forces))
    torque = np.concatenate([segment.record.tau_m for segment in data.fitted])
    size = CURVES.likely_torque * float(np.sqrt(np.mean(torque**2)))
    found, first = [], 0
    for basis in bases:
        at = slice(first, first + len(basis.knots))
        if projected.whole[:, at].any():
            found.append(_curve(projected, at, basis, size, acting))
        first = at.stop
    return sorted(found, key=lambda s: -s.energy)


def _curve(projected: Projected, at: slice, basis: Basis, torque: float, acting: Array | float) -> FittedCurve:
    """The curve that the residual asks for through the columns `at`, no larger than is likely. torque [Nm] : its likely
    size."""
    columns, whole, residual = projected.missing[:, at], projected.whole[:, at], projected.residual
    variable, knots = basis.variable, basis.knots
    covariance = np.linalg.inv(columns.T @ columns + np.eye(len(knots)) * (basis.size / torque) ** 2)
    values = covariance @ (columns.T @ residual)
    scale = basis.size if variable.counted in IN_PROPORTION else 1.0
    curve = Curve(
        along=f"{variable.along},{variable.counted}" if variable.counted else variable.along,
        unit=variable.unit,
        x=knots,
        missing_torque=scale * _sparsest(values + acting, _confounded(columns, whole)),
        spread=scale * np.sqrt(np.diag(covariance)),
        count=basis.seen,
        order=0.0,
        at=scale,
    )
    energy = float(residual @ residual - np.sum((residual - columns @ values) ** 2))
    return FittedCurve(basis, curve, energy, values + acting, projected.moved(values, at))


def _confounded(columns: Array, whole: Array) -> Array:
    """Curves (m, k) of which the fitted parameters leave next to nothing: the fit may have taken or added them.

    columns, whole : after and before the fitted parameters were taken out.
    """
    ridge = CURVES.ridge * float(np.trace(whole.T @ whole)) * np.eye(whole.shape[1])
    left, vectors = eigh(columns.T @ columns, whole.T @ whole + ridge)
    return np.asarray(vectors[:, left < CURVES.faded_share].T)


def _sparsest(values: Array, free: Array) -> Array:
    """Of all curves values + a free, the one of least absolute sum: what is not needed is zero."""
    m, k = free.shape
    cost = np.concatenate([np.zeros(m), np.ones(k)])
    limits = np.block([[free.T, -np.eye(k)], [-free.T, -np.eye(k)]])
    scale = max(float(np.abs(values).max()), 1e-300)
    bounds = [(None, None)] * m + [(0.0, None)] * k
    found = linprog(cost, limits, np.concatenate([-values, values]) / scale, bounds=bounds)
    return values if found.x is None else np.asarray(values + scale * (found.x[:m] @ free))
