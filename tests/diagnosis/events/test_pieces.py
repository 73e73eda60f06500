"""The pieces of records in which events are sought."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest
from support.small_bench import fitted, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.pieces import simulated_pieces
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.estimate.fitted_model import fitted_model, simulate_records
from robotid.signals.record import Record


def pieces(of_each: int, further: int = 0, *, apart: bool = False) -> Counter[str]:
    """How many there are of records that the search has cut into so many. apart : with a gap after each piece."""
    made = records({})
    model, horizon = fitted_model(fitted(made)), made[0].duration / of_each
    own = [record for record in made if record.name in model.records]
    evidence = Evidence(model, simulate_records(model, own, horizon), [], horizon)
    state = first_state(evidence, Criteria(skip=("record_change",)))
    segments = [replace(one, record=_moved(one.record, apart=apart)) for one in state.data.fitted]
    found = simulated_pieces(model, state.first, segments, further)
    return Counter(one.record.name for one in found)


def _moved(record: Record, *, apart: bool) -> Record:
    return replace(record, begin=2.0 * record.begin) if apart else record


@pytest.mark.parametrize(
    ("of_each", "found"), [(1, EVENTS.pieces), (2, EVENTS.pieces), (5, 3 * 5), (16, 16)], ids=["whole", "2", "5", "16"]
)
def test_those_of_a_record_that_is_cut_already_are_cut_only_as_far_as_they_are_fewer(of_each: int, found: int) -> None:
    assert set(pieces(of_each).values()) == {found}
    assert set(pieces(of_each, further=1).values()) == {found + of_each}


def test_stretches_of_a_long_record_are_cut_each_as_a_record_is() -> None:
    assert set(pieces(2, apart=True).values()) == {2 * EVENTS.pieces}
