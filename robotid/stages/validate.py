"""Stage validate: what every model is worth on every record, the initial one included."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robotid.config.schema import Config
from robotid.estimate.fitted_model import FittedModel, fitted_model
from robotid.estimate.flexible import FlexResult
from robotid.estimate.result import Fits
from robotid.estimate.rigid import RigidResult
from robotid.estimate.sensing import joint_for
from robotid.progress import Log
from robotid.signals.quality import Recordings
from robotid.signals.record import usable_horizon
from robotid.stages.fit import start
from robotid.stages.ingestion.virtual import controller_of
from robotid.validation import ModelValidation, Validation, ValidationOptions, initial_name, validate_models


def validate(
    settings: Config,
    recordings: Recordings,
    rigid: RigidResult,
    flex: FlexResult,
    fits: Fits,
    log: Log | None = None,
) -> Validation:
    """Validate the initial model and every fitted one on every record. log : gets an event for each model.

    Only the best model's parameters are perturbed. A model that diverges on a record is without that record, and says
    so. The best model's fit below a threshold is a sentence in `failed`, not an error: the artifact is saved first.
    """
    initial, options = _initial(settings, recordings, rigid, flex, fits), _options(settings, recordings, fits)
    free = settings.fit.initial_states == "free"
    fitted = {name: fitted_model(fit, estimate_states=free) for name, fit in fits.models.items()}
    found = validate_models({initial.name: initial} | fitted, fits, recordings.records, flex.frfs, options, log)
    return replace(found, failed=tuple(_failed(settings, recordings, fits.best, found.models[fits.best])))


def _options(settings: Config, recordings: Recordings, fits: Fits) -> ValidationOptions:
    section, filtering = settings.validation, settings.init_rigid
    return ValidationOptions(
        perturbation=section.perturbation,
        horizon=section.horizon or usable_horizon(fits.models[fits.best].horizon, recordings.records),
        controller=None if settings.loop is None else controller_of(settings.loop),
        cutoff=filtering.cutoff,
        order=filtering.order,
        min_speed=filtering.min_speed,
    )


def _initial(settings: Config, recordings: Recordings, rigid: RigidResult, flex: FlexResult, fits: Fits) -> FittedModel:
    """Where the fits started, first states as measured."""
    output = fits.models[fits.best].output
    joint = joint_for(settings.structure(), output, recordings.records)
    parameters = start(settings, joint, rigid, flex)
    return FittedModel(initial_name(fits), joint, parameters, output, (), {}, estimate_states=False)


def _failed(settings: Config, recordings: Recordings, best: str, model: ModelValidation) -> Iterator[str]:
    thresholds = settings.validation.thresholds.fit_percent
    demands = [(record.name, least) for name, least in thresholds.items() for record in recordings.of([name])]
    for record, least in demands:
        if record not in model.records:
            yield f"{best} cannot be simulated on {record}, where a fit of {least:g} % is asked"
        elif model.records[record].fit_percent < least:
            yield f"{best} fits {record} to {model.records[record].fit_percent:.2f} %, below the {least:g} % asked"
