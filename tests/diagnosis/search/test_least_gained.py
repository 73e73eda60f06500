"""An effect must raise the fit by more than nothing to be a cause, and is as large as that at its limit."""

from __future__ import annotations

import numpy as np
import pytest
from diagnosis.search.test_least_scored import through

from robotid.diagnosis.search.added_signals import in_any_proportion
from robotid.diagnosis.search.least_gained import least_gained
from robotid.diagnosis.search.least_scored import residuals_with


@pytest.mark.parametrize("effect", ["motor.quadratic_friction", "motor.constant_torque"])
def test_an_effect_of_the_least_size_lowers_the_fit_by_the_gain(effect: str) -> None:
    seen, projected, at = through(effect)
    (size,) = least_gained(seen, projected, [at], 2.0)
    hidden = residuals_with(seen, projected, at, in_any_proportion(at, size))
    motion = np.concatenate([one.segment.record.dphi_m - one.segment.record.dphi_m.mean() for one in seen])
    before = np.concatenate([one.signals[-1] for one in seen])
    after = np.concatenate([one.residual for one in hidden])
    lost = 100.0 * (np.linalg.norm(after) - np.linalg.norm(before)) / np.linalg.norm(motion)
    assert lost == pytest.approx(2.0, rel=0.05)


def test_where_no_gain_is_asked_for_no_size_is() -> None:
    seen, projected, at = through("motor.quadratic_friction")
    assert least_gained(seen, projected, [at], 0.0) == 0.0


def test_what_the_fitted_parameters_do_as_well_gains_nothing() -> None:
    seen, projected, at = through("torque.torque_gain")
    assert np.isinf(least_gained(seen, projected, [at], 1e-3))
