"""Stage extend: the model with the effects it lacked, fitted anew, and what that gains."""

from __future__ import annotations

from pathlib import Path

from robotid.config.extended import extended_text
from robotid.config.load import Loaded
from robotid.config.schema import Config
from robotid.estimate.result import Fits
from robotid.judge.diagnosis import Diagnosis, Extension
from robotid.judge.extension import extend as extend_model
from robotid.model.structure import RECORD_CHANGE, changed
from robotid.signals.quality import Recordings
from robotid.stages.fit import fit_options
from robotid.stages.progress import Log, Progress


def extend(
    settings: Config, recordings: Recordings, fits: Fits, diagnosis: Diagnosis, log: Log | None = None
) -> Extension:
    """Extend the diagnosed model by its causes, or by the effects that the configuration asks for.

    Raises NumericsError where the extended model does not converge.
    """

    def say(text: str) -> None:
        if log is not None:
            log(Progress(text))

    used = fits.models[diagnosis.model].records
    named = tuple(cause.effect for cause in diagnosis.causes if _can_be_fitted(cause.effect, used))
    effects = named if settings.extend.effects is None else settings.extend.effects
    starts = [diagnosis.refitted, {p.name: p.value for cause in diagnosis.causes for p in cause.parameters}]
    before, horizon = fits.models[diagnosis.model], settings.fit.horizon
    return extend_model(before, effects, starts, recordings.records, fit_options(settings), horizon, say)


def extended_configuration(loaded: Loaded, extension: Extension, folder: Path) -> str:
    """The text of extended.yaml, to be kept in a folder."""
    added = [p for p in extension.fit.parameters if _belongs(p.name, extension.added)]
    return extended_text(loaded, extension.fit.structure, {p.name: p.value for p in added}, folder)


def _can_be_fitted(effect: str, records: tuple[str, ...]) -> bool:
    """A difference on a record that is held out is told, not fitted."""
    return not effect.startswith(RECORD_CHANGE) or changed(effect)[0] in records


def _belongs(parameter: str, effects: tuple[str, ...]) -> bool:
    return parameter in effects or parameter.rpartition(".")[0] in effects
