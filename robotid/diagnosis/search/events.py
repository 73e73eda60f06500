"""Events set aside: what happened once is taken out of the records before causes are sought, or sought again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.applied import without_events
from robotid.diagnosis.events.detection import find_event
from robotid.diagnosis.events.pieces import scan_pieces
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.results import Event
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.scoring.score_test import score
from robotid.diagnosis.search.data import Evidence
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import simulate_record
from robotid.interrupt import OutOfTime


@dataclass(frozen=True, slots=True)
class SeenEvent:
    """An event; leading : it explains so much beside the best effect of the catalogue that no cause can be sought
    before it is out of the way."""

    event: Event
    leading: bool


def largest_event(
    evidence: Evidence, model: RefittedModel, data: EvaluationData, criteria: Criteria
) -> SeenEvent | None:
    """The largest event that a model leaves, None where there is none, nothing to explain, or no time for it.

    The records are simulated in pieces, those that validate among them: an event there would be counted against every
    cause.
    """
    if not leaves_something(model, data):
        return None
    missing = candidates(model.structure, model.output, criteria.skip)
    try:
        seen = scan_pieces(evidence.model, model, (*data.fitted, *data.validation), missing)
    except (NumericsError, OutOfTime):
        return None
    found = find_event(seen, criteria.significance)
    if found is None:
        return None
    rival = max((one.energy for one in score(project(seen), missing)), default=0.0)
    return SeenEvent(found.event, found.energy > EVENTS.leading_share * rival)


def leaves_something(model: RefittedModel, data: EvaluationData) -> bool:
    """Whether the residuals of a model have more energy than noise has by chance, on the fitted or on the validation
    segments."""
    pairs = ((model.energy, data.samples), (model.validation_energy, data.validation_samples))
    return any(energy > n + EVENTS.chance * np.sqrt(2.0 * n) for energy, n in pairs)


def without_event(evidence: Evidence, event: Event) -> Evidence:
    """The evidence as it would be without an event."""
    fitted = [
        simulate_record(evidence.model, without_events(run.record, [event]), evidence.horizon)
        if run.record.name == event.record
        else run
        for run in evidence.fitted
    ]
    return replace(evidence, fitted=fitted, validation=[without_events(r, [event]) for r in evidence.validation])
