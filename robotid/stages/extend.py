"""Stage extend: the model with the effects it lacked, fitted anew, and what that gains."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from robotid.config.extended import extended_text
from robotid.config.load import Loaded
from robotid.config.schema import Config
from robotid.diagnosis.results import Diagnosis
from robotid.estimate.result import FitResult, Fits
from robotid.extension.extend import Refit
from robotid.extension.extend import extend as extend_model
from robotid.extension.results import Extension
from robotid.model.structure import RECORD_CHANGE, belongs, changed
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings
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

    refit = refitting(settings, diagnosis, fits, recordings, say)
    named = extensible(diagnosis, refit.before)
    return extend_model(refit, named if settings.extend.effects is None else settings.extend.effects)


def refitting(
    settings: Config, diagnosis: Diagnosis, fits: Fits, recordings: Recordings, say: Callable[[str], None]
) -> Refit:
    """The diagnosed model, to be extended on these records."""
    before, options = fits.models[diagnosis.model], fit_options(settings)
    return Refit(before, _starts(diagnosis), recordings.records, options, settings.fit.horizon, say)


def extensible(diagnosis: Diagnosis, fit: FitResult) -> tuple[str, ...]:
    """The causes that a fit on the same records can take; a difference on a record that is held out is told, not
    fitted."""
    return tuple(c.effect for c in diagnosis.causes if _can_be_fitted(c.effect, fit.records))


def _starts(diagnosis: Diagnosis) -> list[dict[str, float]]:
    """Where the extended model's fit may start."""
    return [diagnosis.refitted, {p.name: p.value for cause in diagnosis.causes for p in cause.parameters}]


def extended_configuration(loaded: Loaded, extension: Extension, folder: Path) -> str:
    """The text of extended.yaml, to be kept in a folder."""
    added = [p for p in extension.fit.parameters if any(belongs(p.name, effect) for effect in extension.added)]
    return extended_text(loaded, extension.fit.structure, {p.name: p.value for p in added}, folder)


def _can_be_fitted(effect: str, records: tuple[str, ...]) -> bool:
    return not effect.startswith(RECORD_CHANGE) or changed(effect)[0] in records
