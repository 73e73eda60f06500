"""Changes of single records that are none: what varies along a motion, or from day to day, may seem another on each.

A record differs from a model that is right elsewhere, and by more than the other records do among themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, by_record
from robotid.diagnosis.scoring.record_change_candidate import record_changes
from robotid.diagnosis.search.changed_record import run, segments_of
from robotid.diagnosis.search.settings import CHANGES
from robotid.diagnosis.search.state import AcceptedCause, SearchResult
from robotid.diagnosis.settings import VERDICT
from robotid.model.structure import changed, is_change
from robotid.parallel import each

WRONG_ELSEWHERE = "only imitates: the model is far from the noise on the other records, too"
AS_MUCH_ELSEWHERE = "differs as much elsewhere: {} on {} by {:.0f} % of it"


def without_mere_changes(result: SearchResult, coloured: EvaluationData) -> SearchResult:
    """The result with its causes rejected where all of them are changes of single records of the fit, and none stands.

    coloured : the data by noise of any colour, as the last model leaves it.
    """
    if not result.causes or not all(is_change(one.effect) for one in result.causes):
        return result
    wrong = WRONG_ELSEWHERE if _is_wrong_elsewhere(result, coloured) else None
    whys = [wrong or _as_much_elsewhere(one, result) for one in result.causes]
    if None in whys:
        return result
    return result.without_causes(list(map(str, whys)))


def _is_wrong_elsewhere(result: SearchResult, coloured: EvaluationData) -> bool:
    """Whether the last model is far from the noise on the records of the fit without a change."""
    others = [one for one in result.last.fitted if one.record.name not in _differing(result)]
    samples = sum(len(one.record) for one in others)
    far = sum(one.energy for one in others) > VERDICT.clear_misfit**2 * samples
    return far and not coloured.noise_reached


def _as_much_elsewhere(cause: AcceptedCause, result: SearchResult) -> str | None:
    """Why a change is none where another record asks for a good part of it, in words; None where none does."""
    _, parameter = changed(cause.effect)
    size, model = abs(result.last.parameters[cause.effect]), result.last
    every, differing = by_record((*model.fitted, *model.validation), model.output), _differing(result)
    others = {name: segments_of(seen) for name, seen in every.items() if name not in differing}
    if not others:
        return None
    shared = replace(model, fitted=(), validation=()), parameter
    asked = each(_asked_for, shared, [*others.values()], samples=model.samples)
    name, most = max(zip(others, asked, strict=True), key=lambda pair: pair[1])
    if CHANGES.apart * most < size:
        return None
    return AS_MUCH_ELSEWHERE.format(parameter, name, 100.0 * most / max(size, 1e-300))


def _asked_for(around: tuple[RefittedModel, str], segments: Sequence[Segment]) -> float:
    """How much a record asks a parameter to differ, all others fixed; nothing where it cannot be simulated."""
    model, parameter = around
    every = record_changes(model.joint, model.columns, [segments[0].record.name])
    end = run(model, segments, [one for one in every if changed(one.name)[1] == parameter])
    return 0.0 if end is None else abs(float(end.unknowns[0]))


def _differing(result: SearchResult) -> frozenset[str]:
    """The records with changes, by name."""
    return frozenset(changed(one.effect)[0] for one in result.causes)
