"""Stage diagnose: what the simulation gets wrong, and why."""

from __future__ import annotations

from dataclasses import replace

from robotid.config.schema import Config
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.search.search import search
from robotid.diagnosis.verdict import verdict
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.estimate.result import Fits
from robotid.extension.extend import Refit, gains
from robotid.model.structure import belongs
from robotid.progress import Log, Progress
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.signals.stretches import stretches
from robotid.stages.experiments import separated
from robotid.stages.extend import extensible, refitting


def diagnose(settings: Config, recordings: Recordings, fits: Fits, log: Log | None = None) -> Diagnosis:
    """Diagnose one fitted model: its causes are fitted on the records of its fit and measured on the others.

    Raises NumericsError where the model cannot be simulated.
    """
    section = settings.diagnose
    fit = fits.models[section.model or fits.best]
    model = fitted_model(fit, estimate_states=settings.fit.initial_states == "free")

    def say(text: str) -> None:
        if log is not None:
            log(Progress(text))

    conditions = Criteria(section.level, section.worth, section.refits, section.causes, section.skip)
    remarks = tuple(_shortened(r, section.samples) for r in recordings.records if len(r) > section.samples)
    for remark in remarks:
        say(remark)
    records = [s for r in recordings.records for s in stretches(r, section.samples)]
    simulated = [simulate_record(model, r, settings.fit.horizon) for r in records]
    fitted = [run for run in simulated if run.record.name in model.records]
    held = [r for r in records if r.name not in model.records]
    growth = search(model, fitted, held, settings.fit.horizon, conditions, say)
    say("measuring where the misfit sits")
    diagnosis = verdict(model, simulated, growth)
    diagnosis = replace(diagnosis, remarks=(*diagnosis.remarks, *remarks))
    say("measuring the gains")
    return separated(settings, _with_gains(diagnosis, refitting(settings, diagnosis, fits, recordings, say)), growth)


def _with_gains(diagnosis: Diagnosis, refit: Refit) -> Diagnosis:
    """The diagnosis with the parameters and gains that its causes have in fits as the pipeline makes them, those that
    `extend` will find; the search weighs the noise otherwise."""
    effects = extensible(diagnosis, refit.before)
    found, last = gains(refit, effects)
    if last is None:
        return diagnosis
    measured = {
        effect: (gain, tuple(p for p in last.parameters if belongs(p.name, effect)))
        for effect, gain in zip(effects, found, strict=True)
    }
    causes = []
    for cause in diagnosis.causes:
        gain, parameters = measured.get(cause.effect, (cause.heldout_gain, cause.parameters))
        causes.append(replace(cause, heldout_gain=gain, parameters=parameters))
    return replace(diagnosis, causes=tuple(causes), refitted={p.name: p.value for p in last.parameters})


def _shortened(record: Record, samples: int) -> str:
    taken = sum(map(len, stretches(record, samples)))
    return f"{record.name}: {taken} of {len(record)} samples are looked at, in stretches (diagnose.samples)"
