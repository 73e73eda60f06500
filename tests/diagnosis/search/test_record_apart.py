"""A change of one fitted record is found beside a model of the others, where one of all of them leads nowhere."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from support.small_bench import QUICK, begun, fitted, records

from robotid.diagnosis.procedure import diagnose
from robotid.diagnosis.search import rounds, step
from robotid.diagnosis.search.acceptance import Steps
from robotid.diagnosis.search.record_apart import changed_apart
from robotid.diagnosis.search.state import SearchState

DIFFERENCE = {"record_change.slow.motor.coulomb.Fc": 0.3, "record_change.wide.motor.coulomb.Fc": -0.3}
"""Half as much again in the slow record; which of two records is the odd one, none can tell."""


@cache
def state() -> SearchState:
    """Two records that no parameters suit, scored once."""
    return begun(records({}, changed={"motor.coulomb.Fc": 1.5}), QUICK).scored(QUICK)


def test_each_record_is_set_against_the_others() -> None:
    found = changed_apart(state(), QUICK)
    assert {one.effect for one in found} == set(DIFFERENCE)
    for one in found:
        assert one.model.parameters[one.effect] == pytest.approx(DIFFERENCE[one.effect], rel=0.02)
        assert one.model.energy < 1.2 * one.model.samples
        assert one.confirmed < 1e-6


def test_one_record_differs_from_nothing() -> None:
    alone = state()
    data = replace(alone.data, fitted=alone.data.fitted[:1])
    assert changed_apart(replace(alone, data=data), QUICK) == []


def test_what_another_part_of_the_record_confirms_is_no_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few blocks tell of a change that acts at one moment above all."""
    found = changed_apart(state(), QUICK)[0]
    steps = [Steps(state()).to(replace(found, confirmed=p)) for p in (1.0, 1e-9)]
    monkeypatch.setattr(step, "p_value", lambda *_: 0.4)
    monkeypatch.setattr(step.Step, "held_out", None)
    assert [one.p_value for one in steps] == [0.4, pytest.approx(1e-9 * steps[1].tried.effects)]


def test_what_another_part_confirms_is_noise_where_enough_blocks_tell_and_scatter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A torque that walks at random lasts from one part to the other, and these confirm each other."""
    found = changed_apart(state(), QUICK)[0]
    monkeypatch.setattr(step, "p_value", lambda *_: 0.4)
    monkeypatch.setattr(step, "by_blocks", lambda *_: 0.1)
    monkeypatch.setattr(step.Step, "held_out", None)
    assert Steps(state()).to(replace(found, confirmed=1e-9)).p_value == 0.1


def test_it_is_the_cause_where_a_refit_from_the_model_of_all_records_leads_nowhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rounds, "accept_best", lambda state, *_: state)
    monkeypatch.setattr(rounds, "accept_asked_for", lambda state, *_: state)
    made, said = records({}, changed={"motor.coulomb.Fc": 1.5}), list[str]()
    found = diagnose(fitted(made), made, QUICK, log=said.append)
    assert any("fitting all records but one" in line for line in said)
    (cause,) = found.causes
    assert cause.parameters[0].value == pytest.approx(DIFFERENCE[cause.effect], rel=0.02)
    assert found.verdict == "named"
