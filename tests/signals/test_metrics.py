"""Metrics against numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.signals.metrics import error_percent, fit_percent, rmse

Y = np.array([1.0, 2.0, 3.0, 4.0])


def test_a_shift_by_hand():
    # ||y - yhat|| = 0.5 * 2 = 1; ||y - mean|| = sqrt(2.25 + 0.25 + 0.25 + 2.25) = sqrt(5)
    assert fit_percent(Y, Y + 0.5) == pytest.approx(100 * (1 - 1 / np.sqrt(5)))
    assert rmse(Y, Y + 0.5) == pytest.approx(0.5)
    assert error_percent(Y, Y + 0.5) == pytest.approx(100 / np.sqrt(30))


def test_the_mean_fits_nothing_and_worse_is_negative():
    assert fit_percent(Y, np.full(4, 2.5)) == pytest.approx(0.0)
    assert fit_percent(Y, Y) == 100.0
    assert fit_percent(Y, -Y) < 0


def test_a_signal_that_does_not_vary_has_no_fit():
    assert fit_percent(np.ones(4), Y) == 0.0
    assert error_percent(np.zeros(4), Y) == 0.0
