"""Stage diagnose: what the simulation gets wrong, and why."""

from __future__ import annotations

import re

from robotid.config.schema import Config
from robotid.diagnosis import Criteria, Diagnosis, DiagnosisOptions
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.result import Fits
from robotid.extension import diagnose_with_gains
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings
from robotid.signals.record import usable_horizon
from robotid.stages.experiments import experiments
from robotid.stages.fit import fit_options

COUNT = re.compile(r"\b(\d+) of (\d+)\b")


def diagnose(settings: Config, recordings: Recordings, fits: Fits, log: Log | None = None) -> Diagnosis:
    """Diagnose one fitted model: its causes are fitted on the records of its fit and measured on the others.

    Raises NumericsError where the model cannot be simulated.
    """
    section = settings.diagnose
    fit = fits.models[section.model or fits.best]
    model = fitted_model(fit, estimate_states=settings.fit.initial_states == "free")

    def say(text: str) -> None:
        if log is not None:
            log(Progress(text, *_counted(text)))

    criteria = Criteria(
        section.significance, section.min_improvement_sigma, section.max_refits, section.max_causes, section.skip
    )
    horizon = settings.fit.fixed_horizon or usable_horizon(fit.horizon, recordings.records)
    options = DiagnosisOptions(horizon, section.samples, experiments(settings), section.budget)
    of_fits = fit_options(settings, fit.output, horizon)
    return diagnose_with_gains(model, fit, recordings.records, of_fits, criteria, options, say)


def _counted(text: str) -> tuple[int, int]:
    """Candidates of a round that are done, and all of them, as the search announces the one that comes."""
    found = COUNT.search(text)
    return (int(found[1]) - 1, int(found[2])) if found else (0, 0)
