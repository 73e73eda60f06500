"""Tangents and the matrices that they are summed up in."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.model.derivatives import DerivativeColumns, Derivatives, Tangent, absent, combine


def test_columns_are_parameters_then_forces_then_the_motor_torque() -> None:
    wanted = DerivativeColumns(parameters=(7, 2), forces=(0, 1))
    assert wanted.width == 5
    found = Derivatives.zeros(1, 3, 2, wanted)
    assert found.states is not None
    assert found.columns is not None
    assert (found.states.shape, found.columns.shape) == ((1, 3, 2), (1, 5, 2))
    assert found.where == {7: 0, 2: 1}


def test_tangents_add_up_in_their_columns() -> None:
    found = Derivatives.zeros(2, 3, 2, DerivativeColumns((7, 2)))
    found.add(1, Tangent({2: 1.0}, {2: np.array([3.0, 4.0]), 5: 9.0}), -2.0)
    found.add(1, Tangent({2: np.array([0.5, 1.5])}, {7: 1.0}))
    assert found.states is not None
    assert found.columns is not None
    np.testing.assert_array_equal(found.states[1, 2], [-1.5, -0.5])
    np.testing.assert_array_equal(found.columns[1], [[1.0, 1.0], [-6.0, -8.0], [0.0, 0.0]])
    assert np.count_nonzero(found.states) == 2
    assert not found.columns[0].any()


def test_without_columns_only_the_states_count() -> None:
    found = Derivatives.zeros(1, 2, 1, None)
    found.add(0, Tangent({0: 2.0}, {0: 3.0}))
    assert found.columns is None
    assert found.states is not None
    np.testing.assert_array_equal(found.states[0], [[2.0], [0.0]])


def test_tangents_combine_with_factors() -> None:
    total = combine([(2.0, Tangent({0: 1.0}, {1: 3.0})), (0.0, Tangent({5: 1.0})), (1.0, Tangent({0: 4.0}))])
    assert total == Tangent({0: 6.0}, {1: 6.0})


@pytest.mark.parametrize(("partial", "is_absent"), [(0.0, True), (1.0, False), (np.zeros(1), False)])
def test_only_the_plain_zero_is_absent(partial: float, is_absent: bool) -> None:
    assert absent(partial) is is_absent
