"""Checks of the constants of the verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.diagnosis import experiment
from robotid.diagnosis.confirmation import is_idle
from robotid.diagnosis.experiment import default_speed_controller, design_discriminating_experiment
from robotid.diagnosis.results import Cause
from robotid.diagnosis.scoring.score_test import Score
from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.search.torque_errors import is_swamped, lead_astray
from robotid.diagnosis.settings import VERDICT
from robotid.diagnosis.verdict import _Levels, _rejected, _word, hardly_explained, is_partial, negligible
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from support.plain_models import plain_model, plain_record
from support.tuning import sees
from support.tuning.search import friction, state


def result(energy: float, *scores: Score) -> SearchResult:
    seen = state(energy, *scores)
    return SearchResult(seen.data, seen.first, seen.model, (), (), seen.rounds)


def named(k: int) -> Score:
    return replace(friction(10.0), candidate=replace(friction(1.0).candidate, name=f"motor.effect{k}"))


@sees(VERDICT, "telling")
def check_an_experiment_must_tell_models_apart_by_five_sigma() -> None:
    reference, controller = Reference("a", 1e-3, np.zeros(100), "speed"), Controller("speed", 1.0, 1.0)
    model = plain_model(1000.0)
    for ratio, proposed in ((0.52, True), (0.48, False)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(experiment, "_difference", lambda *_, ratio=ratio: ratio)
            found = design_discriminating_experiment(model, model, "b", {"{}": reference}, controller, 1.0)
        assert (found is not None) is proposed


@sees(VERDICT, "max_rejected")
def check_a_dozen_effects_are_listed() -> None:
    assert len(list(_rejected(result(2000.0, *map(named, range(50))), "unknown", ()))) == 12


@sees(VERDICT, "clear_misfit")
def check_a_misfit_of_twice_the_noise_is_something() -> None:
    found = result(2000.0, friction(1.0))
    assert _word(found, (), _Levels(1.0, 1.9, 1.9)) == "clean"
    assert _word(found, (), _Levels(1.0, 2.1, 2.1)) == "unknown"


@sees(VERDICT, "partial_share")
def check_causes_that_leave_more_than_half_explain_a_part() -> None:
    for left, partial in ((0.45, False), (0.55, True)):
        assert is_partial(left, misfit=1.0, remaining=0.1, floor=0.1) is partial
        assert is_partial(0.0, misfit=1.0, remaining=float(np.sqrt(left)), floor=0.1) is partial


@sees(VERDICT, "min_explained")
def check_a_fit_below_ten_percent_is_no_model() -> None:
    y = plain_record().t
    for fit, nothing in ((10.5, False), (9.5, True)):
        left = (1.0 - fit / 100.0) * (y - y.mean())
        assert hardly_explained({"a": y}, {"a": left}) is nothing


def led_away(found: SearchResult, speed: float, share: float) -> SearchResult:
    """A result whose record moves at this speed [rad/s], and off which the model is by this share of its variance, the
    noise besides."""
    (one,), (segment,) = found.last.fitted, found.data.fitted
    moving = replace(one.record, dphi_m=speed * np.sin(one.record.t))
    noise, whole = segment.whitening.output_variance, float(np.var(moving.dphi_m))
    residual = np.full(len(one.residual), np.sqrt(noise + share * whole))
    return replace(found, last=replace(found.last, fitted=(replace(one, record=moving, residual=residual),)))


@sees(VERDICT, "swamped_share")
def check_torque_errors_that_cause_a_tenth_of_the_motion_hide_what_is_missing() -> None:
    found = result(1000.0, friction(1.0))
    for share, swamped in ((0.09, False), (0.11, True)):
        assert is_swamped(led_away(found, 3.0, share)) is swamped


@sees(VERDICT, "astray_share")
def check_torque_errors_of_three_percent_of_the_motion_lead_a_simulation_astray() -> None:
    found = result(1000.0, friction(1.0))
    (segment,) = found.data.fitted
    driven = replace(segment, record=replace(segment.record, tau_m=np.full(len(segment.record), 100.0)))
    coloured = replace(found.data, fitted=(driven,), noise_reached=True)
    for share, far in ((0.9e-3, False), (1.1e-3, True)):
        assert lead_astray(replace(led_away(found, 200.0, share), coloured=coloured)) is far


@sees(VERDICT, "swamped_torque")
def check_torque_errors_of_a_tenth_of_the_torque_hide_what_is_missing() -> None:
    found = result(1000.0, friction(1.0))
    (one,), (segment,) = found.last.fitted, found.data.fitted
    still = replace(found.last, fitted=(replace(one, residual=0.0 * one.residual),))
    driven = replace(segment.record, tau_m=np.full(len(segment.record), 0.5))
    for share, swamped in ((0.09, False), (0.11, True)):
        levels = replace(segment.whitening.levels, torque=0.0, red=(0.5 * share) ** 2)
        noisy = replace(segment, record=driven, whitening=replace(segment.whitening, levels=levels))
        data = replace(found.data, fitted=(noisy,))
        assert is_swamped(replace(found, last=still, data=data, coloured=None)) is swamped


@sees(VERDICT, "negligible")
def check_a_millionth_of_the_output_is_rounding() -> None:
    y = plain_record().t
    for share, nothing in ((0.95e-6, True), (1.05e-6, False)):
        assert negligible(y, share * np.std(y) * np.ones(len(y))) is nothing


@sees(VERDICT, "chance")
def check_a_share_is_of_no_less_misfit_than_chance_makes() -> None:
    # a thousand samples: the energy of their noise has a standard deviation of root 2000
    (one,) = _rejected(result(1000.0, friction(20.0)), "unknown", ())
    assert one.explained == pytest.approx(20.0 / (3 * np.sqrt(2000.0)))


@sees(VERDICT, "speed_bandwidth")
def check_a_speed_loop_is_closed_at_five_hertz() -> None:
    model = plain_model(1.0)
    inertia = model.parameters["motor.inertia.J"]
    assert default_speed_controller(model).kp / inertia == pytest.approx(2 * np.pi * 5.0)


@sees(VERDICT, "least_gain")
def check_a_gain_of_less_than_half_a_hundredth_is_none() -> None:
    for gain, idle in ((0.0049, True), (0.0051, False)):
        cause = Cause("motor.stribeck", (), 0.5, gain, 1e-6, ("motor.stribeck",), None)
        assert is_idle(cause) is idle
