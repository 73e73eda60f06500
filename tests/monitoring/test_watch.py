"""An accepted model against new logs: silent where nothing has changed, and right about what has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from support.small_bench import AXIS, SAMPLING_TIME, TRUTH, made_along, references
from support.watched_axis import watched

from robotid.catalogue import assemble
from robotid.errors import ConfigError
from robotid.estimate.fitted_model import fitted_model
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.monitoring import WatchOptions, watch

LEVEL = 0.05


@pytest.mark.parametrize("draws", [4, pytest.param(60, marks=pytest.mark.slow)])
def test_unchanged_logs_alarm_no_more_often_than_the_level(draws: int) -> None:
    alarms = 0
    for seed in range(draws):
        model, fitted, log = watched(seed)
        found = watch(model, fitted, [log], WatchOptions(level=LEVEL))
        assert found.logs[0].state == "unchanged" or found.alarm
        alarms += found.alarm
    assert alarms <= binom.ppf(0.99, draws, LEVEL)


@pytest.mark.parametrize(("parameter", "value"), [("motor.coulomb.Fc", 0.33), ("motor.inertia.J", 0.0128)])
def test_what_has_changed_is_named_with_its_size(parameter: str, value: float) -> None:
    model, fitted, log = watched(0, {parameter: value})
    found = watch(model, fitted, [log])
    (one,) = found.logs
    assert found.alarm
    assert one.state == "changed"
    assert one.p_value < 0.01
    assert one.change is not None
    assert one.twins[0] == one.change.parameter == parameter
    assert one.change.before + one.change.shift == pytest.approx(value, rel=0.02)
    assert one.fit_percent < one.usual_percent


def test_what_no_parameter_explains_is_said_to_be_that() -> None:
    """A hundred times the noise of the sensor changes no parameter."""
    model, fitted, log = watched(1)
    noise = np.random.default_rng(0).standard_normal(len(log))
    found = watch(model, fitted, [replace(log, dphi_m=log.dphi_m + 2.0 * noise)])
    assert found.logs[0].state == "not explained"
    assert found.logs[0].change is None
    assert found.logs[0].residual_ratio > 10.0


def test_what_the_records_of_the_fit_left_uncertain_has_not_changed() -> None:
    """An axis fitted at all but constant speed, with an inertia that is wrong by some per cent."""
    t = np.arange(1500) * SAMPLING_TIME
    even = {f"even{k}": 6.0 - k + 0.1 * np.sin(2 * np.pi * (0.5 + 0.1 * k) * t) for k in range(2)}
    fitted = [one.piece(500, 1500) for one in made_along(even)]
    (log,) = made_along({"log": references()["wide"]})
    joint = assemble(AXIS)
    fit = fit_model("m", joint, joint.parameters().with_values(TRUTH), fitted, FitOptions())
    (found,) = watch(fitted_model(fit), fitted, [replace(log, role="validate")]).logs
    assert found.residual_ratio > 5.0
    assert found.p_residual < 1e-6
    assert found.state == "unchanged"


def test_no_log_is_refused() -> None:
    model, fitted, _ = watched(0)
    with pytest.raises(ConfigError, match="there is no log"):
        watch(model, fitted, [])
