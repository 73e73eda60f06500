"""The verdict on a model: how much is wrong, where, what caused it, and what was tried in vain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from robotid.diagnosis.misfit.summary import locate_misfit
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.results import Cause, Diagnosis, Misfit, Rejected, Verdict
from robotid.diagnosis.scoring.ranking import best_of_each
from robotid.diagnosis.search.record_changes import Change
from robotid.diagnosis.search.state import Found, SearchResult
from robotid.estimate.fitted_model import FittedModel, Simulated, SimulatedSegment, joined
from robotid.estimate.residual import measured_output
from robotid.estimate.result import Estimate
from robotid.model.array import Array
from robotid.model.structure import belongs
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record
from robotid.signals.trace import Trace, thinned

MOST_REJECTED = 12  # effects that are listed as scored in vain
FAR = 2.0  # noise floors: a misfit that large is something
SHAPELESS = "the misfit is far above the noise, yet no curve along one variable explains much of it"
CHANCE = 3.0  # standard deviations of the energy of noise: less is no misfit to have a share in
LEAST = 1e-12  # of the output: where even the noise is nothing


def verdict(model: FittedModel, simulated: Sequence[Simulated], growth: SearchResult) -> Diagnosis:
    """The diagnosis of a model simulated on records, or on stretches of them, from the search for what it lacks."""
    names = dict.fromkeys(run.record.name for run in simulated)
    runs = {name: joined([run for run in simulated if run.record.name == name]) for name in names}
    segments = [segment for run in runs.values() for segment in run.segments(model.output)]
    where = locate_misfit(segments, _segments_after(growth) if growth.causes else (), model.output)
    residuals = {name: run.measured(model.output) - run.signal(model.output) for name, run in runs.items()}
    after = _after(growth) if growth.causes else {}
    misfits = {
        name: _misfit(model, run.record, residuals[name], where.floors, after.get(name)) for name, run in runs.items()
    }
    fitted = [misfits[name] for name in dict.fromkeys(r.name for r in growth.bench.fitted)]
    floor = _rms([m.noise_floor for m in fitted])
    misfit = _beyond(_rms([m.rmse for m in fitted]), floor)
    believed = growth.changes if growth.causes or growth.shape is None else ()
    word = _word(growth, misfit, floor)
    left = _beyond(_rms([root_mean_square(after[r.name]) for r in growth.bench.fitted]), floor) if after else misfit
    return Diagnosis(
        verdict=word,
        model=model.name,
        output=model.output,
        unit=model.unit,
        noise_floor=floor,
        misfit=misfit,
        remaining=left,
        records=misfits,
        causes=(*map(_cause, growth.causes), *map(_changed, believed)),
        rejected=tuple(_rejected(growth, word)),
        curves=() if word == "clean" else where.curves,
        missing=where.missing,
        residuals={name: trace(runs[name], model) for name in runs},
        shape=None if growth.shape is None else replace(growth.shape.curve, order=growth.share),
        refitted=dict(zip(growth.last.parameters.names, growth.last.parameters.values.tolist(), strict=True)),
        remarks=(SHAPELESS,) if word == "unknown" and growth.shape is None else (),
    )


def _word(growth: SearchResult, misfit: float, floor: float) -> Verdict:
    """A misfit far above the noise is never clean, even where it has neither a name nor a shape."""
    if growth.causes or (growth.changes and growth.shape is None):
        return "named"
    return "clean" if growth.shape is None and misfit <= FAR * floor else "unknown"


def _segments_after(growth: SearchResult) -> list[SimulatedSegment]:
    """The records once the causes are there."""
    return [*growth.last.segments, *growth.last.held_segments]


def _after(growth: SearchResult) -> dict[str, Array]:
    """Residuals of the extended model, by record."""
    segments = _segments_after(growth)
    names = dict.fromkeys(one.record.name for one in segments)
    return {name: np.concatenate([one.residual for one in segments if one.record.name == name]) for name in names}


def _misfit(
    model: FittedModel, record: Record, residual: Array, floors: Mapping[str, float], after: Array | None
) -> Misfit:
    rmse, floor = root_mean_square(residual), floors.get(record.name, 0.0)
    output = measured_output(record, model.output)
    beyond = _beyond(rmse, floor)
    left = 0.0 if after is None else _beyond(root_mean_square(after), floor)
    explained = 0.0 if after is None else 1.0 - left**2 / max(beyond**2, LEAST)
    return Misfit(
        role=record.role,
        fit_percent=fit_percent(output, output - residual),
        rmse=rmse,
        noise_floor=min(floor, rmse),
        misfit=beyond,
        explained_after=float(np.clip(explained, 0.0, 1.0)),
    )


def root_mean_square(signal: Array) -> float:
    """Of a signal (n,)."""
    return float(np.sqrt(np.mean(signal**2)))


def _rms(levels: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(levels))))


def _beyond(rmse: float, floor: float) -> float:
    """What an RMS error is beyond the noise."""
    return float(np.sqrt(max(0.0, rmse**2 - floor**2)))


def trace(run: Simulated, model: FittedModel) -> Trace:
    """Measured and simulated output of a record, thinned for figures."""
    return thinned(run.t, run.measured(model.output), run.signal(model.output), model.unit)


def _cause(found: Found) -> Cause:
    """A cause as it is told."""
    estimates = _estimates(found.after, found.effect)
    return Cause(found.effect, estimates, found.explained, found.gain, found.p_value, found.twins, None)


def _changed(found: Change) -> Cause:
    """A difference of a held-out record as it is told; its deviation is not known."""
    nan = float("nan")
    estimate = Estimate(found.effect, found.value, found.unit, nan, nan, float("-inf"), float("inf"))
    return Cause(found.effect, (estimate,), found.explained, found.gain, found.p_value, found.twins, None)


def _estimates(trial: RefittedModel, effect: str) -> tuple[Estimate, ...]:
    """The effect's own parameters with the deviations of the whitened fit."""
    parameters, covariance = trial.parameters, trial.covariance
    found = []
    for i, k in enumerate(trial.problem.columns):
        name = parameters.names[k]
        if belongs(name, effect):
            std = float(np.sqrt(max(0.0, covariance[i, i])))
            bounds = float(parameters.lower[k]), float(parameters.upper[k])
            found.append(Estimate(name, float(parameters.values[k]), parameters.units[k], std, std, *bounds))
    return tuple(found)


def _rejected(growth: SearchResult, word: Verdict) -> Iterator[Rejected]:
    """What was refitted in vain, and then what the score alone turned down in the first round.

    Where something unknown is wrong with the model everywhere, a difference on one record only imitates it.
    """
    told = {c.effect for c in growth.causes} | {t for c in growth.causes for t in c.twins}
    for turned in growth.turned:
        if turned.effect not in told:
            told.add(turned.effect)
            yield Rejected(turned.effect, turned.explained, turned.gain, turned.why)
    if growth.shape is not None and not growth.causes:
        why = f"only imitates what no effect explains along {growth.shape.curve.along}"
        yield from (Rejected(c.effect, c.explained, c.gain, why) for c in growth.changes)
    first = growth.rounds[0]
    samples = growth.bench.samples
    whole = max(first.projected.energy - samples, CHANCE * np.sqrt(2 * samples))
    for one in best_of_each(first.scores)[:MOST_REJECTED]:
        if one.candidate.name not in told:
            share = float(np.clip(one.energy / whole, 0.0, 1.0))
            yield Rejected(one.candidate.name, share, float("nan"), _why(share, growth, word))


def _why(share: float, growth: SearchResult, word: Verdict) -> str:
    if word == "clean":
        return "there is nothing to explain"
    best = growth.causes[0] if growth.causes else None
    if best is not None and share < best.explained:
        return f"scored {100 * share:.2g} % of the misfit, less than {best.effect}"
    return f"scored {100 * share:.2g} % of the misfit, which no refit bore out"
