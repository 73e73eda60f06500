"""A cause that explains by its first states alone is none: what shakes a joint from outside is no load of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.small_bench import QUICK, begun, records

from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.refit.refitted_model import extended
from robotid.diagnosis.remarks import remarks as remarks_of
from robotid.diagnosis.search import acceptance
from robotid.diagnosis.search.acceptance import OBJECTIONS, Steps, accept_best, is_noise, objection
from robotid.diagnosis.search.driven import energy_from_rest, starts_by_itself
from robotid.diagnosis.search.refits import CandidateRefit
from robotid.diagnosis.search.rounds import as_result
from robotid.diagnosis.search.step import Step
from robotid.signals.record import Record

LOAD = "motor.elastic_load"
SWING = 25.0  # rad/s
HUNG = {f"{LOAD}.J": 0.004, f"{LOAD}.w": 40.0, f"{LOAD}.zeta": 0.05}
LOOSE = {f"{LOAD}.J": 1e-5, f"{LOAD}.w": SWING, f"{LOAD}.zeta": 0.0}


def shaken(record: Record) -> Record:
    """The record of the same motion, of which a sine of time, which nobody recorded, carried a part."""
    return replace(record, tau_m=record.tau_m - 0.05 * np.sin(SWING * record.t))


@cache
def step(case: str) -> Step:
    """From the axis to the axis with an elastic load, where it has one, and where something else shakes it."""
    made, start = (records(HUNG), HUNG) if case == "hung" else ([*map(shaken, records({}))], LOOSE)
    state = begun(made, QUICK)
    structure, parameters = extended(state.first, LOAD, start)
    after = refit(structure, [parameters], state.data, state.first.trajectories, CAREFUL)
    return Step(state.first, state.first, after, state.data)


def test_a_load_that_swings_by_itself_explains_what_shakes_the_axis() -> None:
    """Also where it was not fitted: no other test may find anything against it."""
    assert step("shaken").share > 0.9
    assert step("shaken").gain > 0.0


def test_it_is_no_cause_for_nothing_moves_it() -> None:
    why = starts_by_itself(step("shaken"), QUICK)
    assert why is not None
    assert why.startswith("is not driven by the motion")
    assert objection(step("shaken"), QUICK) is not None


def test_what_rings_by_itself_is_no_noise_either(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else errors of the torque would pass for it, and the machine for clean."""
    tests = tuple(one for one in OBJECTIONS if one is not is_noise)  # a sine as small as this passes for slow errors
    monkeypatch.setattr(acceptance, "OBJECTIONS", tests)
    state = begun([*map(shaken, records({}))], QUICK).scored(QUICK)
    score = next(one for one in state.round.scores if one.candidate.name == LOAD)
    after = accept_best(state, [CandidateRefit(score, step("shaken").after)], Steps(state), QUICK)
    (rejected,) = after.rejected
    assert (rejected.imitates, rejected.undriven) == (True, True)
    found = as_result(after)
    assert found.shaken_share == rejected.explained > 0.9
    assert any("shakes the joint from outside" in one for one in remarks_of("unknown", found, swamped=False))


def test_a_load_that_the_motion_moves_is_one() -> None:
    assert starts_by_itself(step("hung"), QUICK) is None
    after = step("hung").after
    assert energy_from_rest(after, LOAD) == pytest.approx(after.energy, rel=0.05)


def test_what_has_no_memory_starts_nowhere() -> None:
    assert energy_from_rest(step("hung").after, "motor.coulomb") is None


def test_it_is_asked_of_every_cause() -> None:
    assert starts_by_itself in OBJECTIONS
