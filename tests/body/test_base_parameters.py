from __future__ import annotations

import numpy as np
import pytest

from robotid.body.base_parameters import base_parameters


def test_dependent_columns_join_those_they_depend_on() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 100))
    columns = np.stack([3.0 * a, b, np.zeros(100), a / 2 - 2.0 * b], axis=1)
    found = base_parameters(columns)
    assert len(found.picked) == 2
    every = rng.normal(size=4)
    base = found.grouping @ every
    assert columns[:, list(found.picked)] @ base == pytest.approx(columns @ every)


def test_independent_columns_stay_as_they_are() -> None:
    columns = np.random.default_rng(2).normal(size=(50, 5)) * [1e-3, 1.0, 1e3, 3.0, 1.0]
    found = base_parameters(columns)
    assert found.picked == (0, 1, 2, 3, 4)
    assert np.array_equal(found.grouping, np.eye(5))


def test_a_base_parameter_is_called_by_its_sum() -> None:
    a, b = np.random.default_rng(3).normal(size=(2, 60))
    found = base_parameters(np.stack([10.0 * a, b, 5.0 * a - b, -10.0 * a + b], axis=1))
    symbols = ("p", "q", "r", "s")
    for name, row in zip(found.names(symbols), found.grouping, strict=True):
        shares = {symbol: share for symbol, share in zip(symbols, row, strict=True) if share}
        assert all(symbol in name for symbol in shares)
        assert ("-" in name) == any(share < 0 for share in shares.values())
    assert all(name.endswith(" + ...") for name in found.names(symbols, terms=2))


def test_nothing_that_acts_has_no_base() -> None:
    assert base_parameters(np.zeros((10, 3))).picked == ()
