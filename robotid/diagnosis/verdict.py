"""The verdict on a model: how much is wrong, where, what caused it, and what was tried without success."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.misfit.summary import MisfitLocation, locate_misfit
from robotid.diagnosis.noise.noise_floor import Noise
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.remarks import UNEXPLAINED, remarks
from robotid.diagnosis.results import NOT_EXAMINED, Cause, DetectionLimit, Diagnosis, Misfit, Rejected, Verdict
from robotid.diagnosis.search.agreement import Agreement
from robotid.diagnosis.search.coloured import energy_a_sample
from robotid.diagnosis.search.limits import detection_limits
from robotid.diagnosis.search.record_changes import RecordChange
from robotid.diagnosis.search.state import AcceptedCause, SearchResult
from robotid.diagnosis.search.torque_errors import is_swamped, passing
from robotid.diagnosis.settings import VERDICT
from robotid.estimate.fitted_model import FittedModel, Simulated, SimulatedSegment, joined
from robotid.estimate.residual import measured_output
from robotid.estimate.result import Estimate
from robotid.model.array import Array
from robotid.model.structure import changed
from robotid.numerals import portion
from robotid.parallel import each
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record
from robotid.signals.trace import Trace, downsampled

K = TypeVar("K")
SAME = 1e-9  # relative: levels that are closer are one


def verdict(
    model: FittedModel, simulated: Sequence[Simulated], found: SearchResult, criteria: Criteria | None = None
) -> Diagnosis:
    """The diagnosis of a model simulated on records, or on stretches of them, from the search for what it lacks.

    criteria : of the search, by which an effect would have been seen.
    """
    names = dict.fromkeys(run.record.name for run in simulated)
    runs = {name: joined([run for run in simulated if run.record.name == name]) for name in names}
    segments = [segment for run in runs.values() for segment in run.segments(model.output)]
    segments_after = (*found.last.fitted, *found.last.validation) if found.causes else ()
    location, limits = _assessed(
        found,
        criteria or Criteria(),
        partial(locate_misfit, segments, segments_after, model.output, known_noise(found)),
    )
    before, after = _residuals(segments), _residuals(segments_after)
    explained = found.explained_by_record() if found.causes else {}
    misfits = {
        name: _misfit(model, run.record, before[name], location.floors, explained.get(name, 0.0))
        for name, run in runs.items()
    }
    fitted = dict.fromkeys(segment.record.name for segment in found.data.fitted)
    levels = _Levels.of([misfits[name] for name in fitted], [after[name] for name in fitted] if after else None)
    left = {name: after.get(name, before[name]) for name in fitted}
    measured = {name: runs[name].measured(model.output) for name in left}
    if _is_clear(levels.misfit, levels.floor):  # it is wrong on the records of its fit, too
        found = replace(found, agreement=Agreement())
    changes = _changes(found, levels.misfit, levels.floor)
    word = "not explained" if hardly_explained(measured, left) else _word(found, changes, levels)
    swamped = word == "clean" and is_swamped(found)
    if swamped:
        word = "unknown"
    return Diagnosis(
        verdict=word,
        model=model.name,
        output=model.output,
        unit=model.unit,
        noise_floor=levels.floor,
        misfit=levels.misfit,
        remaining=levels.remaining,
        records=misfits,
        causes=(*map(as_reported, found.causes), *map(_changed, changes)),
        rejected=tuple(_rejected(found, word, changes)),
        curves=() if word == "clean" else location.curves,
        missing=location.missing,
        twist=location.twist,
        residuals={name: trace(runs[name], model) for name in runs},
        shape=None if found.curve is None else replace(found.curve.curve, order=found.curve_share),
        refitted=found.last.parameters.by_name,
        remarks=remarks(word, found, swamped=swamped),
        remaining_share=found.remaining_share,
        events=found.events,
        limits=limits,
        apart=found.agreement.apart,
        torque_errors=passing(found),
        beside_shape=found.beside_curve,
        is_cut_short=found.late,
    )


def _assessed(
    found: SearchResult, criteria: Criteria, located: Callable[[], MisfitLocation]
) -> tuple[MisfitLocation, tuple[DetectionLimit, ...]]:
    """Where the misfit sits, and what would have been found, which take about as long: side by side."""
    alone = replace(found, causes=(), rejected=(), rounds=found.rounds[-1:], first=found.last)  # it is sent
    tasks: tuple[Callable[[], Any], ...] = (located, partial(detection_limits, alone, criteria))
    location, limits = each(_done, None, tasks, samples=found.data.samples)
    return location, limits


def _done(_: None, task: Callable[[], Any]) -> Any:
    return task()


def known_noise(found: SearchResult) -> dict[str, Noise] | None:
    """The noise of every record, None where what the causes leave is more than noise of any colour.

    By as much as a whitened residual exceeds noise, the residual itself does.
    """
    if found.curve is not None or found.imitated or found.coloured is None or not found.coloured.noise_reached:
        return None
    fitted = {one.record.name for one in found.last.fitted}
    segments, left = (*found.coloured.fitted, *found.coloured.validation), (*found.last.fitted, *found.last.validation)
    known = {}
    for name in dict.fromkeys(one.record.name for one in left):
        own = [(s, one) for s, one in zip(segments, left, strict=True) if one.record.name == name]
        residual, unknowns = np.concatenate([one.residual for _, one in own]), found.last.unknowns
        energy = sum(energy_a_sample(one, s, unknowns) * len(one.residual) for s, one in own if name not in fitted)
        beyond, filtered = max(1.0, energy / len(residual)), own[0][0].whitening
        noise, torque = np.sqrt([filtered.output_variance, filtered.levels.torque]).tolist()
        known[name] = Noise(noise, torque, root_mean_square(residual) / float(np.sqrt(beyond)), beyond == 1.0)
    return known


def _is_clear(misfit: float, floor: float) -> bool:
    """Whether a misfit stands out of the noise so far that something is wrong, whatever it is."""
    return misfit > VERDICT.clear_misfit * floor


def _changes(found: SearchResult, misfit: float, floor: float) -> tuple[RecordChange, ...]:
    """What differs on held-out records. It differs from a model that is right elsewhere: where the records of the fit
    are far from the noise and nothing explains them, the model is wrong everywhere, and a change only imitates that."""
    unexplained = found.curve is not None or _is_clear(misfit, floor)
    return () if unexplained and not found.causes else found.changes


@dataclass(frozen=True, slots=True)
class _Levels:
    """RMS over the records of the fit, each counted once: of the noise, and beyond it of the misfit and of what the
    causes leave."""

    floor: float
    misfit: float
    remaining: float

    @classmethod
    def of(cls, misfits: Sequence[Misfit], after: Sequence[Array] | None) -> _Levels:
        """after : residuals (n,) with the causes, None without any."""
        floor = _rms([one.noise_floor for one in misfits])
        misfit = _beyond(_rms([one.rmse for one in misfits]), floor)
        remaining = misfit if after is None else _beyond(_rms([root_mean_square(one) for one in after]), floor)
        return cls(floor, misfit, remaining)


def _word(found: SearchResult, changes: Sequence[RecordChange], levels: _Levels) -> Verdict:
    """The verdict in a word or two on a model of these records. changes : that stand."""
    if found.causes and is_partial(found.remaining_share, levels.misfit, levels.remaining, levels.floor):
        return "partly named"
    if found.causes or changes:
        return "named"
    if found.late or found.agreement.apart or found.imitated:
        return "unknown"
    return without_cause(levels.misfit, levels.floor, shape=found.curve is not None, events=bool(found.events))


def without_cause(misfit: float, floor: float, *, shape: bool, events: bool) -> Verdict:
    """The verdict where there is no cause: what has a shape is never clean, nor is a misfit far above the noise that
    has none. An event that leaves nothing else is a name, too."""
    if shape or _is_clear(misfit, floor):
        return "unknown"
    return "named" if events else "clean"


def is_partial(share: float, misfit: float, remaining: float, floor: float) -> bool:
    """Whether causes leave more than half of the misfit's energy: by the noise of every frequency (share), or plainly
    in the unit of the output, where what remains is beyond the noise."""
    plain = remaining > floor and remaining**2 > VERDICT.partial_share * misfit**2
    return share > VERDICT.partial_share or plain


def explains_nothing(model: FittedModel, simulated: Sequence[Simulated]) -> bool:
    """Whether a model hardly simulates the records that it was fitted to, so that there is nothing to extend: no
    effect can be scored along a motion that is not the measured one."""
    runs = [run for run in simulated if run.record.name in model.records]
    measured = {k: run.measured(model.output) for k, run in enumerate(runs)}
    left = {k: measured[k] - run.signal(model.output) for k, run in enumerate(runs)}
    return bool(runs) and hardly_explained(measured, left)


def explains_all(model: FittedModel, simulated: Sequence[Simulated]) -> bool:
    """Whether a model simulates every record to within rounding, so that there is nothing to search for: rounding has
    shapes of its own, which must not pass for causes."""
    errors = [(run.measured(model.output), run.signal(model.output)) for run in simulated]
    return all(negligible(measured, measured - signal) for measured, signal in errors)


def negligible(measured: Array, left: Array) -> bool:
    """Whether what is left of a measured output, (n,) each, is rounding."""
    return root_mean_square(left) <= VERDICT.negligible * float(np.std(measured))


def all_explained(model: FittedModel, simulated: Sequence[Simulated]) -> Diagnosis:
    """The diagnosis of a model that simulates every record to within rounding: clean."""
    return _without_cause("clean", model, *_unsearched(model, simulated, floor=float("inf")))


def not_explained(model: FittedModel, simulated: Sequence[Simulated], why: str = UNEXPLAINED) -> Diagnosis:
    """The diagnosis of a model that explains nothing: how much is wrong, and no cause. The noise is not known. why : in
    words."""
    nan = float("nan")
    misfits, residuals = _unsearched(model, simulated, floor=0.0)
    misfits = {name: replace(one, noise_floor=nan) for name, one in misfits.items()}
    diagnosis = _without_cause("not explained", model, misfits, residuals)
    return replace(diagnosis, noise_floor=nan, remarks=(why,))


def _unsearched(
    model: FittedModel, simulated: Sequence[Simulated], *, floor: float
) -> tuple[dict[str, Misfit], dict[str, Trace]]:
    """How much is wrong, by record, and the residuals. floor : of the noise, in every record."""
    names = dict.fromkeys(run.record.name for run in simulated)
    runs = {name: joined([run for run in simulated if run.record.name == name]) for name in names}
    left = {name: run.residual(model.output) for name, run in runs.items()}
    floors = dict.fromkeys(names, floor)
    misfits = {name: _misfit(model, run.record, left[name], floors, 0.0) for name, run in runs.items()}
    return misfits, {name: trace(run, model) for name, run in runs.items()}


def _without_cause(
    word: Verdict, model: FittedModel, misfits: dict[str, Misfit], residuals: dict[str, Trace]
) -> Diagnosis:
    """A diagnosis without a search for causes."""
    fitted = [one for name, one in misfits.items() if name in model.records]
    wrong = _rms([one.misfit for one in fitted])
    return Diagnosis(
        verdict=word,
        model=model.name,
        output=model.output,
        unit=model.unit,
        noise_floor=_rms([one.noise_floor for one in fitted]),
        misfit=wrong,
        remaining=wrong,
        records=misfits,
        causes=(),
        rejected=(),
        curves=(),
        missing={},
        residuals=residuals,
        shape=None,
        refitted=model.parameters.by_name,
    )


def hardly_explained(measured: Mapping[K, Array], left: Mapping[K, Array]) -> bool:
    """Whether a model leaves so much of measured outputs, by record, (n,) each, that it is no model of them."""
    return explained_variance(measured, left) < VERDICT.min_explained


def explained_variance(measured: Mapping[K, Array], left: Mapping[K, Array]) -> float:
    """Share of the variance of measured outputs, by record, (n,) each, that a model explains: all but what is left.
    Negative where a constant would be better; zero where nothing varies."""
    spread = sum(float(np.sum((y - y.mean()) ** 2)) for y in measured.values())
    wrong = sum(float(residual @ residual) for residual in left.values())
    return 1.0 - wrong / spread if spread > 0.0 else 0.0


def _residuals(segments: Sequence[SimulatedSegment]) -> dict[str, Array]:
    """Residuals by record, (n,)."""
    parts: dict[str, list[Array]] = {}
    for one in segments:
        parts.setdefault(one.record.name, []).append(one.residual)
    return {name: np.concatenate(residuals) for name, residuals in parts.items()}


def _misfit(
    model: FittedModel, record: Record, residual: Array, floors: Mapping[str, float], explained: float
) -> Misfit:
    rmse, floor = root_mean_square(residual), floors.get(record.name, 0.0)
    output = measured_output(record, model.output)
    return Misfit(
        role=record.role,
        fit_percent=fit_percent(output, output - residual),
        rmse=rmse,
        noise_floor=min(floor, rmse),
        misfit=_beyond(rmse, floor),
        explained_after=explained,
    )


def root_mean_square(signal: Array) -> float:
    """Of a signal (n,)."""
    return float(np.sqrt(np.mean(signal**2)))


def _rms(levels: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(levels))))


def _beyond(rmse: float, floor: float) -> float:
    """What an RMS error is beyond the noise; nothing where the two are one but for rounding."""
    return float(np.sqrt(rmse**2 - floor**2)) if rmse > floor * (1.0 + SAME) else 0.0


def trace(run: Simulated, model: FittedModel) -> Trace:
    """Measured and simulated output of a record, downsampled for figures."""
    return downsampled(run.t, run.measured(model.output), run.signal(model.output), model.unit)


def as_reported(found: AcceptedCause) -> Cause:
    """A cause as it is reported."""
    estimates = _estimates(found.after, found.effect)
    alike = tuple(one for one in found.confounded if one.effect not in found.twins)
    return Cause(
        effect=found.effect,
        parameters=estimates,
        explained=found.explained,
        heldout_gain=found.gain,
        p_value=found.p_value,
        twins=found.twins,
        separation=None,
        confounded_with=alike,
        beside=found.beside,
        gain_p_value=found.gain_p_value,
    )


def _changed(found: RecordChange) -> Cause:
    """A change of a validation record as it is reported."""
    std = found.std
    estimate = Estimate(found.effect, found.value, found.unit, std, std, float("-inf"), float("inf"))
    of = changed(found.effect)[0]
    return Cause(found.effect, (estimate,), found.explained, found.gain, found.p_value, found.twins, None, (), of)


def _estimates(model: RefittedModel, effect: str) -> tuple[Estimate, ...]:
    """The effect's own parameters with the deviations of the whitened fit."""
    parameters, covariance = model.parameters, model.covariance
    found = []
    for i in model.own_columns(effect):
        k = model.columns[i]
        std = float(np.sqrt(max(0.0, covariance[i, i])))
        bounds = float(parameters.lower[k]), float(parameters.upper[k])
        value, unit = float(parameters.values[k]), parameters.units[k]
        found.append(Estimate(parameters.names[k], value, unit, std, std, *bounds))
    return tuple(found)


def _rejected(found: SearchResult, word: Verdict, changes: Sequence[RecordChange]) -> Iterator[Rejected]:
    """What was refitted without success, and then what the score alone rejected in the first round.

    Where something unknown is wrong with the model everywhere, a difference on one record only imitates it.
    """
    reported = {c.effect for c in found.causes} | {t for c in found.causes for t in c.twins}
    for one in found.rejected:
        if one.effect not in reported:
            reported.add(one.effect)
            yield Rejected(one.effect, one.explained, one.gain, one.why)
    along = "" if found.curve is None else f" along {found.curve.curve.along}"
    why = f"only imitates what no effect explains{along}"
    yield from (Rejected(c.effect, c.explained, c.gain, why) for c in found.changes if c not in changes)
    first = found.rounds[0]
    samples = found.data.samples
    whole = max(first.projected.energy - samples, VERDICT.chance * np.sqrt(2 * samples))
    for score in first.best_of_each[: VERDICT.max_rejected]:
        if score.candidate.name not in reported:
            share = float(np.clip(score.energy / whole, 0.0, 1.0))
            why = NOT_EXAMINED if score.candidate.name in found.unexamined else _why(share, found, word)
            yield Rejected(score.candidate.name, share, float("nan"), why)


def _why(share: float, found: SearchResult, word: Verdict) -> str:
    if word == "clean":
        return "there is nothing to explain"
    best = found.causes[0] if found.causes else None
    if best is not None and share < best.explained:
        return f"scored {portion(share)} of the misfit, less than {best.effect}"
    return f"scored {portion(share)} of the misfit, which no refit confirmed"
