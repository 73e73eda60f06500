"""The state in which a search begins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.small_bench import QUICK, STRIBECK, begun, idle_then_stribeck, records

from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.search import data
from robotid.diagnosis.search.state import AcceptedCause
from robotid.errors import NumericsError


def test_where_the_whitened_refit_runs_away_the_model_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = begun(records(STRIBECK))
    asked = []

    def running_away(*arguments: Any) -> Any:
        asked.append(arguments)
        if arguments[-1] is CAREFUL:
            raise NumericsError("the simulation diverges")
        return refit(*arguments)

    monkeypatch.setattr(data, "refit", running_away)
    state = begun(records(STRIBECK))
    (start,) = asked[0][1]
    assert len(asked) == 2
    assert np.array_equal(state.first.parameters.values, start.values)
    assert not np.array_equal(usual.first.parameters.values, start.values)
    assert state.first.energy > usual.first.energy


def test_noise_that_leads_the_model_astray_is_not_renewed(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the noise before it the refit loses what the causes explain, as it may beside what is left of an event."""
    state, idle, both = idle_then_stribeck()
    cause = AcceptedCause("motor.stribeck", 0.9, 1.0, 1e-9, ("motor.stribeck",), idle, both, None)
    named = replace(state.with_model(both, QUICK), causes=(cause,))
    assert data.renew_noise(named).data is not named.data
    monkeypatch.setattr(data, "refit", lambda *_: idle)
    assert data.renew_noise(named) is named
    assert data.renew_noise(replace(named, causes=())).model is idle


def test_noise_by_which_no_fit_ends_is_not_renewed(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverging(*_: object) -> None:
        raise NumericsError("the simulation diverges")

    state = begun(records({}), QUICK)
    monkeypatch.setattr(data, "refit", diverging)
    assert data.renew_noise(state) is state
