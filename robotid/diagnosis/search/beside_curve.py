"""Causes beside what no effect explains: a torque of no known law hides the known ones until it is out of their way.

The curve that explains most acts in time on every record, as a recorded torque would, and the search goes on beside it.
What is found stands only where it explains most of what the curve leaves: beside a curve that is but a part of what is
wrong, the rest looks like many an effect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robotid.channels.torque_gain import TorqueGain
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.nonparametric.curve_course import READERS, is_course, joined_courses, with_course
from robotid.diagnosis.nonparametric.curve_fit import refit_beside
from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.refit.refitted_model import carried
from robotid.diagnosis.search.coloured import in_colour, left_by
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.state import AcceptedCause, SearchResult, is_plain, share_removed
from robotid.diagnosis.settings import VERDICT
from robotid.model.structure import belongs


def with_curve(evidence: Evidence, found: SearchResult) -> Evidence | None:
    """The evidence of records on which the curve that was found acts, the model beside it; None where it only does
    harm there. Raises NumericsError where the model cannot be simulated."""
    beside = None if found.curve is None else refit_beside(found.curve, found.last, found.data)
    if beside is None:
        return None
    courses = joined_courses([*beside.fitted, *beside.validation])
    model = beside.put_into(evidence.model)
    return replace(evidence, model=model).on(lambda record: with_course(record, courses[record.name]))


def without_readers(criteria: Criteria) -> Criteria:
    """The criteria of a search beside a curve, which is nothing that an effect could read, nor a known torque by which
    the recorded one could be gauged: a gain of this would only tell that the curve has another size."""
    return replace(criteria, skip=(*criteria.skip, *READERS, TorqueGain.name))


def explain_most(beside: SearchResult) -> bool:
    """Whether the causes of a search beside a curve explain more than half of what the curve leaves."""
    return bool(beside.causes) and beside.remaining_share <= VERDICT.partial_share


def with_causes(found: SearchResult, beside: SearchResult) -> SearchResult:
    """What was found, with the causes of a search beside its curve: shares are of all that the first model misses, and
    the last model has the causes alone, as they are beside the curve, for without it a fit would lead them astray.
    Raises NumericsError where that cannot be simulated."""
    first, data, causes = found.first, found.data, list[AcceptedCause]()
    plain = is_plain(first, data)
    for cause in beside.causes:
        explained = share_removed(first, cause.before, cause.after, data, plain=plain)
        causes.append(replace(cause, explained=explained))
    structure = beside.last.structure
    for course in filter(is_course, structure.effects):
        structure = structure.without(course)
    named = {cause.effect for cause in causes}
    known = beside.last.parameters
    own = {name: known[name] for name in known.names if any(belongs(name, effect) for effect in named)}
    starts = [carried(old, structure, {}).held_at(own) for old in (known, first.parameters)]
    last = refit(structure, starts, data, options=CAREFUL)
    noise = left_by(last).noise
    return replace(
        found,
        last=last,
        causes=tuple(causes),
        rejected=(*beside.rejected, *(one for one in found.rejected if one.effect not in named)),
        curve_share=min(found.curve_share, 1.0 - float(np.sum([cause.explained for cause in causes]))),
        noise=noise,
        coloured=in_colour(last, data, noise),
        beside_curve=True,
        changes=(),
    )
