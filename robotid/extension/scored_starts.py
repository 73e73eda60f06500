"""Where a fit with effects starts that no diagnosis has sized: at what the score of each promises."""

from __future__ import annotations

from collections.abc import Sequence

from robotid.diagnosis.refit.refit import AS_IT_IS, refit
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.scoring.ranking import best_of_each
from robotid.diagnosis.scoring.scan import scans
from robotid.diagnosis.scoring.score_test import score
from robotid.diagnosis.search.data import unweighted
from robotid.diagnosis.search.refits import start_values
from robotid.diagnosis.search.settings import CHOICE
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel
from robotid.signals.record import Record


def scored_starts(
    model: FittedModel, records: Sequence[Record], effects: Sequence[str], horizon: float | None
) -> list[dict[str, float]]:
    """Values of parameters by dotted name, those of the best shape of every effect, and of the model beside the first;
    from all the way to what the scores promise to a part of it. None where nothing is promised.

    records : of the fit; horizon [s] : of their pieces, None for whole records.
    """
    missing = [c for c in candidates(model.joint.structure, model.output, records=records) if c.name in effects]
    try:
        now = refit(model.joint.structure, [model.parameters], unweighted(model, records, horizon), options=AS_IT_IS)
    except NumericsError:
        return []
    best = best_of_each(score(project(scans(now.fitted, now.unknowns, missing)), missing)) if missing else []
    starts = list[dict[str, float]]()
    for way in CHOICE.start_ways if best else ():
        values = start_values(now, best[0], way)
        for other in best[1:]:
            values |= other.candidate.start([way * a for a in other.amplitude])
        starts.append(values)
    return starts
