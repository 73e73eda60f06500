"""Everything that validation finds out of one model: every record, every parameter, every measured response."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated, simulate_record
from robotid.estimate.result import FitResult, Fits
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.numerals import plain
from robotid.parallel import each
from robotid.progress import Log, Progress
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.frf import Frf
from robotid.signals.metrics import fit_percent, rmse
from robotid.signals.record import Record
from robotid.signals.trace import downsampled
from robotid.simulation.closed_loop.controller import Controller
from robotid.validation.bode import bode
from robotid.validation.closed_loop import loop_errors
from robotid.validation.identifiability import correlations, identify
from robotid.validation.inverse_dynamics import torque_error
from robotid.validation.perturbation import NOT_PERTURBED, perturb
from robotid.validation.residual_tests import residual_test
from robotid.validation.results import Identifiability, ModelValidation, RecordValidation, Validation
from robotid.validation.torque_share import torque_shares

NOTABLE = 0.5  # of the RMS error: a first state moved further than this flatters the model
SIMULATIONS = 2  # that a model costs on a record, first states found, besides those with a parameter changed


@dataclass(frozen=True, slots=True)
class ValidationOptions:
    """How to validate.

    perturbation [%]; horizon [s] : of the pieces simulated afresh; controller : of the records' loop; each None where
    not wanted or not known. cutoff [Hz], order, min_speed [rad/s] : of the filter of the torque error.
    """

    perturbation: float | None = None
    horizon: float | None = None
    controller: Controller | None = None
    cutoff: float | None = None
    order: int = 4
    min_speed: float = 0.0


def validate_model(
    model: FittedModel,
    records: Sequence[Record],
    frfs: Sequence[Frf],
    options: ValidationOptions,
    fit: FitResult | None = None,
) -> ModelValidation:
    """Validate a model on records, used for its fit or not. fit : what made the model, absent for the initial one."""
    samples = sum(map(len, records)) // max(1, len(records))
    found = each(_on_record, (model, options), records, samples=samples)
    simulated = {record.name: one.simulated for record, one in zip(records, found, strict=True) if one.simulated}
    covariance = np.zeros((0, 0)) if fit is None else fit.covariance_robust
    return ModelValidation(
        names=model.parameters.names,
        units=model.parameters.units,
        values=model.theta,
        output=model.output,
        structure=model.joint.structure,
        records={record.name: one.validated for record, one in zip(records, found, strict=True) if one.validated},
        covariance=covariance,
        correlation=correlations(covariance),
        identifiability=() if fit is None else _identifiability(fit, simulated),
        bode=bode(model.joint, model.theta, frfs, records[0].sampling_time),
        remarks=tuple(one.remark for one in found if one.remark),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _OnRecord:
    """A model on a record; where it diverges, only a remark."""

    simulated: Simulated | None = None
    validated: RecordValidation | None = None
    remark: str = ""


def _on_record(shared: tuple[FittedModel, ValidationOptions], record: Record) -> _OnRecord:
    model, options = shared
    try:
        simulated = simulate_record(model, record, options.horizon)
    except NumericsError as error:
        return _OnRecord(remark=f"{record.name}: {error.what}")
    return _OnRecord(simulated, validate_record(model, simulated, options))


def validate_models(
    models: Mapping[str, FittedModel],
    fits: Fits,
    records: Sequence[Record],
    frfs: Sequence[Frf],
    options: ValidationOptions,
    log: Log | None = None,
) -> Validation:
    """Validate every model on every record.

    models : by name, the initial one, which no fit made, first; frfs : measured frequency responses to compare with.
    log is called for each model. Only the best model's parameters are perturbed. A model that diverges on a record is
    without that record, and has a remark.
    """
    asked = {name: options if name == fits.best else replace(options, perturbation=None) for name in models}
    effort = {
        name: SIMULATIONS + 2 * len(model.theta) * (asked[name].perturbation is not None)
        for name, model in models.items()
    }
    found: dict[str, ModelValidation] = {}
    for name, model in models.items():
        if log is not None:
            log(Progress(name, sum(effort[done] for done in found), sum(effort.values())))
        found[name] = validate_model(model, records, frfs, asked[name], fits.models.get(name))
    return Validation(found, fits.best, tuple(frfs))


def initial_name(fits: Fits) -> str:
    """What the initial model is called: m0, unless a fitted model took the name."""
    return "m0" if "m0" not in fits.models else "initial"


def _identifiability(fit: FitResult, simulated: Mapping[str, Simulated]) -> tuple[Identifiability, ...]:
    used = [(name, t) for name, one in simulated.items() if name in fit.records for t in one.trajectories]
    return identify(fit, torque_shares(used))


def validate_record(model: FittedModel, simulated: Simulated, options: ValidationOptions) -> RecordValidation:
    """All that validation finds out of a model on a record that it was simulated on."""
    record, remarks = simulated.record, list[str]()
    theta = model.joint.in_record(model.theta, record.name)
    torque_error = _torque_error(model.joint, theta, simulated, options)
    position, speed = simulated.signal("position"), simulated.signal("speed")
    measured, output = simulated.measured(model.output), position if model.output == "position" else speed
    errors = {"position": rmse(record.phi_m, position), "speed": rmse(simulated.measured("speed"), speed)}
    closed_loop = None
    try:
        if options.controller is not None:
            closed_loop = loop_errors(model.joint.structure, theta, options.controller, record)
    except NumericsError as error:
        remarks.append(f"closed loop: {error.what}")
    return RecordValidation(
        role=record.role,
        used=record.name in model.records,
        fit_percent=fit_percent(measured, output),
        rmse_speed=errors["speed"],
        rmse_position=errors["position"],
        torque_error_percent=torque_error,
        closed_loop=closed_loop,
        residual=residual_test(measured - output, record.tau_m),
        perturbation=NOT_PERTURBED if options.perturbation is None else perturb(model, simulated, options.perturbation),
        trace=downsampled(record.t, measured, output, model.unit),
        remarks=(*remarks, *_moved(simulated, errors)),
    )


def _moved(simulated: Simulated, errors: Mapping[str, float]) -> Iterator[str]:
    """Sentences where the first state that suits a record is not the measured one, by what the model's errors show."""
    record, first = simulated.record, simulated.trajectories[0]
    signals = {"position": (record.phi_m, first.phi_m), "speed": (record.dphi_m, first.dphi_m)}
    for quantity, (measured, found) in signals.items():
        moved = abs(float(found[0] - measured[0]))
        if moved > NOTABLE * errors[quantity]:
            yield f"first {quantity} {plain(moved, 2)} off the measured one"


def _torque_error(joint: Joint, theta: Array, simulated: Simulated, options: ValidationOptions) -> float | None:
    first_state = simulated.trajectories[0].x[:, 0]
    parallel = ParallelFilter(options.cutoff, options.order, options.min_speed)
    return torque_error(joint, theta, simulated.record, first_state, parallel)
