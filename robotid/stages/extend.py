"""Stage extend: the fitted model with the effects it lacked, and what these gain."""

from __future__ import annotations

from dataclasses import replace

from robotid.config.schema import Config
from robotid.diagnosis import Diagnosis
from robotid.estimate.result import Fits
from robotid.extension import Extension, effects_to_add, extension_task
from robotid.extension import extend as extend_model
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings
from robotid.signals.record import usable_horizon
from robotid.stages.fit import fit_options


def extend(
    settings: Config, recordings: Recordings, fits: Fits, diagnosis: Diagnosis, log: Log | None = None
) -> Extension:
    """Extend the diagnosed model by its causes, or by the effects that the configuration asks for.

    Raises NumericsError where the extended model does not converge.
    """

    def say(text: str) -> None:
        if log is not None:
            log(Progress(text))

    fit = fits.models[diagnosis.model]
    options = fit_options(settings, fit.output, usable_horizon(fit.horizon, recordings.records))
    task = extension_task(diagnosis, fit, recordings.records, options, horizon=options.horizon, log=say)
    task = replace(task, known=diagnosis.extended)
    effects = settings.extend.effects
    return extend_model(task, effects_to_add(diagnosis, fit) if effects is None else effects)
