"""The state in which a search begins."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.small_bench import STRIBECK, begun, records

from robotid.diagnosis.refit.refit import CAREFUL, refit
from robotid.diagnosis.search import data
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
