"""All that figures show beside the results of the stages, of a run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeVar

from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated, fitted_model, simulate_record
from robotid.estimate.result import FitResult
from robotid.extension import corrected
from robotid.interrupt import check
from robotid.model.structure import Structure
from robotid.report.evidence.law import Law, law_of
from robotid.report.evidence.profile import Profiles, profile_intervals
from robotid.report.evidence.response import (
    Coherence,
    ModelResponse,
    coherence,
    model_response,
    simulated_response,
    validated_responses,
)
from robotid.report.evidence.results import Evidence
from robotid.report.evidence.spectrum import ResidualSpectra, residual_spectra
from robotid.report.findings import Findings
from robotid.signals.record import Record, usable_horizon

T = TypeVar("T")


def with_evidence(findings: Findings) -> Findings:
    """The same findings with what figures show beside them. A record on which a model diverges is without."""
    laws, spectra, runs = _by_simulation(findings)
    responses, coherences = _over_frequency(findings, runs)
    profiles = dict(_profiles(findings))
    return replace(findings, evidence=Evidence(laws, spectra, responses, coherences, profiles))


def _profiles(f: Findings) -> Iterator[tuple[str, Profiles]]:
    """Of the best model, and of its extension."""
    if f.fits is None or f.recordings is None:
        return
    fits = {f.fits.best: f.fits.models[f.fits.best]}
    if (extension := f.extension_that_adds) is not None:
        fits[f"{extension.model} extended"] = extension.fit
    for name, fit in fits.items():
        taken = f.recordings.records if name == f.fits.best else _as_extended(f)
        records = [record for record in taken if record.name in fit.records]
        yield name, profile_intervals(fit, records, f.horizon or usable_horizon(fit.horizon, records))


def _by_simulation(f: Findings) -> tuple[dict[str, Law], dict[str, ResidualSpectra], dict[str, Simulated]]:
    """Laws and spectra by record, and the extended model simulated there."""
    laws, spectra, runs = dict[str, Law](), dict[str, ResidualSpectra](), dict[str, Simulated]()
    if f.fits is None or f.recordings is None:
        return laws, spectra, runs
    fit, extension = f.fits.models[f.fits.best], f.extension_that_adds
    if extension is not None:
        fit = f.fits.models.get(extension.model, fit)
    before = fitted_model(fit, estimate_states=f.estimate_states)
    after = None if extension is None else fitted_model(extension.fit, estimate_states=f.estimate_states)
    missing = {} if f.diagnosis is None else f.diagnosis.missing
    for record in _as_extended(f):
        check()
        gained = None if after is None else _simulated(after, record, f.pieces)
        if gained is not None:
            runs[record.name] = gained
            if record.name in missing:
                _put(laws, record.name, partial(law_of, before, gained, missing[record.name].t))
        left = _simulated(before, record, f.pieces)
        if left is not None:
            _put(spectra, record.name, partial(residual_spectra, left, gained, before.output))
    return laws, spectra, runs


def _as_extended(f: Findings) -> list[Record]:
    """The records as the extension takes them, so that all figures of it show the same; as recorded without one."""
    records = [] if f.recordings is None else f.recordings.records
    e = f.extension_that_adds
    return [*records] if e is None else [corrected(record, e) for record in records]


def _simulated(model: FittedModel, record: Record, horizon: float | None) -> Simulated | None:
    try:
        return simulate_record(model, record, horizon)
    except NumericsError:
        return None


def _put(found: dict[str, T], name: str, make: Callable[[], T]) -> None:
    """Keep what can be made: a curve less is better than no page."""
    try:
        found[name] = make()
    except NumericsError:
        return


def _over_frequency(
    f: Findings, runs: Mapping[str, Simulated]
) -> tuple[dict[str, ModelResponse], dict[str, Coherence]]:
    responses, coherences = dict[str, ModelResponse](), dict[str, Coherence]()
    records = () if f.recordings is None else f.recordings.records
    for record in records:
        frf = next((frf for frf in f.frfs if frf.record == record.name), None)
        if frf is not None:
            coherences[record.name] = coherence(record, frf.frequency)
    if f.frfs and records:
        responses = dict(_responses(f, runs, records[0].sampling_time))
    return responses, coherences


def _responses(f: Findings, runs: Mapping[str, Simulated], sampling_time: float) -> Iterator[tuple[str, ModelResponse]]:
    """The model that the fits started from, the best one, and the extended one, as far as there are any."""
    if f.validation is not None:
        yield from validated_responses(f.validation, sampling_time).items()
    elif f.fits is not None:
        yield f.fits.best, model_response(*_values(f.fits.models[f.fits.best]), f.frfs, sampling_time)
    if (extension := f.extension_that_adds) is not None:
        at_amplitude = simulated_response(fitted_model(extension.fit), runs, f.frfs)
        linear = model_response(*_values(extension.fit), f.frfs, sampling_time)
        yield f"{extension.model} extended", linear if at_amplitude is None else at_amplitude


def _values(fit: FitResult) -> tuple[Structure, dict[str, float]]:
    return fit.structure, {p.name: p.value for p in fit.parameters}
