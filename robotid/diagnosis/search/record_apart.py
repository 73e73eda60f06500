"""What one fitted record has another: found beside a model that is fitted to all the others.

A model fitted to records that do not go together is the model of none of them. Along what it simulates the true change
may score next to nothing, as where an arm with a payload resonates elsewhere, and a refit from there gets stuck. The
other records go together: their model is that of the machine, and what it lacks on the one is the change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit_to_confirm
from robotid.diagnosis.refit.refitted_model import RefittedModel, Trajectories, carried
from robotid.diagnosis.search.carry_over import gain_by_blocks
from robotid.diagnosis.search.changed_record import Changed, Halves, simulated
from robotid.diagnosis.search.refits import CandidateRefit, in_order, on_the_whole
from robotid.diagnosis.search.state import SearchState
from robotid.model.parameters import Parameters
from robotid.parallel import each


@dataclass(frozen=True, slots=True, eq=False)
class _Apart:
    """What a record has another. others : parameters of the model of all others; change : that its first part asks for;
    p_value : of the second part showing it by chance."""

    others: Parameters
    change: Changed
    p_value: float


def changed_apart(state: SearchState, criteria: Criteria) -> list[CandidateRefit]:
    """The model refitted with the change that each fitted record asks for most beside a model of the others, the best
    refit first; none where there is only one record."""
    names = list(dict.fromkeys(one.record.name for one in state.data.fitted))
    if len(names) < 2:
        return []
    scores = state.round.by_effect
    found = each(_apart, (state.model, state.data), names, samples=state.data.samples)
    refits = list[CandidateRefit]()
    for one in found:
        name = "" if one is None else one.change.candidates[-1].name
        if one is None or name not in scores:
            continue
        structure = state.model.structure.extended(name)
        start = carried(one.others, structure, {name: one.change.values[-1]})
        refitted = on_the_whole(scores[name], structure, start, state)
        if refitted is not None:
            refits.append(replace(refitted, confirmed=one.p_value))
    return in_order(refits, state, criteria)


def _apart(around: tuple[RefittedModel, EvaluationData], name: str) -> _Apart | None:
    """What a record, by name, has another; None where the others have no model, or that suits the record, too."""
    model, data = around
    own = [k for k, one in enumerate(data.fitted) if one.record.name == name]
    other = [k for k in range(len(data.fitted)) if k not in own]
    alone = replace(data, fitted=tuple(data.fitted[k] for k in other), validation=())
    near = Trajectories(tuple(model.fitted[k].trajectory for k in other))
    others = refit_to_confirm(model.structure, model.parameters, alone, near)
    if others is None:
        return None
    seen = simulated(others, [data.fitted[k] for k in own])
    halves = None if seen is None else Halves.of(others, seen, others.energy / others.samples)
    asked = [] if halves is None else halves.with_one_more(halves.unchanged, halves.candidates)
    if halves is None or not asked:
        return None
    return _Apart(others.parameters, asked[0], gain_by_blocks(halves.before.segments, asked[0].after.segments).p_value)
