"""Stage validate: what every model is worth on every record, the initial one included."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robotid.catalogue import assemble
from robotid.config.schema import Config
from robotid.estimate.fitted_model import FittedModel
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.model.joint import Joint
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings
from robotid.stages.fit import start
from robotid.stages.ingestion.virtual import controller_of
from robotid.validation.procedure import ValidationOptions, validate_model
from robotid.validation.results import ModelValidation, Validation

SIMULATIONS = 2  # that a model costs on a record, first states found, besides those with a parameter changed


def validate(
    settings: Config,
    recordings: Recordings,
    rigid: RigidResult,
    flex: FlexResult,
    fits: Fits,
    log: Log | None = None,
) -> Validation:
    """Validate the initial model and every fitted one on every record. log is told of each model.

    Only the best model's parameters are perturbed. A model that diverges on a record is without that record, and says
    so. The best model's fit below a threshold is a sentence in `failed`, not an error: the artifact is saved first.
    """
    joint = assemble(settings.structure(), angle=settings.fit.output == "position")
    initial, options = _initial(settings, joint, rigid, flex, fits), _options(settings)
    everyone = {initial.name: initial} | {name: _fitted(settings, joint, fit) for name, fit in fits.models.items()}
    asked = {name: options if name == fits.best else replace(options, perturbation=None) for name in everyone}
    effort = {
        name: SIMULATIONS + 2 * len(model.theta) * (asked[name].perturbation is not None)
        for name, model in everyone.items()
    }
    models: dict[str, ModelValidation] = {}
    for name, model in everyone.items():
        if log is not None:
            log(Progress(name, sum(effort[done] for done in models), sum(effort.values())))
        models[name] = validate_model(model, recordings.records, flex.frfs, asked[name], fits.models.get(name))
    failed = tuple(_failed(settings, fits.best, models[fits.best]))
    return Validation(models, fits.best, flex.frfs, failed)


def _options(settings: Config) -> ValidationOptions:
    section, filtering = settings.validation, settings.init_rigid
    return ValidationOptions(
        perturbation=section.perturbation,
        horizon=section.horizon,
        controller=None if settings.loop is None else controller_of(settings.loop),
        cutoff=filtering.cutoff,
        order=filtering.order,
        min_speed=filtering.min_speed,
    )


def _initial(settings: Config, joint: Joint, rigid: RigidResult, flex: FlexResult, fits: Fits) -> FittedModel:
    """Where the fits started, first states as measured: m0, unless a fitted model took the name."""
    parameters = start(settings, joint, rigid, flex)
    name = "m0" if "m0" not in fits.models else "initial"
    return FittedModel(name, joint, parameters, settings.fit.output, (), {}, estimate_states=False)


def _fitted(settings: Config, joint: Joint, fit: FitResult) -> FittedModel:
    parameters = joint.parameters().with_values(np.array([p.value for p in fit.parameters]))
    free = settings.fit.initial_states == "free"
    return FittedModel(fit.name, joint, parameters, settings.fit.output, fit.records, fit.initial_states, free)


def _failed(settings: Config, best: str, model: ModelValidation) -> Iterator[str]:
    for record, least in settings.validation.thresholds.fit_percent.items():
        if record not in model.records:
            yield f"{best} cannot be simulated on {record}, where a fit of {least:g} % is asked"
        elif model.records[record].fit_percent < least:
            yield f"{best} fits {record} to {model.records[record].fit_percent:.2f} %, below the {least:g} % asked"
