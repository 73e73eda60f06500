"""Delays that only smooth the noise of a torque, and those of a machine."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from support.small_bench import QUICK, SAMPLING_TIME, begun, records

from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import extended
from robotid.diagnosis.scoring.ranking import Round
from robotid.diagnosis.search.smoothing import is_smoothing
from robotid.diagnosis.search.state import SearchState
from robotid.diagnosis.search.step import Step
from robotid.signals.record import Record

LOUD = 0.15  # Nm of noise on the logged torque


@cache
def state_of(late: int = 0) -> SearchState:
    """A search on records with a noisy torque that is logged so many samples early, and so acts late."""
    return begun([_loud(one, k, late) for k, one in enumerate(records({}))], QUICK)


def _loud(record: Record, number: int, late: int) -> Record:
    torque = np.concatenate([record.tau_m[late:], np.full(late, record.tau_m[-1])])
    return replace(record, tau_m=torque + LOUD * np.random.default_rng(number).standard_normal(len(torque)))


def step_to(state: SearchState, start: float) -> Step:
    structure, parameters = extended(state.first, "torque.torque_lag", {"torque.torque_lag.T": start})
    after = refit(structure, [parameters], state.data, state.first.trajectories)
    return Step(state.first, state.first, after, state.data)


def test_a_lag_that_smooths_the_noise_of_the_torque_is_none() -> None:
    step = step_to(state_of(), 0.4 * SAMPLING_TIME)
    assert step.after.parameters["torque.torque_lag.T"] > 0.1 * SAMPLING_TIME
    assert "smooths the noise of the torque" in str(is_smoothing(step, QUICK))


def test_a_lag_of_the_machine_is_one() -> None:
    step = step_to(state_of(3), 3 * SAMPLING_TIME)
    assert is_smoothing(step, QUICK) is None


def test_the_score_does_not_take_the_noise_of_the_torque_for_a_delay() -> None:
    clean, late = (share_of_delay(state_of(k).scored(QUICK).round) for k in (0, 3))
    assert clean < 15.0 < 100.0 < late


def share_of_delay(seen: Round) -> float:
    """Energy that the best delay explains, in variances."""
    return max(one.energy for one in seen.scores if one.candidate.name.endswith(("_delay", "_lag")))
